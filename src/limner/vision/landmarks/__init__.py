"""A photo goes in, the faces in it with their landmarks come out."""

from limner.vision.landmarks.annotation import read_faces
from limner.vision.landmarks.detectors import DETECTORS, Detector, DetectSettings, choose, detect

__all__ = ["DETECTORS", "DetectSettings", "Detector", "choose", "detect", "read_faces"]

"""A photo and the face in it go in; what makes it a bad photo to draw from, and what helps, come out.

Every limit lies between the worst of 256 good portraits of all skins, lights and cameras and copies of them spoilt on
purpose. Light is judged by the brightest parts of the face, since dark skin in good light is no dark photo.
"""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np

from limner.types import Face, Floats, Photo
from limner.vision.likeness.descriptor import LANDMARKS, describe_landmarks, landmark_part
from limner.vision.likeness.model import shipped_likeness
from limner.vision.likeness.picture import photo_picture, upright_from_photo
from limner.vision.raster import Image, blurred, filled
from limner.vision.refine.shape import moved

SMALL_PX = 40.0
"""Distance of the outer eye corners below which eyes are a few blots."""

BRIGHT, BURNT, BURNT_SHARE, CONTRAST = 70.0, 250.0, 0.1, 48.0
"""Grey levels, 0 to 255: the bright parts of a face in the dark; white, and its share; from darkest to brightest."""

SHARP = 0.42
"""Fine detail over coarse, each the difference of two blurs; a blur of 3 % of the outer-eye distance goes below."""

TURNED, TILTED_DEG = 0.35, 25.0
"""How far the tip of the nose may be from between the eyes [outer-eye distances]; slope of the line of the eyes."""

LIKE_A_NOSE_OR_MOUTH, LIKE_EYES = 0.5, 0.58
"""Least cosines with what noses and mouths, and both eyes, look like on average."""


def photo_notes(photo: Photo, face: Face) -> tuple[str, ...]:
    """What is wrong with a photo, one line each, with what helps; nothing for a good one.

    Args:
        photo: the whole photo.
        face: in it, all 68 landmarks.
    """
    upright = upright_from_photo(face.points_px)
    picture, marks = photo_picture(photo, upright), moved(face.points_px, upright)
    notes = [*_place(photo, face), *_light(picture, marks)]
    # On a face that is turned, small or burnt, hidden features say nothing new.
    return tuple(notes or _hidden(picture, marks))


def _place(photo: Photo, face: Face) -> Iterator[str]:
    points, unit = face.points_px, face.outer_eye_px
    along = (points[45] - points[36]) / unit
    aside = float((points[30] - (points[36] + points[45]) / 2) @ along) / unit
    slope = float(np.degrees(np.arctan2(along[1], along[0])))
    outside = ((points < -0.5) | (points > np.array(photo.size_px) - 0.5)).any(axis=1)
    if unit < SMALL_PX:
        yield f"face too small: {unit:.0f} px between the outer eye corners; go nearer, or take a larger photo"
    if abs(aside) > TURNED:
        yield "face turned away: one side is hidden; look towards the camera"
    if abs(slope) > TILTED_DEG:
        yield f"head tilted by {abs(slope):.0f} degrees; hold it upright, or turn the photo"
    if outside.any():
        yield f"face partly outside the photo: {outside.sum()} of 68 landmarks; leave room around the head"


def _light(picture: Image, marks: Floats) -> Iterator[str]:
    inside = filled(_hull(marks), picture.shape)
    grey = picture[inside]
    if grey.size == 0:
        return
    dark, bright = np.percentile(grey, [5, 95])
    fine = blurred(picture, 1.5)
    coarse = blurred(picture, 4.0)
    detail = np.percentile(np.abs(picture - fine)[inside], 95)
    if bright < BRIGHT:
        yield "too dark: the face is nearly black; turn it to a window or a lamp"
    elif (grey >= BURNT).mean() > BURNT_SHARE:
        yield f"burnt out: {100 * (grey >= BURNT).mean():.0f} % of the face is white; less light, or no flash"
    elif bright - dark < CONTRAST:
        yield "low contrast: the face is nearly one grey; light from the side, and a clean lens, help"
    if detail < SHARP * np.percentile(np.abs(fine - coarse)[inside], 95):
        yield "blurred: no fine lines around the eyes; hold still and focus on the eyes, or take a sharper photo"


def _hull(marks: Floats) -> Floats:
    """The outline of brows, nose and mouth."""
    corners = cv2.convexHull(marks[17:].astype(np.float32))
    return np.asarray(corners, np.float64).reshape(-1, 2)


def _hidden(picture: Image, marks: Floats) -> Iterator[str]:
    seen = describe_landmarks(picture, marks)
    usual = landmark_part(shipped_likeness().discriminant.photo_mean)
    of = np.array(LANDMARKS)
    eyes, nose, mouth = (of >= 36) & (of < 48), (of >= 27) & (of < 36), of >= 48
    covered = [name for name, part, least in (
        ("eyes", eyes, LIKE_EYES), ("nose", nose, LIKE_A_NOSE_OR_MOUTH), ("mouth", mouth, LIKE_A_NOSE_OR_MOUTH),
    ) if _cosine(seen[part], usual[part]) < least]  # fmt: skip
    if covered:
        yield f"face covered: {' and '.join(covered)} cannot be seen; take away what hides the face"


def _cosine(a: Image, b: Image) -> float:
    return float((a * b).sum() / max(np.linalg.norm(a) * np.linalg.norm(b), 1e-9))

"""People in two photos each, and more faces, in; the model that scores the likeness of drawings out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from limner.evaluate.likeness import PHOTO, Person, Watch, describe_people, of_photo
from limner.pipeline import Settings
from limner.types import Photo
from limner.vision.landmarks.fmp.dataset import Sample
from limner.vision.landmarks.fmp.scenes import read_image
from limner.vision.likeness.discriminant import train_discriminant
from limner.vision.likeness.model import LikenessModel

STYLES, POINTS = ("canny", "gabor"), (250, 600)
"""Drawings that are learnt from: edges and dark lines, few and many."""

DIRECTIONS = 48


def train_likeness(
    people: Sequence[Person],
    others: Sequence[Sample] = (),
    watch: Watch = lambda what, done, total, note: None,
) -> LikenessModel:
    """Learn what tells people apart from two photos and four drawings of each.

    Args:
        people: in two photos each; all are in the gallery too.
        others: more faces for the gallery.
        watch: told of progress.
    """
    described = describe_people(people, STYLES, POINTS, Settings(), watch)
    drawings = [rows for key, rows in described.pictures.items() if key != PHOTO]
    learnt = train_discriminant([described.pictures[PHOTO], described.sought], drawings, DIRECTIONS)
    gallery = [described.pictures[PHOTO]]
    for k, other in enumerate(others):
        watch("gallery", k, len(others), other.path.name)
        gallery.append(of_photo(other, Photo(read_image(other.path)))[None])
    watch("gallery", len(others), len(others), "")
    return LikenessModel(learnt, learnt.of_photos(np.concatenate(gallery)))

"""People in two photos each go in; how surely a drawing of one is found among the other photos of all comes out."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput, NothingToDraw
from limner.pipeline import Session, Settings
from limner.storage import read_bytes
from limner.types import Face, Floats, Photo
from limner.vision.landmarks.fmp.dataset import Sample, folds, read_folder
from limner.vision.landmarks.fmp.scenes import read_image
from limner.vision.likeness.descriptor import describe
from limner.vision.likeness.discriminant import Descriptors, train_discriminant
from limner.vision.likeness.picture import drawing_picture, photo_picture, upright_from_photo
from limner.vision.refine.shape import moved

Watch = Callable[[str, int, int, str], None]
Key = tuple[str, int]
"""Style and budget [points]; 0 points stand for the photo itself."""

PHOTO: Key = ("photo", 0)
FOLDS = 5
DRAWS = 2000
"""Samples of the bootstrap."""

ALL = "all"


@dataclass(frozen=True, eq=False)
class Person:
    """Somebody in two photos.

    Attributes:
        name: of the folder and the person.
        group: what info.csv says of their skin or origin; empty where it says nothing.
        drawn: the photo that is drawn.
        sought: the other one, to be found.
    """

    name: str
    group: str
    drawn: Sample
    sought: Sample


class Figure(NamedTuple):
    """A mean over people, and its 95 % interval of the bootstrap."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Found:
    """How surely drawings of one kind find their people.

    Attributes:
        style, points: what was drawn; ``photo`` and 0 for the photo itself.
        group: of people; ``all`` for everybody.
        people: how many.
        drawn_points: mean number of points that the drawings really have.
        rank_1, rank_5: share [%] of drawings nearest to the right photo, or with it among the nearest five.
        mrr: mean of 1 / rank.
    """

    style: str
    points: int
    group: str
    people: int
    drawn_points: float
    rank_1: Figure
    rank_5: Figure
    mrr: Figure


def read_people(folder: str | Path, limit: int | None = None, seed: int = 0) -> list[Person]:
    """Everybody of a folder in the form of the London set.

    Args:
        folder: with images/ and smiling/, landmarks.npz and landmarks_smiling*.npz, and perhaps info.csv (face_id,
            face_eth).
        limit: take so many people at most, chosen by the seed.
        seed: of the choice.

    Raises:
        BadInput: a file is missing, or fewer than ten people are in both.
    """
    folder = Path(folder)
    smiling = sorted(folder.glob("landmarks_smiling*.npz"))
    if not smiling:
        raise BadInput(f"{folder}: no landmarks_smiling*.npz in it; expected a second photo of each person in smiling/")
    drawn = {sample.person: sample for sample in read_folder(folder / "landmarks.npz")[0] if sample.known.all()}
    sought = {sample.person: sample for sample in read_folder(smiling[0])[0] if sample.known[17:].all()}
    groups = read_groups(folder / "info.csv")
    names = sorted(drawn.keys() & sought.keys())
    if limit and limit < len(names):
        names = sorted(np.random.default_rng(seed).permutation(names)[:limit].tolist())
    if len(names) < 2 * FOLDS:
        raise BadInput(
            f"{folder}: {len(names)} people with both photos and all landmarks; expected {2 * FOLDS} or more"
        )
    return [Person(name, groups.get(name.rpartition("/")[2], ""), drawn[name], sought[name]) for name in names]


def read_groups(path: Path) -> dict[str, str]:
    """The group of each person by the name of his photos, from a table of face_id and face_eth; empty without one.

    Raises:
        BadInput: it is no table.
    """
    if not path.is_file():
        return {}
    try:
        text = read_bytes(path).decode("utf-8-sig")
        return {row.get("face_id") or "": row.get("face_eth") or "" for row in csv.DictReader(io.StringIO(text))}
    except (UnicodeDecodeError, csv.Error) as error:
        raise BadInput(f"{path}: is no table ({error}); expected columns face_id and face_eth") from error


def evaluate_likeness(
    people: Sequence[Person],
    styles: Sequence[str],
    points: Sequence[int],
    settings: Settings | None = None,
    watch: Watch = lambda what, done, total, note: None,
    seed: int = 0,
) -> list[Found]:
    """Match drawings of everybody with other photos of all.

    The measure knows people in general: for each style it learns from the photos and drawings of the other people
    (in five folds) what tells people apart in that style, so that none is at a loss for being strange to it. Who is
    sought is never learnt from.

    Args:
        people: to be drawn and found.
        styles: to draw in.
        points: each style is drawn with each of these budgets.
        settings: of the drawings.
        watch: told of progress.
        seed: of folds and bootstrap.

    Returns:
        First the photos themselves, then each style and budget: everybody, then each group of info.csv.
    """
    described = describe_people(people, styles, points, settings or Settings(), watch)
    rows: list[Found] = []
    groups = np.array([person.group for person in people])
    for style in (PHOTO[0], *styles):
        keys = [key for key in described.pictures if key[0] == style]
        for key, ranks in _ranks(people, described, keys, seed).items():
            for group in [ALL, *sorted(set(groups.tolist()) - {""})]:
                chosen = np.ones(len(people), bool) if group == ALL else groups == group
                rows.append(_found(key, group, ranks[chosen], float(described.points[key][chosen].mean()), seed))
    return rows


@dataclass(frozen=True, eq=False)
class Described:
    """Descriptors (people, n): of the photos sought, and of what was made of the others; and how many points it has."""

    sought: Descriptors
    pictures: dict[Key, Descriptors]
    points: dict[Key, Floats]


def describe_people(
    people: Sequence[Person], styles: Sequence[str], points: Sequence[int], settings: Settings, watch: Watch
) -> Described:
    """Draw everybody in each style and with each budget, and describe photos and drawings."""
    keys: list[Key] = [PHOTO, *((style, budget) for style in styles for budget in points)]
    pictures: dict[Key, list[Descriptors]] = {key: [] for key in keys}
    counts: dict[Key, list[int]] = {key: [] for key in keys}
    sought = []
    for k, person in enumerate(people):
        watch("drawing", k, len(people), person.name)
        sought.append(of_photo(person.sought, Photo(read_image(person.sought.path))))
        photo = Photo(read_image(person.drawn.path))
        pictures[PHOTO].append(of_photo(person.drawn, photo))
        counts[PHOTO].append(0)
        session = Session(photo)
        for key in keys[1:]:
            descriptor, count = _of_drawing(session, person.drawn, key, settings)
            pictures[key].append(descriptor)
            counts[key].append(count)
    watch("drawing", len(people), len(people), "")
    return Described(
        np.stack(sought),
        {key: np.stack(rows) for key, rows in pictures.items()},
        {key: np.array(rows, dtype=np.float64) for key, rows in counts.items()},
    )


def of_photo(sample: Sample, photo: Photo) -> Descriptors:
    """The descriptor (n,) of an annotated face."""
    upright = upright_from_photo(sample.points_px)
    return describe(photo_picture(photo, upright), moved(sample.points_px, upright))


def _of_drawing(session: Session, sample: Sample, key: Key, settings: Settings) -> tuple[Descriptors, int]:
    """The descriptor of a drawing, and its points; that of empty paper where nothing can be drawn."""
    upright = upright_from_photo(sample.points_px)
    face = Face(sample.points_px, sample.box_px)
    try:
        wanted = settings.assign("select.points", str(key[1])).assign("order.by", "given").replace(style=key[0])
        portrait = session.draw(wanted, face=face)
        lines, pen_px, count = portrait.ink_px(), portrait.pen_px, portrait.drawing.points
    except NothingToDraw:
        lines, pen_px, count = (), 1.0, 0
    return describe(drawing_picture(lines, pen_px, upright), moved(sample.points_px, upright)), count


def _ranks(
    people: Sequence[Person], described: Described, keys: Sequence[Key], seed: int
) -> dict[Key, NDArray[np.int64]]:
    """At which place (people,) each person's photo comes, 0 = first; worst place among equals."""
    ranks = {key: np.zeros(len(people), np.int64) for key in keys}
    for held_out in folds([person.drawn for person in people], FOLDS, seed):
        held = np.array([person.name in held_out for person in people])
        photos = [described.sought[~held], described.pictures[PHOTO][~held]]
        drawings = [described.pictures[key][~held] for key in keys if key != PHOTO]
        learnt = train_discriminant(photos, drawings)
        gallery = learnt.of_photos(described.sought)
        for key in keys:
            project = learnt.of_photos if key == PHOTO else learnt.of_drawings
            likeness = project(described.pictures[key][held]) @ gallery.T
            own = likeness[np.arange(held.sum()), np.flatnonzero(held)]
            ranks[key][held] = (likeness >= own[:, None]).sum(axis=1) - 1
    return ranks


def _found(key: Key, group: str, ranks: NDArray[np.int64], drawn_points: float, seed: int) -> Found:
    each = np.stack([100.0 * (ranks == 0), 100.0 * (ranks < 5), 1 / (1 + ranks)], axis=1)
    rank_1, rank_5, mrr = _figures(each, seed)
    return Found(*key, group, len(ranks), drawn_points, rank_1, rank_5, mrr)


def _figures(each: Floats, seed: int) -> list[Figure]:
    """The mean of each column; its interval by drawing rows again and again."""
    drawn = np.random.default_rng(seed).integers(0, len(each), (DRAWS, len(each)))
    low, high = np.percentile(each[drawn].mean(axis=1), [2.5, 97.5], axis=0)
    return [Figure(*three) for three in np.stack([each.mean(axis=0), low, high], axis=1).tolist()]


def to_dict(row: Found) -> dict[str, Any]:
    """A row as it stands in JSON."""
    fields: dict[str, Any] = {}
    for name, value in vars(row).items():
        plain = not isinstance(value, Figure)
        fields |= {name: value} if plain else {name: value.value, f"{name}_interval": [value.low, value.high]}
    return fields

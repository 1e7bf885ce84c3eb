"""A photo goes in, the faces that a flexible mixture of parts finds in it come out, largest first."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from limner.errors import BadInput
from limner.settings import SettingsGroup, setting
from limner.types import LANDMARK_COUNTS, Face, Floats, Photo
from limner.vision.landmarks.boxes import distinct
from limner.vision.landmarks.fmp.hog import Array, half_down
from limner.vision.landmarks.fmp.inference import Detection, SearchSettings, search
from limner.vision.landmarks.fmp.matlab import import_matlab
from limner.vision.landmarks.fmp.model import FmpModel, default_model, load_model
from limner.vision.landmarks.fmp.pyramid import FILTER
from limner.vision.landmarks.fmp.quick import search_quickly
from limner.vision.landmarks.fmp.refine import refine

NAME = "fmp"

_FIRST_SHARE = 0.2
"""Faces larger than this share of the photo's shorter side are looked for first, smaller ones only if there is none."""

_TILE_PX = 4_000_000
"""Pixels searched at once: what a photo becomes when small faces in it are enlarged is cut to tiles of about this."""

_ROOM = 1.25
"""Tiles share this much of the largest face looked for, so that each face is whole in one."""

_LEVEL_DEG = 5.0
"""Eyes tilted by less than this are level enough."""

_TURNS = 2
"""A tilted face is turned level so often: the first time its landmarks still lean towards upright."""

_SIZE_ROOM = 1.3
"""A face that was turned may be found this much larger or smaller."""


@dataclass(frozen=True)
class FmpSettings(SettingsGroup):
    """How a flexible mixture of parts looks for faces."""

    model: str = setting(
        "", "File of the face model (.npz, or .mat of Zhu & Ramanan's release); empty for the one that is shipped"
    )
    threshold: float = setting(
        0.0, "Added to the least score of a face; lower finds more faces, and more that are none", low=-10, high=10
    )
    smallest: float = setting(
        0.1, "Smallest face to look for, as a share of the photo's shorter side", low=0.01, high=1
    )
    smallest_px: float = setting(40.0, "Smallest face to look for", unit="px", low=20, high=10_000)
    interval: int | None = setting(
        None, "Sizes tried from one size to its half; not set: as the model is meant to", low=1, high=20
    )
    overlap: float = setting(
        0.3, "Of two faces that share more than this of either's area the better one stays", low=0, high=1
    )
    refine: int = setting(
        3,
        "Sizes around the found one that landmarks are placed at, between the cells, and averaged;"
        " 0 leaves them on whole cells",
        low=0,
        high=9,
    )
    precision: str = setting("float32", "Numbers computed with", choices=("float32", "float64"))
    exact: bool = setting(
        False,
        "Match all parts everywhere, not only where a face is likely: two to four times slower, seldom finds more",
    )
    tilt: float = setting(
        20.0,
        "Where no upright face is found, look again with the photo turned by this either way; 0: never",
        unit="deg",
        low=0,
        high=90,
    )


def detect(photo: Photo, settings: FmpSettings) -> tuple[Face, ...]:
    """Find the faces, the large ones first, smaller ones only where there is none.

    Each range of sizes is searched in a copy of the photo just large enough for the smallest of them, so that neither
    time nor memory depends on how many pixels the photo has. Tilted faces are looked for where there is no upright one.

    Raises:
        BadInput: no usable model.
    """
    model = model_of(settings.model)
    for turns in ((0.0,), (settings.tilt, -settings.tilt)) if settings.tilt else ((0.0,),):
        for small, large in _ranges_px(photo, settings):
            copies = (
                _turned(copy, turn) for copy in _copies(photo, model.smallest_face_px / small, large) for turn in turns
            )
            scales = (0, model.cell_px * large / small)
            if faces := [face for copy in copies for face in _faces(copy, model, scales, settings)]:
                return distinct(faces, settings.overlap)
    return ()


def _faces(copy: _Copy, model: FmpModel, scale_range_px: tuple[float, float], settings: FmpSettings) -> Iterator[Face]:
    for detection in _search(copy, model, scale_range_px, settings):
        straight, found = _straightened(copy, detection, model, settings)
        yield _face(_refined(straight.picture, found, model, settings), model, straight.photo_from_copy)


def _search(
    copy: _Copy,
    model: FmpModel,
    scale_range_px: tuple[float, float],
    settings: FmpSettings,
    most: int | None = None,
) -> list[Detection]:
    """The faces in a copy; no more than ``most`` are needed."""
    wanted = SearchSettings(
        model.threshold + settings.threshold, settings.interval, settings.precision, scale_range_px, settings.overlap
    )
    if settings.exact:
        return search(copy.picture, model, wanted)
    return search_quickly(copy.picture, model, wanted, most)


def _straightened(copy: _Copy, found: Detection, model: FmpModel, settings: FmpSettings) -> tuple[_Copy, Detection]:
    """The surroundings of a tilted face, turned so that its eyes are level, and the face in them.

    The filters know upright faces: one that is tilted is found, but its landmarks are off. A face that is not found
    better once it is turned is left as it was.
    """
    around = copy
    for _ in range(_TURNS):
        tilt = _tilt_deg(found, model)
        if abs(tilt) < _LEVEL_DEG:
            break
        turned = _surroundings(around, found, -tilt)
        sizes = (found.scale_px / _SIZE_ROOM, found.scale_px * _SIZE_ROOM)
        again = _search(turned, model, sizes, settings, most=1)
        best = max(again, key=lambda detection: detection.score, default=found)
        if best.score <= found.score:
            break
        around, found = turned, best
    return around, found


def _tilt_deg(found: Detection, model: FmpModel) -> float:
    """How far the line through both eyes is turned clockwise; 0 for a profile."""
    landmarks = model.components[found.component].landmarks
    if len(landmarks) != 68:
        return 0.0
    points = np.empty_like(found.points_px)
    points[landmarks] = found.points_px
    right, left = points[36:42].mean(0), points[42:48].mean(0)
    return math.degrees(math.atan2(left[1] - right[1], left[0] - right[0]))


def _surroundings(copy: _Copy, found: Detection, angle_deg: float) -> _Copy:
    """The face and as much again around it, turned clockwise about its middle."""
    low, high = found.points_px.min(axis=0), found.points_px.max(axis=0)
    reach = (high - low).max()
    x0, y0 = np.maximum(np.floor((low + high) / 2 - reach), 0).astype(int)
    x1, y1 = np.ceil((low + high) / 2 + reach).astype(int) + 1
    shift = np.array([[1.0, 0, x0], [0, 1, y0], [0, 0, 1]])
    return _turned(_Copy(copy.picture[y0:y1, x0:x1], copy.photo_from_copy @ shift), angle_deg)


def looked_for(photo: Photo, settings: FmpSettings) -> str:
    """What ``detect`` looked for, for the message when there is none."""
    model = model_of(settings.model)
    yaws = sorted({component.yaw_deg for component in model.components})
    view = "frontal" if yaws == [0] else f"turned {yaws[0]:+g} to {yaws[-1]:+g} degrees"
    small = _smallest_px(photo, settings)
    if small > min(photo.size_px):
        return f"{view} faces of {small:.0f} px or more, but the photo is {photo.size_px[0]} x {photo.size_px[1]} px"
    return f"{view} faces of {small:.0f} px or more with a score of at least {model.threshold + settings.threshold:.3g}"


def model_of(path: str) -> FmpModel:
    """The face model of a file, .npz or .mat; the shipped one where the name is empty.

    Raises:
        BadInput: unreadable, or of another number of parts.
        MissingExtra: a .mat file, and scipy is not installed.
    """
    if not path:
        return default_model()
    model = import_matlab(path) if path.lower().endswith(".mat") else load_model(path)
    for component in model.components:
        if len(component.parents) not in LANDMARK_COUNTS:
            raise BadInput(f"{path}: a face model of {len(component.parents)} parts; expected 68 or 39")
    return model


def _smallest_px(photo: Photo, settings: FmpSettings) -> float:
    return max(settings.smallest_px, settings.smallest * min(photo.size_px))


def _ranges_px(photo: Photo, settings: FmpSettings) -> Iterator[tuple[float, float]]:
    """From where to where the size of a face is looked for at a time: from large to small, each half the last."""
    smallest, side = _smallest_px(photo, settings), min(photo.size_px)
    large, small = math.inf, max(smallest, _FIRST_SHARE * side)
    while small <= side and large > smallest:
        yield small, large
        large, small = small, max(smallest, small / 2)


@dataclass(frozen=True, eq=False)
class _Copy:
    """A part of the photo at another size, perhaps turned.

    Attributes:
        picture: (h, w, 3) float32, 0..255.
        photo_from_copy: (2, 3) from its pixels x, y to those of the photo.
    """

    picture: Array
    photo_from_copy: Floats


def _copies(photo: Photo, scale: float, largest_px: float) -> Iterator[_Copy]:
    """The photo at another size; in tiles that share enough for faces of ``largest_px`` where that is too large."""
    shared = _ROOM * min(largest_px, *photo.size_px)
    side = max(2 * shared, math.sqrt(_TILE_PX) / scale)
    whole = photo.size_px[0] * photo.size_px[1] * scale**2 <= _TILE_PX
    columns, rows = ([(0, length)] if whole else list(_cuts(length, side, shared)) for length in photo.size_px)
    for (top, bottom), (left, right) in itertools.product(rows, columns):
        yield _scaled(photo.rgb[top:bottom, left:right], scale, (left, top))


def _cuts(length: int, side: float, shared: float) -> Iterator[tuple[int, int]]:
    """First and last pixel (exclusive) of as few equal pieces as can be, ``side`` long at most, that share enough."""
    count = max(1, math.ceil((length - shared) / (side - shared)))
    step = (length - shared) / count
    for k in range(count):
        yield math.floor(k * step), min(length, math.ceil(k * step + step + shared))


def _scaled(rgb: Array, scale: float, corner: tuple[int, int]) -> _Copy:
    """A part of the photo at another size, and how it lies in the photo, where its first pixel is at ``corner``."""
    height, width = (max(1, half_down(length * scale)) for length in rgb.shape[:2])
    way = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    planes = [
        cv2.resize(rgb[..., channel].astype(np.float32), (width, height), interpolation=way) for channel in range(3)
    ]
    pixel = np.array(rgb.shape[1::-1]) / (width, height)
    return _Copy(cv2.merge(planes), np.column_stack([np.diag(pixel), 0.5 * pixel - 0.5 + corner]))


def _turned(copy: _Copy, angle_deg: float) -> _Copy:
    """The copy turned clockwise about its middle, in a frame of the same size; beyond its border its edge repeats."""
    if angle_deg == 0:
        return copy
    height, width = copy.picture.shape[:2]
    middle = ((width - 1) / 2, (height - 1) / 2)
    turn = cv2.getRotationMatrix2D(middle, -angle_deg, 1.0)
    picture = cv2.warpAffine(copy.picture, turn, (width, height), borderMode=cv2.BORDER_REPLICATE)
    back = np.vstack([cv2.invertAffineTransform(turn), [0, 0, 1]])
    return _Copy(picture, copy.photo_from_copy @ back)


def _refined(picture: Array, detection: Detection, model: FmpModel, settings: FmpSettings) -> Detection:
    if settings.refine == 0:
        return detection
    points = refine(picture, detection, model, settings.refine, settings.precision)
    return dataclasses.replace(detection, points_px=points)


def _face(detection: Detection, model: FmpModel, photo_from_copy: Floats) -> Face:
    """The detection in the photo."""
    component = model.components[detection.component]
    centres = detection.points_px @ photo_from_copy[:, :2].T + photo_from_copy[:, 2]
    half = FILTER / 2 * detection.scale_px * math.sqrt(abs(np.linalg.det(photo_from_copy[:, :2])))
    points = np.empty_like(centres)
    points[component.landmarks] = centres
    box = np.concatenate([centres.min(axis=0) - half, centres.max(axis=0) + half])
    return Face(points, box, detection.score, component.yaw_deg, NAME)

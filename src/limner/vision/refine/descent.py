"""A grey face and landmarks near the truth go in; landmarks nearer to it come out, by a cascade of linear steps.

Supervised descent (Xiong & De la Torre 2013, doi:10.1109/CVPR.2013.75): each step looks at the slopes around every
landmark, and one linear map, learnt from annotated faces, turns what it sees into a move of all landmarks together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np

from limner.errors import BadInput
from limner.storage import pack_npz, unpack_npz, write_whole
from limner.types import Floats, Value, frozen_array
from limner.vision.raster import Image, blurred, widely_blurred
from limner.vision.refine.shape import inverse, moved, similarity

DIRECTIONS = 8
"""Of slope that are told apart."""

_EDGE_BLUR_PX = 0.8
_LIGHT = 0.13  # sigma, in outer-eye distances, of the surroundings against which a slope is measured
_LEAST_SLOPE = 2.0  # grey levels per px; less is noise
_TAIL = 2.5  # sigmas after which a blur ends; OpenCV's own 4 take half as long again
_CAP = 0.3  # of one value in a landmark's view, as in SIFT, so that one strong edge does not hide the rest
_BESIDE, _ABOVE, _BELOW = 1.5, 1.15, 2.05  # what is seen, in outer-eye distances from between the eyes


@dataclass(frozen=True)
class Look:
    """How one step of the cascade looks at a face.

    Attributes:
        unit_px: outer-eye distance to which the face is brought [px].
        blur: of the slopes [outer-eye distances].
        step: between the places of the square grid around each landmark [outer-eye distances].
        side: places along a side of that grid.
    """

    unit_px: float
    blur: float
    step: float
    side: int

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of the picture that is looked at, both even."""
        return 2 * round(_BESIDE * self.unit_px), 2 * round((_ABOVE + _BELOW) / 2 * self.unit_px)

    def place(self, mean: Floats) -> Floats:
        """A mean face (68, 2) (outer-eye distance 1, origin between the eyes) in that picture."""
        placed: Floats = self.unit_px * (mean + np.array([_BESIDE, _ABOVE]))
        return placed

    @cached_property
    def offsets_px(self) -> Floats:
        """The grid (side^2, 2) around a landmark."""
        along = (np.arange(self.side) - (self.side - 1) / 2) * self.step * self.unit_px
        return np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)


LOOKS = (Look(48, 0.06, 0.12, 4), Look(64, 0.045, 0.09, 4), Look(96, 0.03, 0.06, 4), Look(96, 0.025, 0.045, 4))
"""From far to near."""


@dataclass(frozen=True, eq=False)
class Step(Value):
    """One linear map of the cascade, kept as a product of two.

    Attributes:
        look: what it is applied to.
        basis: (views, rank) float32.
        mix: (rank, 136) float32.
        bias: (136,) float32; moves are in outer-eye distances.
    """

    look: Look
    basis: Image
    mix: Image
    bias: Image

    def __post_init__(self) -> None:
        views = 68 * self.look.side**2 * DIRECTIONS
        self._freeze("basis", frozen_array(self.basis, np.float32, (views, None), "descent: basis"))
        self._freeze("mix", frozen_array(self.mix, np.float32, (self.basis.shape[1], 136), "descent: mix"))
        self._freeze("bias", frozen_array(self.bias, np.float32, (136,), "descent: bias"))

    def move(self, view: Image) -> Floats:
        """How far (68, 2) the landmarks should go."""
        return np.asarray(view @ self.basis @ self.mix + self.bias, np.float64).reshape(68, 2)


@dataclass(frozen=True, eq=False)
class Descent(Value):
    """A learnt cascade.

    Attributes:
        mean: (68, 2) the mean face, outer-eye distance 1, origin between the outer eye corners.
        steps: of the cascade, in order.
    """

    mean: Floats
    steps: tuple[Step, ...]

    def __post_init__(self) -> None:
        self._freeze("mean", frozen_array(self.mean, np.float64, (68, 2), "descent: mean"))

    def run(self, pictures: Pictures, points: Floats) -> Floats:
        """Follow the cascade from landmarks (68, 2) to better ones, all in the pixels of the picture.

        Raises:
            BadInput: all landmarks are one point.
        """
        for step in self.steps:
            points = after_step(pictures, points, self.mean, step)
        return points


@dataclass(frozen=True, eq=False)
class Pictures:
    """A grey picture and its half, from which every look takes the one nearer to its size.

    Attributes:
        image: (H, W) float32.
    """

    image: Image

    @cached_property
    def half(self) -> Image:
        """The picture at half its size."""
        height, width = self.image.shape
        size = max(1, (width + 1) // 2), max(1, (height + 1) // 2)
        return np.asarray(cv2.resize(self.image, size, interpolation=cv2.INTER_AREA), np.float32)

    def warped(self, affine: Floats, size_px: tuple[int, int]) -> Image:
        """The picture after an affine map (2, 3) of its pixels, its border continued."""
        image = self.image
        if abs(np.linalg.det(affine[:, :2])) < 0.36:
            (height, width), image = image.shape, self.half
            x, y = width / image.shape[1], height / image.shape[0]
            affine = np.column_stack(
                [affine[:, :2] * [x, y], affine[:, 2] + affine[:, :2] @ [x / 2 - 0.5, y / 2 - 0.5]]
            )
        warped = cv2.warpAffine(image, affine, size_px, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(warped, np.float32)


def after_step(pictures: Pictures, points: Floats, mean: Floats, step: Step) -> Floats:
    """Landmarks (68, 2) after one step."""
    affine = similarity(points, step.look.place(mean))
    return stepped(points, affine, view(pictures, points, affine, step.look), step)


def stepped(points: Floats, affine: Floats, seen: Image, step: Step) -> Floats:
    """Landmarks (68, 2) after one step that saw ``seen`` of them in the picture to which ``affine`` brings them."""
    return moved(moved(points, affine) + step.move(seen) * step.look.unit_px, inverse(affine))


def view(pictures: Pictures, points: Floats, affine: Floats, look: Look) -> Image:
    """What a look sees (views,) around landmarks (68, 2) of the picture, which ``affine`` brings to its own."""
    slopes = _slopes(pictures.warped(affine, look.size_px), look)
    height, width = slopes.shape[:2]
    places = (moved(points, affine)[:, None] + look.offsets_px).reshape(-1, 2)
    places = (places + 0.5) / 2 - 0.5  # to the pixels of the slopes
    places = np.clip(places, 0, [width - 1.001, height - 1.001])
    corner = places.astype(np.intp)
    x, y = (places - corner).astype(np.float32).T[..., None]
    flat, first = slopes.reshape(-1, DIRECTIONS), corner[:, 1] * width + corner[:, 0]
    above = flat[first] * (1 - x) + flat[first + 1] * x
    below = flat[first + width] * (1 - x) + flat[first + width + 1] * x
    seen = (above * (1 - y) + below * y).reshape(68, -1)
    seen /= np.sqrt((seen**2).sum(axis=1, keepdims=True) + np.float32(1e-3))
    return np.asarray(np.minimum(seen, np.float32(_CAP)).ravel(), np.float32)


def _slopes(image: Image, look: Look) -> Image:
    """How steeply the picture rises in each direction (H / 2, W / 2, directions), over how steep it is around.

    The blur takes away what half the pixels could not hold.
    """
    smooth = blurred(image, _EDGE_BLUR_PX)
    x, y = cv2.Sobel(smooth, cv2.CV_32F, 1, 0, scale=1 / 8), cv2.Sobel(smooth, cv2.CV_32F, 0, 1, scale=1 / 8)
    around = widely_blurred(np.asarray(x * x + y * y, np.float32), _LIGHT * look.unit_px)
    gain = 1 / np.sqrt(around + np.float32(_LEAST_SLOPE**2))
    x, y = x * gain, y * gain
    turns = 2 * np.pi / DIRECTIONS * np.arange(DIRECTIONS)
    rising = [np.maximum(x * np.float32(np.cos(turn)) + y * np.float32(np.sin(turn)), 0) for turn in turns]
    half = image.shape[1] // 2, image.shape[0] // 2
    rising = [cv2.resize(each, half, interpolation=cv2.INTER_AREA) for each in rising]
    sigma = look.blur * look.unit_px / 2
    side = 2 * math.ceil(_TAIL * sigma) + 1
    blurry = [cv2.GaussianBlur(each, (side, side), sigma, borderType=cv2.BORDER_REPLICATE) for each in rising]
    return np.asarray(cv2.merge(blurry), np.float32)


def save_descent(model: Descent, path: str | Path) -> None:
    """Write a cascade as .npz, its large maps in 8 bits."""
    arrays = {
        "mean": model.mean.astype(np.float32),
        "looks": np.array([(s.look.unit_px, s.look.blur, s.look.step, s.look.side) for s in model.steps]),
    }
    for k, step in enumerate(model.steps):
        scale = np.maximum(np.abs(step.basis).max(axis=0), 1e-12) / 127
        arrays[f"basis{k}"] = np.rint(step.basis / scale).astype(np.int8)
        arrays[f"mix{k}"] = (step.mix * scale[:, None]).astype(np.float32)
        arrays[f"bias{k}"] = step.bias
    write_whole(path, pack_npz(arrays))


def unpacked(data: bytes, name: str) -> Descent:
    """The cascade from the bytes of its file.

    Raises:
        BadInput: no such model.
    """
    arrays = unpack_npz(data, name)
    try:
        looks = [Look(float(u), float(b), float(d), int(n)) for u, b, d, n in arrays["looks"]]
        steps = tuple(
            Step(look, arrays[f"basis{k}"], arrays[f"mix{k}"], arrays[f"bias{k}"]) for k, look in enumerate(looks)
        )
        return Descent(arrays["mean"], steps)
    except (KeyError, TypeError, ValueError) as error:
        raise BadInput(f"{name}: no model of `limner train best` ({error})") from error

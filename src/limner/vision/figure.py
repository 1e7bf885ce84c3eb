"""A photo and its face go in; the person in it, and skin, hair, beard and clothes, come out as masks."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import cv2
import numpy as np

from limner.settings import SettingsGroup, setting
from limner.types import Face, Photo, Value, frozen_array
from limner.vision.head import LIPS, face_outline
from limner.vision.raster import Image, Mask, blurred, dilated, filled, pieces, resized
from limner.vision.segment import colours, places
from limner.vision.segment.cut import cut
from limner.vision.segment.ground import smooth_ground
from limner.vision.segment.texture import texture

SMALL_OUTER_EYE_PX = 32.0
"""Size of the face at which the person is found [px]: finer than this is single hairs."""

REACH = 0.04
"""How far the border moves to the nearest edge when seen in full size [outer-eye distances]."""

SLIMMEST = 1.2
"""Width of the narrowest head that goes up to the top of the picture [outer-eye distances]."""

SPUR_PX = 4
"""Radius of the smallest disc that fits everywhere into head and body, in the small copy [px]."""

BEARD_SHARE = 0.6
"""A beard is darker than this share of the skin's lightness."""

LEAST_BEARD = 0.12
"""Part of either half of the lower face that a beard covers at least; less, or on one side only, is shadow."""


@dataclass(frozen=True)
class FigureSettings(SettingsGroup):
    """How the person is told from the background."""

    trust: float = setting(
        8.0, "how much colours and places count against a short outline along edges", low=0.1, high=1000
    )
    smooth: float = setting(
        0.03, "bays and bumps of the outline smaller than this go", unit="outer-eye distances", low=0.001, high=0.5
    )


@dataclass(frozen=True, eq=False)
class Figure(Value):
    """The person in a photo; skin, hair and body make up the figure and do not overlap.

    Attributes:
        figure: (H, W) bool, all of the person: head, hair, hat, neck, shoulders.
        skin: (H, W) bool, face with eyes, lips and beard, ears, neck.
        hair: (H, W) bool, hair of the head and what covers it: hat, scarf.
        body: (H, W) bool, clothes, and what else is below the neck.
        beard: (H, W) bool, the part of the skin that moustache and beard darken.
    """

    figure: Mask
    skin: Mask
    hair: Mask
    body: Mask
    beard: Mask

    def __post_init__(self) -> None:
        shape = np.shape(self.figure)
        for field in dataclasses.fields(self):
            value = frozen_array(getattr(self, field.name), np.bool_, shape, f"Figure.{field.name}")
            self._freeze(field.name, value)


def find_figure(photo: Photo, face: Face, settings: FigureSettings) -> Figure:
    """Tell the person from the background, and the parts of the person from each other.

    Places around the face say first what is likely where, and where the ground runs on smoothly from the upper corners
    (``segment.ground``); each part and the background then learn their colours and textures and every pixel is judged
    again (``segment.colours``); a minimum cut makes one mask of it (``segment.cut``), all on a small copy. The border
    is moved to the edges of the full picture by a guided filter (He, Sun & Tang 2013, doi:10.1109/TPAMI.2012.213).

    Args:
        photo: at the working scale.
        face: a frontal face in it.
        settings: of the cut and its outline.

    Returns:
        Masks of the photo's size. The face within its landmarks always belongs to the figure.

    Raises:
        BadInput: a profile, or both outer eye corners are one point.
    """
    small, small_face = _small(photo, face)
    shape = small.rgb.shape[:2]
    certain = places.inside_face(small_face, shape)
    lab = colours.lab_of(small)
    seen = colours.normalized(lab)
    rough = texture(photo, small.size_px, face.outer_eye_px)
    likely = colours.likely_parts(
        seen,
        rough,
        places.with_ground(places.likely_places(small_face, shape), smooth_ground(lab, small_face, rough)),
        certain,
        places.features(small_face, shape),
        places.above_eyes(small_face, shape),
    )
    mask = cut(1 - likely[0], seen, certain, settings.trust)
    mask = _one_piece(_without_spurs(mask & ~_columns(mask, small_face)) | certain, certain)
    figure = _fine(mask, photo, settings.smooth * face.outer_eye_px, REACH * face.outer_eye_px)
    figure |= places.inside_face(face, figure.shape)
    skin, hair, body = (resized(blurred(one, 1.0), photo.size_px) for one in likely[1:])
    bare = figure & (skin >= hair) & (skin >= body)
    covered = figure & ~bare & (hair >= body)
    return Figure(figure, bare, covered, figure & ~bare & ~covered, _beard(photo, face, bare))


def _small(photo: Photo, face: Face) -> tuple[Photo, Face]:
    """Photo and face with the outer eye corners ``SMALL_OUTER_EYE_PX`` apart."""
    scale = SMALL_OUTER_EYE_PX / face.outer_eye_px
    size = max(1, round(photo.size_px[0] * scale)), max(1, round(photo.size_px[1] * scale))
    rgb = np.asarray(cv2.resize(photo.rgb, size, interpolation=cv2.INTER_AREA), np.uint8)
    points = (face.points_px + 0.5) * np.array(size) / photo.size_px - 0.5
    return Photo(rgb.reshape(size[1], size[0], 3)), dataclasses.replace(face, points_px=points)


def _columns(mask: Mask, face: Face) -> Mask:
    """What rises (H, W) from the head to the top of the picture and is slimmer than any head: background."""
    brows = max(0, round(float(face.points_px[17:27, 1].min())))
    upper = mask[:brows].astype(np.uint8)
    columns = np.zeros_like(mask)
    if upper.size:
        width = 2 * round(SLIMMEST * face.outer_eye_px / 2) + 1
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width))
        wide = np.asarray(cv2.morphologyEx(upper, cv2.MORPH_OPEN, disc, borderType=cv2.BORDER_REPLICATE)) > 0
        _, labels = pieces((upper > 0) & ~wide)
        columns[:brows] = np.isin(labels, np.unique(labels[0][labels[0] > 0]))
    return columns


def _without_spurs(mask: Mask) -> Mask:
    """The mask without arms slimmer than twice ``SPUR_PX``: rails and branches that touch the head."""
    edge = 2 * SPUR_PX + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (edge, edge))
    padded = np.pad(mask.astype(np.uint8), edge, mode="edge")
    wide = np.asarray(cv2.morphologyEx(padded, cv2.MORPH_OPEN, disc))[edge:-edge, edge:-edge] > 0
    return mask & dilated(wide, SPUR_PX // 2)


def _one_piece(mask: Mask, certain: Mask) -> Mask:
    """What hangs together with the face, without holes."""
    _, labels = pieces(mask)
    mask = mask & np.isin(labels, np.unique(labels[certain & mask]))
    _, labels = pieces(~mask)
    outside = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]]))
    return ~np.isin(labels, outside[outside > 0])


def _fine(mask: Mask, photo: Photo, smooth_px: float, reach_px: float) -> Mask:
    """A small mask in the photo's size, its border on the photo's edges and smooth."""
    grey = np.asarray(cv2.cvtColor(photo.rgb, cv2.COLOR_RGB2GRAY), np.float32) / np.float32(255)
    soft = resized(mask.astype(np.float32), photo.size_px)
    side = 2 * max(1, round(reach_px)) + 1

    def mean(image: Image) -> Image:
        return np.asarray(cv2.blur(image, (side, side), borderType=cv2.BORDER_REPLICATE), np.float32)

    mean_soft, mean_grey = mean(soft), mean(grey)
    slope = (mean(soft * grey) - mean_soft * mean_grey) / (mean(grey * grey) - mean_grey**2 + np.float32(1e-3))
    guided = mean(slope) * grey + mean(mean_soft - slope * mean_grey)
    fine: Mask = blurred(guided, max(smooth_px, 0.1)) > 0.5
    return fine


def _beard(photo: Photo, face: Face, skin: Mask) -> Mask:
    """The dark part of the lower face, lips left out; nothing where it is little."""
    unit, marks = face.outer_eye_px, face.points_px
    lower = np.concatenate([marks[[1, 31, 33, 35, 15]], marks[14:1:-1]])
    shape = skin.shape
    below = filled(lower, shape) & skin & ~filled(marks[LIPS], shape)
    bare = filled(face_outline(face), shape) & skin & ~filled(lower, shape)
    if not below.any() or not bare.any():
        return np.zeros(shape, bool)
    light = np.asarray(cv2.cvtColor(photo.rgb, cv2.COLOR_RGB2GRAY), np.float32)
    dark: Mask = below & (blurred(light, 0.02 * unit) < BEARD_SHARE * float(np.median(light[bare])))
    left = np.arange(shape[1]) < marks[33, 0]
    sides = [(dark & side).sum() >= LEAST_BEARD * max((below & side).sum(), 1) for side in (left, ~left)]
    return dark if all(sides) else np.zeros(shape, bool)

"""How well an arm reaches the places of a table goes in; a picture of it, with the sheet on it, comes out."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image, ImageDraw

from limner.types import Floats

_BEYOND = (236, 236, 236)
_POOR, _GOOD = np.array([250, 214, 165.0]), np.array([38, 120, 110.0])


def to_png(
    margin_rad: Floats, x_m: Floats, y_m: Floats, sheet_m: Floats, title: str, pixels_per_m: float = 500.0
) -> bytes:
    """A map of one height: the darker, the farther the joints stay from their limits; grey: not reached.

    Args:
        margin_rad: (ny, nx) distance to the nearest limit, negative or -inf where not reached.
        x_m: (nx,) ascending, in the base frame.
        y_m: (ny,) ascending.
        sheet_m: (n, 2) outline of the sheet in the base frame.
        title: a line above the map.
        pixels_per_m: scale.
    """
    good = np.clip(margin_rad / np.radians(45), 0, 1)[..., None]
    colours = np.where(margin_rad[..., None] > 0, _POOR + good * (_GOOD - _POOR), _BEYOND).astype(np.uint8)
    step = float(x_m[1] - x_m[0]) if len(x_m) > 1 else 0.05
    size = (round(len(x_m) * step * pixels_per_m), round(len(y_m) * step * pixels_per_m))
    top = 28
    image = Image.new("RGB", (max(size[0], 200), size[1] + top), "white")
    # y points up in the base frame and down in the picture.
    image.paste(Image.fromarray(colours[::-1]).resize(size, Image.Resampling.NEAREST), (0, top))
    draw = ImageDraw.Draw(image)

    def at(points: Floats) -> list[tuple[float, float]]:
        x = (points[:, 0] - x_m[0] + step / 2) * pixels_per_m
        y = top + size[1] - (points[:, 1] - y_m[0] + step / 2) * pixels_per_m
        return list(zip(x.tolist(), y.tolist(), strict=True))

    draw.polygon(at(sheet_m), outline=(20, 20, 20), fill=None, width=2)
    (x0, y0), *_ = at(np.zeros((1, 2)))
    draw.line([(x0 - 8, y0), (x0 + 8, y0)], fill=(200, 30, 30), width=2)
    draw.line([(x0, y0 - 8), (x0, y0 + 8)], fill=(200, 30, 30), width=2)
    draw.text((4, 6), title, fill=(20, 20, 20))
    data = io.BytesIO()
    image.save(data, "PNG")
    return data.getvalue()

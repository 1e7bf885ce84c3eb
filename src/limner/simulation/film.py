"""A simulated drawing goes in; a film of the arm drawing it comes out, as GIF or MP4, made without a graphics card."""

from __future__ import annotations

import io
from collections.abc import Iterator

import cv2
import numpy as np
from PIL import Image

from limner.simulation.ink import widths
from limner.simulation.outcome import Simulation
from limner.simulation.render import Camera, Picture, Scene
from limner.targets.movie import HOLD_S, encode_mp4
from limner.types import Floats, Pen, Photo

RATE = {".gif": 10, ".mp4": 25}
"""Pictures per second."""

SIZE_PX = (560, 480)
"""Of the scene; the sheet stands beside it."""

_PAPER_PX_PER_MM = 6.0
_SHIFT = 4


def to_film(made: Simulation, pen: Pen, suffix: str, seconds: float = 12.0, photo: Photo | None = None) -> bytes:
    """The film as a file that ends in ``suffix``, .gif or .mp4, with the photo at its left if there is one.

    Raises:
        BadInput: this OpenCV cannot write MP4.
    """
    rate = RATE[suffix]
    pictures = frames(made, pen, max(2, round(seconds * rate)), photo)
    return encode_mp4(pictures, rate) if suffix == ".mp4" else _gif(list(pictures), rate)


def _gif(pictures: list[Picture], rate: int) -> bytes:
    """One palette for all, from a picture of the middle, so that nothing flickers."""
    palette = Image.fromarray(pictures[len(pictures) // 2]).quantize(128, dither=Image.Dither.NONE)
    indexed = [Image.fromarray(one).quantize(palette=palette, dither=Image.Dither.NONE) for one in pictures]
    durations = [1000 // rate] * (len(indexed) - 1) + [int(1000 * HOLD_S)]
    data = io.BytesIO()
    indexed[0].save(data, "GIF", save_all=True, append_images=indexed[1:], duration=durations, loop=0)
    return data.getvalue()


def frames(made: Simulation, pen: Pen, count: int, photo: Photo | None = None) -> Iterator[Picture]:
    """Pictures (H, W, 3) at even times: the photo if there is one, the arm, its sheet from above."""
    left = _photo_panel(photo) if photo is not None else np.zeros((SIZE_PX[1], 0, 3), np.uint8)
    page = made.paper.page
    paper = np.full(
        (round(page.height_mm * _PAPER_PX_PER_MM), round(page.width_mm * _PAPER_PX_PER_MM), 3), 255, np.uint8
    )
    scene = Scene(made.robot, made.paper, camera(made))
    place = made.ink.place_mm * [1, -1] * _PAPER_PX_PER_MM + [0, page.height_mm * _PAPER_PX_PER_MM]
    fixed = np.rint(place * 2**_SHIFT).astype(np.int32)
    width = np.maximum(1, np.rint(widths(made.ink.force_n, pen.width_mm) * _PAPER_PX_PER_MM)).astype(int)
    done = 1
    for k in np.linspace(0, len(made.ink.t_s) - 1, count).astype(int):
        for i in range(done, k + 1):
            if made.ink.touches[i]:
                cv2.line(
                    paper, fixed[i - 1].tolist(), fixed[i].tolist(), (25, 25, 30), int(width[i]), cv2.LINE_AA, _SHIFT
                )
        done = max(done, k + 1)
        view = scene.picture(made.record.q[k], made.record.tip_m[k], paper)
        right = _beside(view, paper, place[k], made, int(k))
        yield np.ascontiguousarray(np.concatenate([left, right], axis=1))


def _photo_panel(photo: Photo) -> Picture:
    height, room = SIZE_PX[1], SIZE_PX[1] - 70
    scale = min(room / photo.rgb.shape[0], 340 / photo.rgb.shape[1])
    small = cv2.resize(photo.rgb, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    # Films are coded in pairs of columns.
    panel = np.full((height, (small.shape[1] + 41) // 2 * 2, 3), 246, np.uint8)
    top = (room - small.shape[0]) // 2 + 20
    panel[top : top + small.shape[0], 20 : 20 + small.shape[1]] = small
    return panel


def camera(made: Simulation) -> Camera:
    """A place from which arm and sheet are both seen, in front of the sheet and to its side."""
    q = made.trajectory.q[made.trajectory.down]
    joints = made.robot.frames(q)[:, 1:, :3, 3].reshape(-1, 3)
    page = made.paper.page
    sheet = made.paper.points_m(
        np.array([[0.0, 0.0], [page.width_mm, 0], [page.width_mm, page.height_mm], [0, page.height_mm]])
    )
    seen = np.concatenate([joints, sheet])
    middle = 0.5 * (seen.min(0) + seen.max(0)) + 0.5 * (sheet.mean(0) - joints.mean(0)) * 0.3
    size = float(np.linalg.norm(np.ptp(seen, axis=0)))
    # From beyond the sheet, as seen from the robot's base, and a little aside.
    out = sheet.mean(0)[:2] - joints[:, :2].mean(0)
    out = out / max(float(np.linalg.norm(out)), 1e-6)
    aside = np.array([-out[1], out[0]])
    direction = np.array([*(0.8 * out + 0.55 * aside), 0.62])
    return Camera.looking(middle + 1.75 * size * direction / np.linalg.norm(direction), middle, 42.0, SIZE_PX)


def _beside(view: Picture, paper: Picture, tip_px: Floats, made: Simulation, k: int) -> Picture:
    height = view.shape[0]
    room = height - 70
    scale = min(room / paper.shape[0], 340 / paper.shape[1])
    small = cv2.resize(paper, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    down = bool(made.ink.touches[k])
    colour = (200, 40, 30) if down else (150, 170, 200)
    cv2.circle(small, np.rint(tip_px * scale * 16).astype(int).tolist(), 4 * 16, colour, cv2.FILLED, cv2.LINE_AA, 4)
    panel = np.full((height, small.shape[1] + 40, 3), 246, np.uint8)
    top = (room - small.shape[0]) // 2 + 20
    panel[top : top + small.shape[0], 20 : 20 + small.shape[1]] = small
    cv2.rectangle(panel, (19, top - 1), (20 + small.shape[1], top + small.shape[0]), (205, 205, 205), 1)
    told = f"{made.ink.t_s[k]:5.1f} s   {made.ink.force_n[k]:4.2f} N"
    cv2.putText(panel, told, (20, height - 20), cv2.FONT_HERSHEY_SIMPLEX, 0.55, (60, 60, 66), 1, cv2.LINE_AA)
    both = np.concatenate([view, panel], axis=1)
    return np.ascontiguousarray(both[:, : both.shape[1] // 2 * 2])

"""A robot's pose, the sheet and its ink go in; a picture of the scene comes out, drawn without a graphics card."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from limner import transforms
from limner.motion.arm.robot import Capsule, Robot
from limner.simulation.sheet import Sheet
from limner.types import Floats

Picture = NDArray[np.uint8]
Shape = tuple[Floats, Floats, float, tuple[int, int, int]]
"""Both ends of a capsule in the base frame, its radius and its colour."""

_FINE = 2
_SHRINK = 0.3
"""Of the sheet's picture before it is laid into the scene, where thin lines would break up."""

_SKY, _TABLE, _STILL = (236, 239, 243), (205, 196, 182), (150, 155, 163)
_LINKS = ((74, 96, 122), (222, 225, 230))
"""Colours of links, by turns; the last link holds the pen and is of the accent's."""
_ACCENT = (214, 96, 46)
_SUN = np.array([-0.35, -0.5, 0.79])
_TABLE_M = 0.8
_TABLE_PX_PER_M = 500


@dataclass(frozen=True)
class Camera:
    """Where the scene is seen from: a pinhole.

    Attributes:
        camera_from_base: (4, 4), x right, y down, z ahead [m].
        focal_px: distance of the picture.
        size_px: width and height.
    """

    camera_from_base: Floats
    focal_px: float
    size_px: tuple[int, int]

    @classmethod
    def looking(cls, from_m: Floats, at_m: Floats, view_deg: float, size_px: tuple[int, int]) -> Camera:
        """A camera at one place looking at another, level; ``view_deg`` is across the picture's height."""
        ahead = (at_m - from_m) / np.linalg.norm(at_m - from_m)
        right = np.cross(ahead, [0, 0, 1.0])
        right /= np.linalg.norm(right)
        turn = np.stack([right, np.cross(ahead, right), ahead])
        focal = size_px[1] / 2 / np.tan(np.radians(view_deg) / 2)
        return cls(transforms.transform(turn, -turn @ from_m), float(focal), size_px)

    def project(self, points_m: Floats) -> Floats:
        """Points (..., 3) of the base frame as pixels (..., 2)."""
        seen = transforms.apply(self.camera_from_base, points_m)
        depth = np.maximum(seen[..., 2:], 0.05)
        pixels: Floats = self.focal_px * seen[..., :2] / depth + np.array(self.size_px) / 2
        return pixels


class Scene:
    """A robot over its table, drawn pose after pose."""

    def __init__(self, robot: Robot, sheet: Sheet, camera: Camera) -> None:
        width, height = (side * _FINE for side in camera.size_px)
        self.robot, self.sheet, self.size = robot, sheet, (width, height)
        self.camera = Camera(camera.camera_from_base, camera.focal_px * _FINE, (width, height))
        x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, np.arange(height) + 0.5 - height / 2)
        rays = np.stack([x, y, np.full_like(x, self.camera.focal_px)], axis=-1)
        self.rays = (rays / np.linalg.norm(rays, axis=-1, keepdims=True)).astype(np.float32)
        self.sun = camera.camera_from_base[:3, :3] @ _SUN
        middle = np.array([sheet.page.width_mm, sheet.page.height_mm]) / 2
        # The table's own picture: square, the sheet in its middle.
        self.table_corner_mm = middle - 1000 * _TABLE_M / 2

    def picture(self, q: Floats, tip_m: Floats, paper: Picture) -> Picture:
        """The scene (H, W, 3): the arm at joint positions (dof,), its pen's tip, and a picture of the sheet."""
        frames = self.robot.frames(q)[: self.robot.dof + 1]
        capsules: list[Shape] = [
            (
                transforms.apply(frames[c.link], c.start_m),
                transforms.apply(frames[c.link], c.end_m),
                c.radius_m,
                self._colour(c.link),
            )
            for c in self.robot.capsules
            if c.link or self._above(c)
        ]
        pen = self.robot.forward(q)[:3, 2]
        capsules.append((tip_m - 0.002 * pen, tip_m - 0.06 * pen, 0.003, (40, 40, 46)))
        image = np.full((self.size[1], self.size[0], 3), _SKY, np.uint8)
        self._ground(image, capsules, paper)
        depth = self._table_depth()
        for shape in capsules:
            self._capsule(image, depth, shape)
        small = cv2.resize(image, (self.size[0] // _FINE, self.size[1] // _FINE), interpolation=cv2.INTER_AREA)
        return small.astype(np.uint8)

    def _table_depth(self) -> NDArray[np.float32]:
        """How far (H, W) along each ray the table is: what is below it is not seen."""
        camera_from_sheet = self.camera.camera_from_base @ self.sheet.base_from_paper
        turn, origin = camera_from_sheet[:3, :3], camera_from_sheet[:3, 3]
        falling = self.rays @ turn[:, 2].astype(np.float32)
        along = np.where(falling < -1e-6, (origin @ turn[:, 2]) / np.minimum(falling, -1e-6), np.inf)
        with np.errstate(invalid="ignore"):
            place = 1000 * (self.rays * along[..., None] - origin) @ turn[:, :2] - self.table_corner_mm
            inside = ((place >= 0) & (place <= 1000 * _TABLE_M)).all(-1)
        depth: NDArray[np.float32] = np.where(inside, along, np.inf).astype(np.float32)
        return depth

    def _above(self, still: Capsule) -> bool:
        """Whether something that does not move is seen above the table."""
        heights = self.sheet.points_mm(np.stack([still.start_m, still.end_m]))[:, 2]
        return bool(heights.max() + 1000 * still.radius_m > 0)

    def _colour(self, link: int) -> tuple[int, int, int]:
        if link == 0:
            return _STILL
        return _ACCENT if link == self.robot.dof else _LINKS[link % 2]

    def _ground(
        self, image: Picture, capsules: list[tuple[Floats, Floats, float, tuple[int, int, int]]], paper: Picture
    ) -> None:
        """Table and sheet, with the arm's shadow on them."""
        side = round(_TABLE_M * _TABLE_PX_PER_M)
        shade = np.zeros((side, side), np.uint8)
        page = self.sheet.page
        for start, end, radius, _ in capsules:
            ends = np.stack([self._shadow_px(point) for point in (start, end)])
            if np.isfinite(ends).all():
                a, b = np.rint(np.clip(ends, -4000, 4000)).astype(int).tolist()
                cv2.line(shade, a, b, 110, max(1, round(2 * radius * _TABLE_PX_PER_M)), cv2.LINE_AA)
        soft = cv2.GaussianBlur(shade, (0, 0), 5)[..., None].astype(np.float32) / 255
        table = (np.array(_TABLE, np.float32) * (1 - soft)).astype(np.uint8)
        self._lay(image, table, self.table_corner_mm, np.full(2, 1000 * _TABLE_M))
        first = np.rint((-self.table_corner_mm + [0, 0]) * _TABLE_PX_PER_M / 1000).astype(int)
        count = np.rint(np.array([page.width_mm, page.height_mm]) * _TABLE_PX_PER_M / 1000).astype(int)
        paper = cv2.resize(paper, None, fx=_SHRINK, fy=_SHRINK, interpolation=cv2.INTER_AREA).astype(np.uint8)
        # Rows of the table's picture go down the sheet.
        rows = slice(side - first[1] - count[1], side - first[1])
        over = cv2.resize(soft[rows, first[0] : first[0] + count[0], 0], paper.shape[1::-1])[..., None]
        self._lay(image, (paper * (1 - over)).astype(np.uint8), np.zeros(2), np.array([page.width_mm, page.height_mm]))

    def _shadow_px(self, point_m: Floats) -> Floats:
        """Where (2,) a point's shadow falls in the picture of the table."""
        x, y, height = self.sheet.points_mm(point_m)
        sun = self.sheet.base_from_paper[:3, :3].T @ _SUN
        place = np.array([x, y]) - height / sun[2] * sun[:2] - self.table_corner_mm
        pixels: Floats = place * [1, -1] * _TABLE_PX_PER_M / 1000 + [0, _TABLE_M * _TABLE_PX_PER_M]
        return pixels

    def _lay(self, image: Picture, flat: Picture, corner_mm: Floats, size_mm: Floats) -> None:
        """Put a picture that lies in the plane of the sheet into the scene."""
        height, width = flat.shape[:2]
        corners = corner_mm + size_mm * np.array([[0, 1], [1, 1], [1, 0], [0, 0]])
        seen = self.camera.project(self.sheet.points_m(corners)).astype(np.float32)
        source = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
        warp = cv2.getPerspectiveTransform(source, seen)
        laid = cv2.warpPerspective(flat, warp, self.size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        mask = np.zeros(image.shape[:2], np.uint8)
        cv2.fillConvexPoly(mask, np.rint(seen * 16).astype(np.int32), 255, cv2.LINE_AA, 4)
        share = mask[..., None].astype(np.float32) / 255
        image[:] = (image * (1 - share) + laid * share).astype(np.uint8)

    def _capsule(self, image: Picture, depth: NDArray[np.float32], shape: Shape) -> None:
        """Cast the rays near a capsule and shade what they meet."""
        start, end, radius, colour = shape
        seen = transforms.apply(self.camera.camera_from_base, np.stack([start, end]))
        if (seen[:, 2] < radius + 0.05).any():
            return
        centres = self.camera.project(np.stack([start, end]))
        reach = 1.15 * self.camera.focal_px * radius / (seen[:, 2:] - radius) + 2
        low = np.clip(np.floor((centres - reach).min(0)), 0, self.size).astype(int)
        high = np.clip(np.ceil((centres + reach).max(0)), 0, self.size).astype(int)
        if (high <= low).any():
            return
        part = np.s_[low[1] : high[1], low[0] : high[0]]
        distance, normal = _cast(self.rays[part], seen[0].astype(np.float32), seen[1].astype(np.float32), radius)
        near = distance < depth[part]
        light = 0.42 + 0.58 * np.clip(normal @ self.sun.astype(np.float32), 0, 1)
        # A rim of light, so that links stand out from each other.
        rim = 1 - np.clip(-(normal * self.rays[part]).sum(-1), 0, 1)
        lit = np.clip(np.array(colour, np.float32) * light[..., None] + 46 * (rim**3)[..., None], 0, 255).astype(
            np.uint8
        )
        image[part][near] = lit[near]
        depth[part][near] = distance[near]


def _cast(
    rays: NDArray[np.float32], start: NDArray[np.float32], end: NDArray[np.float32], radius: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Distance (h, w), infinite where missed, and normal (h, w, 3) of a capsule along unit rays from the origin."""
    axis = end - start
    length = float(np.linalg.norm(axis))
    far = np.full(rays.shape[:2], np.inf, np.float32)
    along = np.zeros_like(far)
    if length > 1e-6:
        axis = axis / length
        across_ray = rays - (rays @ axis)[..., None] * axis
        across_start = start - (start @ axis) * axis
        a = (across_ray**2).sum(-1)
        b, c = across_ray @ across_start, float(across_start @ across_start) - radius**2
        root = b * b - a * c
        t = (b - np.sqrt(np.maximum(root, 0))) / np.maximum(a, 1e-9)
        s = t * (rays @ axis) - start @ axis
        hit = (root > 0) & (s > 0) & (s < length)
        far[hit], along[hit] = t[hit], s[hit]
    for centre, place in ((start, 0.0), (end, length)):
        b, c = rays @ centre, float(centre @ centre) - radius**2
        root = b * b - c
        t = b - np.sqrt(np.maximum(root, 0))
        hit = (root > 0) & (t > 0) & (t < far)
        far[hit], along[hit] = t[hit], place
    axis_point = start + along[..., None] * (axis if length > 1e-6 else np.zeros(3, np.float32))
    finite = np.where(np.isfinite(far), far, 0)
    normal = (finite[..., None] * rays - axis_point) / radius
    return far, normal.astype(np.float32)

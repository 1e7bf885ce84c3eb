"""Portraits with landmarks for the tests of the lines, and how far the ink of two drawings agrees."""

from __future__ import annotations

import cv2
import numpy as np

from limner import geometry
from limner.types import Face, Photo

ASTRONAUT = np.array(
    (
    (180, 93), (179, 112), (179, 121), (182, 142), (186, 150), (190, 157), (201, 168), (212, 176), (220, 177),
    (229, 177), (241, 170), (254, 161), (259, 154), (264, 146), (270, 126), (271, 117), (273, 98), (184, 89),
    (191, 88), (197, 86), (206, 87), (215, 89), (236, 89), (246, 88), (255, 88), (261, 91), (268, 93),
    (225, 100), (224, 111), (223, 121), (223, 127), (213, 130), (217, 133), (223, 134), (229, 134), (233, 131),
    (194, 101), (198, 98), (206, 98), (213, 104), (207, 104), (200, 104), (237, 105), (245, 100), (252, 101),
    (256, 104), (250, 106), (243, 106), (200, 139), (209, 138), (216, 139), (223, 140), (229, 140), (236, 140),
    (246, 142), (234, 153), (228, 155), (222, 156), (215, 155), (210, 152), (203, 140), (217, 142), (223, 142),
    (229, 142), (243, 143), (228, 150), (222, 150), (217, 149),
    ),
    float,
)  # fmt: skip
"""Landmarks of the astronaut that scikit-image ships, to whole pixels."""

MIRROR = [
    *range(16, -1, -1),
    *range(26, 16, -1),
    *(27, 28, 29, 30, 35, 34, 33, 32, 31),
    *(45, 44, 43, 42, 47, 46, 39, 38, 37, 36, 41, 40),
    *(54, 53, 52, 51, 50, 49, 48, 59, 58, 57, 56, 55),
    *(64, 63, 62, 61, 60, 67, 66, 65),
]
"""Where each landmark of a mirrored face comes from."""


def face_of(points_px):
    """A face with these landmarks and the box around them."""
    points_px = np.asarray(points_px, float)
    return Face(points_px, [*points_px.min(axis=0), *(points_px.max(axis=0) + 1)])


def astronaut():
    """The photo of Eileen Collins, and her face in it."""
    from skimage.data import astronaut as load

    return Photo(load()), face_of(ASTRONAUT)


def plain_face(outer_eye_px=128.0, centre=(280.0, 290.0)):
    """The astronaut's landmarks, set upright, at a given size and place: for photos drawn by a test."""
    left, right = ASTRONAUT[36], ASTRONAUT[45]
    along = (right - left) / ((right - left) @ (right - left))
    down = np.array([-along[1], along[0]])
    upright = (ASTRONAUT - (left + right) / 2) @ np.stack([along, down], axis=1)
    return face_of(upright * outer_eye_px + centre)


def london(shared, name):
    """A portrait of the London set, landmarks by hand."""
    marks = np.load(shared / "data/london/landmarks.npz")
    rgb = cv2.imread(str(shared / "data/london/images" / name))[:, :, ::-1]
    return Photo(rgb), face_of(marks["ibug68"][marks["names"].tolist().index(name)])


def resized(photo, face, factor):
    """Photo and face at another size, and the factors (x, y) that came out."""
    width, height = photo.size_px
    size = round(width * factor), round(height * factor)
    rgb = cv2.resize(photo.rgb, size, interpolation=cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC)
    factors = np.array(size) / photo.size_px
    return Photo(rgb), face_of((face.points_px + 0.5) * factors - 0.5), factors


def mirrored(photo, face):
    """Photo and face seen in a mirror."""
    return Photo(photo.rgb[:, ::-1]), face_of(mirrored_points(face.points_px, photo)[MIRROR])


def mirrored_points(points_px, photo):
    """Points where the mirror shows them."""
    return np.array([photo.size_px[0] - 1, 0]) + np.array([-1, 1]) * points_px


def line_photo(angle_deg, dark=40, light=200, width=3.0, size=240):
    """A straight line through the middle, with soft borders, and the distance of each pixel from it."""
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    turn = np.deg2rad(angle_deg)
    away = -x * np.sin(turn) + y * np.cos(turn)
    values = light + (dark - light) * np.exp(-(away**2) / (2 * (width / 2) ** 2))
    return Photo(np.repeat(np.rint(values).astype(np.uint8)[..., None], 3, axis=2)), away


def ink(lines, step=0.5):
    """Points close together along all lines."""
    return np.concatenate([geometry.resample(line, step) for line in lines])


def darkness_inked(portrait, pen_px=1):
    """How far darkness and the ink of all strokes go together on a face: correlation over 0.3 eye distances."""
    grey = cv2.cvtColor(portrait.photo.rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
    inked = np.zeros(grey.shape, np.float32)
    for line in portrait.strokes.lines_px:
        cv2.polylines(inked, [np.rint(line).astype(np.int32)], False, (1,), max(1, round(pen_px)))
    tile = max(4, round(0.3 * portrait.face.outer_eye_px))
    x0, y0, x1, y1 = np.clip(np.rint(portrait.face.box_px).astype(int), 0, None)
    size = ((x1 - x0) // tile, (y1 - y0) // tile)
    light, lined = (cv2.resize(one[y0:y1, x0:x1], size, interpolation=cv2.INTER_AREA).ravel() for one in (grey, inked))
    return np.corrcoef(-light, lined)[0, 1]


def agreement(one, other, within):
    """The smaller share of the points of either that has a point of the other this near."""
    from scipy.spatial import KDTree

    return min(np.mean(KDTree(b).query(a)[0] <= within) for a, b in ((one, other), (other, one)))


SKIN, DARK, LIPS, IRIS, WHITE, CLOTH = (
    (224, 180, 160),
    (60, 40, 30),
    (180, 90, 90),
    (70, 80, 90),
    (240, 238, 235),
    (60, 80, 140),
)


def painted(outer_eye_px=128.0, background=(200, 210, 215)):
    """A face made up of coloured shapes, and its landmarks: head, hair, ears, eyes, brows, nose, lips, neck, clothes.

    The background is a colour or a picture (620, 560, 3).
    """
    fine = 4
    face = plain_face(128.0, (280.0, 290.0))
    canvas = np.empty((620, 560, 3), np.uint8)
    canvas[:] = background
    canvas = cv2.resize(canvas, None, fx=fine, fy=fine, interpolation=cv2.INTER_NEAREST)
    marks = face.points_px

    def fill(points, colour):
        cv2.fillPoly(
            canvas, [np.rint((np.asarray(points) * fine + (fine - 1) / 2) * 16).astype(np.int32)], colour, 16, 4
        )

    def oval(centre, radii, colour):
        turns = np.linspace(0, 2 * np.pi, 100)
        fill(np.asarray(centre) + np.stack([np.cos(turns), np.sin(turns)], 1) * radii, colour)

    left, right, chin = marks[0], marks[16], marks[8]
    middle = (left[0] + right[0]) / 2
    half = (right[0] - left[0]) / 2
    fill(
        [
            (middle - 220, 620),
            (middle - 190, 560),
            (middle - 60, 520),
            (middle + 60, 520),
            (middle + 190, 560),
            (middle + 220, 620),
        ],
        CLOTH,
    )
    fill(
        [(middle - 55, chin[1] - 40), (middle + 55, chin[1] - 40), (middle + 62, 540), (middle - 62, 540)],
        (200, 155, 138),
    )
    oval((middle, marks[27][1] - 40), (half + 18, 150), DARK)
    for side in (left, right):
        oval(side + np.array([0, 30]), (14, 28), (205, 150, 135))
    fill(
        np.concatenate(
            [marks[:17], [[right[0] - 12, right[1] - 90], [middle, right[1] - 120], [left[0] + 12, left[1] - 90]]]
        ),
        SKIN,
    )
    for eye in (marks[36:42], marks[42:48]):
        centre = eye.mean(axis=0)
        fill(eye + np.array([0, -1.5]), DARK)
        fill(eye + np.array([0, 1.2]), WHITE)
        cover = canvas.copy()
        oval(centre, (8.5, 8.5), IRIS)
        oval(centre, (3.6, 3.6), (10, 10, 10))
        inside = np.zeros(canvas.shape[:2], np.uint8)
        cv2.fillPoly(inside, [np.rint(eye * fine).astype(np.int32)], 1)
        canvas[inside == 0] = cover[inside == 0]
    for brow in (marks[17:22], marks[22:27]):
        fill(np.concatenate([brow, brow[::-1] + np.array([0, 7])]), DARK)
    fill(np.concatenate([marks[31:36], marks[31:36][::-1] - np.array([0, 5])]), (120, 70, 60))
    fill(marks[48:60], LIPS)
    fill(np.concatenate([marks[60:65], marks[64:59:-1] + np.array([0, 3])]), (90, 30, 35))
    small = cv2.GaussianBlur(cv2.resize(canvas, (560, 620), interpolation=cv2.INTER_AREA), (0, 0), 0.8)
    photo, face, _ = resized(Photo(small), face, outer_eye_px / 128.0)
    return photo, face

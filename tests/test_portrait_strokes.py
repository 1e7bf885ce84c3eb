import numpy as np
import pytest

from limner import geometry
from limner.types import Photo
from limner.vision.edges.iris import Disc
from limner.vision.figure import Figure
from limner.vision.head import BROWS, face_frame
from limner.vision.portrait.beard import beard_of, draw_beard
from limner.vision.portrait.brows import draw_brows
from limner.vision.portrait.eyes import between_lids
from limner.vision.portrait.rest import draw_rest
from limner.vision.portrait.seen import FlowSettings, look_at
from limner.vision.portrait.settings import PortraitSettings
from limner.vision.portrait.tofro import to_and_fro
from limner.vision.raster import dilated, filled
from portraits import ink, painted

SHAPE = (620, 560)


def rows(count, apart=8.0, start=50.0, end=150.0):
    """Level strokes one under the other, all from left to right."""
    return [np.stack([np.linspace(start, end, 51), np.full(51, 50 + apart * i)], axis=1) for i in range(count)]


def reach(value=12.0):
    return np.full((300, 300), value, np.float32)


@pytest.mark.parametrize("count", [1, 2, 7])
def test_a_hand_hatches_to_and_fro_without_lifting(count):
    strokes = rows(count)
    (joined,) = to_and_fro(strokes, reach())
    assert geometry.length(joined) == pytest.approx(geometry.total_length(strokes), rel=0.05)
    away = np.abs(ink([joined])[:, None, 1] - np.arange(50, 50 + 8 * count, 8)).min(axis=1)
    assert away.max() <= 4.0 + 1e-9  # half a gap, where the pen turns
    turns = np.abs(np.diff(np.sign(np.diff(joined[:, 0]))))
    assert np.count_nonzero(turns) == count - 1


def test_no_two_strokes_are_joined_that_are_far_or_lead_on_or_across_other_ground():
    assert len(to_and_fro(rows(5), reach(6.0))) == 5
    one, other = rows(1)[0], rows(1, start=155.0, end=250.0)[0]
    assert len(to_and_fro([one, other], reach())) == 2
    split = reach()
    split[54] = 0  # a gap between the first stroke and the second
    assert len(to_and_fro(rows(2), split)) == 2
    assert to_and_fro([], reach()) == []


def test_joining_strokes_makes_no_more_of_them_and_forgets_none():
    rng = np.random.default_rng(5)
    strokes = [start + np.linspace(0, 1, 9)[:, None] * way for start, way in rng.uniform(40, 90, (40, 2, 2))]
    joined = to_and_fro(strokes, reach(9.0))
    assert len(joined) < len(strokes)
    points = np.concatenate([geometry.resample(line, 1.0) for line in joined])
    for stroke in strokes:
        assert np.hypot(*(points - stroke[4]).T).min() < 9.0


def bearded(covers_chin=True):
    face = painted()[1]
    marks = face.points_px
    lower = filled(marks[3:14] if covers_chin else marks[1:6], SHAPE)
    none = np.zeros(SHAPE, bool)
    skin = dilated(lower, 30)
    return face, Figure(skin, skin, none, none, lower & ~filled(marks[48:60], SHAPE))


def test_a_beard_is_a_few_long_strokes_within_it():
    face, figure = bearded()
    lines = [mark.line for mark in draw_beard(face, figure)]
    assert 1 <= len(lines) <= 4
    x, y = np.rint(np.concatenate(lines)).astype(int).T
    assert figure.beard[y, x].all()
    assert geometry.total_length(lines) > 5 * face.outer_eye_px * len(lines)
    wide, whole = np.ptp(np.concatenate(lines)[:, 0]), np.ptp(np.nonzero(beard_of(face, figure))[1])
    assert wide > 0.8 * whole


def test_the_hairs_of_a_beard_grow_down_and_away_from_the_nose():
    face, figure = bearded()
    for mark in draw_beard(face, figure):
        ways, out = np.diff(mark.line, axis=0), mark.line[:-1] - face.points_px[27]
        along = np.abs((ways * out).sum(axis=1)) / (np.hypot(*ways.T) * np.hypot(*out.T))
        assert np.median(along) > 0.8


def test_the_hairs_of_a_beard_do_not_end_on_one_line():
    """Even ends look like the teeth of a saw: neither end follows the beard's border."""
    face, figure = bearded()
    for mark in draw_beard(face, figure):
        out = np.hypot(*(mark.line - face.points_px[27]).T)
        for ends in (out[0::2], out[1::2]):
            # From one hair to the next but one the border hardly bends: what is left is the ends' own.
            bend = ends[2:] - 2 * ends[1:-1] + ends[:-2]
            assert np.abs(bend).mean() > 0.025 * face.outer_eye_px


def test_a_shadow_beside_the_chin_is_no_beard():
    face, figure = bearded(covers_chin=False)
    assert figure.beard.any()
    assert not draw_beard(face, figure)


def test_a_brow_is_one_or_two_strokes_and_ends_with_its_hairs():
    """The landmarks are drawn out beyond the brow: what lies there is skin."""
    photo, face = painted()
    seen = look_at(photo, FlowSettings())
    for side in BROWS:
        start, end = face.points_px[[side[0], side[-1]]]
        middle = (start + end) / 2
        lines = [mark.line for mark in draw_brows(seen, face, 5) if np.hypot(*(mark.line.mean(axis=0) - middle)) < 40]
        assert 1 <= len(lines) <= 2
        assert np.ptp(ink(lines)[:, 0]) <= np.ptp([start[0], end[0]]) + 6


@pytest.mark.parametrize("off", [-9.0, -2.0, 0.0, 2.0, 9.0])
def test_an_iris_lies_about_half_way_between_the_lids(off):
    face = painted()[1]
    frame = face_frame(face)
    eye = face.points_px[36:42]
    middle, radius = eye.mean(axis=0), 8.4
    lids = [middle + np.stack([np.linspace(-18, 18, 19), np.full(19, y)], axis=1) for y in (-6.0, 6.0)]
    disc = between_lids(Disc(middle + np.array([3.0, off]), radius), lids, frame)
    assert disc.radius == radius
    assert disc.centre[0] == pytest.approx(middle[0] + 3.0, abs=0.3)
    assert disc.centre[1] - middle[1] == pytest.approx(np.clip(off, -0.25 * radius, 0.25 * radius), abs=0.1)


def test_what_leads_away_from_the_head_is_no_hair_though_the_figure_has_it():
    """A shelf of the colour of the hair touches the head, and is taken for a part of it."""
    rgb = painted()[0].rgb.copy()
    face = painted()[1]
    shelf = np.zeros(SHAPE, bool)
    shelf[220:250, 20:190] = True
    rgb[shelf] = (40, 30, 30)
    hair = (rgb.astype(int).sum(axis=2) < 150) | shelf
    none = np.zeros(SHAPE, bool)
    head = dilated(hair, 8) | filled(face.points_px[:17], SHAPE)
    figure = Figure(head, head & ~hair, hair, none, none)
    marks = draw_rest(look_at(Photo(rgb), FlowSettings()), face, figure, [], PortraitSettings())
    drawn = ink([mark.line for mark in marks])
    assert ((drawn[:, 0] < 120) & (drawn[:, 1] < 300)).mean() < 0.01

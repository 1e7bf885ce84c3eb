import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from limner import geometry
from limner.errors import BadInput
from limner.types import Face, Photo, Strokes
from limner.vision.completion import PARTS, CompletionSettings, complete, names_of
from limner.vision.lines import STYLES, LineSettings, draw_lines
from limner.vision.regions import RegionSettings
from limner.vision.spline_style import SplinesSettings, spline_strokes
from limner.vision.splines import natural_spline
from portraits import astronaut, ink, plain_face

FACE = plain_face()
UNIT = FACE.outer_eye_px
SETTINGS, IMPORTANCE = CompletionSettings(), RegionSettings()
JAW = natural_spline(FACE.points_px[PARTS["jaw"][0]]).line(0.5)


def strokes_of(*lines):
    return Strokes(lines, ["jaw"] * len(lines), np.arange(len(lines), 0.0, -1), (560, 600))


def completed(strokes, names="jaw", face=FACE, **changes):
    return complete(strokes, face, names, SETTINGS.replace(**changes), IMPORTANCE)


def added(before, after):
    old = {line.tobytes() for line in before.lines_px}
    return [line for line in after.lines_px if line.tobytes() not in old]


def away(points, line):
    """Distance of points to a finely sampled line."""
    return np.min(np.hypot(*(points[:, None] - geometry.resample(line, 0.5)).transpose(2, 0, 1)), axis=1)


@settings(max_examples=20, deadline=None)
@given(st.floats(0.1, 0.4), st.floats(0.55, 0.9), st.floats(-0.05, 0.05))
def test_a_gap_in_the_jaw_is_filled_and_nothing_else(start, end, shift):
    """Two pieces of the jaw, a little beside the landmarks: one stroke goes from the end of one to the other's."""
    a, b = int(start * len(JAW)), int(end * len(JAW))
    before = strokes_of(*(part + np.array([0, shift * UNIT]) for part in (JAW[:a], JAW[b:])))
    after = completed(before)
    assert {line.tobytes() for line in before.lines_px} <= {line.tobytes() for line in after.lines_px}
    (line,) = added(before, after)
    ends = line[[0, -1]], np.stack([before.lines_px[0][-1], before.lines_px[1][0]])
    np.testing.assert_allclose(*ends, atol=0.03 * UNIT)
    assert away(geometry.resample(line, 1.0), JAW[a - 1 : b + 1]).max() <= abs(shift) * UNIT + 1
    assert geometry.length(line) == pytest.approx(geometry.length(JAW[a:b]), rel=0.1)


def test_an_added_line_goes_on_smoothly():
    gap = slice(int(0.3 * len(JAW)), int(0.6 * len(JAW)))
    before = strokes_of(JAW[: gap.start] + np.array([2, 4]), JAW[gap.stop :] - np.array([3, 1]))
    (line,) = added(before, completed(before, tolerance=0.0))
    whole = np.concatenate([before.lines_px[0][-60:], line, before.lines_px[1][:60]])
    steps = np.diff(geometry.resample(whole, 4.0), axis=0)
    turns = np.abs(np.angle(np.exp(1j * np.diff(np.arctan2(steps[:, 1], steps[:, 0])))))
    assert np.rad2deg(turns).max() < 20


def test_a_whole_feature_is_drawn_where_there_is_none():
    after = completed(strokes_of(), "all")
    assert set(after.region) == set(PARTS)
    for name, parts in PARTS.items():
        drawn = ink([line for line, region in zip(after.lines_px, after.region, strict=True) if region == name])
        assert max(away(FACE.points_px[part], drawn).max() for part in parts) <= (0.03 + getattr(SETTINGS, name)) * UNIT
    assert (np.diff(after.weight) <= 0).all()


def test_what_is_complete_stays_as_it_is():
    everything = spline_strokes(Photo(np.zeros((600, 560, 3))), FACE, SplinesSettings(), IMPORTANCE)
    assert completed(everything, "all") == everything
    once = completed(strokes_of(), "all")
    assert completed(once, "all") == once


def test_ink_across_the_jaw_is_no_jaw_and_ink_along_it_is():
    across = np.gradient(JAW, axis=0)[:, ::-1] * [1, -1]
    across /= np.hypot(*across.T)[:, None]
    hairs = strokes_of(*(JAW[k] + np.array([[-6], [6]]) * across[k] for k in range(0, len(JAW), 20)))
    (line,) = added(hairs, completed(hairs))
    assert geometry.length(line) == pytest.approx(geometry.length(JAW), rel=0.02)
    beside = strokes_of(JAW + 0.5 * SETTINGS.jaw * UNIT * across)
    assert completed(beside) == beside


def test_short_gaps_stay_open():
    a, b = int(0.5 * len(JAW)), int(0.5 * len(JAW)) + round(0.1 * UNIT / 0.5)
    broken = strokes_of(JAW[:a], JAW[b:])
    assert completed(broken, shortest=0.2) == broken
    assert len(added(broken, completed(broken, shortest=0.02))) == 1


@pytest.mark.parametrize("style", [style for style in STYLES if style != "splines"])
def test_a_drawing_keeps_its_strokes_and_gains_the_jaw(style):
    photo, face = astronaut()
    before = draw_lines(photo, face, style, LineSettings())
    after = draw_lines(photo, face, style, LineSettings(complete="jaw"))
    # A stroke may go on along the jaw where it ends there, either way round.
    drawn = [turned.tobytes() for line in after.lines_px for turned in (line, line[::-1])]
    assert all(any(line.tobytes() in longer for longer in drawn) for line in before.lines_px)
    jaw = natural_spline(face.points_px[:17]).line(1.0)
    covered = [np.mean(away(jaw, ink(s.lines_px)) < 0.1 * face.outer_eye_px) for s in (before, after)]
    assert covered[0] <= covered[1]
    assert covered[1] > 0.95


def test_twice_the_size_gives_the_same():
    broken = strokes_of(JAW[: len(JAW) // 3])
    large = Face(2 * FACE.points_px, 2 * FACE.box_px)
    one, two = (completed(s, "all", f) for s, f in ((broken, FACE), (strokes_of(2 * broken.lines_px[0]), large)))
    assert one.region == two.region
    for a, b in zip(one.lines_px, two.lines_px, strict=True):
        assert away(b / 2, a).max() < 0.5


@pytest.mark.parametrize("names", ["", "none", " none,"])
def test_nothing_is_added_unless_asked_for(names):
    assert completed(strokes_of(JAW[:9]), names) == strokes_of(JAW[:9])


def test_names():
    assert names_of("jaw, mouth") == ("jaw", "mouth")
    assert names_of("all") == tuple(PARTS)
    with pytest.raises(BadInput, match="complete: 'chin' does not exist; choose from jaw, brow, eye, nose, mouth, all"):
        names_of("jaw,chin")


def test_degenerate_strokes_and_landmarks():
    dots = strokes_of(FACE.points_px[8:9], np.tile(FACE.points_px[9], (2, 1)), JAW[:2])
    assert len(completed(dots, "all").lines_px) > 3
    one_place = np.tile(FACE.points_px[:1], (68, 1))
    one_place[45] += 100
    completed(dots, "all", Face(one_place, FACE.box_px))

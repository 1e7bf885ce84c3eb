import numpy as np
import pytest

from limner.vision.edges.fdog import coherent_lines, evened
from limner.vision.edges.flow import edge_flow
from limner.vision.edges.ridges import crests, hysteresis
from limner.vision.skeleton import skeletonize
from limner.vision.trace import TraceSettings, trace

Y, X = np.indices((201, 201), np.float32) - 100


def across(angle_deg):
    """Signed distance from the line through the middle in this direction."""
    turn = np.deg2rad(angle_deg)
    return (-X * np.sin(turn) + Y * np.cos(turn)).astype(np.float32)


def line(angle_deg, width=1.5):
    return (1 - np.exp(-((across(angle_deg) / width) ** 2) / 2)).astype(np.float32)


def answer(grey, width=1.0):
    flow = edge_flow(grey, 1.0, 2.5)
    return coherent_lines(grey, flow, width, 5.0), flow


@pytest.mark.parametrize("angle", [0, 10, 22.5, 45, 60, 77, 90, 121, 150])
def test_a_dark_line_gives_one_line_at_its_centre_whatever_its_direction(angle):
    strength, flow = answer(line(angle))
    mask = hysteresis(strength, crests(strength, flow.angle_rad), 0.04, 0.1)
    mask[np.hypot(X, Y) > 80] = False
    (found,) = trace(skeletonize(mask), TraceSettings(), mask)
    turn = np.deg2rad(angle)
    assert np.abs((found - 100) @ [-np.sin(turn), np.cos(turn)]).max() < 0.75
    assert np.ptp((found - 100) @ [np.cos(turn), np.sin(turn)]) > 150


@pytest.mark.parametrize("angle", [0, 30, 90, 135])
def test_all_directions_answer_alike(angle):
    middle = [answer(line(a))[0][100, 100] for a in (angle, 0)]
    assert middle[0] == pytest.approx(middle[1], rel=0.1)


def test_the_border_of_a_dark_area_gives_one_line_on_its_dark_side():
    strength, _ = answer(np.clip(across(0) / 2, 0, 1).astype(np.float32))
    profile = strength[:, 100]
    assert -4 <= profile.argmax() - 100 <= 0
    assert (profile > 0.3 * profile.max()).sum() <= 6


def test_a_light_line_answers_beside_itself_only():
    strength, _ = answer(1 - line(0))
    assert strength[100, 100] == 0


def test_an_even_slope_and_an_even_picture_answer_nothing():
    for grey in (np.full((50, 50), 0.4, np.float32), (X[:50, :50] / 50).astype(np.float32)):
        assert answer(grey)[0][15:-15, 15:-15].max() < 1e-3


def test_a_speck_answers_less_than_a_line():
    speck = (1 - np.exp(-(X**2 + Y**2) / (2 * 1.5**2))).astype(np.float32)
    assert answer(speck)[0].max() < 0.5 * answer(line(0))[0].max()


def test_wide_lines_answer_most_to_wide_filters():
    wide = line(0, width=4)
    assert answer(wide, width=2.5)[0][100, 100] > 2 * answer(wide, width=1.0)[0][100, 100]


@pytest.mark.parametrize("gain", [0.3, 0.5, 2.0])
def test_evened_light_hardly_depends_on_contrast(gain):
    rng = np.random.default_rng(0)
    grey = (0.5 + 0.1 * rng.normal(size=(160, 160))).astype(np.float32)
    one, other = evened(grey, 20, 0.001), evened(np.float32(gain) * grey, 20, 0.001)
    assert np.abs(one - other).max() < 0.1 * np.abs(one).max()


def test_evening_amplifies_no_noise_below_the_floor():
    rng = np.random.default_rng(0)
    grey = (0.5 + 0.0005 * rng.normal(size=(100, 100))).astype(np.float32)
    assert np.abs(evened(grey, 20, 0.01)).max() < 0.3

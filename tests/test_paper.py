import numpy as np
import pytest
from hypothesis import given, strategies as st

from limner import transforms
from limner.errors import BadInput
from limner.motion.arm.calibrate import calibrate
from limner.motion.arm.paper import THESIS_AREA_M, Placement, PlaneMapping, thesis_sheet
from limner.simulation.sheet import Sheet
from limner.types import Drawing, Page

seeds = st.integers(0, 2**32 - 1)


def sheet(seed, tilt=0.1):
    rng = np.random.default_rng(seed)
    turn = transforms.from_rpy((*rng.uniform(-tilt, tilt, 2), rng.uniform(-3, 3)))
    return transforms.transform(turn, rng.uniform(-0.5, 0.5, 3))


def probed(frame, seed, n=9, noise_m=0.0):
    rng = np.random.default_rng(seed)
    points = np.column_stack([rng.uniform(0.02, 0.2, (n, 2)), np.zeros(n)])
    points[:3] = [0, 0, 0], [0.2, 0, 0], [0.1, 0.2, 0]
    return transforms.apply(frame, points) + rng.normal(0, noise_m, (n, 3))


@given(seeds)
def test_a_plane_probed_without_noise_is_found_exactly(seed):
    found = calibrate(probed(sheet(seed), seed))
    assert np.allclose(found.base_from_paper, sheet(seed), atol=1e-9)
    assert found.used.all()
    assert found.rms_mm < 1e-9
    assert found.tilt_deg == pytest.approx(np.degrees(np.arccos(sheet(seed)[2, 2])), abs=1e-4)


@given(seeds, st.integers(2, 8))
def test_a_point_off_the_plane_is_left_out(seed, wrong):
    points = probed(sheet(seed), seed, noise_m=0.0001)
    points[wrong] += 0.008 * sheet(seed)[:3, 2]
    found = calibrate(points)
    assert np.flatnonzero(~found.used).tolist() == [wrong]
    assert found.residual_mm[wrong] == pytest.approx(8, abs=1)
    assert found.base_from_paper[:3, 2] @ sheet(seed)[:3, 2] > np.cos(np.radians(0.3))


@pytest.mark.parametrize(
    ("points", "words"),
    [
        (np.zeros((2, 3)), "at least 3"),
        (np.zeros((5, 3)), "on a line or at one place"),
        (np.outer(np.arange(5), (1, 2, 3)), "on a line"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, np.nan]], "finite"),
        ([[0, 0, 0.5], [1, 0, 0], [0, 1, 0], [1, 1, 0], [1, 2, 0], [3, 1, 0]], "first point"),
    ],
)
def test_probing_that_gives_no_plane_says_so(points, words):
    with pytest.raises(BadInput, match=words):
        calibrate(points)


@given(seeds)
def test_paper_to_base_and_back(seed):
    placed = Placement(sheet(seed), 0.3, 0.1, 1.0)
    points = np.random.default_rng(seed).uniform(-50, 300, (10, 3))
    assert np.allclose(placed.points_mm(placed.points_m(points)), points)


def test_the_pen_points_into_the_paper_and_leans_as_asked():
    placed = Placement(sheet(1), spin_rad=0.7, lean_rad=0.2, lean_towards_rad=0.0)
    assert np.allclose(placed.orientations((30, 40))[:, 2], (-np.sin(0.2), 0, -np.cos(0.2)))
    upright = Placement(sheet(1), spin_rad=0.7).tips(np.random.default_rng(1).uniform(0, 200, (9, 3)))
    assert np.allclose(upright[:, :3, :3], upright[0, :3, :3])
    assert np.allclose(upright[:, :3, 2], -sheet(1)[:3, 2])


@given(seeds, st.floats(0, 0.4), st.floats(0, 0.4), st.floats(-3, 3))
def test_a_leaning_pen_touches_where_it_is_asked_to_from_any_height(seed, lean, swing, towards):
    points = np.random.default_rng(seed).uniform((0, 0, -5), (150, 200, 60), (20, 3))
    placed = Placement(sheet(seed), 0.3, lean, towards).swung(swing, points)
    tips = placed.tips(points)
    assert np.allclose(placed.points_mm(tips[:, :3, 3])[:, 2], points[:, 2])
    assert np.allclose(Sheet(placed.base_from_paper, Page()).touched_mm(tips), points[:, :2])


@given(seeds, st.floats(0.01, 0.4))
def test_a_swinging_pen_leans_towards_the_middle_farther_out_more_and_so_its_hand_moves_less(seed, swing):
    points = np.random.default_rng(seed).uniform(0, 150, (20, 2))
    placed = Placement(np.eye(4)).swung(swing, points)
    away = points - placed.swing_about_mm
    up = -placed.orientations(points)[:, :, 2]
    assert (np.einsum("nk,nk->n", up[:, :2], away) < 0).all()
    lean = np.arccos(up[:, 2])
    assert lean.max() == pytest.approx(swing)
    assert np.allclose(lean, swing * np.hypot(*away.T) / np.hypot(*away.T).max())
    hand = points / 1000 + 0.1 * up[:, :2]
    assert np.ptp(hand, axis=0).max() < np.ptp(points, axis=0).max() / 1000


def test_a_small_drawing_does_not_swing_the_hand_against_the_pen():
    dots = np.array([[50.0, 50.0], [50.5, 50.0]])
    assert Placement(np.eye(4)).swung(0.1, dots).lean_deg(dots) < 0.1


def test_a_flat_sheet_has_its_centre_where_asked_for():
    placed = Placement.flat((-0.3, 0.4, -0.2), (148, 210), turn_rad=np.pi / 2)
    assert np.allclose(placed.points_m((74, 105)), (-0.3, 0.4, -0.2))
    assert np.allclose(placed.points_m((148, 105)) - placed.points_m((0, 105)), (0, 0.148, 0))


def test_a_matrix_that_is_no_rigid_motion_is_refused():
    with pytest.raises(BadInput, match="rotation"):
        Placement(2 * np.eye(4))


def test_the_thesis_mapping_takes_its_own_corners_to_the_picture():
    mapping = PlaneMapping.between(THESIS_AREA_M, ((1, 1), (480, 640)))
    assert np.allclose(mapping.to_picture(THESIS_AREA_M), ((1, 1), (480, 640)))
    assert np.allclose(mapping.to_table(((1, 1), (480, 640))), THESIS_AREA_M)
    # Four numbers: it keeps angles, so lengths shrink by the ratio of the diagonals.
    diagonal = np.hypot(*np.subtract(*THESIS_AREA_M))
    assert np.hypot(mapping.a, mapping.b) == pytest.approx(np.hypot(479, 639) / diagonal)


def test_the_thesis_sheet_has_its_corners_where_the_thesis_has_them():
    drawing = Drawing((np.array([[0, 210.0], [148, 0]]),), ("face",), np.ones(1))
    scaled, placed = thesis_sheet(drawing, -0.25)
    assert np.allclose(placed.points_m(scaled.lines_mm[0]), np.column_stack([THESIS_AREA_M, [-0.25, -0.25]]))
    assert scaled.page.width_mm / scaled.page.height_mm == pytest.approx(148 / 210)


def test_a_drawing_area_of_no_size_is_refused():
    with pytest.raises(BadInput, match="one point"):
        PlaneMapping.between(((0, 0), (0, 0)), ((1, 1), (2, 2)))

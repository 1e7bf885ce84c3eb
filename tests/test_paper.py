import numpy as np
import pytest
from hypothesis import given, strategies as st

from limner import transforms
from limner.errors import BadInput
from limner.motion.arm.calibrate import calibrate
from limner.motion.arm.paper import THESIS_AREA_M, Placement, PlaneMapping

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
    pen = sheet(1)[:3, :3].T @ placed.orientation()[:, 2]
    assert np.allclose(pen, (-np.sin(0.2), 0, -np.cos(0.2)))
    upright = Placement(sheet(1), spin_rad=0.7)
    assert np.allclose(upright.orientation()[:, 2], -sheet(1)[:3, 2])


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


def test_a_drawing_area_of_no_size_is_refused():
    with pytest.raises(BadInput, match="one point"):
        PlaneMapping.between(((0, 0), (0, 0)), ((1, 1), (2, 2)))

import numpy as np
import pytest
from hypothesis import given, strategies as st

from limner import transforms

scipy_rotation = pytest.importorskip("scipy.spatial.transform", reason="pip install 'limner[train]'").Rotation

seeds = st.integers(0, 2**32 - 1)


@given(seeds)
def test_rotations_and_quaternions_are_those_of_scipy(seed):
    turn = scipy_rotation.random(20, random_state=seed)
    wxyz = turn.as_quat(scalar_first=True)
    wxyz *= np.where(wxyz[:, :1] < 0, -1, 1)
    assert np.allclose(transforms.to_quaternion(turn.as_matrix()), wxyz, atol=1e-12)
    assert np.allclose(transforms.from_quaternion(wxyz), turn.as_matrix(), atol=1e-12)


@given(seeds, st.floats(-7, 7))
def test_a_turn_about_an_axis_is_that_of_scipy(seed, angle):
    axis = np.random.default_rng(seed).normal(size=3)
    axis /= np.linalg.norm(axis)
    assert np.allclose(
        transforms.rotation(axis, angle), scipy_rotation.from_rotvec(angle * axis).as_matrix(), atol=1e-12
    )


def test_roll_pitch_yaw_turn_about_fixed_axes():
    assert np.allclose(
        transforms.from_rpy((0.1, -0.2, 0.3)), scipy_rotation.from_euler("xyz", (0.1, -0.2, 0.3)).as_matrix()
    )


@pytest.mark.parametrize("axis", np.eye(3))
def test_half_turns_have_a_quaternion(axis):
    half = transforms.rotation(axis, np.pi)
    assert np.allclose(transforms.from_quaternion(transforms.to_quaternion(half)), half)


@given(seeds)
def test_a_transform_and_its_inverse_undo_each_other(seed):
    rng = np.random.default_rng(seed)
    frame = transforms.transform(scipy_rotation.random(5, random_state=seed).as_matrix(), rng.normal(size=(5, 3)))
    points = rng.normal(size=(5, 3))
    assert np.allclose(transforms.apply(transforms.inverse(frame), transforms.apply(frame, points)), points)
    assert np.allclose(transforms.inverse(frame) @ frame, np.eye(4))

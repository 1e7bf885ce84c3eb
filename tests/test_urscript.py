"""URScript: what is written is read back as the same motion."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from hypothesis import given, strategies as st

from limner import storage
from limner.cli import main
from limner.errors import BadInput
from limner.targets import joints
from limner.targets.urscript import UrSettings, read_urscript, to_urscript
from limner.types import Drawing, JointTrajectory

ARM = np.array([[0.4, 0.1, 0, 0.2, 0, 0], [0, 0.3, 0.5, 0, 0.1, 0], [0.1, 0, 0.2, 0.3, 0, 0.4]])
"""A made-up arm whose tip moves in proportion to its joints."""


def motion(seed=0, dof=6):
    """A smooth motion of travel, stroke, travel, stroke, travel."""
    rng = np.random.default_rng(seed)
    t = np.concatenate([[0], np.cumsum(rng.uniform(0.01, 0.03, 200))])
    wave = t[:, None] * rng.uniform(0.5, 2, dof) + rng.uniform(0, 6, dof)
    stroke = np.repeat([-1, 0, -1, 1, -1], [41, 40, 40, 40, 40])
    q, qd, qdd = np.sin(wave) / 5, np.cos(wave) / 5, -np.sin(wave) / 5
    return JointTrajectory(tuple("abcdefgh"[:dof]), t, q, qd, qdd, stroke >= 0, stroke)


def tips(trajectory):
    return trajectory.q @ ARM.T


def distance(points, line):
    a, step = line[:-1], np.diff(line, axis=0)
    part = np.clip(((points[:, None] - a) * step).sum(-1) / np.maximum((step**2).sum(-1), 1e-18), 0, 1)
    return np.linalg.norm(points[:, None] - a - part[..., None] * step, axis=-1).min(1)


@given(st.integers(0, 1000), st.sampled_from([0.002, 0.008, 0.02]))
def test_the_stream_replays_to_the_motion_resampled(seed, step_s):
    made = motion(seed)
    found = read_urscript(to_urscript(made, tips(made), UrSettings(step_s=step_s)))
    assert found.kind == ("movej", *["servoj"] * (len(found.kind) - 1))
    assert np.abs(found.q - made.at(found.t_s)).max() < 1e-6
    assert np.allclose(np.diff(found.t_s)[:-1], step_s)
    assert found.t_s[-1] >= made.t_s[-1] + 0.1 - 1e-9, "it waits for what servoj lags behind"


@given(st.integers(0, 1000), st.floats(0.01, 2), st.floats(0, 2))
def test_straight_lines_keep_to_the_path_and_corners_do_not_overlap(seed, tolerance, blend):
    made = motion(seed)
    text = to_urscript(made, tips(made), UrSettings(way="movel", tolerance_mm=tolerance, blend_mm=blend))
    found = read_urscript(text)
    way = found.q @ ARM.T
    assert distance(tips(made), way).max() < tolerance / 1000 + 1e-7
    assert distance(way, tips(made)).max() < 1e-7
    radii = [float(line.rpartition("r=")[2][:-1]) for line in text.decode().splitlines() if "r=" in line]
    steps = np.linalg.norm(np.diff(way, axis=0), axis=1)
    assert (np.array(radii[:-1]) + radii[1:] <= steps[1:] + 1e-6).all()
    assert max(radii) <= blend / 1000 + 1e-6
    # It comes to rest at both ends of each stroke, where the pen meets the paper.
    for end in np.flatnonzero(np.diff(made.stroke)):
        k = np.abs(found.q - made.q[end]).max(1).argmin()
        assert np.abs(found.q[k] - made.q[end]).max() < 1e-7
        assert radii[k - 1] == 0


def test_lines_draw_and_joints_travel():
    made = motion()
    found = read_urscript(to_urscript(made, tips(made), UrSettings(way="movel")))
    runs = [kind for k, kind in enumerate(found.kind) if k == 0 or found.kind[k - 1] != kind]
    assert runs == ["movej", "movel", "movej", "movel", "movej"]


def test_one_program_of_short_lines_in_plain_text():
    made = motion()
    for way in ("servoj", "movel"):
        text = to_urscript(made, tips(made), UrSettings(way=way)).decode("ascii")
        assert text.startswith("def limner():\n  # 2 strokes")
        assert text.endswith("\nend\n")
        assert to_urscript(made, tips(made), UrSettings(way=way)).decode() == text
        assert "nan" not in text
        assert max(map(len, text.splitlines())) < 140


def test_seven_joints_are_refused():
    made = motion(dof=7)
    with pytest.raises(BadInput, match="6 joints; this one has 7"):
        to_urscript(made, np.zeros((len(made.t_s), 3)), UrSettings())


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text[:-5],
        lambda text: text.replace(b"servoj([", b"servoj([nan, ", 1),
        lambda text: text.replace(b"servoj([", b"servoj([1, ", 1),
        lambda text: text.replace(b"stopj(2)", b"set_digital_out(0, True)"),
        lambda text: text[20:],
        lambda text: b"\xff" + text,
        lambda text: b"",
    ],
)
def test_what_is_no_such_program_is_refused(change):
    made = motion()
    with pytest.raises(BadInput, match="URScript"):
        read_urscript(change(to_urscript(made, tips(made), UrSettings())))


def test_waypoints_are_the_same_in_a_table():
    made = motion()
    poses = joints.waypoints(made, np.column_stack([tips(made), np.tile([1.0, 0, 0, 0], (len(made.t_s), 1))]))
    header, *rows = joints.waypoints_bytes(poses, "base", ".csv").decode().splitlines()
    assert header == "t_s,x_m,y_m,z_m,qw,qx,qy,qz,down,stroke"
    table = np.array([row.split(",") for row in rows], float)
    assert (table[:, 0] == made.t_s).all()
    assert (table[:, 1:4] == tips(made)).all()
    assert (table[:, 8:] == np.column_stack([made.down, made.stroke])).all()
    with pytest.raises(BadInput, match=r"choose \.json, \.csv"):
        joints.waypoints_format("w.txt")


def test_the_command_writes_what_its_trajectory_says(monkeypatch, tmp_path):
    pytest.importorskip("urdf_parser_py", reason="pip install 'limner[robot]'")
    pytest.importorskip("toppra", reason="pip install 'limner[robot]'")
    made = Drawing(
        (np.array([[60.0, 80], [80, 90], [90, 70]]), np.array([[60.0, 100], [70, 110]])), ("face",) * 2, [1, 1]
    )
    monkeypatch.chdir(tmp_path)
    (tmp_path / "d.json").write_text(storage.to_json(made))
    outs = ["-o", "m.script", "-o", "m.npz", "--waypoints", "w.csv"]
    monkeypatch.setattr(sys, "argv", ["limner", "plan", "d.json", "--robot", "ur5e", "--place", "0.45,0,0", *outs])
    with pytest.raises(SystemExit) as exit_:
        main()
    assert exit_.value.code == 0
    found, saved = read_urscript((tmp_path / "m.script").read_bytes()), joints.load("m.npz")
    assert np.abs(found.q - saved.at(found.t_s)).max() < 1e-6
    assert len((tmp_path / "w.csv").read_text().splitlines()) == len(saved.t_s) + 1

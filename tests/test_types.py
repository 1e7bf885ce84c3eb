"""The types check their shapes once, are read-only, compare by content, and come back from every file format."""

from __future__ import annotations

import contextlib
import dataclasses

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra import numpy as hnp

from limner import storage
from limner.errors import BadInput
from limner.types import Drawing, EdgeMap, Face, JointTrajectory, Page, Pen, PenPath, Photo, Strokes

FINITE = st.floats(-1e6, 1e6)
LINES = st.lists(hnp.arrays(np.float64, st.tuples(st.integers(1, 6), st.just(2)), elements=FINITE), max_size=5)


def face(**changes):
    points = np.stack([np.arange(68.0) * 3, np.arange(68.0) % 7], axis=1)
    return dataclasses.replace(Face(points, np.array([0, 0, 10, 10.0]), 1.5, -15, "test"), **changes)


def strokes(lines):
    return Strokes(tuple(lines), ("eye",) * len(lines), np.arange(len(lines)), (640, 480))


def drawing(lines):
    return Drawing(tuple(lines), ("hair",) * len(lines), np.ones(len(lines)), Page(100, 120, 5), (Pen(0.3),))


def samples(n=4, dof=2):
    t = np.arange(n, dtype=float)
    down, stroke = np.arange(n) % 2 == 0, np.arange(n) - 1
    path = PenPath(t, np.ones((n, 3)) * t[:, None], down, stroke)
    q = np.outer(t, np.arange(1, dof + 1))
    return path, JointTrajectory(tuple(f"joint_{i}" for i in range(dof)), t, q, q, q, down, stroke)


@given(LINES)
def test_lines_survive_json_and_npz(lines):
    for value in (strokes(lines), drawing(lines)):
        kind = type(value)
        assert storage.from_json(kind, storage.to_json(value)) == value
        assert storage.from_npz(kind, storage.to_npz(value)) == value


def everything():
    path, trajectory = samples()
    mask = np.eye(3, 4) > 0
    edges = EdgeMap(mask, mask * 0.5, mask * 1.0)
    return [Photo(np.arange(60).reshape(4, 5, 3)), face(), edges, path, trajectory, drawing([np.ones((3, 2))])]


@pytest.mark.parametrize("value", everything(), ids=lambda v: type(v).__name__)
@pytest.mark.parametrize("suffix", [".json", ".npz"])
def test_saved_and_loaded_is_the_same(value, suffix, tmp_path):
    path = tmp_path / f"value{suffix}"
    storage.save(value, path)
    first = path.read_bytes()
    assert storage.load(type(value), path) == value
    storage.save(value, path)
    assert path.read_bytes() == first
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


def test_every_stored_type_is_tested():
    assert {type(v) for v in everything()} | {Strokes} == set(storage.STORED)


@pytest.mark.parametrize("value", everything(), ids=lambda v: type(v).__name__)
def test_arrays_are_read_only_copies(value):
    for field in dataclasses.fields(value):
        item = getattr(value, field.name)
        for array in item if isinstance(item, tuple) else [item]:
            if isinstance(array, np.ndarray):
                assert not array.flags.writeable
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(value, dataclasses.fields(value)[0].name, None)


def test_the_source_array_stays_writeable():
    rgb = np.zeros((2, 2, 3), np.uint8)
    photo = Photo(rgb)
    rgb[:] = 9
    assert photo.rgb.max() == 0


def test_equality_sees_every_field():
    assert face() == face()
    for change in ({"score": 2.0}, {"yaw_deg": 1.0}, {"detector": "x"}, {"points_px": np.zeros((68, 2))}):
        assert face(**change) != face()


BAD = {
    "photo shape": lambda: Photo(np.zeros((4, 4))),
    "photo empty": lambda: Photo(np.zeros((0, 4, 3))),
    "face count": lambda: face(points_px=np.zeros((67, 2))),
    "face nan": lambda: face(points_px=np.full((68, 2), np.nan)),
    "face box": lambda: face(box_px=(5, 0, 5, 9)),
    "edge shape": lambda: EdgeMap(np.zeros((3, 3)), np.zeros((3, 4)), np.zeros((3, 3))),
    "edge strength": lambda: EdgeMap(np.zeros((3, 3)), np.full((3, 3), 1.1), np.zeros((3, 3))),
    "edge angle": lambda: EdgeMap(np.zeros((3, 3)), np.zeros((3, 3)), np.full((3, 3), np.pi)),
    "line of three coordinates": lambda: strokes([np.zeros((2, 3))]),
    "line without points": lambda: strokes([np.zeros((0, 2))]),
    "region": lambda: Strokes((np.zeros((2, 2)),), ("elbow",), [1], (4, 4)),
    "region count": lambda: Drawing((np.zeros((2, 2)),), (), [1]),
    "weight count": lambda: Drawing((np.zeros((2, 2)),), ("eye",), [1, 2]),
    "page margin": lambda: Page(100, 50, 25),
    "page nan": lambda: Page(float("nan"), 50, 5),
    "page zero": lambda: Page(0, 50, 0),
    "pen": lambda: Pen(0),
    "time goes back": lambda: PenPath([1, 0], np.zeros((2, 3)), [0, 0], [0, 0]),
    "no samples": lambda: PenPath([], np.zeros((0, 3)), [], []),
    "joint count": lambda: JointTrajectory(("a",), [0], np.zeros((1, 2)), np.zeros((1, 2)), np.zeros((1, 2)), [0], [0]),
}


@pytest.mark.parametrize("make", BAD.values(), ids=BAD.keys())
def test_wrong_values_are_named(make):
    with pytest.raises(BadInput, match=r"expected|leaves nothing") as error:
        make()
    assert "\n" not in str(error.value)


def test_time_is_a_function():
    path, trajectory = samples()
    assert np.allclose(path.at(1.5), 1.5)
    assert np.allclose(path.at([-1, 99]), [[0] * 3, [3] * 3])
    assert np.allclose(trajectory.at(0.25), [0.25, 0.5])


def test_outer_eye_is_the_distance_of_landmarks_36_and_45():
    points = np.zeros((68, 2))
    points[45] = 3, 4
    assert face(points_px=points).outer_eye_px == 5
    with pytest.raises(BadInput, match="one point"):
        _ = face(points_px=np.zeros((68, 2))).outer_eye_px
    with pytest.raises(BadInput, match="profile"):
        _ = face(points_px=np.zeros((39, 2))).outer_eye_px


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", "null", '{"points_px": 3}', '{"x": 1}', "[" * 100_000, '{"points_px": NaN}']
)
def test_hostile_json_is_bad_input(text):
    with pytest.raises(BadInput):
        storage.from_json(Face, text)


@given(st.binary(max_size=300))
def test_any_bytes_are_bad_input(data):
    with pytest.raises(BadInput):
        storage.from_npz(Strokes, data)


def test_a_damaged_npz_is_bad_input_or_the_value():
    data = bytearray(storage.to_npz(strokes([np.arange(20.0).reshape(10, 2)])))
    for i in range(0, len(data), 3):
        broken = bytearray(data)
        broken[i] ^= 0x55
        with contextlib.suppress(BadInput):
            storage.from_npz(Strokes, bytes(broken))


def test_an_object_array_is_never_unpickled():
    import io

    out = io.BytesIO()
    np.savez(out, lines_px=np.array([object()], dtype=object))
    with pytest.raises(BadInput):
        storage.from_npz(Strokes, out.getvalue())


def test_a_folder_is_made_with_those_around_it_or_what_is_in_the_way_is_named(tmp_path):
    wanted = tmp_path / "one" / "two"
    assert storage.make_folder(wanted) == storage.make_folder(str(wanted)) == wanted
    assert wanted.is_dir()
    (tmp_path / "file").write_bytes(b"")
    for inside in ("file", "file/deeper"):
        with pytest.raises(BadInput, match="no folder can be made there"):
            storage.make_folder(tmp_path / inside)


def test_nothing_is_left_when_writing_fails(tmp_path):
    with pytest.raises(BadInput, match="cannot be written"):
        storage.write_whole(tmp_path / "no such folder" / "x.svg", b"")
    (tmp_path / "folder.svg").mkdir()
    with pytest.raises(BadInput, match="cannot be written"):
        storage.write_whole(tmp_path / "folder.svg", b"data")
    assert [p.name for p in tmp_path.iterdir()] == ["folder.svg"]

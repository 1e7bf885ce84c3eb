"""Landmarks from files: what our own output and the usual formats hold, and everything that may be wrong with them."""

import json

import numpy as np
import pytest

from limner.errors import BadInput
from limner.storage import save, to_fields
from limner.types import Face
from limner.vision.landmarks.annotation import read_faces

POINTS = np.random.default_rng(0).uniform(10, 300, (68, 2)).round(3)
FACE = Face(POINTS, [0, 0, 310, 310], 1.5, -15.0, "fmp")
SMALL = Face(POINTS / 4, [0, 0, 80, 80])


def pts(points, count=None):
    rows = "\n".join(f"{x} {y}" for x, y in points)
    return f"version: 1\nn_points:  {len(points) if count is None else count}\n{{\n{rows}\n}}\n"


def csv(points):
    return "\n".join(f"{x},{y}" for x, y in points)


def test_what_limner_face_prints_comes_back_largest_first(tmp_path):
    (tmp_path / "faces.json").write_text(json.dumps({"faces": [to_fields(SMALL), to_fields(FACE)]}))
    assert read_faces(tmp_path / "faces.json") == (FACE, SMALL)


def test_a_saved_face_comes_back(tmp_path):
    save(FACE, tmp_path / "face.json")
    assert read_faces(str(tmp_path / "face.json")) == (FACE,)


def test_points_alone_get_a_box(tmp_path):
    (tmp_path / "face.json").write_text(json.dumps({"points_px": POINTS.tolist()}))
    (face,) = read_faces(tmp_path / "face.json")
    assert np.array_equal(face.points_px, POINTS)
    assert np.array_equal(face.box_px, [*POINTS.min(axis=0), *POINTS.max(axis=0)])
    assert face.detector == "file"


def test_no_faces_are_no_error(tmp_path):
    (tmp_path / "none.json").write_text('{"faces": []}')
    assert read_faces(tmp_path / "none.json") == ()


@pytest.mark.parametrize("count", [68, 39])
@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_ibug_points_count_from_one(tmp_path, count, ending):
    (tmp_path / "face.PTS").write_bytes(pts(POINTS[:count]).replace("\n", ending).encode())
    (face,) = read_faces(tmp_path / "face.PTS")
    np.testing.assert_allclose(face.points_px, POINTS[:count] - 1)


@pytest.mark.parametrize("heading", ["", "x,y\n", "x_px, y_px\n", "\ufeffx,y\n"])
def test_csv_counts_from_zero(tmp_path, heading):
    (tmp_path / "face.csv").write_text(heading + csv(POINTS) + "\n\n", encoding="utf-8")
    (face,) = read_faces(tmp_path / "face.csv")
    assert np.array_equal(face.points_px, POINTS)


BAD = {
    "empty.json": "",
    "broken.json": '{"faces": [',
    "deep.json": "[" * 100_000,
    "list.json": "[1, 2]",
    "other.json": '{"strokes": 3}',
    "number.json": "3",
    "faces-number.json": '{"faces": 3}',
    "face-number.json": '{"faces": [3]}',
    "points-text.json": '{"faces": [{"points_px": "abc"}]}',
    "points-few.json": json.dumps({"points_px": POINTS[:67].tolist()}),
    "points-none.json": '{"points_px": []}',
    "points-ragged.json": '{"points_px": [[1, 2], [3]]}',
    "points-nan.json": json.dumps({"points_px": [*POINTS[:67].tolist(), [float("nan"), 1]]}),
    "points-far.json": json.dumps({"points_px": [*POINTS[:67].tolist(), [1e300, 1]]}),
    "points-one-place.json": json.dumps({"points_px": [[1, 1]] * 68}),
    "box-far.json": json.dumps(to_fields(FACE) | {"box_px": [0, 0, 1e200, 1e200]}),
    "unknown-field.json": json.dumps(to_fields(FACE) | {"colour": "red"}),
    "empty.pts": "",
    "no-brace.pts": "version: 1\nn_points: 68\n1 2\n",
    "no-end.pts": pts(POINTS).replace("}", ""),
    "more.pts": pts(POINTS) + "1 2\n",
    "count.pts": pts(POINTS, 67),
    "three.pts": pts(POINTS).replace("{\n", "{\n1 2 3\n"),
    "words.pts": pts(POINTS).replace("{\n", "{\nleft eye\n"),
    "nan.pts": pts(POINTS).replace(str(POINTS[0, 0]), "nan"),
    "empty.csv": "",
    "few.csv": csv(POINTS[:12]),
    "three.csv": csv(POINTS).replace("\n", ",0\n", 1),
    "words.csv": "name,place\n" + csv(POINTS),
    "infinite.csv": csv(POINTS[:67]) + "\ninf,3",
    "image.jpg": "",
    "without-suffix": "",
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_gives_one_line_with_its_name(tmp_path, name):
    (tmp_path / name).write_text(BAD[name])
    with pytest.raises(BadInput) as caught:
        read_faces(tmp_path / name)
    assert str(caught.value).startswith(str(tmp_path / name))
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < len(str(tmp_path)) + 300


@pytest.mark.parametrize("name", ["face.csv", "face.json", "face.pts"])
def test_bytes_that_are_no_text(tmp_path, name):
    (tmp_path / name).write_bytes(b"\xff\xfe\x00\x01\x80")
    with pytest.raises(BadInput, match="UTF-8"):
        read_faces(tmp_path / name)


def test_missing_file_folder_and_empty_name(tmp_path):
    for path in (tmp_path / "nowhere.json", tmp_path, ""):
        with pytest.raises(BadInput):
            read_faces(path)

"""Face models: the file format, everything that a damaged or hostile file may hold, and the import of the authors'."""

import contextlib
import dataclasses
import io
import json
import pickle
import sys
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import fmp_toy
from limner.errors import BadInput, MissingExtra
from limner.storage import pack_npz, unpack_npz
from limner.vision.landmarks.fmp import model as model_module
from limner.vision.landmarks.fmp.matlab import import_matlab
from limner.vision.landmarks.fmp.model import (
    Component,
    FmpModel,
    default_model,
    load_model,
    pack_model,
    save_model,
    unpack_model,
)

TOY = fmp_toy.model_of(fmp_toy.texture(), meta={"data": "noise", "numbers": {"error": 0.5}})


def component(**changes):
    fields = {name: getattr(TOY.components[0], name) for name in ("yaw_deg", "bias", "parents", "filters")}
    fields |= {name: getattr(TOY.components[0], name) for name in ("springs", "anchors", "landmarks")}
    return Component(**(fields | changes))


def changed(**arrays):
    """The toy's file with some arrays replaced, or left out where None."""
    known = unpack_npz(pack_model(TOY)) | arrays
    return pack_npz({name: array for name, array in known.items() if array is not None})


def test_a_saved_model_comes_back(tmp_path):
    save_model(TOY, tmp_path / "toy.npz")
    assert load_model(tmp_path / "toy.npz") == TOY
    assert (tmp_path / "toy.npz").read_bytes() == pack_model(TOY)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_precision_and_several_components_survive(dtype):
    single = FmpModel(np.ones((1, 5, 5, 32)), (Component(15, 1, [-1], [0], [[0] * 4], [[0, 0]], [0]),), 0.5)
    both = dataclasses.replace(TOY, filters=TOY.filters.astype(dtype), components=TOY.components + single.components)
    back = unpack_model(pack_model(both))
    assert back == both
    assert back.filters.dtype == dtype


def test_rest_shape_is_where_each_spring_costs_least():
    tree = component(springs=[[0] * 4, [0.1, 0.2, 0.3, -0.6], [1, 0, 1, 0], [1, 0, 1, 0]])
    child = tree.rest_cells[1]
    d = tree.anchors[1] - child

    def cost(dx, dy):
        return 0.1 * dx**2 + 0.2 * dx + 0.3 * dy**2 - 0.6 * dy

    assert all(cost(*d) < cost(d[0] + x, d[1] + y) for x, y in [(0.1, 0), (-0.1, 0), (0, 0.1), (0, -0.1)])
    np.testing.assert_allclose(tree.rest_cells[3], tree.rest_cells[1] + tree.anchors[3])


def test_smallest_face_grows_with_the_anchors():
    wider = component(anchors=TOY.components[0].anchors * 2)
    assert dataclasses.replace(TOY, components=(wider,)).smallest_face_px > TOY.smallest_face_px
    assert TOY.smallest_face_px == (18 - 9 + 5) * 4


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("parents", [0, 0, 0, 1]),
        ("parents", [-1, 0, 0, 3]),
        ("parents", [-1, 2, 1, 0]),
        ("parents", [-1, 0, 0, -1]),
        ("parents", [-1.0, 0, 0, 1]),
        ("filters", [0, 1, 2, 4]),
        ("filters", [0, 1, 2, -1]),
        ("springs", [[0] * 4] * 4),
        ("springs", [[0] * 4, [1, 0, -1, 0], [1, 0, 1, 0], [1, 0, 1, 0]]),
        ("springs", [[0] * 4, [np.nan, 0, 1, 0], [1, 0, 1, 0], [1, 0, 1, 0]]),
        ("springs", [[1, 0, 1, 0]] * 4),
        ("anchors", [[0, 0], [1, 2], [3, 4], [2**40, 0]]),
        ("anchors", [[1, 0], [1, 2], [3, 4], [2, 0]]),
        ("anchors", [[0.0, 0], [1, 2], [3, 4], [2, 0]]),
        ("landmarks", [0, 1, 2, 2]),
        ("bias", np.inf),
    ],
)
def test_an_impossible_component_is_refused(field, value):
    with pytest.raises(BadInput):
        dataclasses.replace(TOY, components=(component(**{field: value}),))


def hostile():
    """Files that a reader must survive, by what is wrong with them."""
    good, arrays = pack_model(TOY), unpack_npz(pack_model(TOY))
    yield "empty", b""
    yield "text", b"no model at all"
    yield "pickle", pickle.dumps({"filters": 1})
    yield "another npz", pack_npz({"a": np.arange(3)})
    yield "cut in half", good[: len(good) // 2]
    yield "first bytes lost", good[10:]
    for name in arrays:
        yield f"without {name}", changed(**{name: None})
        if name != "name":
            yield f"{name} a text", changed(**{name: np.array("x")})
        yield f"{name} empty", changed(**{name: arrays[name].ravel()[:0]})
        if arrays[name].dtype.kind == "f":
            yield f"{name} infinite", changed(**{name: np.full_like(arrays[name], np.inf)})
            yield f"{name} huge", changed(**{name: np.full_like(arrays[name], 1e300)})
        if arrays[name].dtype.kind == "i":
            yield f"{name} huge", changed(**{name: np.full_like(arrays[name], 2**62)})
            yield f"{name} negative", changed(**{name: np.full_like(arrays[name], -5)})
    yield "meta a list", changed(meta=np.array("[1]"))
    yield "meta nested deep", changed(meta=np.array("[" * 100_000))
    yield "another format", changed(format=np.array("limner-fmp-99"))
    yield "objects", _with_member("filters.npy", _object_array())
    yield "a claim of a terabyte", _with_member("filters.npy", _claims(2**40))


def _object_array():
    out = io.BytesIO()
    np.lib.format.write_array(out, np.array([print], dtype=object), allow_pickle=True)
    return out.getvalue()


def _claims(count):
    out = io.BytesIO()
    header = {"descr": "<f8", "fortran_order": False, "shape": (count, 5, 5, 32)}
    np.lib.format.write_array_header_1_0(out, header)
    return out.getvalue()


def _with_member(name, data):
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(pack_model(TOY))) as old, zipfile.ZipFile(out, "w") as new:
        for info in old.infolist():
            new.writestr(info.filename, data if info.filename == name else old.read(info))
    return out.getvalue()


@pytest.mark.parametrize(("what", "data"), list(hostile()), ids=lambda value: value if isinstance(value, str) else "")
def test_a_hostile_file_gives_one_line(what, data):
    with pytest.raises(BadInput) as caught:
        unpack_model(data, "some.npz")
    assert "some.npz" in str(caught.value)
    assert "\n" not in str(caught.value)


@given(st.data())
@settings(max_examples=60, deadline=None)
def test_a_flipped_byte_never_crashes(data):
    good = bytearray(pack_model(TOY))
    good[data.draw(st.integers(0, len(good) - 1))] ^= data.draw(st.integers(1, 255))
    with contextlib.suppress(BadInput):
        assert isinstance(unpack_model(bytes(good)), FmpModel)


def test_a_missing_file_gives_one_line(tmp_path):
    with pytest.raises(BadInput, match=r"nowhere\.npz"):
        load_model(tmp_path / "nowhere.npz")


def test_an_installation_without_the_shipped_model_says_so(monkeypatch):
    monkeypatch.setattr(model_module, "SHIPPED", "absent.npz")
    with pytest.raises(BadInput, match=r"absent\.npz"):
        default_model.__wrapped__()


@pytest.mark.parametrize(("name", "filters"), [("face_p146_small", 146), ("face_p99", 99)])
def test_the_authors_models_are_read(shared, name, filters):
    model = import_matlab(shared / f"data/zhu-ramanan/{name}.mat")
    assert model.threshold == -0.65  # as in the release's demonstration, not as stored
    assert model.filters.shape == (filters, 5, 5, 32)
    assert [len(part.parents) for part in model.components] == [39] * 3 + [68] * 7 + [39] * 3
    assert [part.yaw_deg for part in model.components] == list(range(90, -91, -15))
    assert (model.cell_px, model.interval, model.name) == (4, 10, name)
    assert unpack_model(pack_model(model)) == model
    order = json.loads((shared / "data/zhu-ramanan/zr68_to_ibug68.json").read_text())
    assert model.components[6].landmarks.tolist() == order["part_to_ibug68"]


def test_part_order_puts_the_face_together(shared):
    rest = import_matlab(shared / "data/zhu-ramanan/face_p146_small.mat").components[6]
    points = np.empty((68, 2))
    points[rest.landmarks] = rest.rest_cells
    eyes, nose, mouth, chin = points[36:48], points[30], points[48:68], points[8]
    assert points[36, 0] < points[39, 0] < points[42, 0] < points[45, 0]
    assert points[17:27, 1].mean() < eyes[:, 1].mean() < nose[1] < mouth[:, 1].mean() < chin[1]
    assert points[0, 0] < points[8, 0] < points[16, 0]
    assert (np.diff(points[:16, 0]) > 0).all()


@pytest.mark.parametrize("data", [b"", b"MATLAB 5.0 MAT-file", b"x" * 1000])
def test_a_damaged_matlab_file_gives_one_line(tmp_path, data):
    (tmp_path / "face.mat").write_bytes(data)
    with pytest.raises(BadInput, match=r"face\.mat"):
        import_matlab(tmp_path / "face.mat")


def test_another_matlab_file_gives_one_line(tmp_path):
    savemat = pytest.importorskip("scipy.io").savemat
    savemat(tmp_path / "face.mat", {"model": {"filters": 3, "sbin": "x"}})
    with pytest.raises(BadInput, match=r"face\.mat"):
        import_matlab(tmp_path / "face.mat")


def test_without_scipy_the_extra_is_named(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "scipy.io", None)
    with pytest.raises(MissingExtra, match="train"):
        import_matlab(tmp_path / "face.mat")

import cv2
import numpy as np
import pytest

from limner.errors import BadInput
from limner.storage import pack_npz
from limner.vision.landmarks import mesh
from limner.vision.landmarks.fmp.completion import LEAST_EYE_PX, MOST_YAW_DEG, completed
from limner.vision.landmarks.fmp.dataset import SURE, Sample, folds, read_folder, similarity, transform

FACE = np.stack([np.linspace(10, 50, 68), 20 + 10 * np.sin(np.arange(68))], axis=1)


def write(folder, names=("a_1.png", "b_1.png"), labels="landmarks.npz", images="images", **changes):
    (folder / images).mkdir(parents=True, exist_ok=True)
    for name in names:
        cv2.imwrite(str(folder / images / name), np.zeros((48, 64, 3), np.uint8))
    n = len(names)
    arrays = {"names": np.array(names), "size_wh": np.full((n, 2), [64, 48]), "ibug68": np.stack([FACE] * n)}
    arrays |= changes
    (folder / labels).write_bytes(pack_npz({key: value for key, value in arrays.items() if value is not None}))
    return folder


def test_reads_path_person_and_points(tmp_path):
    samples, left_out = read_folder(write(tmp_path / "set"))
    assert left_out == []
    assert [sample.person for sample in samples] == ["set/a", "set/b"]
    assert samples[0].path.is_file()
    assert (samples[0].points_px == FACE).all()
    assert samples[0].size_px == (64, 48)
    assert not samples[0].machine


def test_a_person_is_one_in_all_folders_of_a_set(tmp_path):
    write(tmp_path / "set", ("001_03.png",))
    write(tmp_path / "set", ("001_08.png",), "landmarks_smiling_machine.npz", "smiling")
    neutral, _ = read_folder(tmp_path / "set")
    smiling, _ = read_folder(tmp_path / "set" / "landmarks_smiling_machine.npz")
    assert neutral[0].person == smiling[0].person
    assert smiling[0].path.parent.name == "smiling"


def test_a_folder_of_images_will_do_when_its_labels_are_clear(tmp_path):
    write(tmp_path / "set")
    write(tmp_path / "set", ("c_2.png",), "landmarks_x_machine.npz", "x")
    assert [sample.path.name for sample in read_folder(tmp_path / "set" / "x")[0]] == ["c_2.png"]
    assert len(read_folder(tmp_path / "set" / "images")[0]) == 2


def test_a_machines_landmarks_are_those_of_its_mesh(tmp_path):
    points = np.random.default_rng(0).uniform(5, 45, (2, mesh.POINTS, 2)).astype(np.float32)
    samples, _ = read_folder(write(tmp_path / "set", labels="landmarks_machine.npz", mp468=points))
    for sample, face in zip(samples, points, strict=True):
        assert sample.machine
        assert sample.points_px == pytest.approx(mesh.landmarks(face.astype(np.float64)))
    by_hand, _ = read_folder(write(tmp_path / "other", mp468=points))
    assert (by_hand[0].points_px == FACE).all()


def test_what_a_machine_is_not_sure_of_is_left_out_and_named(tmp_path):
    score = np.array([SURE, SURE - 0.001])
    samples, left_out = read_folder(write(tmp_path / "set", labels="landmarks_machine.npz", score=score))
    assert [sample.path.name for sample in samples] == ["a_1.png"]
    assert len(left_out) == 1
    assert "b_1.png: the machine is not sure" in left_out[0]


@pytest.mark.parametrize(
    ("eye_px", "aside", "reason"),
    [(LEAST_EYE_PX + 1, 0.0, ""), (LEAST_EYE_PX - 1, 0.0, "px apart"), (100.0, 0.4, "turned by 42 degrees")],
)
def test_a_machines_landmarks_of_small_or_turned_faces_are_not_learned_from(eye_px, aside, reason):
    points = np.random.default_rng(0).uniform(0, 1, (68, 2))
    points[[36, 45, 30]] = [[0, 0], [1, 0], [0.5 + aside, 0.4]]
    by_hand = Sample("a.png", "a", points * eye_px, (300, 300))
    by_machine = Sample("b.png", "b", points * eye_px, (300, 300), machine=True)
    filled, left_out = completed([by_hand, by_machine])
    assert filled == [by_hand, *([] if reason else [by_machine])]
    assert len(left_out) == bool(reason)
    assert all("b.png" in line and reason in line for line in left_out)
    assert MOST_YAW_DEG < 42


def test_a_machines_jaw_is_not_trusted_without_its_mesh(tmp_path):
    samples, _ = read_folder(write(tmp_path / "set", labels="landmarks_machine.npz"))
    assert samples[0].machine
    assert not samples[0].known[:17].any()
    assert samples[0].known[17:].all()


def test_a_jaw_of_the_same_person_is_borrowed():
    points = FACE * 10
    points[[36, 45, 30]] = [[200, 200], [400, 200], [300, 300]]
    turned = points @ np.array([[0, 1], [-1, 0]]) * 0.5 + [450, 0]
    smiling = turned + np.where(np.arange(68)[:, None] >= 48, [0, 3], 0)
    seen = np.where(np.arange(68)[:, None] < 17, np.nan, smiling)
    neutral = Sample("a_1.png", "set/a", points, (600, 600))
    others = [Sample(f"{k}_2.png", f"set/{k}", seen, (600, 600), machine=True) for k in "ac"]
    filled, left_out = completed([*others, neutral])
    assert [sample.path for sample in filled] == ["a_2.png", "a_1.png"]
    assert filled[0].points_px == pytest.approx(smiling)
    assert filled[0].guessed.tolist() == [True] * 17 + [False] * 51
    assert not filled[1].guessed.any()
    assert len(left_out) == 1
    assert "c_2.png" in left_out[0]


def nan_face():
    return np.stack([np.full((68, 2), np.nan), FACE])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"size_wh": np.array([[64, 48], [48, 64]])}, "b_1.png: 64 x 48 px"),
        ({"ibug68": nan_face()}, "a_1.png: none of its landmarks"),
        ({"ibug68": np.stack([FACE, FACE * 100])}, "b_1.png: a landmark far outside"),
    ],
)
def test_a_bad_entry_is_named_and_refused_or_left_out(tmp_path, changes, message):
    write(tmp_path / "set", **changes)
    with pytest.raises(BadInput, match=message):
        read_folder(tmp_path / "set")
    samples, left_out = read_folder(tmp_path / "set", skip=True)
    assert len(samples) == len(left_out) == 1
    assert message.partition(":")[0] in left_out[0]


def test_a_face_without_a_score_beside_others_is_left_out(tmp_path):
    samples, left_out = read_folder(write(tmp_path / "set", score=np.array([1.0, np.nan])))
    assert [sample.path.name for sample in samples] == ["a_1.png"]
    assert "not sure" in left_out[0]


def test_a_missing_or_broken_image_is_named(tmp_path):
    write(tmp_path / "set")
    (tmp_path / "set" / "images" / "a_1.png").unlink()
    (tmp_path / "set" / "images" / "b_1.png").write_bytes(b"no image")
    with pytest.raises(BadInput, match=r"a_1\.png: .*missing"):
        read_folder(tmp_path / "set")
    with pytest.raises(BadInput, match="no usable face"):
        read_folder(tmp_path / "set", skip=True)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ibug68": None}, "has no ibug68"),
        ({"ibug68": np.zeros((2, 5, 2))}, r"\(2, 5, 2\)"),
        ({"score": np.ones(3)}, r"score of shape \(3,\)"),
        ({"names": np.array(["a_1.png", "a_1.png"])}, "named twice"),
        ({"size_wh": np.full((2, 2), np.nan)}, "size_wh of type float64; expected whole numbers"),
        ({"score": np.array(["1", "1"])}, "score of type <U1; expected numbers"),
    ],
)
def test_labels_of_another_form_are_refused(tmp_path, changes, message):
    with pytest.raises(BadInput, match=message):
        read_folder(write(tmp_path / "set", **changes))


def test_labels_must_be_there_and_clear(tmp_path):
    with pytest.raises(BadInput, match="found none"):
        read_folder(tmp_path)
    write(tmp_path, labels="landmarks_x.npz", images="x")
    write(tmp_path, labels="landmarks_y.npz", images="y")
    with pytest.raises(BadInput, match=r"landmarks_x\.npz, landmarks_y\.npz"):
        read_folder(tmp_path)
    assert len(read_folder(tmp_path / "landmarks_y.npz")[0]) == 2


def some(persons, photos=2):
    return [Sample(f"{p}_{k}", f"set/{p}", FACE, (64, 48)) for p in range(persons) for k in range(photos)]


@pytest.mark.parametrize("count", [2, 5, 7])
def test_every_person_is_held_out_once(count):
    parts = folds(some(13), count)
    assert len(parts) == count
    assert sorted(person for part in parts for person in part) == sorted({sample.person for sample in some(13)})
    assert max(map(len, parts)) - min(map(len, parts)) <= 1
    assert parts == folds(some(13)[::-1], count)


def test_folds_need_as_many_persons():
    with pytest.raises(BadInput, match="3 of 2 persons"):
        folds(some(2), 3)


@pytest.mark.parametrize("seed", range(3))
def test_similarity_is_recovered(seed):
    rng = np.random.default_rng(seed)
    angle, scale, shift = rng.uniform(-3, 3), rng.uniform(0.2, 5), rng.normal(size=2) * 50
    turn = scale * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    target = FACE @ turn.T + shift
    assert transform(similarity(FACE, target), FACE) == pytest.approx(target)


@pytest.mark.parametrize(("aside", "sign"), [(8.0, 1), (-8.0, -1), (0.0, 0)])
def test_yaw_follows_the_nose(aside, sign):
    points = np.zeros((68, 2))
    points[[36, 45, 30]] = [[0, 0], [40, 0], [20 + aside, 15]]
    assert np.sign(Sample("x", "x", points, (64, 48)).yaw_deg) == sign


def test_reads_the_shared_sets(shared):
    london, _ = read_folder(shared / "data" / "london")
    smiling, _ = read_folder(shared / "data" / "london" / "landmarks_smiling_machine.npz")
    assert len(london) == len(smiling) == 78
    assert {sample.person for sample in london} == {sample.person for sample in smiling}
    free, unsure = read_folder(shared / "data" / "inter-faces-cc0")
    assert (len(free), len(unsure)) == (64, 6)
    filled, left_out = completed(smiling + london)
    assert all(sample.known.all() for sample in filled)
    assert left_out == []

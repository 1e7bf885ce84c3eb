import dataclasses
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from limner.errors import BadInput
from limner.storage import pack_npz
from limner.types import Photo
from limner.vision.landmarks.fmp import checkpoint
from limner.vision.landmarks.fmp.dataset import Sample, read_folder
from limner.vision.landmarks.fmp.detector import FmpSettings, detect
from limner.vision.landmarks.fmp.examples import Examples
from limner.vision.landmarks.fmp.latent import place
from limner.vision.landmarks.fmp.layout import LEAST_SPRING, Layout, features
from limner.vision.landmarks.fmp.matching import Forest
from limner.vision.landmarks.fmp.mining import is_right, mine, overlap
from limner.vision.landmarks.fmp.model import FmpModel, pack_model, save_model
from limner.vision.landmarks.fmp.positives import (
    Pose,
    View,
    cells_to_points,
    points_to_cells,
    render,
    show,
    views,
)
from limner.vision.landmarks.fmp.response import responses
from limner.vision.landmarks.fmp.scenes import of_folder, of_samples, read_image, textures
from limner.vision.landmarks.fmp.train_settings import TrainSettings
from limner.vision.landmarks.fmp.training import train
from limner.vision.landmarks.fmp.turning import DEPTH, turn
from limner.vision.landmarks.mirror import MIRROR
from processes import begun, until

TINY = TrainSettings(eye_cells=10, yaw_deg=0, tilt_deg=0, scene_px=160, textures=2, scenes=8, per_scene=4, patches=2000)


def mask_points():
    """68 landmarks of a made-up face, 1 wide between its outer eye corners, which lie at (-0.5, 0) and (0.5, 0)."""
    t = np.linspace(0, np.pi, 17)
    jaw = np.stack([-0.75 * np.cos(t), 0.1 + 1.1 * np.sin(t)], axis=1)
    brow = np.stack([np.linspace(-0.55, -0.1, 5), [-0.2, -0.28, -0.3, -0.28, -0.22]], axis=1)
    bridge = np.stack([np.zeros(4), np.linspace(0, 0.4, 4)], axis=1)
    base = np.stack([np.linspace(-0.17, 0.17, 5), [0.46, 0.5, 0.52, 0.5, 0.46]], axis=1)
    eye = np.array([[-0.5, 0], [-0.4, -0.06], [-0.28, -0.06], [-0.18, 0], [-0.28, 0.05], [-0.4, 0.05]])
    outer = np.linspace(np.pi, 3 * np.pi, 12, endpoint=False)
    inner = np.linspace(np.pi, 3 * np.pi, 8, endpoint=False)
    lips = np.stack([0.3 * np.cos(outer), 0.78 + 0.12 * np.sin(outer)], axis=1)
    gap = np.stack([0.24 * np.cos(inner), 0.78 + 0.04 * np.sin(inner)], axis=1)
    right_brow, right_eye = brow[::-1] * [-1, 1], eye[[3, 2, 1, 0, 5, 4]] * [-1, 1]
    return np.vstack([jaw, brow, right_brow, bridge, base, eye, right_eye, lips, gap])


def draw_face(rng, size=(150, 170), eye_px=46):
    """A picture of clouds with a made-up face, whose lines run through its landmarks."""
    shape = mask_points() + rng.normal(0, 0.012, (68, 2))
    points = shape * eye_px * rng.uniform(0.95, 1.05) + np.array(size) * [0.5, 0.4] + rng.uniform(-6, 6, 2)
    image = np.full((size[1], size[0], 3), rng.uniform(150, 220, 3))
    image += cv2.resize(rng.normal(0, 25, (12, 12, 3)), size, interpolation=cv2.INTER_CUBIC)
    runs = [range(17), range(17, 22), range(22, 27), range(27, 31), range(31, 36)]
    loops = [range(36, 42), range(42, 48), range(48, 60), range(60, 68)]
    for run in [*runs, *loops]:
        line = np.round(points[list(run)] * 16).astype(np.int32)
        cv2.polylines(image, [line], run in loops, (20, 20, 20), 2, cv2.LINE_AA, 4)
    return np.clip(image + rng.normal(0, 3, image.shape), 0, 255).astype(np.uint8), points


@pytest.fixture(scope="module")
def faces(tmp_path_factory):
    """An annotated folder of 12 made-up faces."""
    folder, rng = tmp_path_factory.mktemp("faces") / "made-up", np.random.default_rng(0)
    (folder / "images").mkdir(parents=True)
    names, points = [], []
    for k in range(12):
        image, landmarks = draw_face(rng)
        names.append(f"{k:02}_0.png")
        cv2.imwrite(str(folder / "images" / names[-1]), image[..., ::-1])
        points.append(landmarks)
    labels = {"names": np.array(names), "size_wh": np.full((12, 2), [150, 170]), "ibug68": np.array(points)}
    (folder / "landmarks.npz").write_bytes(pack_npz(labels))
    return read_folder(folder)[0]


@pytest.fixture(scope="module")
def scenes(faces):
    return [*of_samples(faces[:6]), *textures(2, 0, 160)]


@pytest.fixture(scope="module")
def trained(faces, scenes):
    return train(faces[:8], scenes, TINY)


def test_finds_made_up_faces_it_never_saw(faces, trained, tmp_path):
    save_model(trained.model, tmp_path / "model.npz")
    settings = FmpSettings(model=str(tmp_path / "model.npz"))
    errors = []
    for sample in faces[8:]:
        found = detect(Photo(read_image(sample.path)), settings)
        assert len(found) == 1
        errors.append(np.hypot(*(found[0].points_px - sample.points_px).T).mean() / sample.outer_eye_px)
    assert np.mean(errors) < 0.05


def test_mixtures_may_share_their_filters(faces, scenes, tmp_path):
    settings = TINY.replace(shared=True, tilt_deg=15.0, rounds=1)
    model = train(faces[:8], scenes, settings).model
    assert len(model.components) == 3
    assert model.filters.shape[0] == 68
    for component in model.components:
        assert (component.filters == component.landmarks).all()
    save_model(model, tmp_path / "shared.npz")
    for sample in faces[8:10]:
        (found,) = detect(Photo(read_image(sample.path)), FmpSettings(model=str(tmp_path / "shared.npz")))
        assert np.hypot(*(found.points_px - sample.points_px).T).mean() / sample.outer_eye_px < 0.08


def test_reports_what_it_reached(trained):
    assert len(trained.rounds) == TINY.rounds
    for item in trained.rounds:
        assert item.faces == len(trained.face_scores) == 16
        assert item.solution.converged
        assert 0 <= item.solution.gap <= TINY.gap
    assert np.percentile(trained.face_scores, 5) > trained.model.threshold
    assert trained.model.meta["faces"] == {"made-up/images": 8}


def test_the_learning_curve_falls(trained):
    """More people: less error on people kept aside, who are never easier than those learned from."""
    assert [item.people for item in trained.curve] == sorted({item.people for item in trained.curve})
    first, last = trained.curve[0], trained.curve[-1]
    assert last.unseen_percent <= first.unseen_percent
    assert all(item.unseen_percent > 0.9 * item.seen_percent for item in trained.curve)
    assert trained.model.meta["learning_curve"] == [item.to_dict() for item in trained.curve]


def test_springs_keep_their_floor(trained):
    for component in trained.model.components:
        assert (component.springs[1:, ::2] >= LEAST_SPRING).all()


@pytest.mark.slow
def test_same_seed_same_bytes(faces, scenes, trained):
    again = train(faces[:8], scenes, TINY)
    assert pack_model(again.model) == pack_model(trained.model)


def test_an_interrupted_training_ends_the_same(faces, scenes, trained, tmp_path):
    state = tmp_path / "state.npz"

    class Interrupted(Exception):
        pass

    def interrupt(what, done, total, note):
        if what == "negatives" and state.exists():
            raise Interrupted

    with pytest.raises(Interrupted):
        train(faces[:8], scenes, TINY, interrupt, state)
    seen = []
    resumed = train(faces[:8], scenes, TINY, lambda what, *rest: seen.append(what), state)
    assert "restored" in seen
    assert "background" not in seen
    assert pack_model(resumed.model) == pack_model(trained.model)


TRAIN = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from test_fmp_training import TINY, of_samples, read_folder, textures, train
faces = read_folder(Path(sys.argv[2]))[0]
train(faces[:8], [*of_samples(faces[:6]), *textures(2, 0, 160)], TINY, state=Path(sys.argv[3]))
"""


@pytest.mark.slow
def test_a_killed_training_ends_the_same(faces, scenes, trained, tmp_path):
    """Killed as soon as its first state is there; a state is whole or not there at all."""
    state, folder = tmp_path / "state.npz", faces[0].path.parent.parent
    with begun([sys.executable, "-c", TRAIN, Path(__file__).parent, folder, state]) as process:
        until(lambda: state.exists() or process.poll() is not None)
        assert state.exists()
        process.kill()
    seen = []
    resumed = train(faces[:8], scenes, TINY, lambda what, *rest: seen.append(what), state)
    assert "restored" in seen
    assert pack_model(resumed.model) == pack_model(trained.model)


def test_the_state_of_another_training_is_refused(faces, scenes, tmp_path):
    state = tmp_path / "state.npz"
    train(faces[:4], scenes, TINY.replace(rounds=1), state=state)
    with pytest.raises(BadInput, match="other settings or pictures"):
        train(faces[:4], scenes, TINY.replace(rounds=1, seed=3), state=state)
    with pytest.raises(BadInput, match="other settings or pictures"):
        train(faces[:5], scenes, TINY.replace(rounds=1), state=state)
    assert checkpoint.ticket(TINY, ["a", "b"]) != checkpoint.ticket(TINY, ["b", "a"])


def test_nothing_to_learn_from_is_said(faces, scenes):
    with pytest.raises(BadInput, match="0 usable faces"):
        train([], scenes, TINY)
    with pytest.raises(BadInput, match="0 scenes"):
        train(faces, [], TINY)


def test_progress_is_told_to_its_end(faces, scenes):
    last = {}
    train(faces[:4], scenes, TINY.replace(rounds=1), lambda what, done, total, note: last.update({what: (done, total)}))
    assert {"faces", "background", "negatives", "solution"} <= set(last)
    assert all(done == total for done, total in last.values())


def example_model(trained):
    """The trained model with a second mixture that shares all filters but has other springs."""
    first = trained.model.components[0]
    second = dataclasses.replace(first, springs=first.springs * 1.5, bias=first.bias + 0.25, yaw_deg=15)
    return dataclasses.replace(trained.model, components=(first, second))


def test_layout_packs_and_unpacks(trained):
    model = example_model(trained)
    layout = Layout.of(model.components)
    weights = layout.pack(model)
    again = layout.unpack(weights, model)
    assert np.array_equal(again.filters, model.filters)
    for ours, theirs in zip(again.components, model.components, strict=True):
        assert np.array_equal(ours.springs, theirs.springs)
        assert ours.bias == theirs.bias
    for columns in layout.columns:
        assert len(np.unique(columns)) == len(columns)
    penalty = layout.penalty()
    assert np.isfinite(penalty.lower).sum() == 2 * 2 * 67
    assert sorted(np.unique(penalty.scale)) == [0.01, 0.1, 1.0]


def test_features_times_weights_is_the_score(trained, faces):
    """Eq. 3.4 is the score that the search computes by passing messages."""
    model = example_model(trained)
    layout = Layout.of(model.components)
    weights = layout.pack(model)
    level = show(faces[0], read_image(faces[0].path), [View()], 10, 4)[0].features
    fits = responses(level, model.filters)
    for kind, component in enumerate(model.components):
        match = Forest((component,)).match(fits[component.filters].astype(np.float64))
        y, x = np.unravel_index(match.roots[0].argmax(), match.roots[0].shape)
        cells = match.places(0, np.array([[x, y]]))[0]
        score = features(component, level, cells) @ weights[layout.columns[kind]]
        assert score == pytest.approx(match.roots[0][y, x], rel=1e-4)


def test_placing_is_the_best_of_what_is_allowed(trained, faces):
    """Where nothing is out of reach the placing is the search's; elsewhere every part stays on its landmark."""
    component = trained.model.components[0]
    face = show(faces[9], read_image(faces[9].path), [View()], 10, 4)[0]
    score, cells = place(component, trained.model.filters, face, 0.6)
    fits = responses(face.features, trained.model.filters)
    best = Forest((component,)).match(fits[component.filters].astype(np.float64)).roots[0].max()
    assert score <= best + 1e-4
    weights = Layout.of((component,)).pack(trained.model)
    assert features(component, face.features, cells) @ weights == pytest.approx(score, rel=1e-4)
    for cell, mark in zip(cells, component.landmarks, strict=True):
        box = np.concatenate([face.cells[mark], face.cells[mark] + 5])
        assert overlap(np.concatenate([cell, cell + 5]), box) > 0.6
    assert place(component, trained.model.filters, face, 0.3)[0] >= score - 1e-4


def test_negatives_are_never_on_a_face(faces, trained):
    scene = of_samples(faces[8:9])[0]
    everything = trained.model
    found = mine(scene, everything, -3.0, 170, 4, 50)
    assert all(not is_right(negative.found, scene.faces_px) for negative in found)
    scores = [negative.found.score for negative in found]
    assert scores == sorted(scores, reverse=True)
    unmarked = dataclasses.replace(scene, faces_px=np.zeros((0, 4)))
    assert mine(unmarked, everything, -3.0, 170, 4, 50)[0].found.score > max(scores, default=-3.0)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize(("yaw", "tilt", "zoom"), [(0, 0, 1), (0, 14, 1.1), (20, -10, 0.9)])
def test_views_show_the_landmarks_where_they_say(mirrored, yaw, tilt, zoom):
    """A dot painted on one landmark at a time is found again where the view says that landmark is."""
    points = mask_points() * 120 + [300, 250]
    sample = Sample("x/y/z.png", "x/z", points, (600, 560))
    for mark in (8, 17, 30, 36, 45, 54):
        image = np.zeros((560, 600, 3), np.uint8)
        cv2.circle(image, tuple(np.round(points[mark] * 8).astype(int)), 4 * 8, (255, 255, 255), -1, cv2.LINE_AA, 3)
        picture, placed = render(sample, image, View(mirrored, yaw, tilt, zoom), 0.5, 30)
        y, x = np.mgrid[: picture.shape[0], : picture.shape[1]]
        weight = picture[..., 0] / picture[..., 0].sum()
        there = MIRROR[mark] if mirrored else mark
        assert placed[there] == pytest.approx([(x * weight).sum(), (y * weight).sum()], abs=1.5)


@pytest.mark.parametrize("mirrored", [False, True])
def test_views_have_the_size_and_tilt_asked_for(faces, mirrored):
    sample = faces[0]
    view = View(mirrored, 0.0, 12.0, 1.1)
    scale = 10 * 4 * 1.1 / (sample.outer_eye_px / np.cos(np.radians(sample.yaw_deg)))
    _, points = render(sample, read_image(sample.path), view, scale, 20)
    across = points[45] - points[36]
    assert np.degrees(np.arctan2(across[1], across[0])) == pytest.approx(12, abs=0.5)
    assert np.hypot(*across) == pytest.approx(44, rel=0.02)


def test_mirroring_twice_changes_nothing():
    assert (MIRROR[MIRROR] == np.arange(68)).all()
    mirrored = (mask_points() * [-1, 1])[MIRROR]
    assert mirrored[:60] == pytest.approx(mask_points()[:60], abs=1e-12)


def test_poses_follow_from_the_settings():
    assert len(TrainSettings().poses) == 1  # as the model that ships
    straight, *others = TrainSettings(yaw_deg=20, tilt_deg=10).poses
    assert (straight.yaw_deg, straight.tilt_deg) == (0, 0)
    assert sorted((pose.yaw_deg, pose.tilt_deg) for pose in others) == [(-20, 0), (0, -10), (0, 10), (20, 0)]


def test_views_stay_within_reach():
    poses = (Pose(0, 0, 5, 3), Pose(20, 0, 5, 3))
    for view in views(poses, 10, 1.1, np.random.default_rng(0)):
        pose = poses[view.pose]
        assert abs(view.yaw_deg - pose.yaw_deg) <= 5
        assert abs(view.tilt_deg - pose.tilt_deg) <= 3
        assert 1 / 1.1 <= view.zoom <= 1.1


@pytest.mark.parametrize("yaw", [-20, 10, 20])
def test_turning_moves_what_stands_out(yaw):
    points = mask_points() * 60 + [100, 100]
    turned = turn(points, yaw, (200, 220))
    shift = (turned.points - points)[:, 0] / 60
    expected = (points - [100, 100])[:, 0] / 60 * (np.cos(np.radians(yaw)) - 1) + DEPTH * np.sin(np.radians(yaw))
    assert shift == pytest.approx(expected, abs=1e-9)
    assert turned.points[:, 1] == pytest.approx(points[:, 1])
    x, y = np.round(turned.points[30]).astype(int)
    assert [turned.back_x[y, x], turned.back_y[y, x]] == pytest.approx(points[30], abs=2)


def test_not_turning_changes_nothing():
    turned = turn(mask_points() * 60 + [100, 100], 0, (200, 220))
    x, y = np.meshgrid(np.arange(200), np.arange(220))
    assert turned.back_x == pytest.approx(x, abs=1e-3)
    assert turned.back_y == pytest.approx(y, abs=1e-3)


def test_cells_and_points_are_inverse():
    points = np.random.default_rng(0).uniform(0, 100, (20, 2))
    assert cells_to_points(points_to_cells(points, 4), 4) == pytest.approx(points)


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        ((0, 0, 2, 2), (0, 0, 2, 2), 1),
        ((0, 0, 2, 2), (1, 0, 3, 2), 1 / 3),
        ((0, 0, 1, 1), (2, 2, 3, 3), 0),
        ((0, 0, 0, 0), (0, 0, 0, 0), 0),
    ],
)
def test_overlap(a, b, expected):
    assert overlap(np.array(a, float), np.array(b, float)) == pytest.approx(expected)


def test_textures_are_the_same_every_time():
    for first, second in zip(textures(6, 5, 64), textures(6, 5, 64), strict=True):
        assert first.read().shape == (64, 64, 3)
        assert (first.read() == second.read()).all()


def test_a_folder_without_pictures_is_said(tmp_path):
    with pytest.raises(BadInput, match="no picture"):
        of_folder(tmp_path)
    (tmp_path / "x.png").write_bytes(b"no image")
    with pytest.raises(BadInput, match=r"x\.png: is no picture that can be read"):
        of_folder(tmp_path)[0].read()


def test_examples_hold_their_slack_for_one_place(trained, faces, scenes):
    """Configurations whose root lies at one place of a scene share a slack, also across rounds."""
    shown = [face for sample in faces[:2] for face in show(sample, read_image(sample.path), [View()], 10, 4)]
    examples = Examples(trained.model, shown, scenes, TINY)
    for number in (1, 2, 3):
        examples.round(number)
    seen = {}
    for at, group in zip(examples.placed[2:], examples.problem.groups[2:], strict=True):
        key = (at.source, at.level, *at.cells[0].tolist())
        assert seen.setdefault(key, group) == group
    assert len(set(seen.values())) == len(seen)
    assert isinstance(examples.model, FmpModel)


def test_the_first_negatives_are_found_whatever_the_scale_and_level_of_the_scores(trained, faces, scenes):
    """Faces at the edge of the first model may score far below 0, and scenes below those."""
    shown = [face for sample in faces[:4] for face in show(sample, read_image(sample.path), [View()], 10, 4)]
    weights = []
    for shift, scale in ((0.0, 1.0), (-7.0, 1.0), (3.0, 50.0)):
        parts = tuple(
            dataclasses.replace(part, springs=part.springs * scale, bias=(part.bias + shift) * scale)
            for part in trained.model.components
        )
        model = dataclasses.replace(trained.model, filters=trained.model.filters * scale, components=parts)
        examples = Examples(model, shown, scenes, TINY)
        first = examples.round(0)
        assert first.new >= len(scenes) / 2
        assert first.solution.converged
        weights.append(examples.layout.pack(examples.model))
    scores = np.array([examples.face_scores() for examples in (examples,)])
    assert (scores > 0).all()
    assert weights[1] == pytest.approx(weights[0], rel=1e-2, abs=1e-3)
    assert weights[2] == pytest.approx(weights[0], rel=1e-2, abs=1e-3)


def test_every_round_looks_through_other_scenes(trained, faces, scenes):
    shown = show(faces[0], read_image(faces[0].path), [View()], 10, 4)
    examples = Examples(trained.model, shown, scenes, TINY.replace(scenes=3))
    looked = [examples._of_round(number) for number in range(3)]
    assert looked == [[0, 1, 2], [3, 4, 5], [6, 7, 0]]

"""MediaPipe's mesh as a detector: the published network gives what others got from it, on any photo or file."""

import json

import cv2
import numpy as np
import pytest

from limner.cli.options import model_path
from limner.errors import BadInput, NoFace
from limner.pipeline import Settings
from limner.types import Face, Photo
from limner.vision.landmarks import DETECTORS, DetectSettings, choose, detect, mediapipe, mesh, yunet
from limner.vision.landmarks.mediapipe import MediapipeSettings
from limner.vision.landmarks.mesh import Region, View
from limner.vision.landmarks.mirror import MIRROR
from limner.vision.photo import load_photo

OUTER_EYES = [36, 45]


@pytest.fixture(scope="module")
def models(shared):
    return shared / "data/models"


@pytest.fixture(scope="module")
def settings(models):
    return MediapipeSettings(
        model=str(models / "mediapipe/face_landmark.tflite"), boxes=str(next((models / "yunet").glob("*.onnx")))
    )


@pytest.fixture(scope="module")
def photo(shared):
    return load_photo(shared / "data/demo/cc0_001.jpg")


@pytest.fixture(scope="module")
def face(photo, settings):
    (face,) = mediapipe.detect(photo, settings, never)
    return face


@pytest.fixture(autouse=True)
def no_folder(monkeypatch):
    monkeypatch.delenv("LIMNER_MODELS", raising=False)


def never(photo):
    raise AssertionError("asked another detector although there is YuNet")


def error_percent(points, truth):
    """(68,) distances over that of the outer eye corners."""
    return 100 * np.hypot(*(points - truth).T) / np.hypot(*np.diff(truth[OUTER_EYES], axis=0)[0])


def warped(photo, matrix, size):
    return Photo(cv2.warpAffine(photo.rgb, matrix, size, flags=cv2.INTER_AREA, borderMode=cv2.BORDER_REPLICATE))


def some_mesh(seed=0):
    return np.random.default_rng(seed).uniform(20, 170, (mesh.POINTS, 3))


def test_every_landmark_lies_on_the_mesh_and_has_a_mirror_image():
    assert np.array_equal(MIRROR[MIRROR], np.arange(68))
    assert np.array_equal(np.flatnonzero(np.arange(68) == MIRROR), [8, 27, 28, 29, 30, 33, 51, 57, 62, 66])
    # Landmarks between vertices move with them: an affine map of the mesh is one of the landmarks.
    points, matrix = some_mesh()[:, :2], np.array([[1.2, 0.3], [-0.4, 0.9]])
    assert np.allclose(mesh.landmarks(points @ matrix.T + 7), mesh.landmarks(points) @ matrix.T + 7)


def test_the_mirror_image_of_a_mirror_image_is_the_first():
    view = View.of(some_mesh(), 3.0)
    twice = view.mirrored(192).mirrored(192)
    assert np.allclose(twice.landmarks, view.landmarks)
    assert np.allclose(twice.region.centre_px, view.region.centre_px)
    assert (twice.region.angle_rad, twice.yaw_deg) == pytest.approx((view.region.angle_rad, view.yaw_deg))
    assert view.mirrored(192).yaw_deg == -view.yaw_deg


def test_a_region_holds_its_mesh_however_it_is_turned():
    points = some_mesh()
    square = mesh.region(points)
    for angle in (0.3, -1.0):
        turned = points.copy()
        turned[:, :2] = points[:, :2] @ mesh.turn(angle).T + (5, -8)
        other = mesh.region(turned)
        assert other.side_px == pytest.approx(square.side_px)
        assert other.angle_rad == pytest.approx(square.angle_rad + angle)
        assert np.allclose(other.centre_px, mesh.turn(angle) @ square.centre_px + (5, -8))
    inside = (points[:, :2] - square.centre_px) @ mesh.turn(square.angle_rad)
    assert np.abs(inside).max() == pytest.approx(square.side_px / 2 / mesh.MARGIN)


def test_a_region_in_a_region_is_one_of_the_photo():
    outer, inner = Region(np.array([300.0, 200]), 400.0, 0.4), Region(np.array([90.0, 100]), 120.0, -0.1)
    points = np.random.default_rng(1).uniform(0, 192, (9, 2))
    there = outer.to_photo(inner.to_photo(points, 192), 192)
    assert np.allclose(inner.within(outer, 192).to_photo(points, 192), there)


@pytest.mark.parametrize("degrees", [-40, 0, 15, 60])
def test_yaw_is_positive_where_the_nose_points_to_image_right(degrees):
    rng, angle = np.random.default_rng(2), np.radians(degrees)
    points = np.zeros((mesh.POINTS, 3))
    for left, right in mesh._WIDE:
        side = rng.uniform([20, -50, -30], [60, 50, 30])
        points[left], points[right] = side * [-1, 1, 1], side
    nose = np.array([0, 0, -50.0])  # z away from the camera
    turn = np.array([[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0], [np.sin(angle), 0, np.cos(angle)]])
    assert np.sign(round((turn @ nose)[0], 6)) == np.sign(degrees)
    assert mesh.yaw_deg(points @ turn.T) == pytest.approx(degrees)


def test_the_same_network_gave_the_same_landmarks(shared, settings):
    labels = np.load(shared / "data/inter-faces-cc0/landmarks_machine.npz")
    errors = []
    for k in np.flatnonzero((labels["score"] > 0.99) & (np.abs(labels["yaw_proxy"]) < 0.4))[::4]:
        points = labels["mp468"][k].astype(float)
        # Whoever made the labels gave places whose origin is the corner of the first pixel.
        truth = mesh.landmarks(points) - 0.5
        found = mediapipe.detect(
            load_photo(shared / "data/inter-faces-cc0/images" / labels["names"][k]), settings, never
        )
        errors.append(min(error_percent(face.points_px, truth).mean() for face in found))
    assert len(errors) > 12
    # Another cut of the same face moves the mesh by about one percent.
    assert np.median(errors) < 1.5
    assert max(errors) < 4


@pytest.mark.slow
def test_landmarks_lie_where_people_put_them(shared, settings):
    for name, count in (("london", 13), ("canada", 10)):
        labels = np.load(shared / "data" / name / "landmarks.npz")
        errors = []
        for k in range(0, len(labels["names"]), len(labels["names"]) // count):
            photo = load_photo(shared / "data" / name / "images" / f"{labels['names'][k].removesuffix('.jpg')}.jpg")
            (face,) = mediapipe.detect(photo, settings, never)
            assert abs(face.yaw_deg) < 12
            errors.append(error_percent(face.points_px, labels["ibug68"][k]))
        errors = np.array(errors)
        assert len(errors) >= count
        assert errors[:, 17:].mean() < 2.3
        assert errors.mean() < 3


def test_landmarks_lie_where_people_put_them_on_faces_that_the_table_never_saw(shared, settings):
    labels = np.load(shared / "data/imm-frontal/landmarks.npz")
    errors = []
    for k in range(0, len(labels["names"]), 7):
        (file,) = (shared / "data/imm-frontal/images").glob(
            f"{labels['names'][k].rpartition('.')[0] or labels['names'][k]}.*"
        )
        (face,) = mediapipe.detect(load_photo(file), settings, never)
        errors.append(error_percent(face.points_px, labels["ibug68"][k])[17:])
    assert np.nanmean(errors) < 3


def test_a_mirrored_photo_gives_mirrored_landmarks(photo, face, settings):
    (other,) = mediapipe.detect(Photo(photo.rgb[:, ::-1]), settings, never)
    truth = (face.points_px * [-1, 1] + [photo.size_px[0] - 1, 0])[MIRROR]
    assert error_percent(other.points_px, truth).mean() < 0.7
    assert other.yaw_deg == pytest.approx(-face.yaw_deg, abs=1)


def test_points_of_the_network_begin_at_the_rim_of_its_picture(photo, face, settings):
    file = mediapipe.Path(settings.model)
    network = mediapipe._load(file)
    differences = []
    for shift in np.linspace(-0.1, 0.1, 7) * face.outer_eye_px:
        region = Region(face.points_px.mean(axis=0) + shift, 2.5 * face.outer_eye_px, shift / 500)
        picture = mediapipe._cut(photo, region)
        plain, mirrored = (View.of(*mediapipe._run(network, side, file)) for side in (picture, picture[:, ::-1]))
        differences.append((plain.landmarks - mirrored.mirrored(192).landmarks)[:, 0].mean())
    # Were they counted from the first pixel's centre, both would differ by one pixel.
    assert abs(np.mean(differences)) < 0.35


@pytest.mark.parametrize(("degrees", "scale"), [(25, 1), (-25, 1), (0, 0.5), (0, 0.25), (0, 1.5), (12, 0.7)])
def test_a_turned_or_scaled_photo_gives_landmarks_that_go_along(photo, face, settings, degrees, scale):
    width, height = photo.size_px
    matrix = cv2.getRotationMatrix2D(((width - 1) / 2, (height - 1) / 2), degrees, 1) * scale
    matrix[:, 2] += (scale - 1) / 2
    (other,) = mediapipe.detect(warped(photo, matrix, (round(width * scale), round(height * scale))), settings, never)
    truth = face.points_px @ matrix[:, :2].T + matrix[:, 2]
    assert error_percent(other.points_px, truth).mean() < 1.5


def test_a_face_is_what_the_other_detectors_give(photo, face):
    assert face.detector == "mediapipe"
    assert 0.9 < face.score <= 1
    assert abs(face.yaw_deg) < 8
    assert (face.points_px >= face.box_px[:2]).all()
    assert (face.points_px <= face.box_px[2:]).all()


def test_two_people_are_two_faces_and_the_same_photo_the_same_numbers(photo, face, settings):
    half = cv2.resize(photo.rgb, None, fx=0.7, fy=0.7, interpolation=cv2.INTER_AREA)
    both = np.zeros((photo.size_px[1], photo.size_px[0] + half.shape[1], 3), np.uint8)
    both[:, : photo.size_px[0]], both[: half.shape[0], photo.size_px[0] :] = photo.rgb, half
    found = mediapipe.detect(Photo(both), settings, never)
    assert [round(found_.outer_eye_px / face.outer_eye_px, 1) for found_ in found] == [1.0, 0.7]
    assert mediapipe.detect(Photo(both), settings, never) == found


@pytest.mark.parametrize("size", [(1, 1), (2, 300), (300, 2), (40, 40), (640, 480)])
def test_where_no_face_is_none_is_found(settings, size):
    rng = np.random.default_rng(3)
    for rgb in (np.zeros((*size, 3), np.uint8), rng.integers(0, 256, (*size, 3), np.uint8)):
        assert mediapipe.detect(Photo(rgb), settings, never) == ()
    with pytest.raises(NoFace, match=r"no face found; looked for faces with a probability of at least 0.5"):
        choose((), 1, Photo(rgb), DetectSettings(detector="mediapipe", mediapipe=settings))


def test_without_yunet_another_detector_says_where_faces_are(photo, face, settings):
    rng = np.random.default_rng(4)
    near = face.points_px + rng.normal(0, 0.06 * face.outer_eye_px, (68, 2))
    asked = []

    def find(photo):
        asked.append(photo)
        twice = Face(near + 3, face.box_px, 1.0, detector="fmp")
        return (Face(near, face.box_px, 1.0, detector="fmp"), twice)

    found = mediapipe.detect(photo, settings.replace(boxes=""), find)
    assert asked == [photo]
    assert len(found) == 1, "two boxes on one face are one face"
    assert error_percent(found[0].points_px, face.points_px).mean() < 1.5
    assert mediapipe.detect(photo, settings.replace(boxes=""), lambda photo: ()) == ()
    profile = Face(face.points_px[:39], face.box_px)
    assert len(mediapipe.detect(photo, settings.replace(boxes=""), lambda photo: (profile,))) <= 1


def test_what_looks_unlike_a_face_to_the_mesh_is_none(settings):
    blank = Photo(np.full((300, 300, 3), 90, np.uint8))
    somewhere = Face(np.random.default_rng(5).uniform(100, 200, (68, 2)), [100, 100, 200, 200])
    assert mediapipe.detect(blank, settings.replace(boxes=""), lambda photo: (somewhere,)) == ()
    (face,) = mediapipe.detect(blank, settings.replace(boxes="", least_face=0.0), lambda photo: (somewhere,))
    assert face.score < 0.5


def test_models_are_found_in_the_folder(photo, face, models, settings, tmp_path, monkeypatch):
    for model, file in (("face_landmark.tflite", settings.model), ("face_detection_yunet_x.onnx", settings.boxes)):
        (tmp_path / model).symlink_to(file)
    found = []
    for folder in (tmp_path, models):  # the files themselves, or folders of them
        monkeypatch.setenv("LIMNER_MODELS", str(folder))
        found += detect(photo, DetectSettings(detector="mediapipe"))
    assert found == [face, face]


def test_a_missing_model_says_where_to_get_it_and_what_to_set(monkeypatch, tmp_path):
    photo = Photo(np.zeros((50, 50, 3), np.uint8))
    for folder in ("", str(tmp_path)):
        monkeypatch.setenv("LIMNER_MODELS", folder)
        with pytest.raises(
            BadInput, match=r"get face_landmark.tflite from https://\S+.*--model.*LIMNER_MODELS"
        ) as caught:
            detect(photo, DetectSettings(detector="mediapipe"))
        assert "\n" not in str(caught.value)
    monkeypatch.setenv("LIMNER_MODELS", str(tmp_path / "none"))
    with pytest.raises(BadInput, match=r"LIMNER_MODELS: .*none is no folder"):
        detect(photo, DetectSettings(detector="mediapipe"))


def damage(data, kind):
    rng = np.random.default_rng(6)
    return {
        "empty": b"",
        "text": b"this is no model",
        "truncated": data[: len(data) // 2],
        "one bit": data[:-1] + bytes([data[-1] ^ 1]),
        "noise": rng.bytes(5000),
        "json": json.dumps({"model": "no"}).encode(),
    }[kind]


@pytest.mark.parametrize("kind", ["empty", "text", "truncated", "one bit", "noise", "json"])
@pytest.mark.parametrize("field", ["model", "boxes"])
def test_a_damaged_model_is_refused_before_opencv_sees_it(settings, tmp_path, monkeypatch, kind, field):
    photo, file = Photo(np.zeros((64, 64, 3), np.uint8)), tmp_path / "model"
    with open(getattr(settings, field), "rb") as whole:
        file.write_bytes(damage(whole.read(), kind))
    if field == "model":
        monkeypatch.setattr(cv2.dnn, "readNetFromTFLite", never)
    else:
        monkeypatch.setattr(cv2, "FaceDetectorYN", None)
    with pytest.raises(BadInput, match=r"model: not .*, or damaged \(SHA-256 .*\); get .* from https") as caught:
        mediapipe.detect(photo, settings.replace(**{field: str(file)}), never)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", ["empty", "text", "noise", "json"])
def test_a_file_that_is_trusted_and_no_network_is_one_line(settings, tmp_path, capfd, kind):
    photo, file = Photo(np.zeros((64, 64, 3), np.uint8)), tmp_path / "model"
    file.write_bytes(damage(b"1", kind))
    for field in ("model", "boxes"):
        with pytest.raises(BadInput, match=r"model: not .*, or damaged \(OpenCV cannot run it\)") as caught:
            mediapipe.detect(photo, settings.replace(trust=True, **{field: str(file)}), never)
        assert "\n" not in str(caught.value)
    assert capfd.readouterr().err == ""


def test_a_file_far_too_large_or_none_at_all_is_refused(models, settings, tmp_path):
    photo, file = Photo(np.zeros((64, 64, 3), np.uint8)), tmp_path / "model"
    with file.open("wb") as empty:
        empty.truncate(mediapipe.MODEL.limit + 1)
    for field in ("model", "boxes"):
        with pytest.raises(BadInput, match=r"model: larger than \d+ MB"):
            mediapipe.detect(photo, settings.replace(**{field: str(file)}), never)
        for path in (models, "no\0where", tmp_path / "none"):
            with pytest.raises(BadInput, match="cannot be read"):
                mediapipe.detect(photo, settings.replace(**{field: str(path)}), never)


def test_another_network_is_refused_even_if_trusted(models, settings):
    photo, other = Photo(np.zeros((64, 64, 3), np.uint8)), str(models / "mediapipe/face_detection_short_range.tflite")
    with pytest.raises(BadInput, match=r"not MediaPipe's face mesh.*32256 and 2016 numbers, expected 1404 and 1"):
        mediapipe.detect(photo, settings.replace(model=other, trust=True), never)
    with pytest.raises(BadInput, match="not YuNet"):
        mediapipe.detect(photo, settings.replace(boxes=other, trust=True), never)


@pytest.mark.parametrize("mesh_", [np.full((468, 3), np.nan), np.zeros((468, 3)), np.full((468, 3), 1e30)])
def test_a_network_gone_mad_is_refused(photo, settings, monkeypatch, mesh_):
    class Mad:
        def setInput(self, values):  # noqa: N802 - OpenCV's own name
            assert values.shape == (1, 3, 192, 192)

        def getUnconnectedOutLayersNames(self):  # noqa: N802 - OpenCV's own name
            return ("points", "flag")

        def forward(self, names):
            return (mesh_.reshape(1, 1, 1, -1).astype(np.float32), np.ones((1, 1, 1, 1), np.float32))

    monkeypatch.setattr(cv2.dnn, "readNetFromTFLite", lambda *arguments: Mad())
    with pytest.raises(BadInput, match="it sees a face of no size or far beyond its picture"):
        mediapipe.detect(photo, settings, never)


def test_yunet_gives_boxes_in_the_photo(photo, face, settings):
    (region,) = yunet.find(photo, mediapipe.Path(settings.boxes), 0.7)
    assert np.hypot(*(region.centre_px - face.points_px.mean(axis=0))) < 0.5 * face.outer_eye_px
    assert 2 < region.side_px / face.outer_eye_px < 6
    assert abs(region.angle_rad) < 0.1


def test_a_model_on_the_command_line_is_that_of_the_detector():
    for detector, path in (("fmp", "detect.fmp.model"), ("mediapipe", "detect.mediapipe.model")):
        assert model_path(Settings().assign("detect.detector", detector), "x") == path
    with pytest.raises(BadInput, match="the detector 'file' has no model; choose --detector fmp or mediapipe"):
        model_path(Settings().assign("detect.detector", "file"), "x")
    with pytest.raises(BadInput, match=r"x.tflite: not for the detector 'fmp'; add --detector mediapipe"):
        model_path(Settings(), "x.tflite")
    assert set(DETECTORS) == {"fmp", "mediapipe", "file"}

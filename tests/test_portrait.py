import cv2
import numpy as np
import pytest

from limner import geometry
from limner.types import Face, Photo
from limner.vision.head import face_outline
from limner.vision.lines import LineSettings, draw_lines
from limner.vision.portrait.band import fill, measure, tapered
from limner.vision.portrait.eyes import draw_eyes, hatched
from limner.vision.portrait.follow import follow, normals, settle
from limner.vision.portrait.grow import Rule, grow
from limner.vision.portrait.seen import FlowSettings, look_at
from limner.vision.raster import dilated, filled
from portraits import agreement, astronaut, ink, london, mirrored, mirrored_points, painted, plain_face, resized

SETTINGS = LineSettings()
CHANGES = {
    "brighter": lambda rgb: np.clip(rgb.astype(float) + 18, 0, 255),
    "darker": lambda rgb: np.clip(rgb.astype(float) - 18, 0, 255),
    "gamma 0.8": lambda rgb: 255 * (rgb / 255) ** 0.8,
    "gamma 1.25": lambda rgb: 255 * (rgb / 255) ** 1.25,
    "jpeg": lambda rgb: cv2.imdecode(cv2.imencode(".jpg", rgb, [cv2.IMWRITE_JPEG_QUALITY, 85])[1], cv2.IMREAD_COLOR),
}


def portrait(photo, face, **changes):
    settings = SETTINGS.replace(portrait=SETTINGS.portrait.replace(**changes))
    return draw_lines(photo, face, "portrait", settings)


def within(face):
    return 0.03 * face.outer_eye_px


@pytest.fixture(scope="module")
def sitters(shared):
    return [astronaut(), london(shared, "062_03.jpg"), london(shared, "017_03.jpg")]


@pytest.fixture(scope="module")
def drawings(sitters):
    return [portrait(*sitter) for sitter in sitters]


@pytest.mark.parametrize("factor", [0.5, 2])
def test_another_size_gives_nearly_the_same_drawing(sitters, drawings, factor):
    for (photo, face), drawing in zip(
        sitters[1:] if factor < 1 else sitters[:1], drawings[1:] if factor < 1 else drawings[:1], strict=True
    ):
        other, other_face, factors = resized(photo, face, factor)
        back = (ink(portrait(other, other_face).lines_px) + 0.5) / factors - 0.5
        assert agreement(ink(drawing.lines_px), back, within(face)) >= 0.85


@pytest.mark.parametrize("change", CHANGES)
def test_light_and_compression_hardly_change_the_drawing(sitters, drawings, change):
    shares = []
    for (photo, face), drawing in zip(sitters, drawings, strict=True):
        other = Photo(np.rint(CHANGES[change](photo.rgb)).astype(np.uint8))
        shares.append(agreement(ink(drawing.lines_px), ink(portrait(other, face).lines_px), within(face)))
    assert np.mean(shares) >= 0.85


def test_a_mirrored_photo_gives_nearly_the_mirrored_drawing(sitters, drawings):
    for (photo, face), drawing in zip(sitters, drawings, strict=True):
        lines = portrait(*mirrored(photo, face)).lines_px
        assert agreement(ink(drawing.lines_px), mirrored_points(ink(lines), photo), within(face)) >= 0.85


def test_agreement_can_be_low(sitters, drawings):
    (_, face), *_ = sitters
    other = draw_lines(*sitters[0], "canny", SETTINGS)
    assert agreement(ink(drawings[0].lines_px), ink(other.lines_px), within(face)) < 0.8


def test_a_dark_copy_of_a_face_keeps_its_inner_ink(sitters, drawings):
    for (photo, face), drawing in zip(sitters, drawings, strict=True):
        linear = (photo.rgb / 255.0) ** 2.2 * 0.3
        dark = Photo(np.rint(255 * linear ** (1 / 2.2)).astype(np.uint8))
        light, same = (_inner_ink(d, face) for d in (drawing, portrait(dark, face)))
        assert same >= 0.9 * light


def _inner_ink(drawing, face):
    points = ink(drawing.lines_px)
    mask = filled(face_outline(face), drawing.size_px[::-1])
    columns, rows = np.rint(points).astype(int).T
    return mask[np.clip(rows, 0, mask.shape[0] - 1), np.clip(columns, 0, mask.shape[1] - 1)].sum()


def test_a_face_on_clutter_draws_hardly_anything_outside_the_figure():
    """Its outline included, which may be drawn a pen's width outside."""
    rng = np.random.default_rng(3)
    clutter = np.full((620, 560, 3), 128, np.uint8)
    for _ in range(250):
        corner, size = rng.integers(0, 560, 2), rng.integers(8, 70, 2)
        colour = rng.integers(0, 256, 3).tolist()
        cv2.rectangle(clutter, corner.tolist(), (corner + size).tolist(), colour, -1)
    photo, face = painted(background=clutter)
    alone, _ = painted(background=(255, 0, 255))
    figure = dilated((alone.rgb[..., 1] > 30) & ~((alone.rgb[..., 0] > 200) & (alone.rgb[..., 2] > 200)), 6)
    points = np.rint(ink(portrait(photo, face).lines_px)).astype(int)
    outside = ~figure[np.clip(points[:, 1], 0, 619), np.clip(points[:, 0], 0, 559)]
    assert outside.mean() <= 0.05


def test_every_region_of_a_made_up_face_is_drawn():
    photo, face = painted()
    strokes = portrait(photo, face)
    assert {"eye", "brow", "nose", "mouth", "jaw", "hair", "body"} <= set(strokes.region)
    assert (np.diff(strokes.weight) <= 0).all()
    for part, reach in ((slice(36, 48), 0.05), (slice(17, 27), 0.09), (slice(48, 60), 0.09), (slice(2, 15), 0.06)):
        away = [np.hypot(*(ink(strokes.lines_px) - mark).T).min() for mark in face.points_px[part]]
        assert np.mean(np.array(away) < reach * face.outer_eye_px) > 0.85


def test_the_face_comes_first(drawings):
    for drawing in drawings:
        first = drawing.region[: len(drawing.region) // 3]
        assert sum(name in ("eye", "brow", "nose", "mouth", "jaw", "face") for name in first) > 0.4 * len(first)


def test_few_long_strokes(drawings):
    for drawing in drawings:
        assert 20 < len(drawing.lines_px) <= 120


def test_no_stroke_runs_beside_another(drawings, sitters):
    """One line per feature, but for brows, lids and nostrils, which are meant to be dark."""
    for drawing, (_, face) in zip(drawings, sitters, strict=True):
        lines = [
            line for line, region in zip(drawing.lines_px, drawing.region, strict=True) if region in ("hair", "face")
        ]
        for i, line in enumerate(lines):
            others = lines[:i] + lines[i + 1 :]
            points = geometry.resample(line, 1.0)
            beside = np.array([np.hypot(*(points[:, None] - ink([o])[None]).transpose(2, 0, 1)).min(1) for o in others])
            assert (beside.min(axis=0) < 0.025 * face.outer_eye_px).mean() < 0.35


@pytest.mark.parametrize("change", [{"hair_apart": 0.15}, {"detail": 0.6}, {"body": 0.0}, {"brow_strokes": 1}])
def test_less_can_be_asked_for(sitters, drawings, change):
    less = portrait(*sitters[0], **change)
    assert geometry.total_length(less.lines_px) < geometry.total_length(drawings[0].lines_px)


def test_the_same_photo_gives_the_same_strokes(sitters, drawings):
    assert portrait(*sitters[0]) == drawings[0]


@pytest.mark.parametrize("size", [(1, 1), (40, 40), (300, 7), (400, 400)])
@pytest.mark.parametrize("value", [0, 255])
def test_blank_photos_give_no_strokes(size, value):
    photo = Photo(np.full((*size, 3), value, np.uint8))
    assert portrait(photo, plain_face(60, (size[1] / 2, size[0] / 2))).lines_px == ()


def test_a_face_at_the_border_of_the_photo():
    photo, face = astronaut()
    cut = Photo(photo.rgb[110:, 215:])
    strokes = portrait(cut, Face(face.points_px - [215, 110], face.box_px))
    points = np.concatenate(strokes.lines_px)
    assert points.min() >= -0.5
    assert (points.max(axis=0) <= np.array(cut.size_px) - 0.5).all()


def test_noise_is_drawn_without_a_crash():
    rng = np.random.default_rng(0)
    photo = Photo(rng.integers(0, 256, (500, 500, 3), dtype=np.uint8))
    portrait(photo, plain_face(110, (250, 250)))


# --- the parts ---

Y, X = np.indices((200, 200), np.float32)


def seen_line(curve_y):
    """A picture with one dark line y = curve_y(x), as the portrait sees it."""
    dark = np.exp(-(((Y - curve_y(X)) / 1.5) ** 2) / 2)
    return look_at(Photo(np.repeat((220 - 180 * dark).astype(np.uint8)[..., None], 3, axis=2)), FlowSettings())


def straight(y, start=30.0, end=170.0):
    return np.array([[start, y], [end, y]])


def test_normals_are_at_right_angles():
    line = np.stack([np.linspace(0, 50, 26), np.zeros(26)], axis=1)
    np.testing.assert_allclose(normals(line), np.tile([0.0, 1.0], (26, 1)), atol=1e-9)


@pytest.mark.parametrize("off", [-8, -3, 0, 5, 9])
def test_a_curve_settles_on_the_line_it_is_near(off):
    seen = seen_line(lambda x: 0 * x + 100.0)
    shift = settle(seen, [straight(100.0 + off)], 12.0, seen.coarse)
    assert shift[1] == pytest.approx(-off, abs=1.6)


@pytest.mark.parametrize("off", [-6, 0, 6])
def test_a_line_is_followed_round_its_bends(off):
    def wave(x):
        return 100 + 5 * np.sin(x / 25)

    found = follow(seen := seen_line(wave), straight(100.0 + off), 14.0, seen.fine)
    inner = found.line[5:-5]
    assert np.abs(inner[:, 1] - wave(inner[:, 0])).max() < 1.5
    assert found.strength.min() > 0


def test_parts_bridge_small_gaps_only():
    seen = seen_line(lambda x: 0 * x + 100.0)
    found = follow(seen, straight(100.0), 6.0, seen.fine)
    broken = type(found)(found.line, np.where((found.line[:, 0] > 90) & (found.line[:, 0] < 100), 0, 1.0))
    assert len(broken.parts(0.5, 20, 10)) == 1
    assert len(broken.parts(0.5, 4, 10)) == 2
    assert broken.parts(0.5, 4, 500) == []


@pytest.mark.parametrize("width", [4.0, 8.0, 12.0])
def test_a_band_is_as_wide_as_what_is_dark(width):
    grey = np.where(np.abs(Y - 100) < width / 2, 60, 220).astype(np.uint8)
    seen = look_at(Photo(np.repeat(grey[..., None], 3, axis=2)), FlowSettings())
    band = measure(seen, straight(100.0), 14.0)
    assert np.median(band.width) == pytest.approx(width, abs=1.5)
    strokes = fill(band, 2.4, 9)
    assert len(strokes) == pytest.approx(width / 2.4, abs=1)
    assert all(np.abs(stroke[:, 1] - 100).max() <= width / 2 for stroke in strokes)
    assert tapered(band, 0.2, 0.2).width[0] == 0


def test_strokes_grow_along_what_is_seen_and_keep_apart():
    stripes = (0.5 + 0.5 * np.sin(2 * np.pi * Y / 9)).astype(np.float32)
    seen = look_at(Photo(np.repeat((60 + 140 * stripes).astype(np.uint8)[..., None], 3, axis=2)), FlowSettings())
    labels = np.zeros(Y.shape, np.uint8)
    for apart, every in ((5.0, 1), (12.0, 2)):
        grown = grow(seen.fine, seen.broad, labels, [Rule(0.02, 0.05, 60.0, apart, 1.0)], [])
        rows = np.sort([line.line[:, 1].mean() for line in grown])
        assert all(np.ptp(line.line[:, 1]) < 2 for line in grown)
        assert np.diff(rows).min() > 9 * every - 2
        assert len(rows) > 0.6 * 200 / 9 / every


def test_nothing_grows_beside_what_is_drawn():
    seen = seen_line(lambda x: 0 * x + 100.0)
    rule = [Rule(0.02, 0.05, 30.0, 5.0, 1.0)]
    labels = np.zeros(Y.shape, np.uint8)
    assert grow(seen.fine, seen.broad, labels, rule, [])
    assert not grow(seen.fine, seen.broad, labels, rule, [(straight(101.0, 0, 199), 5.0)])


def test_dark_glasses_hide_the_eyes():
    photo, face = painted()
    rgb = photo.rgb.copy()
    for eye in (face.points_px[36:42], face.points_px[42:48]):
        cv2.circle(rgb, np.rint(eye.mean(axis=0)).astype(int).tolist(), 22, (20, 20, 25), -1)
    eyes = [Photo(rgb), photo]
    hidden, seen = (draw_eyes(look_at(each, FlowSettings()), face) for each in eyes)
    assert not hidden
    assert seen


def test_an_eye_that_is_turned_away_is_left_out():
    photo, face = painted()
    points = face.points_px.copy()
    points[42:48] = points[42] + 0.2 * (points[42:48] - points[42])
    seen = look_at(photo, FlowSettings())
    turned, frontal = (draw_eyes(seen, each) for each in (Face(points, face.box_px), face))
    assert len(turned) < len(frontal)


def test_lines_of_the_background_do_not_lead_away_from_the_head():
    """A shelf behind the head begins at the hair's outline, and is none of it."""
    rgb = painted()[0].rgb.copy()
    photo, face = painted()
    for row in range(120, 300, 30):
        cv2.line(rgb, (0, row), (175, row), (90, 90, 90), 3)
        cv2.line(rgb, (395, row), (559, row), (90, 90, 90), 3)
    shelf = np.abs(ink(portrait(Photo(rgb), face).lines_px)[:, 0] - 285)
    assert (shelf > 150).mean() < (np.abs(ink(portrait(photo, face).lines_px)[:, 0] - 285) > 150).mean() + 0.03


def test_a_pupil_is_filled_but_for_its_glint():
    hatch = hatched(np.array([10.0, 20.0]), 4.0) - [10.0, 20.0]
    assert np.hypot(*hatch.T).max() <= 4.0 + 1e-9
    y, x = np.mgrid[-2:2.1:0.5, -2:2.1:0.5]
    away = np.hypot(x[..., None] - hatch[:, 0], y[..., None] - hatch[:, 1]).min(axis=-1)
    assert away[(y > 0)].max() < 1.0
    assert away[(y < -1.3) & (x > 1.3)].min() > 0.9

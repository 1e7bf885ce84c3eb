import cv2
import numpy as np
import pytest

from limner import geometry
from limner.errors import BadInput
from limner.types import Photo, Strokes
from limner.vision.figure import FigureSettings, find_figure
from limner.vision.hatching.darkness import darkness
from limner.vision.hatching.streamlines import STEP_PX, Ground, streamlines
from limner.vision.lines import STYLES, LineSettings, draw_lines, without_effect
from limner.vision.scale import ScaleSettings, to_working_scale
from limner.vision.tone import AREAS, LEVELS, ToneSettings, areas, hatch
from portraits import astronaut, painted, resized

NO_LINES = Strokes((), (), np.zeros(0), (1, 1))


def seen(photo, face):
    working = to_working_scale(photo, face, ScaleSettings())
    return working.photo, working.face, find_figure(working.photo, working.face, FigureSettings())


def hatched(parts, level="medium", **settings):
    return hatch(*parts, NO_LINES, ToneSettings(level=level, **settings))


@pytest.fixture(scope="module")
def parts():
    return seen(*astronaut())


def ink_in(strokes, mask):
    """Length of strokes within a mask [px]."""
    points = np.concatenate([geometry.resample(line, 1.0) for line in strokes.lines_px])
    column, row = np.clip(np.rint(points), 0, np.array(mask.shape[::-1]) - 1).astype(int).T
    return mask[row, column].sum()


def test_ink_grows_with_the_level(parts):
    ink = [geometry.total_length(hatched(parts, level).lines_px) for level in LEVELS]
    assert 0 < ink[0] < 0.85 * ink[1] < 0.85**2 * ink[2]


@pytest.mark.parametrize("level", LEVELS)
def test_dark_places_get_more_ink_than_light_ones(parts, level):
    _, face, figure = parts
    dark, area, strokes = darkness(*parts), areas(face, figure), hatched(parts, level)
    within = area == AREAS.index("hair")
    density = [
        ink_in(strokes, within & (dark >= low) & (dark < high)) / (within & (dark >= low) & (dark < high)).sum()
        for low, high in ((0, 0.3), (0.3, 0.6), (0.6, 1.01))
    ]
    assert density[0] < density[1] < density[2]


@pytest.mark.parametrize("level", LEVELS)
def test_the_background_stays_white(parts, level):
    figure = parts[2].figure
    strokes = hatched(parts, level)
    rim = cv2.dilate(figure.astype(np.uint8), np.ones((5, 5))) > 0
    assert ink_in(strokes, ~rim) == 0


def test_a_darkened_cheek_gets_ink_and_a_lit_one_none(parts):
    photo, face, figure = parts
    x, y = np.rint(face.points_px[[2, 31]].mean(axis=0)).astype(int)
    cheek = np.zeros(figure.figure.shape, np.uint8)
    cv2.circle(cheek, (int(x), int(y)), 30, 1, -1)
    shade = np.where(cheek[..., None] > 0, 0.35, 1.0)
    darker = Photo((photo.rgb * shade).astype(np.uint8))
    assert ink_in(hatched(parts), cheek > 0) < 30
    assert ink_in(hatched((darker, face, figure)), cheek > 0) > 120


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_dark_skin_is_not_drawn_black(parts, share):
    """The same photo, darker: about as much ink on the skin, not a black face."""
    photo, face, figure = parts
    darker = (Photo((photo.rgb * share).astype(np.uint8)), face, figure)
    ink = [geometry.total_length(hatched(some).lines_px) for some in (parts, darker)]
    assert 0.6 < ink[1] / ink[0] < 1.5


def test_the_same_photo_gives_the_same_strokes(parts):
    assert hatched(parts) == hatched(parts)


@pytest.mark.parametrize("factor", [0.5, 2])
def test_another_size_gives_about_the_same_ink(parts, factor):
    other = seen(*resized(*astronaut(), factor)[:2])
    ink = [geometry.total_length(hatched(some).lines_px) for some in (parts, other)]
    assert 0.8 < ink[1] / ink[0] < 1.25


def test_regions_and_weights_say_what_a_stroke_is_for(parts):
    strokes = hatched(parts, "rich")
    assert {"hair", "body", "brow", "eye"} <= set(strokes.region)
    assert "background" not in strokes.region
    assert (np.diff(strokes.weight) <= 0).all()


def test_clothes_can_stay_white(parts):
    body = areas(parts[1], parts[2]) == AREAS.index("body")
    assert ink_in(hatched(parts, clothes=0), body) < 0.02 * ink_in(hatched(parts), body)


def test_parallel_strokes_are_parallel(parts):
    strokes = hatched(parts, hatch="parallel", angle_deg=30)
    hatching = [line for line, region in zip(strokes.lines_px, strokes.region, strict=True) if region == "hair"]
    across = np.concatenate([np.diff(line, axis=0) for line in hatching])
    along = (parts[1].points_px[45] - parts[1].points_px[36]) @ np.array([1, 1j])
    angle = np.angle((across @ np.array([1, 1j]) / along) ** 2 * np.exp(2j * np.deg2rad(30)))
    assert np.abs(angle).max() < 1e-3


def test_an_unknown_level_is_named():
    with pytest.raises(BadInput, match=r"tone\.level|level = 'pitch'"):
        ToneSettings(level="pitch")


def plane(spacing, angle_rad=0.3, shape=(200, 300)):
    full = np.ones(shape, np.float32)
    cos, sin = np.float32(np.cos(angle_rad)) * full, np.float32(np.sin(angle_rad)) * full
    return Ground(cos, sin, np.float32(spacing) * full, full, np.ones(shape, np.uint8))


@pytest.mark.parametrize("spacing", [5.0, 9.0, 20.0])
def test_strokes_on_an_even_ground_are_as_far_apart_as_asked(spacing):
    lines = streamlines(plane(spacing), [], 20.0)
    across = np.array([-np.sin(0.3), np.cos(0.3)])
    at = np.sort([(line @ across).mean() for line in lines])
    assert max(np.ptp(line @ across) for line in lines) < 1e-3
    assert np.diff(at).min() > 0.55 * spacing
    assert np.median(np.diff(at)) == pytest.approx(spacing + 1, abs=1.5)
    assert sum(map(geometry.length, lines)) == pytest.approx(200 * 300 / np.median(np.diff(at)), rel=0.15)


def test_strokes_never_come_closer_than_the_least_spacing(parts):
    from scipy.spatial import KDTree

    strokes = hatched(parts, "rich", closest=0.06)
    lines = [
        geometry.resample(line, 1.0) for line, r in zip(strokes.lines_px, strokes.region, strict=True) if r == "hair"
    ]
    nearest = [KDTree(np.concatenate(lines[:k] + lines[k + 1 :])).query(line)[0].min() for k, line in enumerate(lines)]
    assert min(nearest) > 0.4 * 0.06 * 128


def test_strokes_keep_off_what_is_drawn_and_where_none_are_wanted():
    ground = plane(6.0, 0.0)
    spacing = ground.spacing.copy()
    spacing[:, :50] = 0
    drawn = np.array([[0, 100], [299, 100]], float)
    lines = streamlines(Ground(ground.cos, ground.sin, spacing, ground.fade, ground.area), [drawn], 10.0)
    points = np.concatenate(lines)
    assert points[:, 0].min() >= 49.5
    assert np.abs(points[:, 1] - 100).min() >= 3
    assert min(map(geometry.length, lines)) >= 10 - STEP_PX


def test_a_vortex_ends():
    y, x = np.indices((120, 120)) - 60.0
    far = np.hypot(x, y) + 1e-9
    ground = plane(5.0, shape=(120, 120))
    lines = streamlines(
        Ground((-y / far).astype(np.float32), (x / far).astype(np.float32), ground.spacing, ground.fade, ground.area),
        [],
        5.0,
    )
    assert 10 < len(lines) < 400


@pytest.mark.parametrize("style", ["splines", "canny"])
def test_every_style_can_be_shaded(style):
    photo, face = astronaut()
    settings = LineSettings()
    plain = draw_lines(photo, face, style, settings)
    shaded = draw_lines(photo, face, style, settings.assign("tone.level", "medium"))
    count = len(plain.lines_px)
    assert all(np.array_equal(a, b) for a, b in zip(shaded.lines_px, plain.lines_px, strict=False))
    assert len(shaded.lines_px) > count + 20
    each = [geometry.length(line) for line in shaded.lines_px]
    per_length = shaded.weight / np.maximum(each, 1e-9)
    assert np.median(per_length[count:]) < np.median(per_length[:count])


@pytest.mark.parametrize("value", [0, 255])
def test_a_blank_photo_gives_hardly_any_hatching(parts, value):
    _, face, figure = parts
    blank = Photo(np.full((*figure.figure.shape, 3), value, np.uint8))
    strokes = hatch(blank, face, figure, NO_LINES, ToneSettings(level="medium"))
    assert geometry.total_length(strokes.lines_px) == 0


def test_a_budget_cuts_tone_before_lines():
    from limner import draw

    photo, face = astronaut()
    plain = draw(photo, face=face, style="splines")
    shaded = draw(photo, face=face, style="splines", tone__level="medium", points=plain.drawing.points)
    assert len(shaded.drawing.lines_mm) <= len(plain.drawing.lines_mm) + 10
    assert shaded.drawing.weight.sum() > 0.95 * plain.drawing.weight.sum()


@pytest.mark.parametrize("style", STYLES)
def test_what_has_no_effect_is_said_and_only_that(style):
    """A style is either changed by it, or a line says that it is not."""
    photo, face = painted()
    settings = LineSettings()
    shaded, completed = settings.assign("tone.level", "rich"), settings.assign("complete", "all")
    assert without_effect(style, settings) == ()
    told = without_effect(style, shaded.assign("complete", "all"))
    assert [note.split()[0] for note in told] in ([], ["--tone", "--complete"])
    if told:
        assert all(style in note for note in told)
        small = settings.with_points(style, 60)
        before, after = (draw_lines(photo, face, style, each) for each in (small, shaded.with_points(style, 60)))
        assert before == after
        assert draw_lines(photo, face, style, completed.with_points(style, 60)) == before
    elif style == "canny":
        assert len(draw_lines(photo, face, style, shaded).lines_px) > len(
            draw_lines(photo, face, style, settings).lines_px
        )

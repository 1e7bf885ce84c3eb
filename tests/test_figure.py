import cv2
import numpy as np
import pytest

from limner.types import Photo
from limner.vision.figure import FigureSettings, find_figure
from limner.vision.raster import filled
from limner.vision.scale import ScaleSettings, to_working_scale
from portraits import astronaut, face_of, london, mirrored, plain_face, resized

SETTINGS = FigureSettings()
PARTS = ("skin", "hair", "body")


def shared_part(a, b):
    """Intersection over union."""
    return (a & b).sum() / max((a | b).sum(), 1)


def found(photo, face):
    working = to_working_scale(photo, face, ScaleSettings())
    return working, find_figure(working.photo, working.face, SETTINGS)


@pytest.fixture(scope="module")
def person():
    return found(*astronaut())


def hull(face, shape):
    return filled(cv2.convexHull(face.points_px.astype(np.float32))[:, 0].astype(float), shape)


def test_the_parts_make_up_the_figure(person):
    _, figure = person
    assert sum(getattr(figure, part).astype(int) for part in PARTS).max() == 1
    assert (figure.skin | figure.hair | figure.body == figure.figure).all()
    assert not (figure.beard & ~figure.skin).any()


def test_the_face_belongs_to_the_figure_and_is_skin(person):
    working, figure = person
    inside = hull(working.face, figure.figure.shape)
    assert figure.figure[inside].all()
    assert figure.skin[inside].mean() > 0.9


def test_the_astronaut_has_hair_above_and_clothes_below(person):
    working, figure = person
    unit, brow, chin = working.face.outer_eye_px, working.face.points_px[24], working.face.points_px[8]
    for part, place in (("hair", brow - np.array([0, 0.8 * unit])), ("body", chin + np.array([0, 0.9 * unit]))):
        column, row = np.rint(place).astype(int)
        assert getattr(figure, part)[row, column]
    assert not figure.figure[5, 5]
    assert not figure.figure[5, -5]


def test_the_same_photo_gives_the_same_masks(person):
    assert found(*astronaut())[1] == person[1]


def test_a_mirrored_photo_gives_the_mirrored_figure(person):
    _, figure = found(*mirrored(*astronaut()))
    assert shared_part(figure.figure[:, ::-1], person[1].figure) > 0.96


@pytest.mark.parametrize("factor", [0.5, 2])
def test_a_photo_of_another_size_gives_nearly_the_same_figure(person, factor):
    _, figure = found(*resized(*astronaut(), factor)[:2])
    size = person[1].figure.shape[::-1]
    same = cv2.resize(figure.figure.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
    assert shared_part(same, person[1].figure) > 0.95


@pytest.mark.parametrize(
    "change",
    [lambda v: 0.5 * v, lambda v: 255 * (v / 255) ** 0.6, lambda v: 60 + 0.7 * v],
    ids=["dark", "gamma", "fog"],
)
def test_brightness_hardly_matters(person, change):
    photo, face = astronaut()
    _, figure = found(Photo(np.clip(change(photo.rgb.astype(float)), 0, 255).astype(np.uint8)), face)
    assert shared_part(figure.figure, person[1].figure) > 0.93


def made_up(ground):
    """A bust in plain colours over a background, and its true mask."""
    face = plain_face()
    height, width = ground.shape[:2]
    rgb, truth = ground.copy(), np.zeros((height, width), np.uint8)
    shapes = [
        ((90, 60, 40), ((280, 265), (135, 190))),
        ((40, 70, 140), ((280, 660), (270, 200))),
        ((215, 165, 140), ((280, 420), (60, 110))),
        ((215, 165, 140), ((280, 310), (108, 150))),
    ]
    for colour, (centre, axes) in shapes:
        cv2.ellipse(rgb, centre, axes, 0, 0, 360, colour, -1)
        cv2.ellipse(truth, centre, axes, 0, 0, 360, 1, -1)
    return Photo(rgb), face, truth > 0


def clutter(shape=(600, 560)):
    """Boxes and discs in greens and greys all over."""
    rng = np.random.default_rng(3)
    ground = np.full((*shape, 3), 120, np.uint8)
    for _ in range(250):
        x, y = rng.integers(0, shape[1]), rng.integers(0, shape[0])
        colour = (rng.integers([60, 120, 60], [120, 230, 120])).tolist()
        cv2.circle(ground, (int(x), int(y)), int(rng.integers(5, 40)), colour, -1)
    return ground


def test_a_bust_on_clutter_is_found():
    photo, face, truth = made_up(clutter())
    assert shared_part(find_figure(photo, face, SETTINGS).figure, truth) > 0.93


def test_a_bust_on_a_plain_ground_is_found():
    photo, face, truth = made_up(np.full((600, 560, 3), 230, np.uint8))
    assert shared_part(find_figure(photo, face, SETTINGS).figure, truth) > 0.95


@pytest.mark.parametrize("value", [0, 128, 255])
@pytest.mark.parametrize("size", [(600, 560), (300, 300), (40, 700), (1, 1)])
def test_where_nothing_can_be_seen_it_is_neither_nothing_nor_everything(value, size):
    face = plain_face()
    figure = find_figure(Photo(np.full((*size, 3), value, np.uint8)), face, SETTINGS).figure
    assert figure.shape == size
    if size[0] == 600:
        assert 0.2 < figure.mean() < 0.8


@pytest.mark.slow
@pytest.mark.parametrize("name", ["062_03.jpg", "017_03.jpg"])
def test_the_head_before_a_plain_ground_is_found(shared, name):
    """Above the shoulders, what is not the light grey of the ground is the person."""
    working, figure = found(*london(shared, name))
    grey = working.photo.rgb.astype(float)
    chin = int(working.face.points_px[8, 1])
    dark = (grey.max(axis=-1) < 140)[:chin]
    assert figure.figure[:chin][dark].mean() > 0.93
    corner = figure.figure[: chin // 3, : figure.figure.shape[1] // 6]
    assert not corner.any()


def test_a_dark_column_above_the_head_is_background(person):
    working, figure = person
    top = int(np.nonzero(figure.figure.any(axis=1))[0][0])
    tall = cv2.copyMakeBorder(working.photo.rgb, 60, 0, 0, 0, cv2.BORDER_REPLICATE)
    middle = int(working.face.points_px[27, 0])
    tall[: top + 80, middle - 40 : middle + 40] = tall[top + 100, middle]
    face = face_of(working.face.points_px + np.array([0, 60]))
    found_figure = find_figure(Photo(tall), face, SETTINGS).figure
    assert not found_figure[:40, middle - 40 : middle + 40].any()
    assert shared_part(found_figure[60:], figure.figure) > 0.9


def grained(rgb, mask, rng, strength=30):
    """Grain, as of hair or cloth, on part of a picture."""
    noise = cv2.GaussianBlur(rng.normal(0, 1, mask.shape), (0, 0), 1.5)
    changed = rgb + np.where(mask, strength / noise.std() * noise, 0)[..., None]
    return np.clip(changed, 0, 255).astype(np.uint8)


def shaded(light, darkest=0.2):
    """A grey wall with the soft shadow of a head on it."""
    rows, columns = np.indices((600, 560))
    far = np.hypot((columns - 380) / 60, (rows - 420) / 90)
    shadow = darkest + (1 - darkest) / (1 + np.exp(-5 * (far - 1)))
    return np.clip(np.array(light) * shadow[..., None], 0, 255).astype(np.uint8)


@pytest.mark.parametrize("wall", [(190, 190, 190), (150, 180, 210)], ids=["grey", "blue"])
def test_a_soft_shadow_on_the_wall_is_no_hair(wall):
    ground = shaded(wall)
    photo, face, truth = made_up(ground)
    hair = (photo.rgb == (90, 60, 40)).all(axis=-1)
    dark = np.where(hair[..., None], (45, 42, 42), photo.rgb)
    figure = find_figure(Photo(grained(dark, hair, np.random.default_rng(1))), face, SETTINGS)
    shadow = ~truth & (ground[..., 0] < 0.6 * wall[0])
    shadow[470:] = False
    assert shadow.sum() > 2000
    assert (figure.figure & shadow).sum() < 0.25 * shadow.sum()
    assert shared_part(figure.figure, truth) > 0.93


def long_haired(colour, ground):
    """The bust with hair down to the shoulders and wide beside the face."""
    photo, face, truth = made_up(ground)
    hair = np.zeros(truth.shape, np.uint8)
    cv2.ellipse(hair, (280, 330), (225, 260), 0, 0, 360, 1, -1)
    behind = (hair > 0) & ~truth
    own = (photo.rgb == (90, 60, 40)).all(axis=-1)
    rgb = photo.rgb.copy()
    rgb[behind | own] = colour
    return Photo(grained(rgb, behind | own, np.random.default_rng(2), 8)), face, truth | behind


@pytest.mark.parametrize("colour", [(40, 30, 28), (190, 150, 90)], ids=["dark", "fair"])
def test_wide_long_hair_belongs_to_the_figure(colour):
    photo, face, truth = long_haired(colour, np.full((600, 560, 3), (150, 190, 150), np.uint8))
    figure = find_figure(photo, face, SETTINGS)
    assert shared_part(figure.figure, truth) > 0.93
    assert figure.hair[330, 90]
    assert figure.hair[330, 470]


def test_texture_tells_the_hat_from_a_wood_of_its_colour():
    rng = np.random.default_rng(5)
    photo, face, truth = made_up(np.full((600, 560, 3), (100, 72, 50), np.uint8))
    figure = find_figure(Photo(grained(photo.rgb, truth & (np.indices(truth.shape)[0] < 300), rng)), face, SETTINGS)
    assert shared_part(figure.figure[:300], truth[:300]) > 0.85


def test_a_rail_behind_the_ears_is_background():
    ground = np.full((600, 560, 3), 225, np.uint8)
    ground[300:318] = (80, 55, 40)
    photo, face, truth = made_up(ground)
    figure = find_figure(photo, face, SETTINGS).figure
    assert (figure & ~truth)[300:318].sum() < 0.1 * (~truth)[300:318].sum()
    assert shared_part(figure, truth) > 0.93


def test_the_ground_above_a_bald_head_is_background():
    """Brown and blurred as autumn woods: darker than the skin, of its hue."""
    rng = np.random.default_rng(4)
    spots = cv2.GaussianBlur(rng.normal(0, 1, (600, 560)), (0, 0), 12)
    ground = np.clip(np.array([75, 62, 52]) + 18 * (spots / spots.std())[..., None], 0, 255).astype(np.uint8)
    photo, face, truth = made_up(ground)
    rgb = photo.rgb.copy()
    rgb[(rgb == (90, 60, 40)).all(axis=-1)] = (190, 142, 118)
    rgb[:120, 200:360] = np.where(truth[:120, 200:360, None], rgb[:120, 200:360], 0.75 * rgb[:120, 200:360])
    figure = find_figure(Photo(rgb), face, SETTINGS).figure
    assert not figure[:60].any()
    assert shared_part(figure, truth) > 0.93

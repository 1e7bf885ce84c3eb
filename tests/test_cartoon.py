"""The cartoon: flat tones that noise does not move, edges where it is dark, few inks, and films that are steady."""

import dataclasses
import itertools
import json

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

import limner
from limner.cli.film import film
from limner.errors import BadInput
from limner.pipeline import Settings
from limner.targets.movie import encode_mp4
from limner.types import Photo
from limner.vision.cartoon.abstraction import AbstractionSettings, abstract, edges, on_levels
from limner.vision.cartoon.film import cartoon_frames, frames, steadied
from limner.vision.palette import inks, nearest, to_lab, to_pens, to_rgb
from portraits import astronaut, darkness_inked

PHOTO, FACE = astronaut()
PLAIN = AbstractionSettings()


def noisy(picture, sigma, seed):
    noise = np.random.default_rng(seed).normal(0, sigma, picture.shape)
    return np.clip(np.rint(picture + noise), 0, 255).astype(np.uint8)


def scene():
    """Soft light from left to right, and a dark disc."""
    y, x = np.mgrid[:240, :320]
    light = 90 + 100 * x / 320
    light = np.where(np.hypot(x - 160, y - 120) < 60, 40, light)
    return np.repeat(light[..., None], 3, axis=2).astype(np.uint8)


@pytest.fixture(scope="module")
def drawn():
    return limner.draw(PHOTO, face=FACE, style="cartoon")


def test_lightness_on_levels_keeps_order_and_flat_places():
    ramp = np.tile(np.linspace(0, 100, 500, dtype=np.float32), (5, 1))
    soft = on_levels(ramp, 8)
    assert (np.diff(soft[2]) >= -1e-3).all()
    assert np.abs(soft - ramp).max() <= 100 / 8 / 2 + 1e-3
    middle = (np.arange(8) + 0.5) * 100 / 8
    flat = on_levels(np.tile(middle.astype(np.float32)[:, None, None], (1, 9, 9)).reshape(-1, 9), 8)
    assert np.allclose(flat[4::9, 4], middle, atol=1e-3)


def test_noise_moves_soft_levels_less_than_hard_ones():
    light = np.tile(np.linspace(20, 80, 400, dtype=np.float32), (300, 1))
    first, second = (light + np.random.default_rng(k).normal(0, 0.5, light.shape).astype(np.float32) for k in (1, 2))
    hard = [(np.floor(one / 12.5) + 0.5) * 12.5 for one in (first, second)]
    soft = [on_levels(one, 8) for one in (first, second)]
    jumps = [float((np.abs(a - b) > 6).mean()) for a, b in (hard, soft)]
    assert jumps[0] > 0.01
    assert jumps[1] < jumps[0] / 20


def test_edges_are_where_it_is_darker_than_around():
    light = to_lab(scene())[..., 0]
    ink = edges(light, PLAIN, 1.2)
    rows, columns = np.nonzero(ink > 0.5)
    away = np.abs(np.hypot(columns - 160, rows - 120) - 60)
    assert len(rows) > 200
    assert away.max() < 5
    assert ink[:, 300].max() < 0.05


def test_what_has_little_contrast_becomes_flat_and_the_border_stays():
    made = abstract(noisy(scene(), 4, 0), PLAIN)
    inside = made.smooth[100:140, 140:180, 0]
    assert inside.std() < to_lab(noisy(scene(), 4, 0))[100:140, 140:180, 0].std() / 2
    assert made.smooth[120, 90, 0] - made.smooth[120, 110, 0] > 20


def test_a_film_of_something_still_is_steadier_than_its_noise():
    clean = scene()
    pictures = [noisy(clean, 3, k) for k in range(12)]
    made = list(cartoon_frames(iter(pictures), PLAIN))
    alone = [abstract(picture, PLAIN).rgb() for picture in pictures]

    def flicker(films):
        late = [film.astype(float) for film in films[6:]]
        return float(np.mean([np.abs(a - b).mean() for a, b in itertools.pairwise(late)]))

    assert flicker(made) < flicker(pictures) / 3
    assert flicker(made) < flicker(alone)


def test_what_moves_is_not_smeared():
    before, after = np.full((40, 40, 3), 30, np.uint8), np.full((40, 40, 3), 220, np.uint8)
    assert np.array_equal(steadied(steadied(None, before), after), after)


def test_films_are_read_and_scaled(tmp_path):
    file = tmp_path / "film.mp4"
    file.write_bytes(encode_mp4(iter([scene()] * 5), 12.5, hold_s=0))
    rate, pictures = frames(str(file), 160)
    found = list(pictures)
    assert (rate, len(found), found[0].shape) == (12.5, 5, (120, 160, 3))
    (tmp_path / "no.mp4").write_bytes(b"nothing")
    for bad in ("camera:x", str(tmp_path / "missing.mp4"), str(tmp_path / "no.mp4")):
        with pytest.raises(BadInput, match="expected"):
            frames(bad)


def test_inks_are_the_colours_of_the_picture():
    rgb = np.array([[180, 40, 40]] * 50 + [[40, 60, 170]] * 50 + [[60, 130, 60]] * 50, np.uint8)
    lab = to_lab(rgb[None])[0].astype(float)
    found = inks(lab, 3, 20, 60)
    assert sorted(np.bincount(nearest(lab[:, 1:], found[:, 1:]), minlength=3)) == [50, 50, 50]
    assert found[:, 0].min() >= 20
    assert found[:, 0].max() <= 60
    assert {pen.name.split()[-1] for pen in to_pens(found)} == {"red", "blue", "green"}
    assert np.array_equal(to_rgb(to_lab(rgb[None])), rgb[None])


def test_pens_of_one_colour_have_names_of_their_own():
    names = [pen.name for pen in to_pens(np.array([[30.0, 0, 0], [32, 0, 0], [34, 0, 0]]))]
    assert len(set(names)) == 3


def test_it_is_drawn_in_as_many_pens_as_asked(drawn):
    assert len(drawn.drawing.pens) == 4
    assert drawn.drawing.pens[0].rgb == (0, 0, 0)
    assert set(drawn.drawing.layer.tolist()) <= set(range(4))
    assert len(set(drawn.drawing.layer.tolist())) >= 3
    one = limner.draw(PHOTO, face=FACE, style="cartoon", cartoon__pens=1)
    assert one.drawing.pens == (limner.Pen(),)


def test_it_is_deterministic_within_the_photo_and_the_page(drawn):
    again = limner.draw(PHOTO, face=FACE, style="cartoon")
    assert again.drawing == drawn.drawing
    points, page = np.concatenate(drawn.drawing.lines_mm), drawn.drawing.page
    assert points.min() >= page.margin_mm - 1e-6
    assert (points <= np.array([page.width_mm, page.height_mm]) - page.margin_mm + 1e-6).all()


@pytest.mark.parametrize("points", [150, 600])
def test_budgets_are_kept(points):
    drawing = limner.draw(PHOTO, face=FACE, style="cartoon", points=points).drawing
    assert points * 0.8 <= drawing.points <= points
    assert "eye" in drawing.region


def test_more_ink_where_it_is_darker(drawn):
    assert darkness_inked(drawn, 0.02 * drawn.face.outer_eye_px) > 0.3


def test_its_picture_has_the_photos_size_and_fewer_lightnesses(drawn):
    picture = drawn.picture()
    assert picture.shape == drawn.photo.rgb.shape
    with pytest.raises(BadInput, match="no picture"):
        dataclasses.replace(drawn, settings=Settings(style="canny")).picture()


def test_a_large_photo_has_a_smaller_picture():
    large = Photo(cv2.resize(PHOTO.rgb, (2000, 1500)))
    grow = np.array([2000, 1500]) / PHOTO.size_px
    bigger = dataclasses.replace(FACE, points_px=FACE.points_px * grow, box_px=FACE.box_px * np.tile(grow, 2))
    assert limner.draw_picture(large, bigger, "cartoon", Settings()).shape == (1200, 1600, 3)


def test_the_command_makes_a_film_and_refuses_what_is_none(tmp_path):
    file, out = tmp_path / "film.mp4", tmp_path / "cartoon.mp4"
    file.write_bytes(encode_mp4(iter([scene()] * 6), 20, hold_s=0))
    ran = CliRunner().invoke(film, [str(file), "-o", str(out), "--length", "0.2s", "--json"])
    assert ran.exit_code == 0
    assert json.loads(ran.stdout)["frames"] == 4
    assert len(list(frames(str(out))[1])) == 4
    refused = CliRunner().invoke(film, [str(tmp_path / "missing.mp4")])
    assert isinstance(refused.exception, BadInput)
    refused = CliRunner().invoke(film, [str(file), "-o", "x.gif"])
    assert isinstance(refused.exception, BadInput)

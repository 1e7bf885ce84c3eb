"""A session draws what a fresh drawing gives, and does nothing twice."""

from __future__ import annotations

import numpy as np
import pytest

import limner
from limner.errors import NoFace
from limner.pipeline import Session, budget, draw, session as drawing_session
from limner.stages import Stages
from limner.types import Photo
from limner.vision.edges import EXTRACTORS, IN_TWO
from limner.vision.landmarks.detectors import DETECTORS
from limner.vision.lines import sitter, styles, traced
from portraits import astronaut

PHOTO, FACE = astronaut()


@pytest.fixture
def calls(monkeypatch):
    """The names of the stages that were really done."""
    done = []

    def watch(module, name):
        run = getattr(module, name)

        def watched(*args):
            done.append(name)
            return run(*args)

        monkeypatch.setattr(module, name, watched)

    watch(sitter, "to_working_scale")
    watch(traced, "trim")
    watch(traced, "_traced")
    watch(styles, "spline_strokes")
    for name in ("refine", "compose", "clean", "select"):
        watch(drawing_session, name)
    watch(budget, "order")
    for name, run in dict(EXTRACTORS).items():
        monkeypatch.setitem(EXTRACTORS, name, lambda *args, name=name, run=run: done.append(name) or run(*args))
    for name, steps in dict(IN_TWO).items():
        watched = [
            lambda *args, name=f"{name} {step}", run=run: done.append(name) or run(*args)
            for step, run in zip(("sight", "lines"), steps, strict=True)
        ]
        monkeypatch.setitem(IN_TWO, name, tuple(watched))

    def found(photo, settings):
        done.append("detect")
        return (FACE,)

    monkeypatch.setitem(DETECTORS, "fmp", DETECTORS["fmp"]._replace(detect=found))
    return done


def after(calls, session, **changes):
    """What a drawing with these changes had to do."""
    calls.clear()
    session.draw(**changes)
    return list(calls)


ON_PAGE = ["compose", "clean", "select", "order"]


def test_a_changed_setting_costs_only_what_follows_it(calls):
    session = Session(PHOTO)
    everything = ["detect", "refine", "to_working_scale", "gabor sight", "gabor lines", "trim", "_traced", *ON_PAGE]
    assert after(calls, session, style="gabor", points=600) == everything
    assert after(calls, session, style="gabor", points=600) == []
    assert after(calls, session, style="gabor", points=300) == ["select", "order"]
    assert after(calls, session, style="gabor", points=300, trim__near_px=25) == ["trim", "_traced", *ON_PAGE]
    assert after(calls, session, style="gabor", points=300, trim__near_px=25, page="a4") == ON_PAGE
    threshold = {"style": "gabor", "points": 300, "gabor__high": 1.5}
    assert after(calls, session, **threshold) == ["gabor lines", "trim", "_traced", *ON_PAGE]
    assert after(calls, session, **threshold, gabor__orientations=6)[:2] == ["gabor sight", "gabor lines"]
    assert after(calls, session, style="canny") == ["canny", "trim", "_traced", *ON_PAGE]
    assert after(calls, session, style="splines") == ["spline_strokes", *ON_PAGE]
    refined = ["refine", "to_working_scale", "canny", "trim", "_traced", *ON_PAGE]
    assert after(calls, session, style="canny", refine="none") == refined


def test_what_comes_out_the_same_is_not_gone_on_with(calls):
    session = Session(PHOTO)
    session.draw(style="canny", trim__fewest_px=20)
    assert after(calls, session, style="canny", trim__fewest_px=20, detect__fmp__threshold=-0.5) == ["detect"]


def test_more_can_be_kept(calls):
    session = Session(PHOTO, keep=2)
    session.draw(style="canny")
    session.draw(style="gabor")
    assert after(calls, session, style="canny") == []
    assert after(calls, session, style="gabor") == []


def test_any_way_through_the_settings_gives_what_a_fresh_drawing_gives():
    choices = {
        "style": ["portrait", "gabor", "canny", "splines"],
        "points": [150, 600],
        "trim__near_px": [25, 40],
        "trace__tolerance_px": [0.4, 1.5],
        "scale__outer_eye_px": [96, 128],
        "page": ["a5", "a4"],
        "complete": ["none", "jaw,mouth"],
        "trim__by": ["rectangle,distance,length", "boxes,length"],
        "regions__hair": [0.5, 1.5],
        "clean__min_length_mm": [0, 2],
        "gabor__high": [1.5, 2.1],
    }
    session, random, now = Session(PHOTO), np.random.default_rng(5), {"style": "canny"}
    for _ in range(9):
        for name in random.choice(list(choices), 2, replace=False):
            now[str(name)] = choices[str(name)][random.integers(len(choices[str(name)]))]
        crop = [None, (60, 10, 400, 420)][random.integers(2)]
        kept, fresh = (drawn(face=FACE, crop=crop, **now) for drawn in (session.draw, lambda **c: draw(PHOTO, **c)))
        assert kept.svg() == fresh.svg()
        assert kept.strokes == fresh.strokes
        np.testing.assert_array_equal(kept.page_from_photo, fresh.page_from_photo)


def test_a_session_goes_on_after_an_error():
    session = Session(PHOTO)
    with pytest.raises(NoFace):
        session.draw(face=None, crop=(0, 300, 60, 60), detect__fmp__threshold=5)
    assert session.draw(face=FACE).drawing == draw(PHOTO, face=FACE).drawing


def test_a_stream_is_read_once(tmp_path):
    path = tmp_path / "photo.png"
    path.write_bytes(limner.to_png(draw(PHOTO, face=FACE, style="splines").drawing))
    with path.open("rb") as stream:
        session = Session(stream)
        portraits = [session.draw(face=FACE, style="splines", points=points) for points in (100, 200)]
    assert portraits[0].photo is portraits[1].photo


def test_seconds_are_those_of_this_drawing():
    session = Session(PHOTO)
    first = session.draw(face=FACE).seconds
    second = session.draw(face=FACE).seconds
    assert list(first) == list(second)
    assert sum(second.values()) < sum(first.values()) / 5


def test_no_more_is_kept_than_asked_for():
    stages, done = Stages(keep=2), []

    def double(value):
        done.append(value)
        return 2 * value

    for value in (1, 2, 1, 3, 1, 2):
        assert stages("double", double, value) == 2 * value
    assert done == [1, 2, 3, 2]


def test_inputs_of_the_same_content_count_as_the_same():
    stages, done = Stages(), []

    def size(photo, numbers):
        done.append(photo)
        return photo.size_px

    for _ in range(2):
        stages("size", size, Photo(PHOTO.rgb.copy()), (1, np.arange(3)))
    stages("size", size, PHOTO, (1, np.arange(4)))
    assert len(done) == 2

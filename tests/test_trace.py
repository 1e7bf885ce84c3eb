from collections import Counter
from itertools import pairwise

import cv2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import arrays
from scipy import ndimage

from limner import geometry
from limner.vision.chains import join, join_gaps, runs_of
from limner.vision.graph import branches_of, prune_spurs, through_nodes
from limner.vision.skeleton import skeletonize
from limner.vision.trace import TraceSettings, skip_near, smooth, trace

MASKS = arrays(bool, st.tuples(st.integers(1, 16), st.integers(1, 16)))
PLAIN = TraceSettings(spur_px=0, gap_px=0, shortest_px=0, smooth_px=0, step_px=0, tolerance_px=0)


def pixels_of(skeleton):
    return {(float(x), float(y)) for y, x in np.argwhere(skeleton)}


def drawn(lines, size=120):
    """The thinned picture of some lines, drawn two pixels wide."""
    picture = np.zeros((size, size), np.uint8)
    for line in lines:
        cv2.polylines(picture, [np.rint(line).astype(np.int32)], False, 1, 2)
    return skeletonize(picture > 0)


def on_circle(radius, centre, count=200):
    turn = np.linspace(0, 2 * np.pi, count)
    circle = np.asarray(centre) + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    circle[-1] = circle[0]
    return circle


@settings(max_examples=300, deadline=None)
@given(MASKS)
def test_every_pixel_lies_in_one_branch_once_or_is_a_node_and_no_step_is_walked_twice(mask):
    skeleton = skeletonize(mask)
    branches = branches_of(skeleton)
    paths = [list(map(tuple, branch.path.tolist())) for branch in branches]
    inside = Counter(pixel for path in paths for pixel in path[1:-1])
    nodes = {pixel for path in paths for pixel in (path[0], path[-1])}
    assert set(inside) | nodes == pixels_of(skeleton)
    assert not set(inside) & nodes
    assert set(inside.values()) <= {1}
    steps = Counter(frozenset(step) for path in paths for step in pairwise(path))
    assert set(steps.values()) <= {1}
    assert all(max(abs(a[0] - b[0]), abs(a[1] - b[1])) == 1 for a, b in map(tuple, steps))


@settings(max_examples=200, deadline=None)
@given(MASKS, st.floats(0, 180))
def test_linking_loses_no_pixel_and_walks_no_step_twice(mask, bend):
    skeleton = skeletonize(mask)
    paths = [list(map(tuple, line.path.tolist())) for line in through_nodes(branches_of(skeleton), bend)]
    assert {pixel for path in paths for pixel in path} == pixels_of(skeleton)
    steps = Counter(frozenset(step) for path in paths for step in pairwise(path))
    assert set(steps.values()) <= {1}
    branch_steps = sum(len(branch.path) - 1 for branch in branches_of(skeleton))
    assert sum(steps.values()) == branch_steps


@settings(max_examples=150, deadline=None)
@given(MASKS, st.floats(0, 10))
def test_pruning_takes_only_spurs_and_leaves_pieces_and_holes(mask, shorter):
    skeleton = skeletonize(mask)
    kept = np.zeros_like(skeleton)
    branches = prune_spurs(branches_of(skeleton), shorter)
    for branch in branches:
        columns, rows = branch.path.astype(int).T
        kept[rows, columns] = True
    eight = np.ones((3, 3))
    assert not (kept & ~skeleton).any()
    assert ndimage.label(kept, eight)[1] == ndimage.label(skeleton, eight)[1]
    assert ndimage.label(~np.pad(kept, 1))[1] == ndimage.label(~np.pad(skeleton, 1))[1]
    ends = Counter(node for branch in branches for node in branch.nodes)
    for branch in branches:
        meeting = sorted(ends[node] for node in branch.nodes)
        assert not (meeting[0] == 1 and meeting[1] >= 3 and geometry.length(branch.path) < shorter)


@pytest.mark.parametrize("radius", [8, 20.5, 44])
@pytest.mark.parametrize("centre", [(60, 60), (59.5, 60.25)])
def test_a_circle_comes_back_as_one_closed_stroke_within_a_pixel(radius, centre):
    y, x = np.mgrid[:121, :121]
    ring = np.abs(np.hypot(x - centre[0], y - centre[1]) - radius) <= 1
    (line,) = trace(skeletonize(ring), TraceSettings(), ring)
    assert geometry.is_closed(line)
    away = np.hypot(*(geometry.resample(line, 0.5) - centre).T)
    assert np.abs(away - radius).max() <= 1
    assert geometry.length(line) == pytest.approx(2 * np.pi * radius, rel=0.06)


def test_a_cross_is_two_straight_strokes():
    cross = np.zeros((99, 99), bool)
    cross[10:90, 50] = cross[40, 5:95] = True
    lines = trace(cross, TraceSettings())
    assert sorted(geometry.length(line) for line in lines) == pytest.approx([79, 89])
    assert [len(line) for line in lines] == [2, 2]


@pytest.mark.parametrize("angle", [35, 50, 70, 90])
@pytest.mark.parametrize("turn", [0, 17, 50])
def test_lines_that_cross_at_any_angle_are_two_straight_strokes(angle, turn):
    mask = np.zeros((160, 160), np.uint8)
    ends = []
    for way in np.deg2rad([turn, turn + angle]):
        along = 65 * np.array([np.cos(way), np.sin(way)])
        ends.append((80 - along, 80 + along))
        cv2.line(mask, *(tuple(np.rint(end).astype(int).tolist()) for end in ends[-1]), 1, thickness=4)
    lines = trace(skeletonize(mask > 0), TraceSettings())
    assert len(lines) == 2
    for line in lines:
        off = [geometry.distance_to_segments(line, a, b).max() for a, b in ends]
        assert min(off) < 2.5
        assert geometry.length(line) > 115


def test_two_lines_joined_by_a_short_piece_do_not_cross():
    mask = np.zeros((99, 99), bool)
    mask[40, 5:95] = mask[50, 5:95] = mask[40:50, 50] = True
    lines = trace(mask, TraceSettings(spur_px=0, shortest_px=0))
    assert sorted(round(np.ptp(line[:, 1])) for line in lines)[:2] == [0, 0]


def test_an_even_width_is_traced_in_its_middle():
    bar = np.zeros((40, 90), bool)
    bar[20:22, 10:80] = True
    (line,) = trace(skeletonize(bar), TraceSettings(), bar)
    np.testing.assert_allclose(line[:, 1], 20.5, atol=0.1)


def test_at_a_t_the_bar_goes_on_and_the_stem_ends():
    skeleton = drawn([np.array([[10, 60], [110, 60]]), np.array([[60, 60], [60, 110]])])
    bar, stem = sorted(trace(skeleton, TraceSettings()), key=geometry.length, reverse=True)
    assert geometry.length(bar) == pytest.approx(100, abs=3)
    assert geometry.length(stem) == pytest.approx(50, abs=3)


def test_spurs_go_and_the_line_stays_whole():
    comb = [np.array([[10, 60], [110, 60]])]
    comb += [np.array([[x, 60], [x + 1, 60 + side * 5]]) for x, side in ((30, 1), (50, -1), (70, 1), (90, -1))]
    (line,) = trace(drawn(comb), TraceSettings())
    assert geometry.length(line) == pytest.approx(100, abs=4)
    assert len(trace(drawn(comb), PLAIN.replace(bend_deg=60))) == 5


def test_ends_that_face_each_other_are_joined_and_others_are_not():
    left, right = np.array([[0.0, 0], [40, 0]]), np.array([[44.0, 1], [90, 2]])
    (joined,) = join_gaps([left, right], 6, 0.6)
    assert geometry.length(joined) == pytest.approx(90, abs=0.5)
    beside = np.array([[40.0, 4], [0, 4]])
    assert len(join_gaps([left, beside], 6, 0.6)) == 2
    assert len(join_gaps([left, np.add(right, [10, 0])], 6, 0.6)) == 2
    assert len(join_gaps([left, right], 0, 0.6)) == 2


def test_a_ring_with_a_gap_is_closed():
    open_ring = on_circle(20, (0, 0))[3:-3]
    (ring,) = join_gaps([open_ring], 6, 0.6)
    assert geometry.is_closed(ring)


@settings(max_examples=100, deadline=None)
@given(st.integers(1, 12), st.randoms(use_true_random=False))
def test_runs_take_every_line_once(lines, random):
    ends = list(range(2 * lines))
    random.shuffle(ends)
    pairs = [(ends[2 * i], ends[2 * i + 1]) for i in range(random.randint(0, lines))]
    runs = runs_of(lines, pairs)
    assert sorted(end // 2 for run in runs for end in run) == list(range(lines))
    points = [np.array([[float(i), 0], [float(i), 1]]) for i in range(lines)]
    assert sum(map(len, join(points, runs))) == 2 * lines


@pytest.mark.parametrize("sigma", [0.5, 1.5, 4])
def test_smoothing_keeps_ends_straight_lines_and_closedness(sigma):
    straight = np.stack([np.arange(30.0), 2 + 0.5 * np.arange(30.0)], axis=1)
    np.testing.assert_allclose(smooth(straight, sigma), straight, atol=1e-9)
    stairs = np.stack([np.arange(40.0), np.round(np.arange(40) / 3)], axis=1)
    smoothed = smooth(stairs, sigma)
    np.testing.assert_allclose(smoothed[[0, -1]], stairs[[0, -1]], atol=1e-9)
    assert geometry.length(smoothed) < geometry.length(stairs)
    assert geometry.is_closed(smooth(on_circle(20, (0, 0)), sigma))


def test_smoothing_follows_the_line_whichever_way_it_is_walked():
    line = drawn([on_circle(40, (60, 60))[:120]])
    (path,) = trace(line, PLAIN.replace(bend_deg=60))
    np.testing.assert_allclose(smooth(path[::-1], 2)[::-1], smooth(path, 2), atol=1e-9)


@settings(max_examples=100, deadline=None)
@given(arrays(float, st.tuples(st.integers(1, 30), st.just(2)), elements=st.floats(-50, 50)), st.floats(0.01, 20))
def test_skipping_keeps_both_ends_and_no_two_near_points(line, step):
    kept = skip_near(line, step)
    np.testing.assert_array_equal(kept[[0, -1]], line[[0, -1]])
    between = np.hypot(*np.diff(kept, axis=0).T)
    assert (between[:-1] >= step * (1 - 1e-12)).all()


def test_fewer_points_stay_within_the_tolerance():
    skeleton = drawn([on_circle(45, (60, 60)), on_circle(12, (50, 55))])
    loose = TraceSettings(tolerance_px=0.4)
    exact = trace(skeleton, loose.replace(step_px=0, tolerance_px=0))
    few = trace(skeleton, loose)
    for one, other in zip(exact, few, strict=True):
        points = geometry.resample(one, 0.5)
        away = np.min([geometry.distance_to_segments(points, a, b) for a, b in pairwise(other)], 0)
        assert away.max() <= loose.tolerance_px + loose.step_px**2 / 8 / 10
        assert len(other) < len(one) / 3


@pytest.mark.parametrize("shape", [(1, 1), (1, 30), (30, 1), (40, 40)])
def test_degenerate_skeletons(shape):
    assert trace(np.zeros(shape, bool), TraceSettings()) == []
    one = np.zeros(shape, bool)
    one[0, 0] = True
    assert trace(one, TraceSettings()) == []
    (dot,) = trace(one, PLAIN)
    np.testing.assert_array_equal(dot, [[0, 0]])
    trace(skeletonize(np.ones(shape, bool)), TraceSettings())


def test_single_pixels_and_rings_survive_linking():
    ring = np.zeros((9, 9), bool)
    ring[[1, 1, 1, 2, 3, 3, 3, 2], [2, 3, 4, 5, 4, 3, 2, 1]] = True
    ring[7, 7] = True
    branches = through_nodes(branches_of(ring), 180)
    assert sorted(len(branch.path) for branch in branches) == [1, 9]
    assert all((branch.path[0] == branch.path[-1]).all() for branch in branches)

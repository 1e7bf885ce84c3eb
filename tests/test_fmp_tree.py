import itertools

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from limner.errors import BadInput
from limner.vision.landmarks.fmp.tree import chow_liu, mutual_information, spanning_tree


def edges(tree):
    pairs = zip(tree.parents[1:], tree.landmarks[1:], strict=True)
    return {frozenset((tree.landmarks[parent], landmark)) for parent, landmark in pairs}


def all_trees(n):
    """Every labelled tree on n nodes, from its Pruefer sequence."""
    for code in itertools.product(range(n), repeat=n - 2):
        degree = [1 + code.count(k) for k in range(n)]
        tree, rest = [], list(degree)
        for node in code:
            leaf = rest.index(1)
            tree.append((leaf, node))
            rest[leaf] -= 1
            rest[node] -= 1
        tree.append(tuple(k for k in range(n) if rest[k] == 1))
        yield tree


def random_weights(seed, n):
    weight = np.random.default_rng(seed).normal(size=(n, n))
    weight = weight + weight.T
    np.fill_diagonal(weight, -np.inf)
    return weight


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("n", [2, 3, 5, 6])
def test_no_tree_weighs_more(seed, n):
    weight = random_weights(seed, n)
    best = max(sum(weight[a, b] for a, b in tree) for tree in all_trees(n))
    assert sum(weight[tuple(edge)] for edge in edges(spanning_tree(weight, 0))) == pytest.approx(best)


@given(st.integers(0, 10_000), st.integers(2, 40), st.data())
@settings(max_examples=30, deadline=None)
def test_is_a_tree_with_parents_first(seed, n, data):
    root = data.draw(st.integers(0, n - 1))
    tree = spanning_tree(random_weights(seed, n), root)
    assert tree.landmarks[0] == root
    assert tree.parents[0] == -1
    assert sorted(tree.landmarks) == list(range(n))
    assert all(0 <= parent < k for k, parent in enumerate(tree.parents) if k)


@pytest.mark.parametrize("n", [3, 30])
def test_the_root_does_not_change_the_edges(n):
    weight = random_weights(3, n)
    assert len({frozenset(edges(spanning_tree(weight, root))) for root in range(n)}) == 1


def chain(faces=4000, n=7, seed=0):
    """Shapes drawn from a chain of springs: each landmark hangs from the one before."""
    rng = np.random.default_rng(seed)
    steps = rng.normal(size=(faces, n, 2)) * np.linspace(0.5, 2, n)[:, None] + [5, 1]
    return steps.cumsum(axis=1)


def test_finds_the_springs_the_shapes_were_drawn_from():
    order = np.array([3, 0, 5, 1, 6, 2, 4])
    shapes = np.empty_like(chain())
    shapes[:, order] = chain()
    tree = chow_liu(shapes, root=int(order[0]))
    assert edges(tree) == {frozenset(pair) for pair in itertools.pairwise(order.tolist())}


def test_where_the_faces_lie_does_not_matter():
    shapes = chain(200)
    moved = shapes + np.random.default_rng(1).normal(size=(200, 1, 2)) * 100
    assert mutual_information(moved, 0.01)[0, 1:] == pytest.approx(mutual_information(shapes, 0.01)[0, 1:])


def test_one_face_is_enough_for_some_tree():
    assert len(chow_liu(chain(1), root=0).parents) == 7


@pytest.mark.parametrize(
    ("shapes", "root", "message"),
    [
        (np.zeros((3, 4)), 0, "shapes"),
        (np.zeros((0, 4, 2)), 0, "shapes"),
        (np.full((3, 4, 2), np.nan), 0, "not known"),
        (np.zeros((3, 4, 2)), 4, "root"),
    ],
)
def test_bad_input_is_named(shapes, root, message):
    with pytest.raises(BadInput, match=message):
        chow_liu(shapes, root)

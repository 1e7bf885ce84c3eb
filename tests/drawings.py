"""Random drawings for property tests: open strokes, closed ones, dots, repeated points, ends that meet, extremes."""

import itertools

import numpy as np
from hypothesis import strategies as st

from limner.types import REGIONS, Drawing, Page, Pen

# Few different places, so that points repeat and ends meet; many, so that nothing is special.
_CROWDED = st.tuples(st.integers(0, 12), st.integers(0, 12)).map(lambda p: (p[0] * 0.4 + 50, p[1] * 0.4 + 50))
_SPARSE = st.tuples(st.floats(0, 148), st.floats(0, 210))
PENS = (Pen(), Pen(0.5, (200, 30, 40), "red ink"), Pen(0.5, (20, 60, 200), "blue"))


@st.composite
def lines(draw, places):
    points = draw(st.lists(places, min_size=1, max_size=9))
    if draw(st.booleans()) and len(points) > 1:
        points.append(points[0])
    return np.array(points)


@st.composite
def drawings(draw, least=0, most=9, most_pens=1):
    """Every pen draws something."""
    places = draw(st.sampled_from([_CROWDED, _SPARSE, _CROWDED | _SPARSE]))
    some = draw(st.lists(lines(places), min_size=least, max_size=most))
    regions = draw(st.lists(st.sampled_from(REGIONS[:3]), min_size=len(some), max_size=len(some)))
    weights = draw(st.lists(st.floats(0, 100), min_size=len(some), max_size=len(some)))
    page = draw(st.sampled_from([Page(), Page(210, 297, 0)]))
    pens = PENS[: draw(st.integers(1, max(1, min(most_pens, len(some)))))]
    layer = [k if k < len(pens) else draw(st.integers(0, len(pens) - 1)) for k in range(len(some))]
    return Drawing(tuple(some), tuple(regions), np.array(weights), page, pens, sorted(layer))


def of(*some, regions=None, weights=None):
    """A drawing of the lines given as lists."""
    return Drawing(
        tuple(np.array(line, float) for line in some),
        tuple(regions or ("face",) * len(some)),
        np.array(weights if weights is not None else [1.0] * len(some)),
    )


def segments(some):
    """Every segment of the lines, without direction and order, and every dot: what the pen draws."""
    found = []
    for line in some:
        points = [tuple(point) for point in line.tolist()]
        found += [tuple(sorted(pair)) for pair in itertools.pairwise(points)] or [(points[0],)]
    return sorted(found)

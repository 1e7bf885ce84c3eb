"""Labelled feature vectors in, the max-margin weights of thesis eq. 3.5 out, with the duality gap that was reached.

Minimise over w, with w_j >= lower_j and one slack for each group g of examples::

    1/2 sum_j r_j (w_j - prior_j)^2  +  sum_g C_g max(0, max_{i in g} (1 - y_i w . x_i))

The dual is climbed one example at a time (dual coordinate descent, Hsieh et al. 2008, doi:10.1145/1390156.1390208;
with shared slacks as in Zhu & Ramanan 2012, doi:10.1109/CVPR.2012.6248014). The lower bound makes the primal point the
clipped sum of the examples, which keeps the dual smooth with the same constant, so that every step still climbs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types import Floats

Array = NDArray[Any]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Penalty:
    """What the weights cost, (d,) each.

    Attributes:
        scale: r, the price of a weight's squared distance from its prior, > 0.
        prior: where a weight costs nothing.
        lower: the least value of a weight, -inf for none; not above its prior.
    """

    scale: Floats
    prior: Floats
    lower: Floats

    def __post_init__(self) -> None:
        if not len(self.scale) == len(self.prior) == len(self.lower):
            raise BadInput("solver: scale, prior and lower of the weights differ in length")
        if (self.scale <= 0).any() or (self.lower > self.prior).any():
            raise BadInput("solver: expected scales > 0 and lower bounds that do not exceed their priors")


@dataclass(frozen=True)
class Report:
    """How far a solution is from the best.

    Attributes:
        primal, dual: values of the two objectives; the best lies between them.
        sweeps: times that the active examples were gone through.
        support: examples that hold the solution up.
        converged: whether the gap that was asked for is reached.
    """

    primal: float
    dual: float
    sweeps: int
    support: int
    converged: bool

    @property
    def gap(self) -> float:
        """Relative duality gap: (primal - dual) / primal."""
        return (self.primal - self.dual) / max(self.primal, 1e-300)


@dataclass(eq=False)
class Problem:
    """The examples met so far and their dual variables; examples may be added and dropped between solutions.

    The rows are kept in the frame where every weight costs the same: u = sqrt(r) (w - prior).

    Attributes:
        penalty: of the weights.
        columns: for each kind of example (each mixture), the weights that its features meet, none twice.
        dtype: of the rows; float32 halves the memory.
    """

    penalty: Penalty
    columns: Sequence[NDArray[np.int64]]
    dtype: Any = np.float32
    rows: list[Array] = field(default_factory=list)
    kinds: list[int] = field(default_factory=list)
    groups: list[int] = field(default_factory=list)
    margins: list[float] = field(default_factory=list)
    costs: dict[int, float] = field(default_factory=dict)
    alpha: Floats = field(default_factory=lambda: np.zeros(0))

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def megabytes(self) -> float:
        """Memory of the rows."""
        return sum(row.nbytes for row in self.rows) / 2**20

    def add(self, kind: int, features: Array, label: int, group: int, cost: float) -> None:
        """Ask for ``label * w . features >= 1``; the examples of a group share one slack that costs ``cost``."""
        row, margin = self._scaled(kind, features, label)
        self.rows.append(row)
        self.margins.append(margin)
        self.kinds.append(kind)
        self.groups.append(group)
        self.costs[group] = float(cost)
        self.alpha = np.append(self.alpha, 0.0)

    def replace(self, i: int, kind: int, features: Array, label: int) -> None:
        """Give an example other features; its dual variable stays."""
        self.rows[i], self.margins[i] = self._scaled(kind, features, label)
        self.kinds[i] = kind

    def _scaled(self, kind: int, features: Array, label: int) -> tuple[Array, float]:
        columns = self.columns[kind]
        signed = label * np.asarray(features, np.float64)
        margin = 1.0 - float(signed @ self.penalty.prior[columns])
        return (signed / np.sqrt(self.penalty.scale[columns])).astype(self.dtype), margin

    def keep(self, wanted: Mask) -> None:
        """Forget the examples that are not ``wanted`` (n,)."""
        for name in ("rows", "kinds", "groups", "margins"):
            setattr(self, name, [item for item, keep in zip(getattr(self, name), wanted, strict=True) if keep])
        self.alpha = self.alpha[wanted]

    def weights(self) -> Floats:
        """The primal point w of the dual variables: (d,)."""
        bounded: Floats = self._point() / np.sqrt(self.penalty.scale) + self.penalty.prior
        return np.maximum(bounded, self.penalty.lower)

    def lacks(self) -> Floats:
        """How much each example lacks to its margin under ``weights``, 1 - y w . x; negative when it has more: (n,)."""
        return self._lacks(np.maximum(self._point(), self._floor()))

    def solve(
        self, gap: float, sweeps: int = 1000, seed: int = 0, watch: Callable[[Report], None] | None = None
    ) -> Report:
        """Climb the dual until the relative duality gap is at most ``gap``.

        Args:
            gap: where to stop, relative to the primal value.
            sweeps: give up after so many.
            seed: of the order in which examples are taken.
            watch: told of every check.

        Returns:
            What was reached; the caller decides whether a solution that has not converged will do.
        """
        order, done = np.random.default_rng(seed), 0
        while True:
            point = self._point()
            primal_point = np.maximum(point, self._floor())
            lacks = self._lacks(primal_point)
            report = self._report(primal_point, point, lacks, done, gap)
            if watch:
                watch(report)
            if report.converged or done >= sweeps:
                return report
            active = np.flatnonzero((self.alpha > 0) | (lacks > 0))
            climb = _Climb(self, point)
            for _ in range(min(_SWEEPS_BETWEEN_CHECKS, sweeps - done)):
                done += 1
                if climb.sweep(order.permutation(active)) <= gap * report.primal * _SETTLED:
                    break

    def _floor(self) -> Floats:
        floor: Floats = (self.penalty.lower - self.penalty.prior) * np.sqrt(self.penalty.scale)
        return floor

    def _point(self) -> Floats:
        """The sum of the examples by their dual variables, before clipping."""
        point = np.zeros(len(self.penalty.scale))
        for i in np.flatnonzero(self.alpha):
            point[self.columns[self.kinds[i]]] += self.alpha[i] * self.rows[i].astype(np.float64)
        return point

    def _lacks(self, primal_point: Floats) -> Floats:
        u = primal_point.astype(self.dtype)
        parts = [u[columns] for columns in self.columns]
        pairs = zip(self.margins, self.rows, self.kinds, strict=True)
        return np.array([margin - float(row @ parts[kind]) for margin, row, kind in pairs])

    def _report(self, u: Floats, point: Floats, lacks: Floats, sweeps: int, gap: float) -> Report:
        slack: dict[int, float] = {}
        for group, lack in zip(self.groups, lacks, strict=True):
            slack[group] = max(slack.get(group, 0.0), float(lack))
        primal = 0.5 * float(u @ u) + sum(self.costs[group] * value for group, value in slack.items())
        dual = 0.5 * float(u @ u) - float(point @ u) + float(self.alpha @ np.array(self.margins))
        report = Report(primal, dual, sweeps, int((self.alpha > 0).sum()), False)
        return Report(primal, dual, sweeps, report.support, report.gap <= gap)


_SWEEPS_BETWEEN_CHECKS = 20
_SETTLED = 0.01
"""A sweep that climbs less than this share of the wanted gap ends the work on the active examples."""


class _Climb:
    """Coordinate ascent on the dual from a point; changes the problem's ``alpha`` in place."""

    def __init__(self, problem: Problem, point: Floats) -> None:
        self.problem = problem
        self.alpha = problem.alpha
        self.slices = [_as_slice(columns) for columns in problem.columns]
        floor = problem._floor()
        self.bounded = [np.flatnonzero(np.isfinite(floor[columns])) for columns in problem.columns]
        self.targets = [columns[inner] for columns, inner in zip(problem.columns, self.bounded, strict=True)]
        self.floor = floor.astype(problem.dtype)
        self.free = point.astype(problem.dtype)
        self.u = np.maximum(self.free, self.floor)
        self.norms = np.array([float(row @ row) for row in problem.rows])
        self.members: dict[int, list[int]] = {}
        for i, group in enumerate(problem.groups):
            self.members.setdefault(group, []).append(i)
        self.spent = {group: float(self.alpha[items].sum()) for group, items in self.members.items()}

    def sweep(self, order: NDArray[np.int64]) -> float:
        """Go through the examples once; how much the dual rose at least."""
        return sum(self._step(int(i)) for i in order)

    def _step(self, i: int) -> float:
        lack, group = self._lack(i), self.problem.groups[i]
        room = max(self.problem.costs[group] - self.spent[group], 0.0)
        norm = float(self.norms[i])
        change = lack / max(norm, 1e-12)
        if change > room and len(self.members[group]) > 1:
            return self._trade(i, lack, group, room)
        change = min(max(change, -float(self.alpha[i])), room)
        self._move(i, change)
        self.spent[group] += change
        return change * lack - 0.5 * change * change * norm

    def _trade(self, i: int, lack: float, group: int, room: float) -> float:
        """Use up the group's budget, then move some of it from the member that needs it least."""
        gain = room * lack - 0.5 * room * room * float(self.norms[i])
        self._move(i, room)
        self.spent[group] += room
        others = [j for j in self.members[group] if j != i and self.alpha[j] > 0]
        if not others:
            return gain
        lacks = [self._lack(j) for j in others]
        least = int(np.argmin(lacks))
        j, rise = others[least], self._lack(i) - lacks[least]
        change = min(max(rise / max(self._distance(i, j), 1e-12), 0.0), float(self.alpha[j]))
        self._move(i, change)
        self._move(j, -change)
        return gain + change * rise - 0.5 * change * change * self._distance(i, j)

    def _lack(self, i: int) -> float:
        columns = self.slices[self.problem.kinds[i]]
        return self.problem.margins[i] - float(self.problem.rows[i] @ self.u[columns])

    def _distance(self, i: int, j: int) -> float:
        if self.problem.kinds[i] != self.problem.kinds[j]:
            return 2 * float(self.norms[i] + self.norms[j])
        difference: Array = self.problem.rows[i] - self.problem.rows[j]
        return float(difference @ difference)

    def _move(self, i: int, change: float) -> None:
        if change == 0:
            return
        self.alpha[i] = max(self.alpha[i] + change, 0.0)
        kind, row = self.problem.kinds[i], self.problem.rows[i]
        inner, target = self.bounded[kind], self.targets[kind]
        self.u[self.slices[kind]] += row.dtype.type(change) * row
        self.free[target] += row.dtype.type(change) * row[inner]
        self.u[target] = np.maximum(self.free[target], self.floor[target])


def _as_slice(columns: NDArray[np.int64]) -> Any:
    """The same columns as a slice when they follow each other, which is much faster."""
    first, count = int(columns[0]), len(columns)
    return slice(first, first + count) if (columns == np.arange(first, first + count)).all() else columns

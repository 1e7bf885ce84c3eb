import numpy as np
import pytest
from scipy.optimize import minimize

from limner.errors import BadInput
from limner.vision.landmarks.fmp.solver import Penalty, Problem


def small_problem(seed=0, n=40, d=8, kinds=1, shared=True, dtype=np.float64):
    rng = np.random.default_rng(seed)
    scale, prior = rng.choice([0.01, 0.1, 1.0], d), np.zeros(d)
    lower = np.full(d, -np.inf)
    lower[:3] = prior[:3] = 0.01
    half = [np.arange(d)] if kinds == 1 else [np.arange(d - 2), np.array([0, 2, 3, 5, d - 2, d - 1])]
    problem = Problem(Penalty(scale, prior, lower), half, dtype)
    truth = rng.normal(size=d)
    for i in range(n):
        kind = i % kinds
        x = rng.normal(size=d)
        x[0] = -abs(x[0])
        label = 1 if x @ truth + rng.normal() > 0 else -1
        group = i if label > 0 or not shared else 1000 + i // 6
        problem.add(kind, x[: len(half[kind])], label, group, 0.2 if label > 0 else 0.1)
    return problem


def plain_objective(problem, w):
    penalty, slack = problem.penalty, {}
    for row, margin, kind, group in zip(problem.rows, problem.margins, problem.kinds, problem.groups, strict=True):
        columns = problem.columns[kind]
        u = (w - penalty.prior)[columns] * np.sqrt(penalty.scale[columns])
        slack[group] = max(slack.get(group, 0.0), margin - row @ u)
    value = 0.5 * (penalty.scale * (w - penalty.prior) ** 2).sum()
    return value + sum(problem.costs[group] * xi for group, xi in slack.items())


def plain_solution(problem):
    """The same problem with explicit slacks, by a general solver."""
    penalty, d = problem.penalty, len(problem.penalty.scale)
    groups = sorted(set(problem.groups))
    cost = np.array([problem.costs[g] for g in groups])

    def value(z):
        return 0.5 * (penalty.scale * (z[:d] - penalty.prior) ** 2).sum() + cost @ z[d:]

    def slope(z):
        return np.concatenate([penalty.scale * (z[:d] - penalty.prior), cost])

    matrix = np.zeros((len(problem), d + len(groups)))
    for i in range(len(problem)):
        columns = problem.columns[problem.kinds[i]]
        matrix[i, columns] = problem.rows[i] * np.sqrt(penalty.scale[columns])
        matrix[i, d + groups.index(problem.groups[i])] = 1
    margins = np.array(problem.margins) + matrix[:, :d] @ penalty.prior
    limits = [(low if np.isfinite(low) else None, None) for low in penalty.lower] + [(0, None)] * len(groups)
    start = np.concatenate([penalty.prior, np.full(len(groups), 10.0)])
    result = minimize(
        value,
        start,
        jac=slope,
        bounds=limits,
        method="SLSQP",
        constraints={"type": "ineq", "fun": lambda z: matrix @ z - margins, "jac": lambda z: matrix},
        options={"maxiter": 2000, "ftol": 1e-13},
    )
    assert result.success
    return result.x[:d], result.fun


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("kinds", "shared"), [(1, False), (1, True), (2, True)])
def test_agrees_with_a_general_solver(seed, kinds, shared):
    problem = small_problem(seed, kinds=kinds, shared=shared)
    report = problem.solve(1e-7, sweeps=100_000)
    weights, best = plain_solution(problem)
    assert report.converged
    assert report.primal == pytest.approx(best, rel=1e-5)
    assert problem.weights() == pytest.approx(weights, abs=2e-3)


@pytest.mark.parametrize("seed", range(4))
def test_the_reported_gap_encloses_the_best(seed):
    problem = small_problem(seed)
    _, best = plain_solution(problem)
    reports = []
    problem.solve(1e-6, sweeps=400, watch=reports.append)
    for report in reports:
        assert report.dual <= best * (1 + 1e-6)
        assert report.primal >= best * (1 - 1e-6)
    assert reports[-1].primal == pytest.approx(plain_objective(problem, problem.weights()), rel=1e-9)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kinds", [1, 2])
def test_the_dual_never_falls_and_the_constraints_hold(seed, kinds):
    problem = small_problem(seed, n=80, kinds=kinds)
    duals = []
    problem.solve(1e-8, sweeps=300, watch=lambda report: duals.append(report.dual))
    assert (np.diff(duals) >= -1e-12).all()
    assert (problem.alpha >= 0).all()
    for group in set(problem.groups):
        spent = problem.alpha[np.array(problem.groups) == group].sum()
        assert spent <= problem.costs[group] * (1 + 1e-9)
    assert (problem.weights() >= problem.penalty.lower).all()


def test_single_precision_reaches_a_practical_gap():
    problem = small_problem(5, n=200, dtype=np.float32)
    assert problem.solve(1e-3, sweeps=2000).converged


def test_dropping_idle_examples_changes_nothing():
    problem = small_problem(2, n=120)
    problem.solve(1e-8, sweeps=50_000)
    before = problem.weights()
    lacks = problem.lacks()
    problem.keep((problem.alpha > 0) | (lacks > -0.5))
    assert len(problem) < 120
    problem.solve(1e-8, sweeps=50_000)
    assert problem.weights() == pytest.approx(before, abs=1e-5)


def test_same_seed_same_weights():
    first, second = small_problem(1), small_problem(1)
    first.solve(1e-3, seed=7)
    second.solve(1e-3, seed=7)
    assert (first.weights() == second.weights()).all()


def test_no_examples_give_the_prior():
    problem = Problem(Penalty(np.ones(3), np.array([0.5, 0, 0]), np.array([0.1, -np.inf, -np.inf])), [np.arange(3)])
    assert problem.solve(0.01).converged
    assert problem.weights() == pytest.approx([0.5, 0, 0])


def test_refuses_impossible_penalties():
    with pytest.raises(BadInput, match="lower bounds"):
        Penalty(np.ones(2), np.zeros(2), np.ones(2))
    with pytest.raises(BadInput, match="length"):
        Penalty(np.ones(2), np.zeros(3), np.zeros(3))

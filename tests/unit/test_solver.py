"""The batched bounded solver finds what scipy's finds, with parameters at bounds too."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from drillid.solver import solve_bounded

ABSCISSA = np.linspace(0, 3, 40)


def model(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two decaying exponentials and an offset, with derivatives; points (problem, 5)."""
    a, b, c, d, e = (points[:, [index]] for index in range(5))
    first, second = np.exp(-b * ABSCISSA), np.exp(-d * ABSCISSA)
    value = a * first + c * second + e
    rows = [first, -a * ABSCISSA * first, second, -c * ABSCISSA * second, np.ones_like(value)]
    return value, np.stack(rows, axis=1)


def problems(count: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(2)
    truth = rng.uniform([0.5, 0.2, 0.5, 2.0, -0.2], [2.0, 1.0, 2.0, 6.0, 0.2], size=(count, 5))
    return truth, model(truth)[0] + 0.02 * rng.normal(size=(count, ABSCISSA.size))


@pytest.mark.parametrize("lowest_offset", [-1.0, 0.0, 0.1])
def test_never_worse_than_scipy(lowest_offset: float) -> None:
    _, data = problems(30)
    low, high = np.array([0, 0, 0, 1.5, lowest_offset]), np.array([5, 1.2, 5, 20, 1.0])
    start = np.tile([1.0, 0.5, 1.0, 4.0, 0.5], (30, 1))

    def curvature(points: np.ndarray, which: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        value, rows = model(points)
        error = value - data[which]
        return 0.5 * np.sum(error**2, axis=1), np.matvec(rows, error), rows @ np.swapaxes(rows, 1, 2)

    points, costs = solve_bounded(curvature, start, low, high)
    assert np.all((points >= low) & (points <= high))
    for row in range(30):
        reference = least_squares(
            lambda p, row=row: model(p[None])[0][0] - data[row], start[row], bounds=(low, high), xtol=1e-12, ftol=1e-12
        )
        assert costs[row] <= reference.cost * (1 + 1e-6)


def test_a_problem_that_starts_at_its_optimum_stays() -> None:
    truth, _ = problems(3)
    exact = model(truth)[0]

    def curvature(points: np.ndarray, which: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        value, rows = model(points)
        error = value - exact[which]
        return 0.5 * np.sum(error**2, axis=1), np.matvec(rows, error), rows @ np.swapaxes(rows, 1, 2)

    points, costs = solve_bounded(curvature, truth, np.full(5, -10.0), np.full(5, 10.0))
    np.testing.assert_allclose(points, truth)
    np.testing.assert_allclose(costs, 0, atol=1e-20)

"""The compiled solver within bounds and the profile's intervals, on noisy mobilities."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.optimize import least_squares

from drillid.fits.intervals import intervals, quantile
from drillid.fits.likelihood import curvature
from drillid.fits.search import from_scaled, to_scaled
from drillid.fits.solver import bounded_step, minimise, solve_free
from drillid.fits.window_fit import Measured, Prior, likelihood
from drillid.physics.eight_parameters import command_mobility_with_derivatives, drilling_system
from drillid.physics.parameters import BOUNDS, DELTA, KAPPA, LENGTH, SCALES
from drillid.physics.responses import command_mobility, laplace
from tests.simulated import SHALLOW
from tests.workflow.toys import ROOT

FREQUENCY = np.arange(10, 400) / 100.0
LOW, HIGH = to_scaled(BOUNDS)


def noisy(seed: int, freedom: float = 1e9) -> Measured:
    """Mobility of the shallow rig with errors of 5 %; the solver, not the model, is on trial here."""
    generator = np.random.default_rng(seed)
    exact = command_mobility(drilling_system(SHALLOW.parameters, SHALLOW.known), laplace(FREQUENCY))
    deviation = 0.05 * np.abs(exact)
    parts = generator.standard_normal((2, FREQUENCY.size))
    mobility = exact + deviation * (parts[0] + 1j * parts[1]) / np.sqrt(2)
    return Measured(FREQUENCY, mobility, deviation**2, np.full(FREQUENCY.size, freedom), np.ones(FREQUENCY.size))


def optimum(measured: Measured, start: np.ndarray, low: np.ndarray = LOW) -> tuple[np.ndarray, float, np.ndarray]:
    """Where the solver ends, its cost and the gradient there."""
    point, gradient, hessian = start.copy(), np.empty(8), np.empty((8, 8))
    data = likelihood(measured, SHALLOW.known, Prior.silent())
    cost = minimise(point, data, True, low, HIGH, np.zeros(8, bool), 200, 1e-9, gradient, hessian)
    return point, cost, gradient


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("least_kappa", [0.0, 400.0], ids=["free", "against a bound"])
def test_never_worse_than_scipy(seed: int, least_kappa: float) -> None:
    measured = noisy(seed)
    low = LOW.copy()
    low[KAPPA] = least_kappa / SCALES[KAPPA]
    start = np.maximum(to_scaled(1.05 * SHALLOW.parameters), low + 1e-3)

    def residuals(scaled: np.ndarray) -> np.ndarray:
        fitted, _ = command_mobility_with_derivatives(from_scaled(scaled), SHALLOW.known, laplace(FREQUENCY))
        error = (fitted - measured.mobility) * measured.weight
        return np.concatenate([error.real, error.imag, [scaled[DELTA] / np.log(3)]])

    reference = least_squares(residuals, start, bounds=(low, HIGH), x_scale="jac", xtol=1e-12, ftol=1e-12)
    point, cost, _ = optimum(measured, start, low)
    assert np.all((point >= low) & (point <= HIGH))
    assert cost <= reference.cost + 1e-4


def test_gradient_is_that_of_the_cost() -> None:
    data = likelihood(noisy(0, freedom=9.0), SHALLOW.known, Prior.silent())
    point, gradient, hessian = to_scaled(1.1 * SHALLOW.parameters), np.empty(8), np.empty((8, 8))
    for robust in (True, False):
        curvature(point, data, robust, gradient, hessian)
        for i in range(8):
            costs = []
            for sign in (1, -1):
                moved = point.copy()
                moved[i] += sign * 1e-5
                costs.append(curvature(moved, data, robust, np.empty(8), np.empty((8, 8))))
            assert gradient[i] == pytest.approx((costs[0] - costs[1]) / 2e-5, rel=1e-4, abs=1e-4)


def test_systems_are_solved_for_the_free_unknowns() -> None:
    generator = np.random.default_rng(1)
    root = generator.standard_normal((8, 8))
    matrix, right = root @ root.T, generator.standard_normal(8)
    free = np.array([1, 1, 0, 1, 0, 1, 1, 1], dtype=bool)
    solution = generator.standard_normal(8)
    given = solution[~free].copy()
    assert solve_free(matrix, right, free, solution)
    np.testing.assert_allclose(solution[~free], given)
    np.testing.assert_allclose((matrix @ solution)[free], right[free])
    assert not solve_free(-matrix, right, free, solution)


def test_a_step_that_leaves_the_bounds_ends_on_them() -> None:
    matrix, gradient = np.diag(np.arange(1.0, 9.0)), -np.ones(8)
    step = np.zeros(8)
    assert bounded_step(np.zeros(8), gradient, matrix, np.full(8, -0.2), np.full(8, 0.2), np.zeros(8, bool), step)
    np.testing.assert_allclose(step, np.minimum(1 / np.arange(1.0, 9.0), 0.2))


def test_interval_ends_lie_where_the_profile_says() -> None:
    measured = noisy(5)
    point, cost, _ = optimum(measured, to_scaled(SHALLOW.parameters))
    data = likelihood(measured, SHALLOW.known, Prior.silent())
    ends = np.empty((2, 8))
    intervals(point[None], np.array([cost]), data, data, DELTA, LOW, HIGH, ends)
    assert np.all(ends[0] <= point)
    assert np.all(ends[1] >= point)
    for i in range(8):
        for end in ends[:, i]:
            low, high = LOW.copy(), HIGH.copy()
            low[i], high[i] = end - 1e-12, end + 1e-12
            held = point.copy()
            held[i] = end
            args = (np.zeros(8, bool), 200, 1e-9, np.empty(8), np.empty((8, 8)))
            rise = np.sqrt(2 * max(minimise(held, data, True, low, high, *args) - cost, 0.0))
            at_bound = end in (LOW[i], HIGH[i])
            assert rise < 2.01
            assert at_bound or rise > (1.6 if LOW[i] == 0 else 1.91)


@pytest.mark.parametrize("distance", [0.0, 0.3, 1.0, 1.6, 3.0])
def test_intervals_of_what_cannot_be_negative_cover_as_stated(distance: float) -> None:
    drawn = distance + np.random.default_rng(4).standard_normal(100_000)
    held = np.sqrt(np.maximum(distance**2 - 2 * distance * drawn, 0.0))
    rise = np.where(drawn > 0, np.abs(drawn - distance), held)
    assert np.mean(rise > quantile(distance)) == pytest.approx(0.05, abs=0.003)


def test_the_interval_holds_what_is_about_each_optimum() -> None:
    measured = noisy(5)
    point, cost, _ = optimum(measured, to_scaled(SHALLOW.parameters))
    data = likelihood(measured, SHALLOW.known, Prior.silent())
    alone, both = np.empty((2, 8)), np.empty((2, 8))
    intervals(point[None], np.array([cost]), data, data, DELTA, LOW, HIGH, alone)
    # another optimum that costs as much, half an interval away, and one that costs too much
    away = point.copy()
    away[LENGTH] = alone[1, LENGTH]
    costs = np.array([cost, cost + 1.0, cost + 3.0])
    intervals(np.stack([point, away, away * 2]), costs, data, data, DELTA, LOW, HIGH, both)
    assert np.all(both[0] <= alone[0] + 1e-9)
    assert np.all(both[1] >= alone[1] - 1e-9)
    assert both[1, LENGTH] < 1.5 * alone[1, LENGTH]


ORDER = """
import numpy as np
from tests.unit.fits.test_solver import SHALLOW, Prior, curvature, likelihood, noisy, optimum, to_scaled

measured, start = noisy(0, 9.0), to_scaled(1.1 * SHALLOW.parameters)
if {solver_first}:
    optimum(measured, start)
gradient, hessian = np.empty(8), np.empty((8, 8))
cost = curvature(start, likelihood(measured, SHALLOW.known, Prior.silent()), True, gradient, hessian)
print(cost.hex(), gradient.tobytes().hex(), hessian.tobytes().hex())
"""


def test_no_bit_depends_on_what_a_process_compiled_or_loaded_before() -> None:
    """The solver holds a copy of the likelihood, optimised together with it, which must not stand in for it."""
    found = [
        subprocess.run(
            [sys.executable, "-c", ORDER.format(solver_first=first)],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for first in (False, True)
    ]
    assert found[0] == found[1]

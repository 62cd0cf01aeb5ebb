"""One measured mobility → the eight parameters of the transmission line, their errors and correlations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drillid.physics.model import (
    DELTA,
    INERTIA_TD,
    LENGTH,
    POLAR_MOMENT,
    KnownEquipment,
    command_mobility_with_derivatives,
)
from drillid.physics.responses import laplace
from drillid.schema import PARAMETERS
from drillid.solver import solve_bounded
from drillid.starts import BOUNDS, SCALES, starting_points
from drillid.statistics import expected_ratio, mixture_half_width, sum_of_ratios_probability

if TYPE_CHECKING:
    from drillid.config import FitsSettings

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_NEAR_BOUND = 0.01
"""Standard errors from a physical bound below which a value counts as at the bound."""
_USUAL_FACTOR = 3.0
"""Factor within which internal damping lies about its usual size, at one standard deviation."""
_DAMPING_GRID = np.linspace(-4.5, 3.0, 16)
"""Logarithms of internal damping, per usual size, over which the errors are integrated."""
_PROFILE_ITERATIONS = 20
_LEAST_FREQUENCIES = 20
"""Frequencies below which eight parameters are not worth a fit."""


@dataclass(frozen=True)
class Measured:
    """One measured mobility at the frequencies that passed the gate; arrays of shape (frequency,)."""

    frequency: Floats
    mobility: Complex
    variance: Floats
    degrees_of_freedom: Floats
    sharing: Floats

    @property
    def weight(self) -> Floats:
        """One over the deviation of real and imaginary part, the variance's own uncertainty included."""
        return np.sqrt(2 / (self.variance * expected_ratio(self.degrees_of_freedom)))


@dataclass(frozen=True)
class Prior:
    """What the rig's papers say: value and standard uncertainty, shape (8,); NaN where they are silent."""

    value: Floats
    error: Floats

    @staticmethod
    def silent() -> Prior:
        """No knowledge."""
        return Prior(np.full(len(PARAMETERS), np.nan), np.full(len(PARAMETERS), np.nan))


@dataclass(frozen=True)
class Fit:
    """Result of a fit; a failure is a fit that is not accepted, with its reason."""

    value: Floats
    error: Floats
    correlation: Floats
    at_bound: NDArray[np.bool_]
    chi2_per_dof: float
    residual_dof: float
    probability: float
    accepted: bool
    reason: str

    @staticmethod
    def refused(reason: str) -> Fit:
        """No fit at all."""
        size = len(PARAMETERS)
        nothing = np.full(size, np.nan)
        return Fit(
            nothing, nothing, np.full((size, size), np.nan), np.zeros(size, bool), np.nan, 0.0, np.nan, False, reason
        )


def fit(measured: Measured, known: KnownEquipment, prior: Prior, settings: FitsSettings) -> Fit:
    """Weighted least squares from several starting points that need no advance information.

    Residuals are the complex errors over their deviations, and the prior's pulls. Derivatives
    are exact.
    """
    if measured.frequency.size < _LEAST_FREQUENCIES:
        return Fit.refused(
            f"only {measured.frequency.size} frequencies passed the gate, of {_LEAST_FREQUENCIES} needed"
        )
    problem = _LeastSquares(measured, known, prior)
    starts = starting_points(
        measured.frequency, measured.mobility, measured.variance, known, prior.value, settings.starts
    )
    low, high = to_scaled(BOUNDS)
    points, costs = solve_bounded(problem.curvature, to_scaled(np.stack(starts)), low, high)
    return _judge(problem, points[int(np.argmin(costs))], settings)


def to_scaled(values: Floats) -> Floats:
    """Parameters (..., 8) in SI as the solver sees them: of order one, internal damping as its logarithm."""
    scaled: Floats = values / SCALES
    scaled[..., DELTA] = np.log(scaled[..., DELTA])
    return scaled


def from_scaled(scaled: Floats) -> tuple[Floats, Floats]:
    """Parameters (..., 8) in SI and their derivatives to the solver's, shape (..., 8)."""
    values, slopes = scaled * SCALES, np.broadcast_to(SCALES, scaled.shape).copy()
    values[..., DELTA] = slopes[..., DELTA] = SCALES[DELTA] * np.exp(scaled[..., DELTA])
    return values, slopes


class _LeastSquares:
    """Half the sum of squared residuals and its exact derivatives in scaled parameters.

    Besides the rig's papers, internal damping has a prior of its own: its logarithm is that of
    the usual size within a factor of three, which spans the paper's table 1. Without it, noise
    is fitted by resonances too sharp for any string.
    """

    def __init__(self, measured: Measured, known: KnownEquipment, prior: Prior) -> None:
        self.measured, self.known = measured, known
        self.s = laplace(measured.frequency)
        self.informed = np.isfinite(prior.value)
        self.prior_value = np.where(self.informed, prior.value, 0.0) / SCALES
        self.prior_weight = np.where(self.informed, SCALES / prior.error, 0.0)
        self.prior_value[DELTA], self.prior_weight[DELTA] = 0.0, 1 / np.log(_USUAL_FACTOR)

    def curvature(self, scaled: Floats, _: NDArray[np.intp]) -> tuple[Floats, Floats, Floats]:
        """Cost (point,), gradient (point, 8) and Gauss–Newton Hessian (point, 8, 8)."""
        values, slopes = from_scaled(scaled)
        mobility, derivatives = command_mobility_with_derivatives(values, self.known, self.s)
        error = (mobility - self.measured.mobility) * self.measured.weight
        rows = derivatives * slopes[..., None] * self.measured.weight
        stacked = np.concatenate([rows.real, rows.imag], axis=-1)
        pulls = (scaled - self.prior_value) * self.prior_weight
        gradient = np.matvec(stacked, np.concatenate([error.real, error.imag], axis=-1)) + pulls * self.prior_weight
        hessian = stacked @ np.swapaxes(stacked, -1, -2) + np.diag(self.prior_weight**2)
        cost = 0.5 * (np.sum(np.abs(error) ** 2, axis=-1) + np.sum(pulls**2, axis=-1))
        return cost, gradient, hessian

    def chi2(self, scaled: Floats) -> float:
        """Sum of squared residuals without the prior's pulls."""
        mobility, _ = command_mobility_with_derivatives(from_scaled(scaled)[0], self.known, self.s)
        return float(np.sum(np.abs((mobility - self.measured.mobility) * self.measured.weight) ** 2))

    def posterior(self, scaled: Floats) -> tuple[Floats, Floats]:
        """Standard errors (8,) and correlations (8, 8) about the optimum, in SI units.

        How sharp the resonances are decides how well their place is known, so the curvature at one
        value of internal damping misleads. The posterior is therefore a mixture over a grid of it:
        at each value the others are fitted again, and weighted as Laplace's approximation says
        (Rue, Martino and Chopin 2009). A standard error is the half-width of the mixture's central
        95 % over 1.96.
        """
        others = np.delete(np.arange(scaled.size), DELTA)
        starts = np.tile(scaled, (_DAMPING_GRID.size, 1))
        starts[:, DELTA] = _DAMPING_GRID
        low, high = to_scaled(BOUNDS)
        points, costs = solve_bounded(self._at_fixed_damping, starts, low, high, _PROFILE_ITERATIONS)
        hessians = self.curvature(points, np.arange(costs.size))[2] + np.diag(12 / (high - low) ** 2)
        blocks = hessians[:, others[:, None], others]
        _, log_determinant = np.linalg.slogdet(blocks)
        log_weights = -costs - 0.5 * log_determinant
        weights = np.exp(log_weights - log_weights.max())
        weights /= weights.sum()
        values, slopes = from_scaled(points)
        covariances = np.zeros_like(hessians)
        covariances[:, others[:, None], others] = (
            np.linalg.inv(blocks) * slopes[:, others, None] * slopes[:, None, others]
        )
        centre = weights @ values
        about = values - centre
        total = np.einsum("k,kij->ij", weights, covariances + about[:, :, None] * about[:, None, :])
        deviations = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))
        deviations[:, DELTA] = values[:, DELTA] * (_DAMPING_GRID[1] - _DAMPING_GRID[0]) / 2
        moment = np.sqrt(np.diag(total))
        return mixture_half_width(weights, values, deviations), total / np.outer(moment, moment)

    def _at_fixed_damping(self, points: Floats, which: NDArray[np.intp]) -> tuple[Floats, Floats, Floats]:
        cost, gradient, hessian = self.curvature(points, which)
        gradient[:, DELTA] = hessian[:, DELTA] = hessian[:, :, DELTA] = 0.0
        hessian[:, DELTA, DELTA] = 1.0
        return cost, gradient, hessian


def _judge(problem: _LeastSquares, scaled: Floats, settings: FitsSettings) -> Fit:
    measured, value = problem.measured, from_scaled(scaled)[0]
    error, correlation = problem.posterior(scaled)
    at_bound = np.minimum(value - BOUNDS[0], BOUNDS[1] - value) < _NEAR_BOUND * error
    total = problem.chi2(scaled)
    lost = (value.size - np.count_nonzero(at_bound | problem.informed)) / 2
    dof = 2 * (measured.frequency.size - lost)
    ratio = expected_ratio(measured.degrees_of_freedom)
    chance = sum_of_ratios_probability(
        float(np.mean(ratio)) * total / 2, measured.degrees_of_freedom, measured.sharing, fitted=lost
    )
    reason = _why_refused(value, error, chance, settings)
    return Fit(value, error, correlation, at_bound, total / dof, dof, chance, not reason, reason)


def _why_refused(value: Floats, error: Floats, chance: float, settings: FitsSettings) -> str:
    if not np.all(np.isfinite(error)):
        return "the data do not determine the parameters"
    for index in (LENGTH, POLAR_MOMENT, INERTIA_TD):
        name, unit = list(PARAMETERS)[index], list(PARAMETERS.values())[index][0]
        if min(value[index] - BOUNDS[0, index], BOUNDS[1, index] - value[index]) < error[index]:
            return f"{name} ended at the edge of what is searched, {value[index]:.4g} {unit}"
    if chance < settings.error_rate:
        return f"the residuals are larger than the noise allows (chance {chance:.1g})"
    return ""

"""One measured mobility → the eight parameters of the transmission line, their errors and correlations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from drillid.arrays import Array, Booleans, Complex, Floats
from drillid.datasets.codes import Gate, Identifiability
from drillid.fits.intervals import QUANTILE, intervals
from drillid.fits.likelihood import Data, curvature
from drillid.fits.sandwich import error_factors
from drillid.fits.search import from_scaled, starting_points, thin, to_scaled
from drillid.fits.solver import follow
from drillid.physics.eight_parameters import KnownEquipment, command_mobility_with_derivatives, compiled_line
from drillid.physics.parameters import BOUNDS, DELTA, INERTIA_TD, LENGTH, PARAMETERS, POLAR_MOMENT, SCALES, USUAL
from drillid.physics.responses import laplace
from drillid.physics.top_drive import gain_responses, with_gains
from drillid.statistics import expected_ratio, sharing, sum_of_ratios_probability

if TYPE_CHECKING:
    from drillid.config.settings import FitsSettings


_NEAR_BOUND = 0.01
"""Number of standard errors from a physical bound within which a value counts as at the bound."""
_USUAL_FACTOR = 3.0
"""Factor within which internal damping lies about its usual size, at one standard deviation."""
_FARTHEST_FACTOR = 30.0
"""Factor about its usual size within which the interval of internal damping is searched for."""
_LEAST_FREQUENCIES = 20
"""Number of frequencies below which a fit of eight parameters is not worthwhile."""
_KEPT = 8
"""Number of optima that are followed on all of the data."""
_MISMATCH_RATE = 0.05
"""Probability of the residuals below which they count as larger than the noise."""
_MOST_FREEDOM = 1e9
_LOW, _HIGH = to_scaled(BOUNDS)
_GAIN_REACH = 10.0
"""Number of standard uncertainties within which the gains of the control are searched for."""
_LEAST_GAIN = 0.1
"""Share of a gain's known value below which it is not searched for."""


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

    @property
    def noiseless(self) -> int:
        """Number of frequencies without any noise, which no fit can weigh."""
        return int(np.count_nonzero(self.variance <= 0))

    @property
    def informs(self) -> bool:
        """Whether there are frequencies, all of them with noise."""
        return self.frequency.size > 0 and not self.noiseless


@dataclass(frozen=True)
class Prior:
    """What the rig's data sheets state: value and standard uncertainty, shape (8,); NaN where they are silent."""

    value: Floats
    error: Floats
    gains: Floats = field(default_factory=lambda: np.zeros(2))
    """Relative standard uncertainty of the control's P and I, (2,); zeros where they are exact."""

    @staticmethod
    def silent() -> Prior:
        """The prior without any knowledge."""
        return Prior(np.full(len(PARAMETERS), np.nan), np.full(len(PARAMETERS), np.nan))


@dataclass(frozen=True)
class Fit:
    """Result of a fit; a failure is a fit that is not accepted, with its reason. Arrays of shape (8,), SI."""

    value: Floats
    error: Floats
    """Standard error: half the 95 % interval's width over 1.96; if one end is at a bound, the other half over 1.96."""
    lower: Floats
    upper: Floats
    """Ends of the 95 % interval; a physical bound where the data set none."""
    status: NDArray[np.int8]
    """How far the data determine each parameter, as `drillid.datasets.codes.Identifiability`."""
    correlation: Floats
    """Shape (8, 8)."""
    at_bound: Booleans
    gains: Floats
    """P and I of the control at the optimum, relative to the known ones, (2,)."""
    chi2_per_dof: float
    residual_dof: float
    probability: float
    mismatch: float
    """Factor by which residuals exceed the noise; 1 where they may be noise. The errors include the part of the excess
    that is alike over neighbouring frequencies."""
    accepted: bool
    reason: str

    @staticmethod
    def refused(reason: str) -> Fit:
        """The result where no fit was made."""
        size = len(PARAMETERS)
        nothing, status = np.full(size, np.nan), np.full(size, Identifiability.UNDETERMINED, dtype=np.int8)
        return Fit(
            nothing,
            nothing,
            nothing,
            nothing,
            status,
            np.full((size, size), np.nan),
            np.zeros(size, bool),
            np.ones(2),
            np.nan,
            0.0,
            np.nan,
            np.nan,
            False,
            reason,
        )


def fit(measured: Measured, known: KnownEquipment, prior: Prior, settings: FitsSettings) -> Fit:
    """Most likely parameters from many starting points that need no prior knowledge.

    Errors over their estimated deviations follow Student's t with the variance's own degrees of
    freedom; the rig's data sheets pull as Gaussian priors. Derivatives are exact.
    """
    if measured.frequency.size < _LEAST_FREQUENCIES:
        return Fit.refused(
            f"only {measured.frequency.size} frequencies passed the gate, of {_LEAST_FREQUENCIES} needed"
        )
    if measured.noiseless:
        return Fit.refused(
            f"{measured.noiseless} frequencies have no noise at all, as where the recorded speed stands still"
        )
    data = likelihood(measured, known, prior)
    points, costs = optima(data, measured, known, prior, settings.starts)
    return _judge(data, measured, known, prior, points, costs, settings)


def likelihood(measured: Measured, known: KnownEquipment, prior: Prior) -> Data:
    """Data and priors as the compiled likelihood reads them.

    Besides the rig's data sheets, internal damping has a prior of its own: its logarithm is that of
    the usual size within a factor of three, which spans the paper's table 1. Without it, noise
    is fitted by resonances too sharp for any string.
    """
    informed = np.isfinite(prior.value)
    value = np.where(informed, prior.value, 0.0) / SCALES
    weight = np.where(informed, SCALES / prior.error, 0.0)
    value[DELTA], weight[DELTA] = 0.0, 1 / np.log(_USUAL_FACTOR)
    s = laplace(measured.frequency)
    gains = _gain_columns(known, prior, s)
    value, weight = np.append(value, np.zeros(len(gains))), np.append(weight, np.ones(len(gains)))
    freedom = np.minimum(measured.degrees_of_freedom, _MOST_FREEDOM)
    mobility, variance, freedom = _contiguous(measured.mobility, measured.variance, freedom)
    return Data(compiled_line(known, s), mobility, variance, freedom, value, weight, SCALES, gains)


def _gain_columns(known: KnownEquipment, prior: Prior, s: Complex) -> Complex:
    """Change of the control's response by one standard uncertainty of P and of I, (2, frequency); (0, frequency) where
    both are exact.
    """
    if not prior.gains.any():
        return np.empty((0, s.size), dtype=complex)
    return np.ascontiguousarray(gain_responses(known.controller, s) * prior.gains[:, None])


def _bounds(prior: Prior, free: int) -> tuple[Floats, Floats]:
    """Bounds of the scaled parameters and of the free gains (`free` of them)."""
    reach = np.minimum(_GAIN_REACH, (1 - _LEAST_GAIN) / np.maximum(prior.gains, 1e-9))[:free]
    return np.append(_LOW, -reach), np.append(_HIGH, reach)


def optima(data: Data, measured: Measured, known: KnownEquipment, prior: Prior, starts: int) -> tuple[Floats, Floats]:
    """Distinct optima, best first: scaled parameters and free gains (optimum, n), and costs (optimum,)."""
    frequency, mobility, variance, freedom = thin(
        *_contiguous(measured.frequency, measured.mobility, measured.variance, measured.degrees_of_freedom)
    )
    s = laplace(frequency)
    gains = _gain_columns(known, prior, s)
    begun = to_scaled(starting_points(frequency, mobility, variance, known, prior.value, starts))
    begun = np.concatenate([begun, np.zeros((len(begun), len(gains)))], axis=1)
    rough = data._replace(
        line=compiled_line(known, s), mobility=mobility, variance=variance, freedom=freedom, gains=gains
    )
    points, costs = np.empty((_KEPT, begun.shape[1])), np.empty(_KEPT)
    count = follow(begun, rough, data, *_bounds(prior, len(gains)), points, costs)
    order = np.argsort(costs[:count])
    return points[order], costs[order]


def _contiguous(*arrays: Array) -> Iterator[Array]:
    return (np.ascontiguousarray(values) for values in arrays)


def _interval(data: Data, prior: Prior, points: Floats, costs: Floats) -> tuple[Floats, Floats]:
    """Ends of the 95 % intervals, scaled: by profile likelihood about all optima that the data do not separate.

    The interval of internal damping is the wider of those with and without its prior: that of the data alone, but
    no narrower than with the prior, as noise can be fitted by resonances too sharp for any string.
    """
    low, high = _bounds(prior, len(data.gains))
    low[DELTA], high[DELTA] = _farthest(points)
    weight = data.prior_weight.copy()
    weight[DELTA] = 0.0
    ends = np.empty((2, len(PARAMETERS)))
    intervals(points, costs, data, data._replace(prior_weight=weight), DELTA, low, high, ends)
    return ends[0], ends[1]


def _farthest(points: Floats) -> tuple[float, float]:
    """Range of the interval of internal damping, scaled: the usual one, or as far as optima (K, n) lie."""
    usual, found = np.log(_FARTHEST_FACTOR), points[:, DELTA]
    return min(-usual, float(found.min())), max(usual, float(found.max()))


def _status(lower: Floats, upper: Floats, points: Floats) -> NDArray[np.int8]:
    """Status of intervals in SI: one that spans all values met in practice carries no information."""
    edge = to_scaled(BOUNDS)
    edge[:, DELTA] = _farthest(points)
    reach = 1e-6 * (edge[1] - edge[0])
    no_lower, no_upper = to_scaled(lower) <= edge[0] + reach, to_scaled(upper) >= edge[1] - reach
    nothing = (lower <= USUAL[0]) & (upper >= USUAL[1]) | (no_lower & no_upper)
    status = np.where(
        no_lower,
        Identifiability.BOUNDED_ABOVE,
        np.where(no_upper, Identifiability.BOUNDED_BELOW, Identifiability.KNOWN),
    )
    return np.asarray(np.where(nothing, Identifiability.UNDETERMINED, status), dtype=np.int8)


def _errors(value: Floats, lower: Floats, upper: Floats, status: NDArray[np.int8]) -> Floats:
    half = (upper - lower) / 2
    half = np.where(status == Identifiability.BOUNDED_ABOVE, upper - value, half)
    half = np.where(status == Identifiability.BOUNDED_BELOW, value - lower, half)
    return np.asarray(half / QUANTILE, dtype=float)


def _covariance(data: Data, prior: Prior, scaled: Floats) -> Floats:
    """Inverse of the curvature at the optimum in SI, with the search range's variance as the widest prior."""
    gradient, hessian = np.empty(scaled.size), np.empty((scaled.size, scaled.size))
    curvature(scaled, data, True, gradient, hessian)
    slopes = SCALES.copy()
    slopes[DELTA] *= np.exp(scaled[DELTA])
    low, high = _bounds(prior, len(data.gains))
    inverse = np.linalg.inv(hessian + np.diag(12 / (high - low) ** 2))[: SCALES.size, : SCALES.size]
    return np.asarray(inverse * np.outer(slopes, slopes), dtype=float)


def _error_factors(
    measured: Measured, mobility: Complex, derivatives: Complex, known: KnownEquipment, prior: Prior, value: Floats
) -> Floats:
    """Factors (8,) on standard errors for model error, as seen in residuals alike over neighbouring frequencies.

    Parameters
    ----------
    mobility, derivatives : at the optimum `value`, (frequency,) and (8, frequency)
    known : with the fitted gains
    """
    gains = _gain_columns(known, prior, laplace(measured.frequency))
    precision = np.where(np.isfinite(prior.error), prior.error**-2.0, 0.0)
    precision[DELTA] = (np.log(_USUAL_FACTOR) * value[DELTA]) ** -2.0
    return error_factors(
        mobility - measured.mobility,
        np.concatenate([derivatives, -(mobility**2) * gains]),
        measured.variance,
        np.minimum(measured.degrees_of_freedom, _MOST_FREEDOM),
        np.append(precision, np.ones(len(gains))),
    )[: value.size]


def _widened(ends: tuple[Floats, Floats], points: Floats, factors: Floats) -> Iterator[Floats]:
    """Ends of the scaled intervals in SI, farther from the first optimum by factors (8,), within the bounds."""
    low, high = to_scaled(BOUNDS)
    low[DELTA], high[DELTA] = _farthest(points)
    best = np.clip(points[0, : factors.size], low, high)
    return (from_scaled(np.clip(best + factors * (end - best), low, high)) for end in ends)


def _judge(
    data: Data,
    measured: Measured,
    known: KnownEquipment,
    prior: Prior,
    points: Floats,
    costs: Floats,
    settings: FitsSettings,
) -> Fit:
    value = from_scaled(points[0, : len(PARAMETERS)])
    gains = 1 + prior.gains * (points[0, len(PARAMETERS) :] if len(data.gains) else 0.0)
    fitted = with_fitted_gains(known, gains)
    mobility, derivatives = command_mobility_with_derivatives(value, fitted, laplace(measured.frequency))
    factors = _error_factors(measured, mobility, derivatives, fitted, prior, value)
    lower, upper = _widened(_interval(data, prior, points, costs), points, factors)
    status = _status(lower, upper, points)
    covariance = _covariance(data, prior, points[0])
    deviation = np.sqrt(np.diag(covariance))
    error = _errors(value, lower, upper, status)
    error[DELTA] = factors[DELTA] * deviation[DELTA]
    at_bound = np.minimum(value - BOUNDS[0], BOUNDS[1] - value) < _NEAR_BOUND * error
    total = float(np.sum(np.abs((mobility - measured.mobility) * measured.weight) ** 2))
    lost = (value.size - np.count_nonzero(at_bound | np.isfinite(prior.value))) / 2
    dof = 2 * (measured.frequency.size - lost)
    ratio = expected_ratio(measured.degrees_of_freedom)
    p_value = sum_of_ratios_probability(
        float(np.mean(ratio)) * total / 2, measured.degrees_of_freedom, measured.sharing, fitted=lost
    )
    mismatch = float(np.sqrt(max(total / dof, 1.0))) if p_value < _MISMATCH_RATE else 1.0
    reason = _why_refused(value, error, p_value, settings)
    correlation = covariance / np.outer(deviation, deviation)
    return Fit(
        value,
        error,
        lower,
        upper,
        status,
        correlation,
        at_bound,
        gains,
        total / dof,
        dof,
        p_value,
        mismatch,
        not reason,
        reason,
    )


def _why_refused(value: Floats, error: Floats, p_value: float, settings: FitsSettings) -> str:
    if not np.all(np.isfinite(error)):
        return "the data do not determine the parameters"
    for index in (LENGTH, POLAR_MOMENT, INERTIA_TD):
        name, unit = list(PARAMETERS)[index], list(PARAMETERS.values())[index][0]
        if min(value[index] - BOUNDS[0, index], BOUNDS[1, index] - value[index]) < error[index]:
            return f"{name} ended at the edge of what is searched, {value[index]:.4g} {unit}"
    if p_value < settings.error_rate:
        return f"the residuals are larger than the noise allows (p-value below {settings.error_rate:g})"
    return ""


def with_fitted_gains(known: KnownEquipment, factors: Floats) -> KnownEquipment:
    """The known equipment with the control's gains times fitted factors (2,)."""
    return replace(known, controller=with_gains(known.controller, factors))


def measured_rows(mobility: xr.Dataset) -> list[Measured]:
    """The used frequencies of every row (window or stack) of a mobility dataset."""
    frequency, freedom = mobility["frequency"].values, mobility["degrees_of_freedom"].values
    names = ("command_mobility", "command_mobility_variance")
    columns = (*(mobility[name].values for name in names), freedom, sharing(freedom, mobility["averages"].values))
    used = mobility["gate"].values == Gate.USED
    return [
        Measured(frequency[chosen], *(values[chosen] for values in row))
        for chosen, *row in zip(used, *columns, strict=True)
    ]

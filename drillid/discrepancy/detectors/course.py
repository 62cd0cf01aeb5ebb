"""The course of a parameter that changes within a window, fitted to the whole record by maximum likelihood.

While a parameter changes, the speed at each moment is that of the rig with the parameter's value at that moment
(quasi-static approximation). The course's values, the moment of a jump, and the model's other parameters are fitted
together: at a strong change these are not those of the window's own fit, which is that of a rig without a change.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from scipy.fft import irfft, rfft
from scipy.special import chdtrc, ndtr

from drillid.arrays import Complex, Floats
from drillid.discrepancy.detectors.residual_record import ResidualRecord
from drillid.discrepancy.detectors.score import Score, block_starts, normal_of_p_value
from drillid.physics.eight_parameters import command_mobility_with_derivatives
from drillid.physics.parameters import BOUNDS, SCALES

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

CHANGES = np.linspace(0.15, 0.85, 15)
"""Moments at which a jump is tried, as shares of the window."""

_STARTS = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
"""Moments from which the fit of a jump is started, besides that at which it is detected."""
_KNOTS = 5
"""Values of a free course, which is linear between them."""
_INTERPOLATED = {2: 9, _KNOTS: 5}
"""Moments between which the responses are interpolated wherever a course of so many values is linear."""
_EVALUATIONS, _FIRST_EVALUATIONS = 30, 3
"""Function evaluations of a fit, and from each of several starts before the best is chosen."""
_LEAST = 1e-3
"""Lower bound of a course, as a share of the parameter's fitted value."""
_LOWEST = 1.0
"""N m s/rad, or m, lower bound of the fitted value as a scale."""
_SETTLING_S = 10.0
"""s, over which a jump is smoothed; a sudden one would have power at all frequencies."""
_MOMENT_STEP = 1e-4


class Course(NamedTuple):
    """A parameter's course, fitted."""

    size: float
    size_error: float
    cost: float
    """Half the residual sum of squares."""
    gain: float
    """Log-likelihood ratio against no change, corrected for heteroscedastic noise."""
    spread: float
    """Variance of the fitted change relative to that in stationary noise."""
    values: Floats
    """Values before and after, and the moment of a jump."""
    others: Floats
    """(7,) the model's other parameters."""
    residual: Floats
    """Whitened residual speed (whitened samples,)."""

    @property
    def penalised_cost(self) -> float:
        """Cost plus one for each fitted value (Akaike 1974)."""
        return self.cost + self.values.size

    @property
    def jumps(self) -> bool:
        """Whether it jumps, instead of changing linearly."""
        return self.values.size > 2

    def misfit_against(self, least: float) -> float:
        """Standard normal value of this course's excess over half the residual sum of squares of a free course.

        A free course has _KNOTS values; twice the excess follows χ² with as many degrees of freedom as it has more.
        """
        better = max(self.cost - least, 0.0) / self.spread
        return normal_of_p_value(float(chdtrc(_KNOTS - self.values.size, 2 * better)))

    @property
    def normal(self) -> float:
        """Standard normal value of the gain by one value, Bonferroni-corrected for the moments tried."""
        tried = CHANGES.size if self.jumps else 1
        return normal_of_p_value(min(tried * 2 * float(ndtr(-np.sqrt(2 * self.gain))), 1.0))


def separation(courses: Sequence[Course]) -> float:
    """Standard deviations between the speeds predicted by two courses; NaN where there are not two."""
    if len(courses) != 2:
        return np.nan
    first, second = courses
    return float(np.linalg.norm(first.residual - second.residual) / np.sqrt(max(first.spread, second.spread)))


class ChangingWindow:
    """A window in which one parameter of the model changes."""

    def __init__(self, parameter: int, residual: ResidualRecord) -> None:
        self.residual, self.parameter = residual, parameter
        self.fitted = residual.record.fitted
        self.level = max(float(self.fitted[parameter]), _LOWEST)
        speed = residual.speed - residual.subtracted
        self.measured = residual.weighted(speed - speed.mean())
        # all else is computed at the times of whitened series
        self.samples, self.duration = residual.whitened_samples, residual.samples / residual.record.rate
        self.elapsed = np.arange(self.samples) / self.samples + 0.5 / residual.samples
        self.taper = np.interp(self.elapsed, residual.elapsed, residual.taper)
        fewer = self.samples / residual.samples
        self.s, self.weight = residual.s[: residual.lines], residual.weight / fewer
        sweep = rfft(residual.sweep - residual.sweep.mean()) * residual.inside
        self.spectrum = sweep[: residual.lines] * fewer
        self.others = np.delete(np.arange(SCALES.size), parameter)
        self.polynomials = {
            values: _polynomials(self.elapsed, values - 1, count) for values, count in _INTERPOLATED.items()
        }

    def course(self, detected: Score, *, jumps: bool) -> Course:
        """The best course from the detected one; of a jump, whose cost has several minima, also from others in time."""
        moments = [float(CHANGES[int(np.argmax(np.abs(detected.amplitudes)))]), *_STARTS] if jumps else [0.5]
        count = 3 if jumps else 2
        # the window's own fit gives about the mean over the window
        begins = [(self.level - detected.size * (1 - moment), moment) for moment in moments]
        starts = [np.array([begin, begin + detected.size, moment])[:count] for begin, moment in begins]
        starts = [np.append(start, self.fitted[self.others]) for start in starts]
        if jumps:
            first = [self._least(start, count, _FIRST_EVALUATIONS) for start in starts]
            starts = [min(first, key=lambda fit: float(fit.cost)).x]
        best = self._least(starts[0], count)
        scale = np.append(np.full(count, self.level), SCALES[self.others])
        slopes, change = best.jac * scale, np.zeros(best.x.size)
        change[:2] = -self.level, self.level
        direction = np.linalg.pinv(slopes.T @ slopes) @ change
        stationary = float(change @ direction)
        spread = max(self._variance(slopes @ direction, best.fun) / stationary, 1.0)
        unchanged = min(self.unchanged, self._constant(float(best.x[:2].mean()), best.x[count:]))
        gain = max(unchanged - float(best.cost), 0.0) / spread
        size, error = float(best.x[1] - best.x[0]), float(np.sqrt(spread * stationary))
        return Course(size, error, float(best.cost), gain, spread, best.x[:count], best.x[count:], best.fun)

    @cached_property
    def unchanged(self) -> float:
        """Half the residual sum of squares of a rig without a change, from the window's own fit."""
        return self._constant(self.level, self.fitted[self.others])

    def free_cost(self, course: Course) -> float:
        """Half the residual sum of squares of a free course, fitted from a given course as start."""
        begin, end = course.values[:2]
        knots = np.linspace(0.0, 1.0, _KNOTS)
        values = begin + (end - begin) * (course.values[2] < knots if course.jumps else knots)
        return float(self._least(np.append(values, course.others), _KNOTS).cost)

    def _variance(self, column: Floats, error: Floats) -> float:
        """Variance of a fitted value, robust to heteroscedasticity by sums over blocks of the record (White 1980)."""
        return float(np.sum(np.add.reduceat(column * error, block_starts(self.residual, self.samples)) ** 2))

    def _constant(self, value: float, others: Floats) -> float:
        return float(self._least(np.append(value, others), 1).cost)

    def _least(self, start: Floats, count: int, evaluations: int = _EVALUATIONS) -> OptimizeResult:
        """Least squares over `count` values of the course and the model's other parameters, within bounds."""
        from scipy.optimize import least_squares

        lowest, highest, scale = np.full((3, count), [[_LEAST * self.level], [np.inf], [self.level]])
        if count == 3:
            lowest[2], highest[2], scale[2] = CHANGES[0], CHANGES[-1], 0.1
        low, high = BOUNDS[:, self.others]
        lowest, highest = np.append(lowest, low), np.append(highest, high)
        evaluated: dict[bytes, tuple[Floats, Floats]] = {}

        def at(values: Floats) -> tuple[Floats, Floats]:
            # the slopes are asked for where the residual was computed last
            if values.tobytes() not in evaluated:
                evaluated.clear()
                evaluated[values.tobytes()] = self._residual(values, count)
            return evaluated[values.tobytes()]

        return least_squares(
            lambda values: at(values)[0],
            np.clip(start, lowest + _LEAST * np.append(scale, SCALES[self.others]), highest),
            jac=lambda values: at(values)[1],
            bounds=(lowest, highest),
            x_scale=np.append(scale, SCALES[self.others]),
            max_nfev=evaluations,
            xtol=1e-4,
            ftol=1e-5,
        )

    def _residual(self, values: Floats, count: int) -> tuple[Floats, Floats]:
        """Whitened residual (whitened samples,) and its derivatives (whitened samples, values).

        Parameters
        ----------
        values : `count` values of the course, and the other parameters: one value, which does not change; two, at begin
            and end of a linear change; three, before and after a jump and its moment; or those at the knots of a free
            course
        """
        weights, shares = self._interpolation(values[:count])
        places = shares @ values[: shares.shape[1]]
        points = np.empty((places.size, SCALES.size))
        points[:, self.others] = values[count:]
        points[:, self.parameter] = places
        mobility, slopes = command_mobility_with_derivatives(points, self.residual.record.known, self.s)
        responses = self._response(mobility)
        columns = [shares.T @ (weights * self._response(slopes[:, self.parameter]))]
        if count == 3:
            columns.append(self._jump_slope(values[2]) * (responses[1] - responses[0])[None])
        columns.append(np.stack([(weights * self._response(slopes[:, k])).sum(axis=0) for k in self.others]))
        error = self.measured - self._weighted((weights * responses).sum(axis=0))
        return error, -self._weighted(np.concatenate(columns)).T

    def _response(self, mobility: Complex) -> Floats:
        """Response (..., whitened samples) to the sweep, rad/s."""
        return np.asarray(irfft(mobility * self.spectrum, self.samples), dtype=float)

    def _weighted(self, series: Floats) -> Floats:
        """A series (..., whitened samples) whitened as `ResidualRecord.weighted` would."""
        return self.residual.of_band(rfft(series * self.taper)[..., : self.s.size] * self.weight)

    def _interpolation(self, course: Floats) -> tuple[Floats, Floats]:
        """Weights (K, samples) of the responses at K values of the parameter, and these values' shares (K, n) of the
        course's own.
        """
        if course.size == 1:
            return np.ones((1, self.samples)), np.ones((1, 1))
        if course.size == 3:
            after = jump(self.elapsed, self.duration, course[2:])[0]
            return np.stack([1 - after, after]), np.eye(2)
        places, weights = self.polynomials[course.size]
        return weights, _hats(places, course.size).T

    def _jump_slope(self, moment: float) -> Floats:
        """Derivative of a smoothed step to its moment, (whitened samples,)."""
        earlier, later = jump(self.elapsed, self.duration, moment + np.array([-_MOMENT_STEP, _MOMENT_STEP]))
        return np.asarray((later - earlier) / (2 * _MOMENT_STEP), dtype=float)


def _polynomials(elapsed: Floats, pieces: int, count: int) -> tuple[Floats, Floats]:
    """Places (pieces · count,) from which functions on equal pieces of 0 … 1 are interpolated by polynomials, and the
    weights (pieces · count, samples) of the values there.

    Responses change the faster the smaller a damping is, so that straight lines between few moments would be off by
    more than the noise.
    """
    own = -np.cos(np.pi * np.linspace(0.0, 1.0, count))
    piece = np.minimum((elapsed * pieces).astype(int), pieces - 1)
    within = np.linalg.solve(chebvander(own, count - 1).T, chebvander(2 * (elapsed * pieces - piece) - 1, count - 1).T)
    weights = (np.arange(pieces)[:, None] == piece)[:, None] * within
    places = (np.arange(pieces)[:, None] + (1 + own) / 2) / pieces
    return places.ravel(), weights.reshape(-1, elapsed.size)


def _hats(places: Floats, count: int) -> Floats:
    """Shares (count, places) of equally spaced knots in values between them."""
    knots = np.linspace(0.0, 1.0, count)
    return np.asarray(np.maximum(1 - np.abs(places - knots[:, None]) * (count - 1), 0.0), dtype=float)


def jump(elapsed: Floats, duration: float, moments: Floats) -> Floats:
    """Smoothed steps from 0 to 1 (jumps, samples), at moments (jumps,) and times (samples,) in shares of a duration."""
    since = (elapsed - moments[:, None]) * duration
    return np.asarray(np.sin(np.pi / 2 * np.clip(since / _SETTLING_S + 0.5, 0.0, 1.0)) ** 2, dtype=float)

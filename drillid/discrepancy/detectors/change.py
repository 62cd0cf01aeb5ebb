"""Detections of changes in time: fitted non-linearly along the course of a parameter, not by its derivative alone.

While a parameter changes, the speed at each moment is that of the rig with the parameter's value at that moment
(quasi-static approximation). Initial value and size of the change, and the moment of a jump, are fitted to the whole
window; the rig's other parameters are adjusted linearly.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.fft import irfft, rfft
from scipy.special import chdtrc, ndtr

from drillid.arrays import Floats
from drillid.discrepancy.detectors.detector import Detector, Inspection
from drillid.discrepancy.detectors.residual_record import ResidualRecord
from drillid.discrepancy.detectors.score import (
    Candidate,
    Score,
    block_starts,
    normal_of_p_value,
    orthonormal,
    score,
    whitened,
    without_basis,
)
from drillid.discrepancy.rules import CHANGE_FOLLOWED
from drillid.physics.eight_parameters import command_mobility_with_derivatives
from drillid.physics.parameters import DAMPING_BHA, DELAY, INERTIA_TD, LENGTH

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult

_KNOTS = 5
"""Moments between which responses to a linear change are interpolated, and a free course is linear."""
_AT_KNOTS = np.linspace(0.0, 1.0, _KNOTS)
_EVALUATIONS, _FIRST_EVALUATIONS = 30, 3
"""Of a fit, and from each of several starts before the best is chosen."""
_LEAST = 1e-3
"""Lower bound of a course, as a share of the parameter's fitted value."""
_LOWEST = 1.0
"""N m s/rad, or m, lower bound of the fitted value as a scale."""

CHANGES = np.linspace(0.15, 0.85, 15)
"""Moments at which a jump is tried, as shares of the window."""

_STARTS = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
"""Moments from which the fit of a jump begins, beside that at which it is detected."""

_MOVING = (LENGTH, DELAY, INERTIA_TD, DAMPING_BHA)
"""Parameters of the model that may change linearly in time, whatever the cause."""
_SETTLING_S = 10.0
"""s, over which a jump is smoothed; a sudden one would have power at all frequencies."""


class ChangeDetector(Detector):
    """A parameter of the model that changes linearly over the window, or jumps at one moment.

    Parameters
    ----------
    parameter : its index among the eight
    jumps : whether it jumps, instead of changing linearly
    one_sided : whether it can only grow
    """

    needs_periods = True

    def __init__(self, parameter: int, *, jumps: bool = False, one_sided: bool = False) -> None:
        self.parameter, self.jumps, self.one_sided = parameter, jumps, one_sided

    def candidate(self, name: str, inspection: Inspection) -> Candidate:
        """Derivative of the response with respect to the parameter, times the parameter's change so far."""
        residual = inspection.residual
        derivative = residual.response_to_sweep(residual.derivatives[self.parameter])
        change = jump(residual, CHANGES) if self.jumps else (residual.elapsed - 0.5)[None]
        return Candidate(name, change * derivative, one_sided=self.one_sided)

    @classmethod
    def reviewed(
        cls, detectors: Mapping[str, Detector], scores: dict[str, Score], inspection: Inspection
    ) -> dict[str, Score]:
        """Scores, sizes and errors of apparent changes, from a fit of the whole course.

        Among causes that change the same parameter, the one whose course fits best gets the best score, by that fit
        or by the derivative, and the others are lower by the difference of their fits.
        """
        own = {name: detector for name, detector in detectors.items() if isinstance(detector, ChangeDetector)}
        for parameter in dict.fromkeys(detector.parameter for detector in own.values()):
            sharing = {name: detector for name, detector in own.items() if detector.parameter == parameter}
            scores = scores | _followed(parameter, sharing, scores, inspection.residual)
        return scores


class TrendDetector(Detector):
    """A response to the sweep that changes linearly in time, whichever parameters of the model cause it."""

    needs_periods = True

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Joint score of trends in all those parameters."""
        residual = inspection.residual
        derivatives = residual.response_to_sweep(residual.derivatives[list(_MOVING)])
        trend = Candidate(name, (residual.elapsed - 0.5) * derivatives, together=True)
        return score(whitened(trend, residual), residual.error, residual)


def _followed(
    parameter: int, detectors: Mapping[str, ChangeDetector], scores: dict[str, Score], residual: ResidualRecord
) -> dict[str, Score]:
    """Scores of the causes that change one parameter, by their courses; none where no such change is apparent."""
    best = max((scores[name] for name in detectors), key=lambda candidate: candidate.normal)
    if best.normal < CHANGE_FOLLOWED:
        return {}
    window = _Window(parameter, residual)
    courses = {name: _fitted(window, scores[name], jumps=detector.jumps) for name, detector in detectors.items()}
    nearest = min(courses.values(), key=lambda course: course.penalised_cost)
    separation = _separation(list(courses.values()))
    # a free course has several optima, one near each of the others
    free = min(window.free_cost(course) for course in courses.values())
    normal, log_ratio = max(best.normal, nearest.normal), max(best.log_ratio, nearest.gain)
    return {
        name: replace(
            scores[name],
            normal=float(np.sqrt(max(normal**2 - 2 * (course.penalised_cost - nearest.penalised_cost), 0.0))),
            log_ratio=max(log_ratio - (course.penalised_cost - nearest.penalised_cost), 0.0),
            size=course.size,
            size_error=course.size_error,
            misfit=course.misfit_against(free),
            separation=separation,
        )
        for name, course in courses.items()
    }


class _Course(NamedTuple):
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
    residual: Floats
    """Whitened residual speed (samples,)."""

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


def _separation(courses: list[_Course]) -> float:
    """Standard deviations between the speeds predicted by two courses; NaN where there are not two."""
    if len(courses) != 2:
        return np.nan
    first, second = courses
    return float(np.linalg.norm(first.residual - second.residual) / np.sqrt(max(first.spread, second.spread)))


def _fitted(window: _Window, detected: Score, *, jumps: bool) -> _Course:
    """The best course from the detected one; of a jump, whose cost has several minima, also from others in time."""
    moments = [float(CHANGES[int(np.argmax(np.abs(detected.amplitudes)))]), *_STARTS] if jumps else [0.5]
    level, count = window.level, 3 if jumps else 2
    highest = np.array([np.inf, np.inf, CHANGES[-1]])[:count]
    lowest, scale = np.array([_LEAST * level, _LEAST * level, CHANGES[0]]), np.array([level, level, 0.1])
    residual_of = window.residual_of_jump if jumps else window.residual_of_drift

    def fitted_from(start: Floats, evaluations: int) -> OptimizeResult:
        return _least_squares(residual_of, start, lowest[:count], highest, scale[:count], evaluations)

    # the window's own fit gives about the mean over the window
    begins = [(level - detected.size * (1 - moment), moment) for moment in moments]
    starts = [np.array([begin, begin + detected.size, moment])[:count] for begin, moment in begins]
    if jumps:
        starts = [min((fitted_from(each, _FIRST_EVALUATIONS) for each in starts), key=lambda fit: float(fit.cost)).x]
    best = fitted_from(starts[0], _EVALUATIONS)
    change = np.array([-1.0, 1.0])
    inverse = np.linalg.pinv(best.jac.T @ best.jac)
    variance = change @ _covariance(best.jac, best.fun, window.residual, inverse)[:2, :2] @ change
    spread = max(float(variance / (change @ inverse[:2, :2] @ change)), 1.0)
    gain = max(window.unchanged - float(best.cost), 0.0) / spread
    return _Course(
        float(best.x[1] - best.x[0]), float(np.sqrt(variance)), float(best.cost), gain, spread, best.x, best.fun
    )


def _least_squares(
    residual_of: Callable[[Floats], Floats],
    start: Floats,
    lowest: Floats,
    highest: Floats,
    scale: Floats,
    evaluations: int = _EVALUATIONS,
) -> OptimizeResult:
    """Least-squares values (count,) from a start, within bounds."""
    from scipy.optimize import least_squares

    return least_squares(
        residual_of,
        np.clip(start, lowest * (1 + _LEAST), highest),
        bounds=(lowest, highest),
        x_scale=scale,
        diff_step=1e-4,
        max_nfev=evaluations,
        xtol=1e-4,
        ftol=1e-5,
    )


class _Window:
    """A window in which one parameter of the model changes."""

    def __init__(self, parameter: int, residual: ResidualRecord) -> None:
        self.residual, self.parameter = residual, parameter
        self.level = max(float(residual.record.fitted[parameter]), _LOWEST)
        self.spectrum = rfft(residual.sweep - residual.sweep.mean()) * residual.inside
        others = np.delete(residual.derivatives, parameter, axis=0) * self.spectrum
        self.others = orthonormal(residual.weighted(irfft(others, residual.samples)))
        speed = residual.speed - residual.subtracted
        self.measured = without_basis(residual.weighted(speed - speed.mean()), self.others)

    @cached_property
    def unchanged(self) -> float:
        """Half the residual sum of squares at the best constant value."""
        return self._least(lambda value: self._residual_at(value, np.ones((1, self.residual.samples))), np.ones(1))

    def free_cost(self, course: _Course) -> float:
        """Half the residual sum of squares of a free course, fitted from a given course as start."""
        begin, end = course.values[:2]
        shares = course.values[2] < _AT_KNOTS if course.jumps else _AT_KNOTS
        return self._least(self.residual_at_knots, (begin + (end - begin) * shares) / self.level)

    def _least(self, residual_of: Callable[[Floats], Floats], start: Floats) -> float:
        """Half the least residual sum of squares, from a start relative to the fitted value."""
        level = np.full(start.size, self.level)
        unbounded = np.full(start.size, np.inf)
        return float(_least_squares(residual_of, level * start, _LEAST * level, unbounded, level).cost)

    def residual_of_jump(self, values: Floats) -> Floats:
        """Whitened residual (samples,) with the values before and after a jump, and its moment."""
        after = jump(self.residual, values[2:3])[0]
        return self._residual_at(values[:2], np.stack([1 - after, after]))

    def residual_of_drift(self, values: Floats) -> Floats:
        """Whitened residual (samples,) with the values at begin and end of a linear change."""
        return self.residual_at_knots(values[0] + (values[1] - values[0]) * _AT_KNOTS)

    def residual_at_knots(self, values: Floats) -> Floats:
        """Whitened residual (samples,) with values at the knots (_KNOTS,), and linear changes between them."""
        weights = np.maximum(1 - np.abs(self.residual.elapsed - _AT_KNOTS[:, None]) * (_KNOTS - 1), 0.0)
        return self._residual_at(values, weights)

    def _residual_at(self, values: Floats, weights: Floats) -> Floats:
        """Whitened residual with the mean of the responses at some values (K,), weighted by (K, samples)."""
        residual = self.residual
        points = np.tile(residual.record.fitted, (values.size, 1))
        points[:, self.parameter] = values
        mobility, _ = command_mobility_with_derivatives(points, residual.record.known, residual.s)
        responses = irfft(mobility * self.spectrum, residual.samples)
        return self.measured - without_basis(residual.weighted(np.sum(weights * responses, axis=0)), self.others)


def _covariance(slopes: Floats, error: Floats, residual: ResidualRecord, inverse: Floats) -> Floats:
    """Covariance of fitted values, robust to heteroscedasticity by sums over blocks of the record (White 1980)."""
    products = np.add.reduceat(slopes * error[:, None], block_starts(residual), axis=0)
    return np.asarray(inverse @ (products.T @ products) @ inverse, dtype=float)


def jump(residual: ResidualRecord, moments: Floats) -> Floats:
    """Smoothed steps from 0 to 1 at moments (jumps,), in shares of the window; shape (jumps, samples)."""
    since = (residual.elapsed - moments[:, None]) * residual.samples / residual.record.rate
    return np.asarray(np.sin(np.pi / 2 * np.clip(since / _SETTLING_S + 0.5, 0.0, 1.0)) ** 2, dtype=float)

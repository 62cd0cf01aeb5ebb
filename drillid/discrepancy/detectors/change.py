"""Detections of changes in time: followed along the course that a parameter takes, not by its derivative alone.

While a parameter changes, the speed is at every moment taken as that of the rig as it is then. Begin and size of the
change, and the moment of a jump, are fitted to the whole window; the rig's other parameters follow by their
derivatives.
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
"""Moments between which the response to an even change is interpolated, and a free course is even."""
_AT_KNOTS = np.linspace(0.0, 1.0, _KNOTS)
_EVALUATIONS = 30
_LEAST = 1e-3
"""Share of a parameter's fitted value below which its course does not go."""
_LOWEST = 1.0
"""N m s/rad, or m, that a fitted value is taken for at least."""

CHANGES = np.linspace(0.15, 0.85, 15)
"""Shares of the window at which a jump is tried."""

_MOVING = (LENGTH, DELAY, INERTIA_TD, DAMPING_BHA)
"""Parameters of the model that may change evenly, whatever the cause."""
_SETTLING_S = 10.0
"""s, over which the string takes up a jump; a sudden one would have power at all frequencies."""


class ChangeDetector(Detector):
    """A parameter of the model that changes evenly over the window, or at one moment.

    Parameters
    ----------
    parameter : its place among the eight
    jumps : whether it changes at a moment, and not evenly
    one_sided : whether it can only grow
    """

    needs_periods = True

    def __init__(self, parameter: int, *, jumps: bool = False, one_sided: bool = False) -> None:
        self.parameter, self.jumps, self.one_sided = parameter, jumps, one_sided

    def candidate(self, name: str, inspection: Inspection) -> Candidate:
        """The response's derivative to the parameter, times how far that has moved."""
        residual = inspection.residual
        derivative = residual.swept(residual.derivatives[self.parameter])
        moved = jump(residual, CHANGES) if self.jumps else (residual.passed - 0.5)[None]
        return Candidate(name, moved * derivative, one_sided=self.one_sided)

    @classmethod
    def reviewed(
        cls, detectors: Mapping[str, Detector], scores: dict[str, Score], inspection: Inspection
    ) -> dict[str, Score]:
        """Scores, sizes and errors of changes that are in sight, by the course as a whole.

        Of causes that move the same parameter, the one whose course fits best has the best score, by what that course
        gains or by the derivative, and the others fall behind it as their courses do.
        """
        own = {name: detector for name, detector in detectors.items() if isinstance(detector, ChangeDetector)}
        for parameter in dict.fromkeys(detector.parameter for detector in own.values()):
            alike = {name: detector for name, detector in own.items() if detector.parameter == parameter}
            scores = scores | _followed(parameter, alike, scores, inspection.residual)
        return scores


class TrendDetector(Detector):
    """A response to the sweep that changes evenly, whichever parameters of the model move."""

    needs_periods = True

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Trends of all those parameters together."""
        residual = inspection.residual
        moved = residual.swept(residual.derivatives[list(_MOVING)])
        trend = Candidate(name, (residual.passed - 0.5) * moved, together=True)
        return score(whitened(trend, residual), residual.error, residual)


def _followed(
    parameter: int, detectors: Mapping[str, ChangeDetector], scores: dict[str, Score], residual: ResidualRecord
) -> dict[str, Score]:
    """Scores of the causes that move one parameter, by their courses; none where no such change is in sight."""
    best = max((scores[name] for name in detectors), key=lambda one: one.normal)
    if best.normal < CHANGE_FOLLOWED:
        return {}
    window = _Window(parameter, residual)
    courses = {name: _fitted(window, scores[name], jumps=detector.jumps) for name, detector in detectors.items()}
    nearest = min(courses.values(), key=lambda course: course.price)
    apart = _apart(list(courses.values()))
    # a free course has several optima, one beside each of the others
    free = min(window.free_cost(course) for course in courses.values())
    normal, log_ratio = max(best.normal, nearest.normal), max(best.log_ratio, nearest.gain)
    return {
        name: replace(
            scores[name],
            normal=float(np.sqrt(max(normal**2 - 2 * (course.price - nearest.price), 0.0))),
            log_ratio=max(log_ratio - (course.price - nearest.price), 0.0),
            size=course.size,
            size_error=course.size_error,
            misfit=course.misfit_beside(free),
            apart=apart,
        )
        for name, course in courses.items()
    }


class _Course(NamedTuple):
    """A parameter's course at its best."""

    size: float
    size_error: float
    cost: float
    """Half the sum of squares that is left."""
    gain: float
    """Log-likelihood ratio against no change, with the noise as it is over the window."""
    spread: float
    """Variance of what is fitted, per that by noise that does not change."""
    values: Floats
    """Values before and after, and the moment of a jump."""
    left: Floats
    """Whitened speed (samples,) that is left."""

    @property
    def price(self) -> float:
        """What is left, and one for each fitted value (Akaike 1974)."""
        return self.cost + self.values.size

    @property
    def jumps(self) -> bool:
        """Whether it goes at a moment, and not evenly."""
        return self.values.size > 2

    def misfit_beside(self, least: float) -> float:
        """Standard normal value of what this course leaves beside half the sum of squares that a free one leaves.

        A free course has _KNOTS values; what it fits better follows χ² of those that it has more.
        """
        better = max(self.cost - least, 0.0) / self.spread
        return normal_of_p_value(float(chdtrc(_KNOTS - self.values.size, 2 * better)))

    @property
    def normal(self) -> float:
        """Standard normal value of the gain by one value, at the best of the moments."""
        tried = CHANGES.size if self.jumps else 1
        return normal_of_p_value(min(tried * 2 * float(ndtr(-np.sqrt(2 * self.gain))), 1.0))


def _apart(courses: list[_Course]) -> float:
    """Standard deviations between the speeds by two courses; NaN where there are not two."""
    if len(courses) != 2:
        return np.nan
    first, second = courses
    return float(np.linalg.norm(first.left - second.left) / np.sqrt(max(first.spread, second.spread)))


def _fitted(window: _Window, detected: Score, *, jumps: bool) -> _Course:
    moment = CHANGES[int(np.argmax(np.abs(detected.amplitudes)))] if jumps else 0.5
    level, count = window.level, 3 if jumps else 2
    # the fitted value is about the mean over the window
    begin = level - detected.size * (1 - moment)
    start, highest = np.array([begin, begin + detected.size, moment]), np.array([np.inf, np.inf, CHANGES[-1]])
    lowest, scale = np.array([_LEAST * level, _LEAST * level, CHANGES[0]]), np.array([level, level, 0.1])
    left = window.left_by_jump if jumps else window.left_by_drift
    best = _settled(left, *(values[:count] for values in (start, lowest, highest, scale)))
    change = np.array([-1.0, 1.0])
    usual = np.linalg.pinv(best.jac.T @ best.jac)
    variance = change @ _covariance(best.jac, best.fun, window.residual, usual)[:2, :2] @ change
    spread = max(float(variance / (change @ usual[:2, :2] @ change)), 1.0)
    gain = max(window.unchanged - float(best.cost), 0.0) / spread
    return _Course(
        float(best.x[1] - best.x[0]), float(np.sqrt(variance)), float(best.cost), gain, spread, best.x, best.fun
    )


def _settled(
    left: Callable[[Floats], Floats], start: Floats, lowest: Floats, highest: Floats, scale: Floats
) -> OptimizeResult:
    """Values (count,) at which least is left, from a start."""
    from scipy.optimize import least_squares

    return least_squares(
        left,
        np.clip(start, lowest * (1 + _LEAST), highest),
        bounds=(lowest, highest),
        x_scale=scale,
        diff_step=1e-4,
        max_nfev=_EVALUATIONS,
        xtol=1e-4,
        ftol=1e-5,
    )


class _Window:
    """A window in which one parameter of the model goes from one value to another."""

    def __init__(self, parameter: int, residual: ResidualRecord) -> None:
        self.residual, self.parameter = residual, parameter
        self.level = max(float(residual.record.fitted[parameter]), _LOWEST)
        self.spectrum = rfft(residual.sweep - residual.sweep.mean()) * residual.inside
        others = np.delete(residual.derivatives, parameter, axis=0) * self.spectrum
        self.others = orthonormal(residual.weighted(irfft(others, residual.samples)))
        speed = residual.speed - residual.taken
        self.measured = without_basis(residual.weighted(speed - speed.mean()), self.others)

    @cached_property
    def unchanged(self) -> float:
        """Half the sum of squares that is left at the best value that does not change."""
        return self._least(lambda value: self._left(value, np.ones((1, self.residual.samples))), np.ones(1))

    def free_cost(self, course: _Course) -> float:
        """Half the sum of squares that is left where the parameter takes any course, from a given one on."""
        begin, end = course.values[:2]
        shares = course.values[2] < _AT_KNOTS if course.jumps else _AT_KNOTS
        return self._least(self.left_freely, (begin + (end - begin) * shares) / self.level)

    def _least(self, left: Callable[[Floats], Floats], start: Floats) -> float:
        """Half the sum of squares that is left at the best values, from a start in fitted values."""
        level = np.full(start.size, self.level)
        return float(_settled(left, level * start, _LEAST * level, np.full(start.size, np.inf), level).cost)

    def left_by_jump(self, values: Floats) -> Floats:
        """Whitened speed (samples,) that is left with the values before and after a jump, and its moment."""
        after = jump(self.residual, values[2:3])[0]
        return self._left(values[:2], np.stack([1 - after, after]))

    def left_by_drift(self, values: Floats) -> Floats:
        """Whitened speed (samples,) that is left with the values at begin and end of an even change."""
        return self.left_freely(values[0] + (values[1] - values[0]) * _AT_KNOTS)

    def left_freely(self, values: Floats) -> Floats:
        """Whitened speed (samples,) that is left with values at the knots (_KNOTS,), and even changes between."""
        weights = np.maximum(1 - np.abs(self.residual.passed - _AT_KNOTS[:, None]) * (_KNOTS - 1), 0.0)
        return self._left(values, weights)

    def _left(self, values: Floats, weights: Floats) -> Floats:
        """With the responses at some values (K,), which count by weights (K, samples)."""
        residual = self.residual
        points = np.tile(residual.record.fitted, (values.size, 1))
        points[:, self.parameter] = values
        mobility, _ = command_mobility_with_derivatives(points, residual.record.known, residual.s)
        responses = irfft(mobility * self.spectrum, residual.samples)
        return self.measured - without_basis(residual.weighted(np.sum(weights * responses, axis=0)), self.others)


def _covariance(slopes: Floats, error: Floats, residual: ResidualRecord, inverse: Floats) -> Floats:
    """Of fitted values, by the errors of blocks of the record as they are (White 1980)."""
    products = np.add.reduceat(slopes * error[:, None], block_starts(residual), axis=0)
    return np.asarray(inverse @ (products.T @ products) @ inverse, dtype=float)


def jump(residual: ResidualRecord, moments: Floats) -> Floats:
    """From 0 to 1 at each of some moments (jumps,), shares of the window; shape (jumps, samples)."""
    since = (residual.passed - moments[:, None]) * residual.samples / residual.record.rate
    return np.asarray(np.sin(np.pi / 2 * np.clip(since / _SETTLING_S + 0.5, 0.0, 1.0)) ** 2, dtype=float)

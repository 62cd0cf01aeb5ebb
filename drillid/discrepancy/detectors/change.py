"""Changes in time that are in sight: the response is followed along the way that a figure goes, not by its derivative.

While a figure changes, the speed is at every moment taken as that of the rig as it is then. Begin and size of the
change, and the moment of a jump, are fitted to the whole window; the rig's other figures follow by their derivatives.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.fft import irfft, rfft
from scipy.special import chdtrc, ndtr

from drillid.arrays import Floats
from drillid.discrepancy.detectors.residual_record import ResidualRecord
from drillid.discrepancy.detectors.score import (
    Candidate,
    Score,
    block_starts,
    normal_of_p_value,
    orthonormal,
    without_basis,
)
from drillid.physics.eight_parameters import command_mobility_with_derivatives
from drillid.physics.parameters import DAMPING_BHA, DELAY, INERTIA_TD, LENGTH

if TYPE_CHECKING:
    from scipy.optimize import OptimizeResult


_FIGURES = {"length_growth": LENGTH, "parameter_drift": DAMPING_BHA, "regime_change": DAMPING_BHA}
"""What changes, of the eight figures of the model, by cause."""
_JUMP = "regime_change"
_IN_SIGHT = 2.0
"""Score from which a change is followed."""
_KNOTS = 5
"""Moments between which an even change's response is interpolated, and a free one is even."""
_AT_KNOTS = np.linspace(0.0, 1.0, _KNOTS)
_EVALUATIONS = 30
_LEAST = 1e-3
"""Of a figure's fitted value, below which it does not go."""
_LOWEST = 1.0
"""N m s/rad, or m, that a fitted value is taken for at least."""

CHANGES = np.linspace(0.15, 0.85, 15)
"""Shares of the window at which the response is tried to jump."""

_MOVING = (LENGTH, DELAY, INERTIA_TD, DAMPING_BHA)
"""Figures of the model that may move evenly when it is not asked why."""
_SETTLING_S = 10.0
"""s, over which the string takes up a jump; a sudden one would have power at all frequencies."""


def along_the_way(scores: dict[str, Score], residual: ResidualRecord) -> dict[str, Score]:
    """Scores of changes that are in sight, and their sizes and errors, told by the change as a whole.

    Of causes that move the same figure, the one whose way fits best has the best score, by what that way gains or by
    the derivative, and the others fall behind it as their ways do.
    """
    scores = dict(scores)
    for figure in dict.fromkeys(_FIGURES.values()):
        causes = [cause for cause in scores if _FIGURES.get(cause) == figure]
        best = max((scores[cause] for cause in causes), key=lambda one: one.normal, default=None)
        if best is None or best.normal < _IN_SIGHT:
            continue
        window = _Window(figure, residual)
        fitted = {cause: _fitted(window, scores[cause], jumps=cause == _JUMP) for cause in causes}
        nearest = min(fitted.values(), key=lambda one: one.price)
        apart = _apart(list(fitted.values()))
        # a free course has several optima, one beside each way
        freely = min(window.freely(way) for way in fitted.values())
        normal, log_ratio = max(best.normal, nearest.normal), max(best.log_ratio, nearest.gain)
        for cause, way in fitted.items():
            behind = way.price - nearest.price
            scores[cause] = replace(
                scores[cause],
                normal=float(np.sqrt(max(normal**2 - 2 * behind, 0.0))),
                log_ratio=max(log_ratio - behind, 0.0),
                size=way.size,
                size_error=way.size_error,
                misfit=way.misfit_beside(freely),
                apart=apart,
            )
    return scores


class _Fitted(NamedTuple):
    """A way at its best."""

    size: float
    size_error: float
    cost: float
    """Half the sum of squares that is left."""
    gain: float
    """Log-likelihood ratio against no change, with the noise as it is over the window."""
    spread: float
    """Variance of what is fitted, per that by noise that does not change."""
    figures: Floats
    """Values before and after, and the moment of a jump."""
    left: Floats
    """Whitened speed (samples,) that is left."""

    @property
    def price(self) -> float:
        """What is left, and one for each fitted figure (Akaike 1974)."""
        return self.cost + self.figures.size

    @property
    def jumps(self) -> bool:
        """Whether it goes at a moment, and not evenly."""
        return self.figures.size > 2

    def misfit_beside(self, least: float) -> float:
        """Standard normal value of what this way leaves beside half the sum of squares that a free one leaves.

        A free way has _KNOTS figures; what it fits better follows χ² of those that it has more.
        """
        better = max(self.cost - least, 0.0) / self.spread
        return normal_of_p_value(float(chdtrc(_KNOTS - self.figures.size, 2 * better)))

    @property
    def normal(self) -> float:
        """Standard normal value of the gain by one figure, at the best of the moments."""
        tried = CHANGES.size if self.jumps else 1
        return normal_of_p_value(min(tried * 2 * float(ndtr(-np.sqrt(2 * self.gain))), 1.0))


def _apart(ways: list[_Fitted]) -> float:
    """Standard deviations between what two ways say of the speed; NaN where there are not two."""
    if len(ways) != 2:
        return np.nan
    one, other = ways
    return float(np.linalg.norm(one.left - other.left) / np.sqrt(max(one.spread, other.spread)))


def _fitted(window: _Window, found: Score, *, jumps: bool) -> _Fitted:
    moment = CHANGES[int(np.argmax(np.abs(found.amplitudes)))] if jumps else 0.5
    level, count = window.level, 3 if jumps else 2
    # the fitted value is about the mean over the window
    begin = level - found.size * (1 - moment)
    start, highest = np.array([begin, begin + found.size, moment]), np.array([np.inf, np.inf, CHANGES[-1]])
    lowest, scale = np.array([_LEAST * level, _LEAST * level, CHANGES[0]]), np.array([level, level, 0.1])
    left = window.left_by_jump if jumps else window.left_by_drift
    best = _settled(left, *(values[:count] for values in (start, lowest, highest, scale)))
    change = np.array([-1.0, 1.0])
    usual = np.linalg.pinv(best.jac.T @ best.jac)
    variance = change @ _covariance(best.jac, best.fun, window.residual, usual)[:2, :2] @ change
    spread = max(float(variance / (change @ usual[:2, :2] @ change)), 1.0)
    gain = max(window.unchanged - float(best.cost), 0.0) / spread
    return _Fitted(
        float(best.x[1] - best.x[0]), float(np.sqrt(variance)), float(best.cost), gain, spread, best.x, best.fun
    )


def _settled(
    left: Callable[[Floats], Floats], start: Floats, lowest: Floats, highest: Floats, scale: Floats
) -> OptimizeResult:
    """Figures (count,) at which least is left, from a start."""
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
    """A window in which one figure of the model goes from one value to another."""

    def __init__(self, figure: int, residual: ResidualRecord) -> None:
        self.residual, self.figure = residual, figure
        self.level = max(float(residual.record.fitted[figure]), _LOWEST)
        self.spectrum = rfft(residual.sweep - residual.sweep.mean()) * residual.inside
        others = np.delete(residual.derivatives, figure, axis=0) * self.spectrum
        self.others = orthonormal(residual.weighted(irfft(others, residual.samples)))
        told = residual.speed - residual.taken
        self.told = without_basis(residual.weighted(told - told.mean()), self.others)

    @cached_property
    def unchanged(self) -> float:
        """Half the sum of squares that is left at the best value that does not change."""
        return self._least(lambda figure: self._left(figure, np.ones((1, self.residual.samples))), np.ones(1))

    def freely(self, way: _Fitted) -> float:
        """Half the sum of squares that is left where the figure takes any course, from a way on."""
        begin, end = way.figures[:2]
        course = way.figures[2] < _AT_KNOTS if way.jumps else _AT_KNOTS
        return self._least(self.left_freely, (begin + (end - begin) * course) / self.level)

    def _least(self, left: Callable[[Floats], Floats], start: Floats) -> float:
        """Half the sum of squares that is left at the best values, from some on, in fitted ones."""
        level = np.full(start.size, self.level)
        return float(_settled(left, level * start, _LEAST * level, np.full(start.size, np.inf), level).cost)

    def left_by_jump(self, figures: Floats) -> Floats:
        """Whitened speed (samples,) that is left with the values before and after a jump, and its moment."""
        after = jump(self.residual, figures[2:3])[0]
        return self._left(figures[:2], np.stack([1 - after, after]))

    def left_by_drift(self, figures: Floats) -> Floats:
        """Whitened speed (samples,) that is left with the values at begin and end of an even change."""
        return self.left_freely(figures[0] + (figures[1] - figures[0]) * _AT_KNOTS)

    def left_freely(self, values: Floats) -> Floats:
        """Whitened speed (samples,) that is left with values at the knots (_KNOTS,), and even changes between."""
        weights = np.maximum(1 - np.abs(self.residual.passed - _AT_KNOTS[:, None]) * (_KNOTS - 1), 0.0)
        return self._left(values, weights)

    def _left(self, values: Floats, weights: Floats) -> Floats:
        """With the responses at some values (K,), which count by weights (K, samples)."""
        residual = self.residual
        points = np.tile(residual.record.fitted, (values.size, 1))
        points[:, self.figure] = values
        mobility, _ = command_mobility_with_derivatives(points, residual.record.known, residual.s)
        answers = irfft(mobility * self.spectrum, residual.samples)
        return self.told - without_basis(residual.weighted(np.sum(weights * answers, axis=0)), self.others)


def _covariance(slopes: Floats, error: Floats, residual: ResidualRecord, inverse: Floats) -> Floats:
    """Of fitted figures, by the errors of blocks of the record as they are (White 1980)."""
    products = np.add.reduceat(slopes * error[:, None], block_starts(residual), axis=0)
    return np.asarray(inverse @ (products.T @ products) @ inverse, dtype=float)


def time_candidates(residual: ResidualRecord) -> list[Candidate]:
    """Growth, drift and jump, and clocks that run apart where no command tells that better; none where the sweep does
    not repeat.
    """
    if not residual.periods:
        return []
    derivatives, passed = residual.derivatives, residual.passed
    by_length, by_damping, by_clock = (
        residual.swept(transfer)
        for transfer in (derivatives[LENGTH], derivatives[DAMPING_BHA], -residual.s * residual.mobility)
    )
    duration = residual.samples / residual.record.rate
    drift = (
        [] if residual.record.has_command else [Candidate("clock_drift", ((passed - 0.5) * duration * by_clock)[None])]
    )
    return [
        *drift,
        Candidate("length_growth", ((passed - 0.5) * by_length)[None], one_sided=True),
        Candidate("parameter_drift", ((passed - 0.5) * by_damping)[None]),
        Candidate("regime_change", jump(residual, CHANGES) * by_damping),
    ]


def trend_candidate(residual: ResidualRecord) -> Candidate | None:
    """All that a response which moves evenly would show, whichever figures of the model move; None without periods."""
    if not residual.periods:
        return None
    moved = residual.swept(residual.derivatives[list(_MOVING)])
    return Candidate("trend", (residual.passed - 0.5) * moved, together=True)


def jump(residual: ResidualRecord, moments: Floats) -> Floats:
    """From 0 to 1 at each of some moments (jumps,), shares of the window; shape (jumps, samples)."""
    since = (residual.passed - moments[:, None]) * residual.samples / residual.record.rate
    return np.asarray(np.sin(np.pi / 2 * np.clip(since / _SETTLING_S + 0.5, 0.0, 1.0)) ** 2, dtype=float)

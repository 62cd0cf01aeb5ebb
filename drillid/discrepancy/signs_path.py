"""Sizes of plain changes in time: the response is followed along the way that a figure goes, not by its derivative.

While a figure changes, the speed is at every moment taken as that of the rig as it is then. Begin and size of the
change, and the moment of a jump, are fitted to the whole window; the rig's other figures follow by their derivatives.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft

from drillid.discrepancy.signs_record import Remainder
from drillid.discrepancy.signs_score import Score, block_starts, orthonormal
from drillid.discrepancy.signs_time import CHANGES, jump
from drillid.physics.model import DAMPING_BHA, LENGTH, command_mobility_with_derivatives

Floats = NDArray[np.float64]

FIGURES = {"length_growth": LENGTH, "parameter_drift": DAMPING_BHA, "regime_change": DAMPING_BHA}
"""What changes, of the eight figures of the model, by cause."""
_KNOTS = 5
"""Moments between which an even change's response is interpolated."""
_EVALUATIONS = 30
_LEAST = 1e-3
"""Of a figure's fitted value, below which it does not go."""


def along_the_way(cause: str, found: Score, remainder: Remainder) -> Score:
    """The score of a change in time with the size, and its error, of the change as a whole."""
    from scipy.optimize import least_squares

    way = _Way(cause, remainder)
    moment = CHANGES[int(np.argmax(np.abs(found.amplitudes)))] if way.jumps else 0.5
    level = way.level
    size = max(found.size, -0.9 * level)
    begin = max(level - size * (1 - moment if way.jumps else 0.5), _LEAST * level)
    start = np.array([begin, begin + size, moment][: way.count])
    low = np.array([_LEAST * level, _LEAST * level, CHANGES[0]])[: way.count]
    high = np.array([np.inf, np.inf, CHANGES[-1]])[: way.count]
    scale = np.array([level, level, 0.1])[: way.count]
    start = np.clip(start, low * (1 + 1e-6), high * (1 - 1e-6) if way.jumps else high)
    best = least_squares(
        way.left, start, bounds=(low, high), x_scale=scale, diff_step=1e-4, max_nfev=_EVALUATIONS, xtol=1e-4, ftol=1e-5
    )
    size = float(best.x[1] - best.x[0])
    covariance = _covariance(best.jac, best.fun, remainder)
    error = float(np.sqrt(np.array([-1.0, 1.0]) @ covariance[:2, :2] @ np.array([-1.0, 1.0])))
    return replace(found, size=size, size_error=error)


class _Way:
    """A window whose figure goes from one value to another."""

    def __init__(self, cause: str, remainder: Remainder) -> None:
        self.remainder, self.place = remainder, FIGURES[cause]
        self.jumps = cause == "regime_change"
        self.count = 3 if self.jumps else 2
        record = remainder.record
        self.level = float(record.fitted[self.place])
        self.spectrum = rfft(remainder.sweep - remainder.sweep.mean()) * remainder.inside
        _, derivatives = command_mobility_with_derivatives(record.fitted, record.known, remainder.s)
        others = np.delete(derivatives, self.place, axis=0) * self.spectrum
        self.others = orthonormal(remainder.weighted(irfft(others, remainder.samples)))
        told = remainder.speed - remainder.taken
        self.told = self._without_others(remainder.weighted(told - told.mean()))

    def left(self, figures: Floats) -> Floats:
        """Whitened speed (samples,) that is left with the figure's values at begin and end, and the jump's moment."""
        remainder = self.remainder
        passed = (np.arange(remainder.samples) + 0.5) / remainder.samples
        if self.jumps:
            after = jump(remainder, figures[2:3])[0]
            values, weights = figures[:2], np.stack([1 - after, after])
        else:
            knots = np.linspace(0.0, 1.0, _KNOTS)
            values = figures[0] + (figures[1] - figures[0]) * knots
            weights = np.maximum(1 - np.abs(passed - knots[:, None]) * (_KNOTS - 1), 0.0)
        points = np.tile(remainder.record.fitted, (values.size, 1))
        points[:, self.place] = values
        mobility, _ = command_mobility_with_derivatives(points, remainder.record.known, remainder.s)
        answers = irfft(mobility * self.spectrum, remainder.samples)
        return self.told - self._without_others(remainder.weighted(np.sum(weights * answers, axis=0)))

    def _without_others(self, series: Floats) -> Floats:
        return np.asarray(series - (series @ self.others.T) @ self.others, dtype=float)


def _covariance(slopes: Floats, error: Floats, remainder: Remainder) -> Floats:
    """Of fitted figures, by the errors of blocks of the record as they are (White 1980)."""
    inverse = np.linalg.pinv(slopes.T @ slopes)
    products = np.add.reduceat(slopes * error[:, None], block_starts(remainder), axis=0)
    return np.asarray(inverse @ (products.T @ products) @ inverse, dtype=float)

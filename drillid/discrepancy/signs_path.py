"""Sizes of plain changes in time: the response is followed along the way that a figure goes, not by its derivative.

While a figure changes, the speed is at every moment taken as that of the rig as it is then. Begin and size of the
change, and the moment of a jump, are fitted to the whole window; the rig's other figures follow by their derivatives.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft

from drillid.discrepancy.signs_record import Remainder
from drillid.discrepancy.signs_score import Score, block_starts, orthonormal
from drillid.discrepancy.signs_time import CHANGES, jump
from drillid.physics.model import DAMPING_BHA, LENGTH, command_mobility_with_derivatives

Floats = NDArray[np.float64]

_FIGURES = {"length_growth": LENGTH, "parameter_drift": DAMPING_BHA, "regime_change": DAMPING_BHA}
"""What changes, of the eight figures of the model, by cause."""
_KNOTS = 5
"""Moments between which an even change's response is interpolated."""
_EVALUATIONS = 30
_LEAST = 1e-3
"""Of a figure's fitted value, below which it does not go."""
_LOWEST = 1.0
"""N m s/rad, or m, that a fitted value is taken for at least."""


def along_the_way(scores: dict[str, Score], remainder: Remainder, plain: float) -> dict[str, Score]:
    """Scores with the sizes of changes from the score `plain` on, and their errors, told by the change as a whole.

    Of causes that move the same figure, the one whose way fits best has the best score, and the others fall behind it
    as their ways do.
    """
    scores = dict(scores)
    for figure in dict.fromkeys(_FIGURES.values()):
        causes = [cause for cause in scores if _FIGURES.get(cause) == figure]
        best = max((scores[cause] for cause in causes), key=lambda one: one.normal, default=None)
        if best is None or best.normal < plain:
            continue
        fitted = {cause: _fitted(cause, scores[cause], remainder) for cause in causes}
        least = min(one.misfit for one in fitted.values())
        for cause, way in fitted.items():
            behind = way.misfit - least
            scores[cause] = replace(
                scores[cause],
                normal=float(np.sqrt(max(best.normal**2 - 2 * behind, 0.0))),
                log_ratio=max(best.log_ratio - behind, 0.0),
                size=way.size,
                size_error=way.size_error,
            )
    return scores


class _Fitted(NamedTuple):
    """A way at its best."""

    size: float
    size_error: float
    misfit: float
    """Half the sum of squares, and one for each fitted figure (Akaike 1974)."""


def _fitted(cause: str, found: Score, remainder: Remainder) -> _Fitted:
    from scipy.optimize import least_squares

    way = _Way(cause, remainder)
    moment = CHANGES[int(np.argmax(np.abs(found.amplitudes)))] if way.jumps else 0.5
    low = np.array([_LEAST * way.level, _LEAST * way.level, CHANGES[0]])[: way.count]
    high = np.array([np.inf, np.inf, CHANGES[-1]])[: way.count]
    # the fitted value is about the mean over the window
    begin = way.level - found.size * (1 - moment)
    start = np.clip(np.array([begin, begin + found.size, moment])[: way.count], low * (1 + _LEAST), high)
    scale = np.array([way.level, way.level, 0.1])[: way.count]
    best = least_squares(
        way.left, start, bounds=(low, high), x_scale=scale, diff_step=1e-4, max_nfev=_EVALUATIONS, xtol=1e-4, ftol=1e-5
    )
    change = np.array([-1.0, 1.0])
    error = float(np.sqrt(change @ _covariance(best.jac, best.fun, remainder)[:2, :2] @ change))
    return _Fitted(float(best.x[1] - best.x[0]), error, float(best.cost) + way.count)


class _Way:
    """A window whose figure goes from one value to another."""

    def __init__(self, cause: str, remainder: Remainder) -> None:
        self.remainder, self.place = remainder, _FIGURES[cause]
        self.jumps = cause == "regime_change"
        self.count = 3 if self.jumps else 2
        record = remainder.record
        self.level = max(float(record.fitted[self.place]), _LOWEST)
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

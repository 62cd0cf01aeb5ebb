"""A law learnt in time where a misfit is not linear: torque of the bit against its speed, with or without a memory, or
twist of a coupling against its torque, as a free cubic spline.

The base model holds the law's tangent at each window's mean, so that only its curvature is left to find: piecewise
linear, its double integral a cubic spline. The law of the speed control also has a slope, as the base model has taken
the gain that answers the sweep for that of small errors. The part of the speed that repeats with the sweep is what the
base model predicts, plus what `drillid.simulation` adds with the law to the same rig without it; so errors of the
simulation are those of a difference. The kind of law is the one that explains most to first order; it is fitted by
Gauss and Newton to the harmonics of the sweep's period, the number of knots is the one that predicts left-out windows
best, and windows that took no part judge the offer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drillid.arrays import Booleans, Complex, Floats
from drillid.discrepancy.learning.fingerprint import Described, Fingerprint
from drillid.discrepancy.learning.law_kinds import PLACES_APART, LawKind, screened
from drillid.discrepancy.learning.law_spline import LawSpline
from drillid.discrepancy.learning.law_window import LawWindow
from drillid.discrepancy.predictive_gain import PredictiveGain
from drillid.discrepancy.rules import NEIGHBOURS_SHARE_VARIANCE
from drillid.statistics import TWO_SIDED

KNOTS = (1, 2, 4)
"""Numbers of knots of the curvature that are tried."""
MOST_WINDOWS = 8
"""Windows that are simulated, evenly chosen."""
_ROUNDS = 2
_BEND, _TILT = 0.3, 0.03
"""Steps of curvatures and of the slope in finite differences, in units in which the law bends by the kind's scale over
its range, and is as steep.
"""
_WIDE = 3.0
"""Prior standard deviation of each in these units."""
_EVERY = 3
"""One window in so many is held back."""


@dataclass(frozen=True, eq=False)
class LearntLaw:
    """A law that was learnt, with its gain on data that it has not seen."""

    kind: LawKind
    spline: LawSpline
    covariance: Floats
    """(K + 1, K + 1) of its slope at the mean, 0 where that is not fitted, and of its second derivatives."""
    slope_in_model: float
    """Slope of the law at the mean in the base model, N m s/rad; 0 where that does not determine it."""
    mean: float
    """Mean over the windows of what the law acts on, rad/s or N m."""
    evidence: float
    """Log Bayes factor of the law against none, in the data that learning saw."""
    gain: PredictiveGain
    held_out: int
    """Row of one of the windows that judged it."""

    @property
    def offered(self) -> bool:
        """Whether the data that learning saw support it, and the lower limit of the gain is above zero."""
        return self.evidence > 0 and self.gain.low > 0

    @property
    def change(self) -> tuple[float, float]:
        """Change of the slope over the range, as the kind counts it, and its standard error."""
        factors = self.kind.change(self.spline)
        return float(factors @ self.spline.values), float(np.sqrt(factors @ self.covariance[1:, 1:] @ factors))

    @property
    def words(self) -> str:
        """The law by the change of its slope over its range, with the 95 % interval of that."""
        change, error = (self.kind.words_scale * value for value in self.change)
        return self.kind.words(f"{change:.3g} ± {TWO_SIDED * error:.2g}", self.spline)

    @property
    def fingerprint(self) -> Fingerprint:
        """The change of its slope relative to its range, and its place where that was sought."""
        per_change, place = self.kind.per_change(self.spline), self.kind.place
        change, error = (per_change * value for value in self.change)
        values, variances = [change], [error**2]
        if place is not None:
            values, variances = [*values, place], [*variances, PLACES_APART**2 / 3]
        return Fingerprint(self.evidence, (Described(self.kind.element, np.array(values), np.diag(variances), 0.0),))

    def drawn(self) -> tuple[Floats, Floats, Floats]:
        """Places (POINTS,), the law about its value at the mean, and its standard errors."""
        own = self.spline
        grid, law = own.drawn(self.mean)
        units = [replace(own, slope=row[0], values=row[1:]) for row in np.eye(own.values.size + 1)]
        slopes = np.stack([unit.drawn(self.mean)[1] for unit in units])
        error = np.sqrt(np.einsum("kp,kl,lp->p", slopes, self.covariance, slopes))
        return grid, law + self.slope_in_model * (grid - self.mean), error


class _Fit:
    """A law with some number of knots fitted to windows; coefficients are its slope, where fitted, and curvatures."""

    def __init__(self, kind: LawKind, windows: Sequence[LawWindow], knots: int) -> None:
        swings = [float(np.abs(kind.swing(window)).max()) for window in windows]
        means = [kind.mean(window) for window in windows]
        self.low = min(mean - swing for mean, swing in zip(means, swings, strict=True))
        self.high = max(mean + swing for mean, swing in zip(means, swings, strict=True))
        self.kind, self.windows = kind, windows
        # one knot is a constant curvature
        self.knots = np.linspace(self.low, self.high, knots)
        scale = max(map(kind.scale, windows))
        bends = np.full(knots, scale / (self.high - self.low))
        self.units = np.append(scale, bends) if kind.has_slope else bends
        self.steps = np.append(_TILT, np.full(knots, _BEND))[-self.units.size :]

    def spline(self, coefficients: Floats) -> LawSpline:
        """The law with coefficients (C,) in their units."""
        values = self.units * coefficients
        slope = float(values[0]) if self.kind.has_slope else 0.0
        return LawSpline(self.knots, values[-self.knots.size :], self.low, self.high, slope)

    def covariance(self, covariance: Floats) -> Floats:
        """Covariance of slope and second derivatives (K + 1, K + 1), from that of the coefficients in their units."""
        own = np.outer(self.units, self.units) * covariance
        return np.asarray(own if self.kind.has_slope else np.pad(own, (1, 0)), dtype=float)

    def added(self, window: int, coefficients: Floats) -> Complex:
        """Whitened change of a window's harmonics by the law, (lines,)."""
        own = self.windows[window]
        if not coefficients.any():
            return np.zeros(own.s.size, dtype=complex)
        return added(self.kind, own, self.spline(coefficients))

    def expanded(self, window: int, coefficients: Floats) -> tuple[Complex, Complex]:
        """The change (lines,) and its derivatives (C, lines)."""
        now = self.added(window, coefficients)
        slopes = [(self.added(window, coefficients + step) - now) / step.sum() for step in np.diag(self.steps)]
        return now, np.stack(slopes)


def added(kind: LawKind, window: LawWindow, spline: LawSpline) -> Complex:
    """Whitened change of a window's harmonics by a law, (lines,)."""
    return np.asarray(kind.added(window, *spline.drawn(kind.mean(window))) / window.error, dtype=complex)


@dataclass(frozen=True, eq=False)
class _Equations:
    """Normal equations of each window about a point, (W, K, K) and (W, K)."""

    point: Floats
    matrix: Floats
    vector: Floats

    @classmethod
    def about(cls, fit: _Fit, point: Floats, kept: Sequence[Booleans]) -> _Equations:
        """The equations from the lines that are kept in each window."""
        matrices, vectors = [], []
        for number, (window, lines) in enumerate(zip(fit.windows, kept, strict=True)):
            now, slopes = fit.expanded(number, point)
            rest, columns = (window.residual - now)[lines], slopes[:, lines]
            matrices.append((columns.conj() @ columns.T).real)
            vectors.append((columns.conj() @ rest).real)
        return cls(point, np.stack(matrices), np.stack(vectors))

    def solved(self, without: int | None = None) -> tuple[Floats, Floats]:
        """Coefficients and their covariance, from all windows, or from all but one where that is given."""
        kept = [number for number in range(self.matrix.shape[0]) if number != without]
        precision = self.matrix[kept].sum(0) + np.eye(self.point.size) / _WIDE**2
        covariance = np.linalg.inv(precision)
        step = covariance @ (self.vector[kept].sum(0) - self.point / _WIDE**2)
        return self.point + step, covariance

    def evidence(self, excess: float) -> float:
        """Log Bayes factor of coefficients with their prior against none, from the equations about the point.

        Parameters
        ----------
        excess : factor on the variance of the residuals
        """
        matrix = self.matrix.sum(0) / excess
        vector = self.vector.sum(0) / excess + matrix @ self.point
        covariance = np.linalg.inv(matrix + np.eye(self.point.size) / _WIDE**2)
        occam = float(np.linalg.slogdet(np.eye(self.point.size) + _WIDE**2 * matrix)[1])
        return 0.5 * float(vector @ covariance @ vector) - 0.5 * occam


def learnt_law(windows: Sequence[LawWindow]) -> LearntLaw:
    """Learn a law from some windows, and judge it on the others.

    Of a single window every other harmonic is held back.
    """
    seen, held = _parts(windows)
    training = [number for number, lines in enumerate(seen) if lines.any()]
    own, lines = [windows[number] for number in training], [seen[number] for number in training]
    kind = max(screened(own, lines), key=lambda each: each.statistic).kind
    fits = {knots: _Fit(kind, own, knots) for knots in KNOTS}
    equations = {knots: _Equations.about(fit, np.zeros(fit.units.size), lines) for knots, fit in fits.items()}
    knots = min(KNOTS, key=lambda number: _missed(equations[number]))
    fit, about = fits[knots], equations[knots]
    for _ in range(_ROUNDS - 1):
        about = _Equations.about(fit, about.solved()[0], lines)
    coefficients, covariance = about.solved()
    spline = fit.spline(coefficients)
    slope = float(np.mean([kind.slope_in_model(window) for window in windows]))
    mean = float(np.mean([kind.mean(window) for window in windows]))
    excess, gain = _gain(kind, windows, held, spline)
    evidence, last = (
        about.evidence(excess),
        max(each.row for each, used in zip(windows, held, strict=True) if used.any()),
    )
    return LearntLaw(kind, spline, excess * fit.covariance(covariance), slope, mean, evidence, gain, last)


def _parts(windows: Sequence[LawWindow]) -> tuple[list[Booleans], list[Booleans]]:
    """Lines of each window that are for learning, and those that are held back."""
    if len(windows) == 1:
        # in pairs, as what a law adds to a sweep of odd harmonics has even ones alone
        second = np.arange(windows[0].s.size) // 2 % 2 == 1
        return [~second], [second]
    is_held = [number % _EVERY == 1 for number in range(len(windows))]
    held = [np.full(window.s.size, each) for window, each in zip(windows, is_held, strict=True)]
    return [~each for each in held], held


def _missed(equations: _Equations) -> float:
    """Half the squared error of left-out windows, to first order, less that without a law; for a single window the
    negative log evidence.
    """
    count = equations.matrix.shape[0]
    if count == 1:
        return -equations.evidence(1.0)
    total = 0.0
    for number in range(count):
        found = equations.solved(number)[0] - equations.point
        total += 0.5 * float(found @ equations.matrix[number] @ found) - float(found @ equations.vector[number])
    return total


def _gain(
    kind: LawKind, windows: Sequence[LawWindow], held: Sequence[Booleans], spline: LawSpline
) -> tuple[float, PredictiveGain]:
    """Factor on variances by what neither model explains, and the gain on the lines held back, per window."""
    total = power = squares = 0.0
    count = lines_held = 0
    for window, lines in zip(windows, held, strict=True):
        if not lines.any():
            continue
        change = added(kind, window, spline)[lines]
        before = window.residual[lines]
        total += 0.5 * float(np.sum(np.abs(before) ** 2 - np.abs(before - change) ** 2))
        power += float(np.sum(np.abs(change) ** 2))
        squares += float(np.sum(np.abs(before - change) ** 2))
        count, lines_held = count + 1, lines_held + int(lines.sum())
    excess = max(squares / (2 * lines_held), 1.0)
    error = float(np.sqrt(NEIGHBOURS_SHARE_VARIANCE * excess * power))
    # scores of a misfit that neither model explains count by their own variance
    whole = count if len(windows) > 1 else 0
    return excess, PredictiveGain(total / excess / count, error / excess / count, whole)

"""A law of the bit learnt in time where an unknown misfit is not linear: torque against speed, as a free cubic spline.

The base model holds the law's tangent at each window's mean speed, so that the law is told by its curvature alone:
piecewise linear in speed, its double integral a cubic spline. The part of the speed that repeats with the sweep is what
the base model predicts, plus what `drillid.simulation` adds with the law to the same rig without it; so errors of the
simulation are those of a difference. Curvatures are fitted by Gauss and Newton to the harmonics of the sweep's period,
the number of knots is the one that predicts left-out windows best, and windows that took no part judge the offer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.integrate import cumulative_trapezoid

from drillid.arrays import Booleans, Complex, Floats
from drillid.discrepancy.catalogue import WindowModel
from drillid.discrepancy.predictive_gain import PredictiveGain
from drillid.discrepancy.rules import NEIGHBOURS_SHARE_VARIANCE
from drillid.physics.equipment import DrillingSystem
from drillid.physics.nonlinear import NonlinearRig, SpeedLaw
from drillid.physics.responses import bit_speed_ratio, laplace
from drillid.simulation.simulate import simulate
from drillid.statistics import TWO_SIDED
from drillid.units import RPM

KNOTS = (1, 2, 4)
"""Numbers of knots of the curvature that are tried."""
POINTS = 41
"""Speeds at which a law is drawn."""
MOST_WINDOWS = 8
"""Windows that are simulated, evenly chosen."""
_RATE, _TIME_STEP = 50.0, 0.005
"""Hz of simulated samples, and s."""
_LEAST_PERIODS = 2
_SMOOTHED = 15
"""Harmonics over which the logarithm of the noise is averaged."""
_LEAST_VARIANCE = 1e-30
_ROUNDS = 2
_STEP = 0.3
"""Step of a curvature in finite differences, in units in which the law bends by the base's damping over its range."""
_WIDE = 3.0
"""Prior standard deviation of a curvature in these units."""
_EVERY = 3
"""Of so many windows one is held back."""


@dataclass(frozen=True, eq=False)
class LawWindow:
    """One window: the base model of it, and the harmonics of its sweep's period.

    s, sweep, speed, variance : (lines,), Laplace variable, mean sweep (N m) and speed (rad/s), variance of the latter
    period : (samples,) N m at _RATE, mean period of the sweep
    """

    window_model: WindowModel
    mean_speed: float
    s: Complex
    sweep: Complex
    speed: Complex
    variance: Floats
    period: Floats

    @classmethod
    def of(
        cls,
        window_model: WindowModel,
        channels: tuple[Floats, Floats],
        rate: float,
        period: float,
        band: tuple[float, float],
    ) -> LawWindow | None:
        """From sweep and speed, (samples,) each at `rate`; None of fewer than two whole periods.

        Parameters
        ----------
        window_model : of this window alone
        period : s, of the sweep
        band : Hz, in which harmonics are compared
        """
        whole = int(channels[0].size / rate / period) if period > 0 else 0
        if whole < _LEAST_PERIODS or not np.isfinite(channels).all():
            return None
        samples = round(period * _RATE)
        time = np.arange(whole * samples) * (period / samples)
        sweep, speed = (np.interp(time, np.arange(each.size) / rate, each) for each in channels)
        lines = np.fft.rfft(speed) / speed.size
        count = lines.size // whole
        frequency = np.arange(count) / period
        kept = (frequency >= band[0]) & (frequency <= band[1])
        mean_sweep = sweep.reshape(whole, -1).mean(axis=0)
        return cls(
            window_model,
            float(speed.mean()),
            laplace(frequency[kept]),
            (np.fft.rfft(mean_sweep)[:count] / samples)[kept],
            lines[: count * whole : whole][kept],
            _noise(lines[: count * whole], whole)[kept],
            mean_sweep - mean_sweep.mean(),
        )

    @property
    def error(self) -> Floats:
        """Standard deviation of real and imaginary part, (lines,)."""
        return np.sqrt(self.variance / 2)

    @cached_property
    def residual(self) -> Complex:
        """Whitened speed that the base model does not predict, (lines,)."""
        predicted = self.window_model.mobility(self.s) * self.sweep
        return np.asarray((self.speed - predicted) / self.error, dtype=complex)

    @property
    def bit_swing(self) -> float:
        """rad/s, greatest deviation of the bit's speed from its mean, as the sweep drives it."""
        lines = self.window_model.mobility(self.s) * self.sweep * bit_speed_ratio(self.window_model.system, self.s)
        spectrum = np.zeros(self.period.size // 2 + 1, dtype=complex)
        first = round(self.s[0].imag / (2 * np.pi) * self.period.size / _RATE)
        spectrum[first : first + lines.size] = lines
        return float(np.abs(np.fft.irfft(spectrum * self.period.size, self.period.size)).max())

    def added(self, law: SpeedLaw) -> Complex:
        """Whitened change of the harmonics by a law, (lines,)."""
        return np.asarray((self._simulated(law) - self._still) / self.error, dtype=complex)

    @cached_property
    def _still(self) -> Complex:
        """Harmonics without a law."""
        return self._simulated(None)

    def _simulated(self, law: SpeedLaw | None) -> Complex:
        """Harmonics of the top drive's speed, (lines,), in the second of two simulated periods."""
        system: DrillingSystem = self.window_model.system
        steps = round(1 / _RATE / _TIME_STEP)
        sweep = np.tile(_finer(self.period, steps), 2)
        still = np.zeros(sweep.size)
        result = simulate(
            NonlinearRig(system, law=law),
            sweep,
            still + self.mean_speed,
            still,
            time_step=_TIME_STEP,
            sample_interval=1 / _RATE,
        )
        spectrum = np.fft.rfft(result.speed[self.period.size :]) / self.period.size
        places = np.rint(self.s.imag / (2 * np.pi) * self.period.size / _RATE).astype(int)
        return np.asarray(spectrum[places], dtype=complex)


def _noise(lines: Complex, whole: int) -> Floats:
    """Variance of each harmonic (lines,) from the lines between harmonics, by the mean of their logarithms."""
    between = np.log(np.maximum(np.abs(lines.reshape(-1, whole)[:, 1:]) ** 2, _LEAST_VARIANCE)).mean(axis=1)
    # half of the lines that belong to a harmonic lie below it
    around = (between + np.concatenate([between[:1], between[:-1]])) / 2
    mean = np.convolve(np.pad(around, _SMOOTHED // 2, mode="edge"), np.ones(_SMOOTHED) / _SMOOTHED, "valid")
    return np.asarray(np.exp(mean + np.euler_gamma), dtype=float)


def _finer(period: Floats, factor: int) -> Floats:
    """A periodic series at a rate that is higher by a whole factor."""
    lines = np.fft.rfft(period)
    return np.asarray(np.fft.irfft(lines, factor * period.size) * factor, dtype=float)


@dataclass(frozen=True, eq=False)
class Curvature:
    """Second derivative of a law, linear between knots over a range of speed."""

    knots: Floats
    """(K,) rad/s."""
    values: Floats
    """(K,) N m s²/rad²."""
    low: float
    high: float
    """rad/s, range beyond which the law is straight."""

    def drawn(self, speed: float) -> tuple[Floats, Floats]:
        """Speeds (POINTS,) and torques of the law less its tangent at a speed, N m."""
        grid = np.linspace(self.low, self.high, POINTS)
        second = np.interp(grid, self.knots, self.values)
        slope = cumulative_trapezoid(second, grid, initial=0)
        torque = cumulative_trapezoid(slope, grid, initial=0)
        tangent = np.interp(speed, grid, torque) + np.interp(speed, grid, slope) * (grid - speed)
        return grid, torque - tangent

    @property
    def bend(self) -> Floats:
        """Factors (K,) of the values in the slope at the upper end less that at the lower, rad/s."""
        grid = np.linspace(self.low, self.high, POINTS)
        return np.array([np.trapezoid(np.interp(grid, self.knots, row), grid) for row in np.eye(self.knots.size)])

    def law_at(self, speed: float) -> SpeedLaw:
        """What it adds to the base model of a window of this mean speed."""
        return SpeedLaw(*self.drawn(speed))


@dataclass(frozen=True, eq=False)
class LearntLaw:
    """A law that was learnt, with its gain on data that it has not seen."""

    curvature: Curvature
    covariance: Floats
    """(K, K) of its values."""
    damping: float
    """N m s/rad, slope of the law at the mean speed, which the base model has."""
    mean_speed: float
    """rad/s."""
    evidence: float
    """Log Bayes factor of the law against a straight one, in the data that learning saw."""
    gain: PredictiveGain

    @property
    def offered(self) -> bool:
        """Whether the data that learning saw speak for it, and the lower limit of the gain is above zero."""
        return self.evidence > 0 and self.gain.low > 0

    @property
    def words(self) -> str:
        """The law by its slope at either end of its range, with the 95 % interval of their difference."""
        own = self.curvature
        rise = float(own.bend @ own.values)
        error = TWO_SIDED * float(np.sqrt(own.bend @ self.covariance @ own.bend))
        return (
            f"the bit's damping changes by {rise:.3g} ± {error:.2g} N m s/rad from {own.low / RPM:.0f} to "
            f"{own.high / RPM:.0f} rpm, a cubic spline of its speed"
        )

    def drawn(self) -> tuple[Floats, Floats, Floats]:
        """Speeds (POINTS,), torques about that at the mean speed, and the standard errors of their bend, N m."""
        own = self.curvature
        grid, bend = own.drawn(self.mean_speed)
        units = (Curvature(own.knots, row, own.low, own.high) for row in np.eye(own.values.size))
        slopes = np.stack([unit.drawn(self.mean_speed)[1] for unit in units])
        error = np.sqrt(np.einsum("kp,kl,lp->p", slopes, self.covariance, slopes))
        return grid, bend + self.damping * (grid - self.mean_speed), error


class _Fit:
    """Curvatures of one number of knots fitted to windows."""

    def __init__(self, windows: Sequence[LawWindow], knots: int) -> None:
        swings = [window.bit_swing for window in windows]
        speeds = [window.mean_speed for window in windows]
        self.low = min(speed - swing for speed, swing in zip(speeds, swings, strict=True))
        self.high = max(speed + swing for speed, swing in zip(speeds, swings, strict=True))
        self.windows = windows
        # one knot is a constant curvature
        self.knots = np.linspace(self.low, self.high, knots)
        pipes = (window.window_model.system.string[0] for window in windows)
        characteristic = max(float(pipe.characteristic_admittance) for pipe in pipes)
        self.unit = characteristic / (self.high - self.low)

    def curvature(self, coefficients: Floats) -> Curvature:
        """The curvature of coefficients (K,) in units."""
        return Curvature(self.knots, self.unit * coefficients, self.low, self.high)

    def added(self, window: int, coefficients: Floats) -> Complex:
        """Whitened change of a window's harmonics by the law, (lines,)."""
        own = self.windows[window]
        if not coefficients.any():
            return np.zeros(own.s.size, dtype=complex)
        return own.added(self.curvature(coefficients).law_at(own.mean_speed))

    def expanded(self, window: int, coefficients: Floats) -> tuple[Complex, Complex]:
        """The change (lines,) and its derivatives (K, lines)."""
        now = self.added(window, coefficients)
        steps = _STEP * np.eye(coefficients.size)
        slopes = [(self.added(window, coefficients + step) - now) / _STEP for step in steps]
        return now, np.stack(slopes)


@dataclass(frozen=True, eq=False)
class _Equations:
    """Normal equations of each window about a point, (W, K, K) and (W, K)."""

    point: Floats
    matrix: Floats
    vector: Floats

    @classmethod
    def about(cls, fit: _Fit, point: Floats, kept: Sequence[Booleans]) -> _Equations:
        """Of the lines that are kept in each window."""
        matrices, vectors = [], []
        for number, (window, lines) in enumerate(zip(fit.windows, kept, strict=True)):
            now, slopes = fit.expanded(number, point)
            rest, columns = (window.residual - now)[lines], slopes[:, lines]
            matrices.append((columns.conj() @ columns.T).real)
            vectors.append((columns.conj() @ rest).real)
        return cls(point, np.stack(matrices), np.stack(vectors))

    def solved(self, without: int | None = None) -> tuple[Floats, Floats]:
        """Coefficients and their covariance, from all windows but one."""
        kept = [number for number in range(self.matrix.shape[0]) if number != without]
        precision = self.matrix[kept].sum(0) + np.eye(self.point.size) / _WIDE**2
        covariance = np.linalg.inv(precision)
        step = covariance @ (self.vector[kept].sum(0) - self.point / _WIDE**2)
        return self.point + step, covariance

    def evidence(self, excess: float) -> float:
        """Log Bayes factor of coefficients with their prior against none, by the equations about the point.

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
    """Learn the curvature of the bit's torque from some windows, and judge it on the others.

    Of a single window every other harmonic is held back.
    """
    seen, held = _parts(windows)
    training = [number for number, lines in enumerate(seen) if lines.any()]
    own, lines = [windows[number] for number in training], [seen[number] for number in training]
    fits = {knots: _Fit(own, knots) for knots in KNOTS}
    equations = {knots: _Equations.about(fit, np.zeros(knots), lines) for knots, fit in fits.items()}
    knots = min(KNOTS, key=lambda number: _missed(equations[number]))
    fit, about = fits[knots], equations[knots]
    for _ in range(_ROUNDS - 1):
        about = _Equations.about(fit, about.solved()[0], lines)
    coefficients, covariance = about.solved()
    curvature = fit.curvature(coefficients)
    damping = float(np.mean([float(window.window_model.system.bit.damping) for window in windows]))
    mean_speed = float(np.mean([window.mean_speed for window in windows]))
    excess, gain = _gain(windows, held, curvature)
    evidence = about.evidence(excess)
    return LearntLaw(curvature, excess * fit.unit**2 * covariance, damping, mean_speed, evidence, gain)


def _parts(windows: Sequence[LawWindow]) -> tuple[list[Booleans], list[Booleans]]:
    """Lines of each window that are for learning, and those that are held back."""
    if len(windows) == 1:
        odd = np.arange(windows[0].s.size) % 2 == 1
        return [~odd], [odd]
    is_held = [number % _EVERY == 1 for number in range(len(windows))]
    held = [np.full(window.s.size, each) for window, each in zip(windows, is_held, strict=True)]
    return [~each for each in held], held


def _missed(equations: _Equations) -> float:
    """Half the squared error of left-out windows, to first order, less that without a law; of one window the fit's."""
    count = equations.matrix.shape[0]
    total = 0.0
    for number in range(count):
        found = equations.solved(number if count > 1 else None)[0] - equations.point
        total += 0.5 * float(found @ equations.matrix[number] @ found) - float(found @ equations.vector[number])
    return total + (equations.point.size if count == 1 else 0.0)


def _gain(windows: Sequence[LawWindow], held: Sequence[Booleans], curvature: Curvature) -> tuple[float, PredictiveGain]:
    """Factor on variances by what neither model explains, and the gain on the lines held back, per window."""
    total = power = squares = 0.0
    count = lines_held = 0
    for window, lines in zip(windows, held, strict=True):
        if not lines.any():
            continue
        added = window.added(curvature.law_at(window.mean_speed))[lines]
        before = window.residual[lines]
        total += 0.5 * float(np.sum(np.abs(before) ** 2 - np.abs(before - added) ** 2))
        power += float(np.sum(np.abs(added) ** 2))
        squares += float(np.sum(np.abs(before - added) ** 2))
        count, lines_held = count + 1, lines_held + int(lines.sum())
    excess = max(squares / (2 * lines_held), 1.0)
    error = float(np.sqrt(NEIGHBOURS_SHARE_VARIANCE * excess * power))
    # scores of a misfit that neither model explains count by their own variance
    whole = count if len(windows) > 1 else 0
    return excess, PredictiveGain(total / excess / count, error / excess / count, whole)

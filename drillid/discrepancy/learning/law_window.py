"""One window from which a law is learnt: its base model, and the harmonics of its sweep's period with their noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.discrepancy.catalogue import WindowModel
from drillid.physics.nonlinear import NonlinearRig
from drillid.physics.responses import laplace
from drillid.simulation.simulate import simulate
from drillid.spectra.periodic import whole_periods

RATE = 50.0
"""Hz, of simulated samples."""
TIME_STEP = 0.005
"""s, of simulated laws."""
_LEAST_PERIODS = 2
_SMOOTHED = 15
"""Harmonics over which the logarithm of the noise is averaged."""
_LEAST_VARIANCE = 1e-30


@dataclass(frozen=True, eq=False)
class LawWindow:
    """One window: the base model of it, and the harmonics of its sweep's period.

    s, sweep, speed, variance : (lines,), Laplace variable, mean sweep (N m) and speed (rad/s), variance of the latter
    period : (samples,) N m at RATE, mean period of the sweep
    """

    window_model: WindowModel
    mean_speed: float
    """rad/s."""
    mean_torque: float
    """N m, of the command; 0 where it is not known, so that torques are about their mean."""
    row: int
    """Row of the window in its set."""
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
        mean_torque: float = 0.0,
        row: int = 0,
    ) -> LawWindow | None:
        """From sweep and speed, (samples,) each at `rate`; None for fewer than two whole periods.

        Parameters
        ----------
        window_model : of this window alone
        period : s, of the sweep
        band : Hz, in which harmonics are compared
        """
        whole = whole_periods(channels[0].size, rate, period) if period > 0 else 0
        if whole < _LEAST_PERIODS or not np.isfinite(channels).all():
            return None
        samples = round(period * RATE)
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
            mean_torque,
            row,
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
    def seconds(self) -> float:
        """Period of the sweep."""
        return self.period.size / RATE

    @cached_property
    def whole_sweep(self) -> tuple[Complex, Complex]:
        """Laplace variable and harmonics of the mean sweep, N m, at all lines but the mean."""
        lines = np.fft.rfft(self.period) / self.period.size
        return laplace(np.arange(1, lines.size) / self.seconds), np.asarray(lines[1:], dtype=complex)

    def series(self, lines: Complex) -> Floats:
        """One period (samples,) of what has these harmonics, at all lines but the mean."""
        size = self.period.size
        return np.asarray(np.fft.irfft(size * np.append(0.0, lines), size), dtype=float)

    def harmonics(self, series: Floats) -> Complex:
        """Harmonics (lines,) of one period of a series (samples,)."""
        return np.asarray((np.fft.rfft(series) / self.period.size)[self._places], dtype=complex)

    @cached_property
    def _places(self) -> np.ndarray:
        return np.rint(self.s.imag / (2 * np.pi) * self.period.size / RATE).astype(int)

    @cached_property
    def still(self) -> Complex:
        """Harmonics of the simulated base model, (lines,)."""
        return self.simulated(NonlinearRig(self.window_model.system), self.mean_speed)

    def simulated(self, rig: NonlinearRig, mean_speed: float) -> Complex:
        """Harmonics of a rig's top-drive speed under the sweep, (lines,), in the second of two simulated periods."""
        steps = round(1 / RATE / TIME_STEP)
        sweep = np.tile(_finer(self.period, steps), 2)
        still = np.zeros(sweep.size)
        result = simulate(rig, sweep, still + mean_speed, still, time_step=TIME_STEP, sample_interval=1 / RATE)
        return self.harmonics(result.speed[self.period.size :])


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

"""Recorded signals from simulated ones: filter, clock, sampling, noise, scale, resolution.

A recorder reads the sensor's signal at the simulation's fine interval and records it at its own. It acts in the
order of a real measurement chain: disturbance at the sensor, filter, clock, sampling, scale, resolution.
"""

from dataclasses import dataclass

import numpy as np

from drillid.arrays import Floats
from drillid.errors import SettingsError

_ROUNDING = 1e-9
"""Of the interval of held samples."""


@dataclass(frozen=True)
class Tone:
    """A tonal disturbance at the sensor; above half the recorder's rate it is aliased unless filtered out."""

    frequency: float
    """Hz."""
    amplitude: float
    """Unit of the signal."""
    phase: float = 0.0
    """rad at the signal's first sample."""


@dataclass(frozen=True)
class Recorder:
    """How one channel is recorded; the defaults record every n-th sample unchanged."""

    interval: float
    """s, between rows, a whole number of the signal's intervals."""
    filter_frequency: float = np.inf
    """Hz, corner of a Butterworth low pass before sampling, such as an anti-alias filter."""
    filter_order: int = 2
    clock_offset: float = 0.0
    """s; positive where the row at time t holds the signal of t − offset."""
    clock_drift: float = 0.0
    """s/s, growth rate of the offset."""
    tones: tuple[Tone, ...] = ()
    noise: float = 0.0
    """Root mean square of white noise in the rows, unit of the signal."""
    scale: float = 1.0
    """Recorded per true value; −1 for a wrong sign, 1.3558 for ft-lbf read as N m."""
    resolution: float = 0.0
    """Quantisation step of the recorded values; 0 for none."""
    held: float = 0.0
    """s, interval of samples that rows hold until the next one; 0 where every row is a sample of its own."""

    def record(self, signal: Floats, signal_interval: float, generator: np.random.Generator | None = None) -> Floats:
        """Rows of a signal.

        Parameters
        ----------
        signal : (samples,), extended by its first and last value
        signal_interval : s
        generator : of the noise, needed where there is noise

        Returns
        -------
        (rows,), the first at the time of the signal's first sample.

        Raises
        ------
        SettingsError
            If the row interval is not a whole number of the signal's, the filter is too high for the signal, or
            noise has no generator.
        """
        every = round(self.interval / signal_interval)
        if every < 1 or abs(every * signal_interval - self.interval) > 1e-9:
            raise SettingsError(
                "recorder",
                f"the interval {self.interval} s is not a whole number of the signal's {signal_interval} s",
                "Choose a multiple of the signal's interval",
            )
        time = signal_interval * np.arange(signal.size, dtype=float)
        shown = self._shown_times(time[::every])
        rows = self._sampled(self._filtered(np.asarray(signal, dtype=float), signal_interval), time, every, shown)
        rows = rows + self._tones_at(shown)
        if self.noise > 0:
            if generator is None:
                raise SettingsError("recorder", "noise needs a random generator", "Pass one")
            rows = rows + self.noise * generator.standard_normal(rows.size)
        rows = self.scale * rows
        return self.resolution * np.rint(rows / self.resolution) if self.resolution > 0 else rows

    def _filtered(self, signal: Floats, interval: float) -> Floats:
        if np.isinf(self.filter_frequency):
            return signal
        if not 0 < self.filter_frequency < 0.5 / interval:
            raise SettingsError(
                "recorder",
                f"a filter at {self.filter_frequency} Hz cannot act on samples every {interval} s",
                "Lower it, or simulate at a finer interval",
            )
        from scipy.signal import bilinear, lfilter, lfilter_zi

        # an analog filter by the trapezoidal rule: its lag is exact for signals slow compared with the interval
        forward, backward = bilinear(*self._analog(), fs=1 / interval)
        passed, _ = lfilter(forward, backward, signal, zi=lfilter_zi(forward, backward) * signal[0])
        return np.asarray(passed, dtype=float)

    def _analog(self) -> tuple[Floats, Floats]:
        """Numerator and denominator of the filter."""
        from scipy.signal import butter

        forward, backward = butter(self.filter_order, 2 * np.pi * self.filter_frequency, analog=True)
        return forward, backward

    def _shown_times(self, rows: Floats) -> Floats:
        """Times of the signal in the rows at given times, s."""
        shown = np.asarray(rows - self.clock_offset - self.clock_drift * rows, dtype=float)
        # a row at a sample's own time holds that sample, though its quotient may round to just below a whole number
        return np.floor(shown / self.held + _ROUNDING) * self.held if self.held > 0 else shown

    def _sampled(self, signal: Floats, time: Floats, every: int, shown: Floats) -> Floats:
        if self.clock_offset == 0.0 and self.clock_drift == 0.0 and self.held == 0.0:
            return signal[::every]
        from scipy.interpolate import make_interp_spline

        return np.asarray(make_interp_spline(time, signal)(np.clip(shown, time[0], time[-1])), dtype=float)

    def _tones_at(self, times: Floats) -> Floats:
        """Tones behind the filter at given times, in closed form, as they may be too fast for the signal's interval."""
        total = np.zeros(times.size)
        for tone in self.tones:
            angular = 2 * np.pi * tone.frequency
            total += np.imag(
                tone.amplitude * self._filter_response(angular) * np.exp(1j * (angular * times + tone.phase))
            )
        return total

    def _filter_response(self, angular: float) -> complex:
        """Response of the filter at an angular frequency, rad/s."""
        if np.isinf(self.filter_frequency):
            return 1.0
        from scipy.signal import freqs

        return complex(freqs(*self._analog(), worN=[angular])[1][0])

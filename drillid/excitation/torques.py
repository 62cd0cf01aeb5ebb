"""Excitation torques: sweeps, multisines and noise; the coloured torque noise of the bit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from drillid.arrays import Floats, Integers
from drillid.errors import SettingsError

SWEEP_BANDS = ((0.05, 0.215), (0.215, 0.93), (0.93, 4.0))
"""Lower and upper frequency (Hz) of the three simultaneous sweeps, about two octaves each."""
SWEEP_PERIOD = 120.0
"""Seconds after which the sweeps repeat."""

_CLIP_SHARES = np.repeat((0.70, 0.74, 0.78, 0.82, 0.86, 0.90), 60)
"""Clipping level of each iteration of the search for low crest factor, relative to the peak."""
_SAMPLES_PER_CYCLE = 8
"""Samples per cycle of the highest line at which a multisine's peak is evaluated."""


def exponential_sweeps(
    time: ArrayLike,
    amplitude: float,
    bands: Sequence[tuple[float, float]] = SWEEP_BANDS,
    period: float = SWEEP_PERIOD,
) -> Floats:
    """Sum of simultaneous exponential sweeps, repeated periodically.

    The instantaneous frequency rises as f₁ r^(t/T) with r = f₂/f₁, so the phase in closed form is
    φ(t) = 2π f₁ T/ln r (r^(t/T) − 1). The number of cycles in a period is rounded to a whole number
    by scaling f₁ and f₂ alike, so that the torque is continuous from period to period; this shifts a
    band's edges by at most half a cycle in its count.

    Parameters
    ----------
    time : s since the start of a period, any shape
    amplitude : N m, of each sweep
    bands : Hz, lower and upper frequency of each sweep
    period : s

    Returns
    -------
    Torque, N m, in the shape of `time`.

    Raises
    ------
    SettingsError
        If the frequencies of a band are equal or not positive.
    """
    torque: Floats = np.zeros(np.shape(time))
    for band in bands:
        torque += np.sin(exponential_phase(time, band, period))
    return amplitude * torque


def exponential_phase(time: ArrayLike, band: tuple[float, float], period: float = SWEEP_PERIOD) -> Floats:
    """Phase φ(t) of one of the `exponential_sweeps`, rad, 0 at the start of each period."""
    share: Floats = np.mod(np.asarray(time, dtype=float), period) / period
    lower, upper = band
    if not (lower > 0 and upper > 0 and lower != upper):
        raise SettingsError("sweep", f"there is none from {lower} to {upper} Hz", "Give two positive frequencies")
    ratio = upper / lower
    cycles = max(1, round(lower * period * (ratio - 1) / np.log(ratio)))
    return np.asarray(2 * np.pi * cycles * (ratio**share - 1) / (ratio - 1), dtype=float)


def linear_sweep(time: ArrayLike, amplitude: float, band: tuple[float, float], period: float = SWEEP_PERIOD) -> Floats:
    """Sweep whose frequency rises linearly, φ(t) = 2π (f₁ t + (f₂ − f₁) t²/2T), repeated periodically.

    As with the exponential sweeps, the frequencies are scaled so that a period holds whole cycles.

    Parameters
    ----------
    time : s since the start of a period, any shape
    amplitude : N m
    band : Hz, lower and upper frequency
    period : s

    Returns
    -------
    Torque, N m, in the shape of `time`.
    """
    share: Floats = np.mod(np.asarray(time, dtype=float), period) / period
    lower, upper = band
    mean = (lower + upper) / 2
    scale = max(1, round(mean * period)) / (mean * period)
    return amplitude * np.sin(2 * np.pi * scale * period * (lower * share + (upper - lower) / 2 * share**2))


def powered_sweep(time: ArrayLike, amplitude: float, edges: Floats, power: Floats, period: float) -> Floats:
    """Sweep of constant amplitude that stays in each band in proportion to its power, repeated periodically.

    The power per band of such a sweep is its time in the band. Within a band the frequency rises linearly.

    Parameters
    ----------
    time : s since the start of a period, any shape
    amplitude : N m
    edges : (bands + 1,) Hz, rising
    power : (bands,) power in any unit; bands without power are skipped
    period : s

    Returns
    -------
    Torque, N m, in the shape of `time`.
    """
    excited = power > 0
    if edges.shape != (power.size + 1,) or np.any(power < 0) or not excited.any():
        raise SettingsError("sweep", "it needs one power ≥ 0 for each band, and some power", "Correct the powers")
    lower, upper, share = edges[:-1][excited], edges[1:][excited], power[excited] / power.sum()
    begin = np.concatenate([[0.0], np.cumsum(share)])
    cycles = np.concatenate([[0.0], np.cumsum((lower + upper) / 2 * share * period)])
    scale = max(1, round(cycles[-1])) / cycles[-1]
    now: Floats = np.mod(np.asarray(time, dtype=float), period) / period
    band = np.clip(np.searchsorted(begin, now, side="right") - 1, 0, share.size - 1)
    into = now - begin[band]
    slope = (upper[band] - lower[band]) / share[band]
    phase: Floats = 2 * np.pi * scale * (cycles[band] + period * (lower[band] * into + slope * into**2 / 2))
    return amplitude * np.sin(phase)


@dataclass(frozen=True, eq=False)
class Multisine:
    """Sum of cosines at harmonics of one period, Σ a_k cos(2πkt/T + φ_k)."""

    period: float
    """T, s."""
    harmonics: Integers
    """(lines,) numbers k of the excited lines, rising."""
    amplitudes: Floats
    """(lines,) a_k, N m."""
    phases: Floats
    """(lines,) φ_k, rad."""

    @property
    def rms(self) -> float:
        """Root mean square, N m."""
        return float(np.sqrt(np.sum(self.amplitudes**2) / 2))

    def sampled(self, samples: int) -> Floats:
        """One period at equally spaced instants, shape (samples,), N m.

        Raises
        ------
        SettingsError
            If the highest line has fewer than two samples a cycle.
        """
        if samples <= 2 * self.harmonics[-1]:
            raise SettingsError("multisine", f"{samples} samples are too few for its highest line", "Sample it faster")
        spectrum = np.zeros(samples // 2 + 1, dtype=complex)
        spectrum[self.harmonics] = self.amplitudes / 2 * np.exp(1j * self.phases) * samples
        return np.fft.irfft(spectrum, samples)

    def torque(self, steps: int, time_step: float) -> Floats:
        """Torque at each step from the start of a period, (steps,), N m; the period is a whole number of steps."""
        samples = round(self.period / time_step)
        if abs(samples * time_step - self.period) > 1e-9 * self.period:
            raise SettingsError(
                "multisine", "its period is not a whole number of time steps", "Choose another time step"
            )
        return np.resize(self.sampled(samples), steps)

    def with_low_crest(self) -> "Multisine":
        """The same amplitudes with phases of low crest factor: iteratively clip the torque and keep the new phases.

        Starts from Schroeder's phases for this spectrum (1970, IEEE Transactions on Information Theory 16, 85–89);
        the iteration is that of van der Ouderaa, Schoukens and Renneboog (1988, IEEE Transactions on
        Instrumentation and Measurement 37, 145–147). The best iterate is returned.
        """
        samples = _SAMPLES_PER_CYCLE * int(self.harmonics[-1])
        share = np.concatenate([[0.0], np.cumsum(self.amplitudes**2)[:-1]]) / np.sum(self.amplitudes**2)
        spacing = np.diff(self.harmonics, prepend=self.harmonics[0])
        current = Multisine(self.period, self.harmonics, self.amplitudes, -2 * np.pi * np.cumsum(spacing * share))
        best, lowest = self, np.max(np.abs(self.sampled(samples)))
        for clip in _CLIP_SHARES:
            torque = current.sampled(samples)
            peak = np.max(np.abs(torque))
            if peak < lowest:
                best, lowest = current, peak
            clipped = np.fft.rfft(np.clip(torque, -clip * peak, clip * peak))[self.harmonics]
            current = Multisine(self.period, self.harmonics, self.amplitudes, np.angle(clipped))
        return best


def harmonics_within(band: tuple[float, float], period: float) -> Integers:
    """Numbers of the harmonics of a period (s) in a band (Hz), those at its edges included whatever their rounding."""
    return np.arange(int(np.ceil(band[0] * period - 1e-9)), int(np.floor(band[1] * period + 1e-9)) + 1)


def odd_multisine(
    generator: np.random.Generator, rms: float, band: tuple[float, float], period: float, group: int = 4
) -> tuple[Multisine, Integers]:
    """Odd multisine with random phases and random odd detection lines, one omitted from each group of odd lines.

    Distortion of even order appears on even lines only, that of odd order also on the omitted odd lines
    (Pintelon and Schoukens 2012, System Identification, chapter 4). Power falls as 1/f, as in an exponential sweep.

    Parameters
    ----------
    rms : N m
    band : Hz, lower and upper frequency
    period : s
    group : number of odd lines of which one is omitted

    Returns
    -------
    multisine, and the omitted odd lines, (groups,)
    """
    lines = harmonics_within(band, period)
    odd = lines[lines % 2 == 1]
    groups = odd.size // group
    if group < 2 or groups == 0:
        raise SettingsError("multisine", f"{odd.size} odd lines lie in its band", "Lengthen the period")
    omitted = odd[np.arange(groups) * group + generator.integers(0, group, groups)]
    excited = np.setdiff1d(odd, omitted)
    amplitudes = 1 / np.sqrt(excited)
    amplitudes *= rms / np.sqrt(np.sum(amplitudes**2) / 2)
    return Multisine(period, excited, amplitudes, generator.uniform(0, 2 * np.pi, excited.size)), omitted


def white_noise(generator: np.random.Generator, samples: int, rms: float) -> Floats:
    """Gaussian noise with equal power at all frequencies up to half the sample rate, shape (samples,)."""
    return np.asarray(rms * generator.standard_normal(samples), dtype=float)


def band_limited_noise(
    generator: np.random.Generator, samples: int, time_step: float, rms: float, band: tuple[float, float]
) -> Floats:
    """Gaussian noise with equal power at all frequencies of a band (Hz) and none outside, shape (samples,).

    The rms is that of the ensemble; the series is periodic with its length.
    """
    frequency = np.fft.rfftfreq(samples, time_step)
    inside = (frequency >= band[0]) & (frequency <= band[1]) & (frequency > 0)
    if not inside.any():
        raise SettingsError("band-limited noise", "no line of the series lies in the band", "Lengthen the series")
    spectrum = generator.standard_normal((2, frequency.size)) * inside
    scale = samples * rms / (2 * np.sqrt(inside.sum()))
    return np.asarray(scale * np.fft.irfft(spectrum[0] + 1j * spectrum[1], samples), dtype=float)


def coloured_noise_density(frequency: ArrayLike, rms: float, bandwidth: float) -> Floats:
    """One-sided power density of `coloured_noise` far below the sample rate, rms²/Hz, in the shape of `frequency`."""
    ratio: Floats = np.asarray(frequency, dtype=float) / bandwidth
    return np.asarray(rms**2 * 2 / (np.pi * bandwidth) / (1 + ratio**2), dtype=float)


def coloured_noise(
    generator: np.random.Generator, samples: int, time_step: float, rms: float, bandwidth: float
) -> Floats:
    """Stationary Gaussian noise through a first-order low pass.

    Parameters
    ----------
    samples : length of the series
    time_step : s
    rms : root mean square of the ensemble, unit of the result
    bandwidth : Hz, corner frequency of the low pass

    Returns
    -------
    Noise, shape (samples,), stationary from its first sample on.
    """
    from scipy.signal import lfilter

    memory = float(np.exp(-2 * np.pi * bandwidth * time_step))
    steps = generator.standard_normal(samples) * rms
    steps[1:] *= np.sqrt(1 - memory**2)
    return np.asarray(lfilter([1.0], [1.0, -memory], steps), dtype=float)

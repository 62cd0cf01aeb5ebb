"""Virtual bit sensor: bit speed and torque on bit in time, from torque command and speed at the top drive.

With u the drive's torque, τ the torque of the rock on the bit, A the bit speed per top-drive speed of the
string driven from the top and M = 1/(J_td s + Y_in), reciprocity gives

    ω_td = M u − M A τ,    ω_bit = A M u − B τ,

B being the bit mobility under a top drive without control. The controller does not enter. τ is modelled as
stationary coloured noise of stated variance, and so are the errors of the logged speed and torque; bit speed and
bit torque are then the Wiener estimates, non-causal within the window, with the error spectra of the posterior.
Where the string transmits nothing of τ to the top, the estimate falls back to the response to the known torque
alone, and its error to that of the prior. Wiener (1949), Extrapolation, Interpolation, and Smoothing of Stationary
Time Series.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.errors import EstimationError, SettingsError
from drillid.physics.equipment import Controller, DrillingSystem
from drillid.physics.responses import bit_mobility, bit_speed_ratio, laplace, string_admittance
from drillid.physics.top_drive import control, drive

_REMEMBERED = 0.999
"""Share of a filter's energy that defines its memory."""
_TAPER_S = 5.0
"""Longest cosine taper at either end, s."""


@dataclass(frozen=True)
class NoiseLevels:
    """Prior noise levels; spectra are one-sided densities."""

    bit_torque: float
    """N m rms, variation of the torque on bit about its mean."""
    bandwidth: float
    """Hz, corner of the first-order low pass that colours the torque on bit."""
    speed: float
    """rad/s rms, error of each logged sample of speed, white."""
    torque: float
    """N m rms, error of each logged sample of the drive's torque, white."""

    def __post_init__(self) -> None:
        if not (min(self.bit_torque, self.bandwidth, self.speed) > 0 and self.torque >= 0):
            raise SettingsError(
                "noise levels", "bit torque, its bandwidth and the error of speed must be positive", "State them"
            )

    def bit_torque_density(self, frequency: Floats) -> Floats:
        """Density of the torque on bit, (N m)²/Hz, the integral over all frequencies being its variance."""
        density: Floats = 2 / (np.pi * self.bandwidth) * self.bit_torque**2 / (1 + (frequency / self.bandwidth) ** 2)
        return density

    def bit_torque_above(self, frequency: float) -> float:
        """N m rms of the torque on bit above a frequency (Hz), such as the log's Nyquist frequency."""
        return float(self.bit_torque * np.sqrt(2 / np.pi * np.arctan(self.bandwidth / frequency)))


@dataclass(frozen=True, eq=False)
class BitMotion:
    """Estimates in time, (samples,), with spectra of their errors, (frequency,)."""

    rate: float
    """Hz."""
    speed: Floats
    """rad/s, of the bit."""
    torque: Floats
    """N m, on the bit."""
    speed_error: float
    """rad/s, standard error of each sample of speed away from the ends."""
    torque_error: float
    """N m, likewise of torque, about the mean torque."""
    edge: int
    """Samples at either end whose estimates lack data: those under the taper, and the filters' memory beyond them."""
    drawn_speed: Floats
    """(draws, samples) rad/s, bit speed for each draw of the model."""
    frequency: Floats
    """Hz."""
    speed_error_density: Floats
    """(rad/s)²/Hz, of bit speed given the model."""
    observed_share: Floats
    """Share by which the data reduce the prior variance of bit speed, 0 to 1."""

    @property
    def inner(self) -> slice:
        """Samples away from the ends."""
        return slice(self.edge, self.speed.size - self.edge)


@dataclass(frozen=True)
class Severity:
    """Stick-slip severity index, peak-to-peak bit speed per twice the mean; 1 where the bit begins to stop."""

    index: float
    error: float
    """Standard error from that of the bit's speed and from the spread of the model's draws."""
    interval: tuple[float, float]
    """95 % interval, central in probability; it is asymmetric, as extremes are."""


def sense_bit(
    system: DrillingSystem, torque_command: Floats, speed: Floats, rate: float, noise: NoiseLevels
) -> BitMotion:
    """Bit speed and torque on bit over one window.

    Parameters
    ----------
    system : the identified model; parameters of shape (draws, 1) are draws from the fit's posterior, whose
        spread enters the errors
    torque_command : (samples,) N m, total command before the drive's delay
    speed : (samples,) rad/s, of the top drive
    rate : samples per s

    Raises
    ------
    EstimationError
        If a sample is missing, or the window is too short for the model's memory.
    """
    _check_series(torque_command, speed)
    samples = speed.size
    padded = 2 * samples
    frequency = np.asarray(np.fft.rfftfreq(padded, 1 / rate)[1:], dtype=float)
    estimators = _Estimators.of(system, frequency, rate, noise)
    taper = _taper(samples, rate)
    driven = _spectrum(torque_command, taper) * drive(system.top_drive, laplace(frequency))
    measured = _spectrum(speed, taper)
    bit_speed, bit_torque = (
        _to_time(filters[0] * driven + filters[1] * measured, padded)[..., :samples]
        for filters in (estimators.speed, estimators.torque)
    )
    edge = _tapered(samples, rate) + estimators.memory(padded)
    if 2 * edge >= samples:
        raise EstimationError(
            "virtual bit sensor",
            f"the window of {samples / rate:.0f} s is shorter than the model's memory at its two ends",
            "Use a longer window, or state a larger error of the logged speed",
        )
    inner = slice(edge, samples - edge)
    width = rate / padded
    return BitMotion(
        rate,
        speed.mean() + bit_speed.mean(axis=0),
        _mean_torque(system, torque_command.mean(), speed.mean()) + bit_torque.mean(axis=0),
        _error(estimators.speed_density, width, bit_speed[:, inner]),
        float(
            np.hypot(_error(estimators.torque_density, width, bit_torque[:, inner]), noise.bit_torque_above(rate / 2))
        ),
        edge,
        speed.mean() + bit_speed,
        frequency,
        np.asarray(np.mean(estimators.speed_density, axis=0), dtype=float),
        np.asarray(1 - np.mean(estimators.speed_density / estimators.speed_prior, axis=0), dtype=float),
    )


def command_of_control(controller: Controller, torque_sweep: Floats, speed: Floats, rate: float) -> Floats:
    """Torque command (N m) about its mean from the injected sweep and the speed, for logs without a command.

    The set point must be constant. Drift over periods as long as the window is not valid, and the mean torque stays
    unknown, so that the torque on bit is known about its mean only.
    """
    if controller.matching is not None:
        raise SettingsError(
            "virtual bit sensor", "impedance matching needs the string's torque", "Give the logged torque command"
        )
    samples = speed.size
    taper = _taper(samples, rate)
    frequency = np.asarray(np.fft.rfftfreq(2 * samples, 1 / rate)[1:], dtype=float)
    feedback = _to_time(control(controller, laplace(frequency)) * _spectrum(speed, taper), 2 * samples)[0, :samples]
    return np.asarray(torque_sweep - feedback - np.mean(torque_sweep - feedback), dtype=float)


def severity(motion: BitMotion, span: float, draws: int = 200, seed: int | Sequence[int] = 0) -> list[Severity]:
    """Severity index of each whole span within the inner samples.

    Each draw adds an error from the error spectrum to the estimate, since the estimate alone lacks part of the
    motion and its peak-to-peak value is too small.

    Parameters
    ----------
    span : s, some periods of the slowest oscillation

    Raises
    ------
    EstimationError
        If no span fits, or the mean rotation is not forward.
    """
    length = round(span * motion.rate)
    estimate = motion.speed[motion.inner]
    count = estimate.size // length if length > 1 else 0
    if count == 0 or estimate.mean() <= 0:
        raise EstimationError("severity index", "no span fits, or the bit does not turn forward", "Give a shorter span")
    generator = np.random.default_rng(seed)
    size = 2 * motion.frequency.size
    scale = np.sqrt(motion.speed_error_density * motion.rate * size / 4)
    drawn_indices: list[Floats] = []
    for _ in range(draws):
        noise = generator.standard_normal(scale.size) + 1j * generator.standard_normal(scale.size)
        model = motion.drawn_speed[generator.integers(motion.drawn_speed.shape[0]), motion.inner]
        drawn = model + _to_time(scale * noise, size)[0, : model.size]
        blocks = drawn[: count * length].reshape(count, length)
        drawn_indices.append(np.ptp(blocks, axis=1) / (2 * blocks.mean(axis=1)))
    table = np.array(drawn_indices)
    return [Severity(float(index.mean()), float(index.std()), _central(index)) for index in table.T]


@dataclass(frozen=True, eq=False)
class _Estimators:
    """Filters from drive torque and speed, (2, draws, frequency), and densities of errors, (draws, frequency)."""

    speed: Complex
    torque: Complex
    speed_density: Floats
    torque_density: Floats
    speed_prior: Floats

    @classmethod
    def of(cls, system: DrillingSystem, frequency: Floats, rate: float, noise: NoiseLevels) -> "_Estimators":
        s = laplace(frequency)
        free = replace(system, top_drive=replace(system.top_drive, controller=Controller(0.0)))
        mobility = 1 / (system.top_drive.inertia * s + string_admittance(system, s))
        ratio = bit_speed_ratio(system, s)
        by_torque, by_bit = ratio * mobility, -bit_mobility(free, s)
        rock = noise.bit_torque_density(frequency)
        speed_noise, torque_noise = 2 * noise.speed**2 / rate, 2 * noise.torque**2 / rate
        top_by_bit = -mobility * ratio
        innovation = np.abs(top_by_bit) ** 2 * rock + speed_noise + np.abs(mobility) ** 2 * torque_noise
        shared = by_torque * np.conj(mobility) * torque_noise + by_bit * np.conj(top_by_bit) * rock
        prior = np.abs(by_torque) ** 2 * torque_noise + np.abs(by_bit) ** 2 * rock
        gain, torque_gain = shared / innovation, np.conj(top_by_bit) * rock / innovation
        speed_density = np.maximum(prior - np.abs(shared) ** 2 / innovation, 0.0)
        torque_density = rock - np.abs(top_by_bit * rock) ** 2 / innovation
        filters = ((by_torque - gain * mobility, gain), (-torque_gain * mobility, torque_gain))
        speed, torque = (np.stack([np.atleast_2d(transfer) for transfer in pair]) for pair in filters)
        densities = (np.atleast_2d(density) for density in (speed_density, torque_density, prior))
        return cls(speed, torque, *densities)

    def memory(self, padded: int) -> int:
        """Samples to either side that hold nearly all energy of the filters of bit speed, the most of all draws."""
        responses = _to_time(self.speed.reshape(-1, self.speed.shape[-1]), padded) ** 2
        half = padded // 2
        folded = responses[:, :half] + responses[:, : -half - 1 : -1]
        reached = np.cumsum(folded, axis=1) >= _REMEMBERED * folded.sum(axis=1, keepdims=True)
        return int(np.argmax(reached, axis=1).max()) + 1


def _check_series(torque_command: Floats, speed: Floats) -> None:
    if torque_command.shape != speed.shape or not np.all(np.isfinite(torque_command) & np.isfinite(speed)):
        raise EstimationError(
            "virtual bit sensor",
            "torque and speed must be of equal length and without gaps",
            "Choose a window without gaps",
        )


def _mean_torque(system: DrillingSystem, command: float, speed: float) -> float:
    """Mean torque on bit (N m): the drive's less the drag of mud on the turning string."""
    drag = np.mean(np.real(string_admittance(system, laplace(np.full(1, 1e-9)))))
    return float(np.mean(system.top_drive.gain) * command - drag * speed)


def _spectrum(series: Floats, taper: Floats) -> Complex:
    """Fourier coefficients of a tapered series about its mean, padded to twice its length; without the first one."""
    return np.asarray(np.fft.rfft((series - series.mean()) * taper, 2 * series.size)[1:], dtype=complex)


def _to_time(spectra: Complex, size: int) -> Floats:
    """Series of shape (draws, size) from spectra without their mean."""
    lines = np.atleast_2d(spectra)
    return np.fft.irfft(np.concatenate([np.zeros((lines.shape[0], 1)), lines], axis=1), size)


def _error(density: Floats, width: float, estimates: Floats) -> float:
    """Standard error by the law of total variance over draws of the model."""
    return float(np.sqrt(np.mean(density.sum(axis=-1) * width) + np.mean(estimates.var(axis=0))))


def _central(drawn: Floats) -> tuple[float, float]:
    """Central 95 % of the draws."""
    low, high = np.quantile(drawn, (0.025, 0.975))
    return float(low), float(high)


def _taper(samples: int, rate: float) -> Floats:
    from scipy.signal.windows import tukey

    return np.asarray(tukey(samples, 2 * _tapered(samples, rate) / samples), dtype=float)


def _tapered(samples: int, rate: float) -> int:
    """Samples at either end that the taper attenuates."""
    return min(samples // 2, round(_TAPER_S * rate))

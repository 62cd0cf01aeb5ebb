"""What a window's own record holds, and the noise that detections are read against.

What repeats with the sweep is taken out first: it is the linear response, right or wrong, and the part of every
distortion that a linear model may absorb. What is left is noise, and whatever changes in time or does not follow
the sweep.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.fft import irfft, rfft, rfftfreq

from drillid.arrays import Booleans, Complex, Floats
from drillid.discrepancy.rules import TORQUE_STEP
from drillid.errors import EstimationError
from drillid.physics.eight_parameters import KnownEquipment, command_mobility_with_derivatives, drilling_system
from drillid.physics.equipment import DrillingSystem
from drillid.physics.responses import bit_speed_ratio, command_mobility, laplace
from drillid.physics.top_drive import control, drive

_BAND = (0.02, 10.0)
"""Hz, in which the model is trusted."""
TAPER_S = 10.0
"""Cosine taper at either end, s."""
_NOISE_LINES = 61
"""Lines between harmonics whose median gives the noise."""
_BIT_BANDWIDTH = 2.0
"""Hz, usual corner of the torque noise at the bit."""
_ABOVE_FLOOR = 10.0
"""Power per the sensor's from which a line tells the bit's noise."""
_LEAST_PERIODS = 2
_LEAST_POWER, _BEYOND_SWEEP = 1e-4, 1.25
"""Share of the sweep's largest power that counts as power, and how far beyond its highest frequency it still may."""

_MOST = 4
"""Steps of a window; what steps more often is no change of rock."""


@dataclass(frozen=True, eq=False)
class WindowRecord:
    """One window: channels of shape (samples,), and the model fitted to it.

    Raises
    ------
    EstimationError
        If a channel has another length than the others, or sweep, speed or fit are not finite.
    """

    sweep: Floats
    """N m, injected torque."""
    speed: Floats
    """rad/s, of the top drive."""
    command: Floats
    """N m, whole torque command with the sweep; NaN where it is not logged."""
    rate: float
    """Samples per s."""
    period: float
    """s, after which the sweep repeats; 0 where it does not."""
    fitted: Floats
    """(8,) parameters of the window's own fit, in the order of the schema."""
    known: KnownEquipment
    """Controller and collars that the fit took as given."""

    def __post_init__(self) -> None:
        if not self.sweep.shape == self.speed.shape == self.command.shape or self.sweep.ndim != 1:
            raise EstimationError("window's record", "its channels differ in length", "Cut them at the same samples")
        if not all(np.isfinite(values).all() for values in (self.sweep, self.speed, self.fitted)):
            raise EstimationError("window's record", "sweep, speed or fit is not finite", "Leave the window out")

    @property
    def has_command(self) -> bool:
        """Whether the torque command is logged."""
        return bool(np.isfinite(self.command).all())


class ResidualRecord:
    """A window less all that repeats with its sweep, and the density of its noise.

    With a sweep that does not repeat, the fitted model's answer to it is taken out instead.

    Parameters
    ----------
    taken : (samples,) rad/s, what of the speed is accounted for already; nothing where not given
    """

    def __init__(self, record: WindowRecord, taken: Floats | None = None) -> None:
        self.record = record
        whole = int(record.speed.size / record.rate / record.period + 1e-9) if record.period > 0 else 0
        self.periods = whole if whole >= _LEAST_PERIODS else 0
        self.samples = round(whole * record.period * record.rate) if self.periods else record.speed.size
        self.taken: Floats = np.zeros(self.samples) if taken is None else taken
        self.time: Floats = np.arange(self.samples) / record.rate
        self.passed: Floats = (np.arange(self.samples) + 0.5) / self.samples
        self.frequency: Floats = rfftfreq(self.samples, 1 / record.rate)
        self.system: DrillingSystem = drilling_system(record.fitted, record.known)
        self.highest = min(_BAND[1], 0.3 * record.rate)
        self.inside = (self.frequency >= _BAND[0]) & (self.frequency <= self.highest)
        ramp = np.minimum(self.time, self.time[::-1]) / TAPER_S
        self.taper: Floats = np.sin(np.pi / 2 * np.minimum(ramp + 0.5 / record.rate / TAPER_S, 1.0)) ** 2

    @cached_property
    def s(self) -> Complex:
        """Laplace variable of all lines; that of the mean, where nothing is asked for, is the first line's."""
        return laplace(np.maximum(self.frequency, self.frequency[1]))

    @cached_property
    def mobility(self) -> Complex:
        """Command mobility of the fitted model at all lines, 0 at the mean."""
        return np.asarray(np.ravel(command_mobility(self.system, self.s)) * (self.frequency > 0), dtype=complex)

    @cached_property
    def derivatives(self) -> Complex:
        """Derivatives of the mobility to the model's eight figures, (8, line)."""
        return command_mobility_with_derivatives(self.record.fitted, self.record.known, self.s)[1]

    @cached_property
    def moved(self) -> Complex:
        """Speed per torque on the top drive at all lines, rad/(N m s), 0 at the mean."""
        return self.mobility / np.ravel(drive(self.system.top_drive, self.s))

    @cached_property
    def moved_from_bit(self) -> Complex:
        """The same per torque at the bit: by reciprocity it moves the top as a torque at the top moves the bit."""
        return self.moved * np.ravel(bit_speed_ratio(self.system, self.s))

    @property
    def sweep(self) -> Floats:
        """N m, over the whole periods."""
        return self.record.sweep[: self.samples]

    @property
    def speed(self) -> Floats:
        """rad/s, over the whole periods."""
        return self.record.speed[: self.samples]

    @cached_property
    def command(self) -> Floats:
        """N m; by the known control about an unknown mean where it is not logged."""
        if self.record.has_command:
            return self.record.command[: self.samples]
        controller = self.system.top_drive.controller
        return self.sweep - self.filtered(control(controller, self.s), self.speed - self.speed.mean())

    def filtered(self, transfer: Complex, series: Floats) -> Floats:
        """A series (..., samples) behind a transfer (line,), as if the window repeated."""
        return np.asarray(irfft(transfer * rfft(series), self.samples), dtype=float)

    def swept(self, transfer: Complex) -> Floats:
        """What the sweep makes of a transfer (..., line), about its mean, (..., samples)."""
        return self.filtered(transfer * (self.frequency > 0), self.sweep)

    def without_sweep(self, series: Floats) -> Floats:
        """A series (..., samples) less its trend and all that repeats with the sweep's period in the sweep's band."""
        centred = self.time - self.time.mean()
        slope = series @ centred / (centred @ centred)
        series = series - series.mean(axis=-1, keepdims=True) - np.multiply.outer(slope, centred)
        if not self.periods:
            return np.asarray(series, dtype=float)
        lines = rfft(series * self.period_weight)
        lines[..., ~self.repeating] = 0
        repeated = irfft(lines, self.samples) * (self.periods / (self.periods - 1))
        return np.asarray(series - repeated, dtype=float)

    @cached_property
    def repeating(self) -> Booleans:
        """Harmonics of the sweep's period up to where the sweep has lost its power, (line,)."""
        power = np.abs(rfft(self.sweep - self.sweep.mean())) ** 2
        highest = self.frequency[np.flatnonzero(power > _LEAST_POWER * power.max())].max()
        low = (self.frequency > 0) & (self.frequency < _BEYOND_SWEEP * highest)
        return np.asarray(~self.between & low, dtype=bool)

    @cached_property
    def period_weight(self) -> Floats:
        """Weight (samples,) of each sample in the mean over periods, rising over the first and falling over the last.

        The weights of all samples of one phase add up to the periods less one, and the mean does not jump where
        periods meet: noise does not join on to itself there, and a jump has power at all frequencies.
        """
        share = np.minimum(self.time, self.time[-1] - self.time) * self.periods / self.time[-1]
        return np.asarray(np.sin(np.pi / 2 * np.minimum(share, 1.0)) ** 2, dtype=float)

    @cached_property
    def left(self) -> Floats:
        """Speed less its answer to the sweep and what is taken, rad/s."""
        told = self.speed - self.taken
        return self.without_sweep(told if self.periods else told - self.filtered(self.mobility, self.sweep))

    @cached_property
    def modelled_noise(self) -> Floats:
        """Noise that the model lets through from bit to top, and a floor of sensor noise, shape (line,).

        Torque of the bit is taken as noise behind a low pass, sensor noise as white; their sizes are medians.
        """
        passed = np.abs(self.moved_from_bit) ** 2 / (1 + (self.frequency / _BIT_BANDWIDTH) ** 2)
        power = self.power
        high, low = (self.between & band for band in (self.frequency > self.highest, self.inside))
        floor = float(np.median(power[high])) / np.log(2) if high.any() else 0.0
        above = low & (power > _ABOVE_FLOOR * floor) & (passed > 0)
        level = float(np.median(power[above] / passed[above])) if above.any() else 0.0
        passed[0] = passed[1]
        return np.asarray(level * passed + floor + np.finfo(float).tiny, dtype=float)

    @cached_property
    def power(self) -> Floats:
        """Squared modulus of the tapered residual record's lines, (line,)."""
        return np.asarray(np.abs(rfft(self.left * self.taper)) ** 2, dtype=float)

    @property
    def between(self) -> Booleans:
        """Lines that are no harmonics of the sweep's period, (line,)."""
        lines = np.arange(self.frequency.size)
        return (lines > 0) if not self.periods else lines % self.periods != 0

    @cached_property
    def noise(self) -> Floats:
        """Mean squared modulus of each line of the tapered remainder, shape (line,).

        The modelled noise times a running median of the lines between harmonics, so that single tones do not
        raise it.
        """
        from scipy.ndimage import median_filter

        lines = np.flatnonzero(self.between)
        ratio = self.power[lines] / self.modelled_noise[lines]
        level = median_filter(ratio, _NOISE_LINES, mode="reflect") / np.log(2)
        return np.asarray(np.interp(np.arange(self.frequency.size), lines, level) * self.modelled_noise, dtype=float)

    @cached_property
    def _weight(self) -> Floats:
        least = np.finfo(float).tiny
        return np.where(self.inside, np.sqrt(self.samples / np.maximum(self.noise, least)), 0.0)

    def whitened(self, series: Floats) -> Floats:
        """A series (..., samples) in rad/s as the residual record's noise sees it, less what repeats with the sweep."""
        return self.weighted(self.without_sweep(series))

    def weighted(self, series: Floats) -> Floats:
        """A series (..., samples) in rad/s as this record's noise sees it, which then has about unit density."""
        return self.filtered(self._weight.astype(complex), series * self.taper)

    @cached_property
    def error(self) -> Floats:
        """The whitened remainder, (samples,)."""
        return self.weighted(self.left)

    @cached_property
    def inflation(self) -> float:
        """Variance of a sum over the noise per variance found from the remainder, which has lost the periods' mean."""
        if not self.periods:
            return 1.0
        share = self.period_weight / (self.periods - 1)
        mean_share = float(np.sum(share**2)) / self.samples * self.periods
        return 1 / float(np.average(1 - 2 * share + mean_share, weights=self.taper))


def without_steps(residual: ResidualRecord) -> ResidualRecord:
    """The remainder less the answers of the speed to steps of the torque at the bit."""
    for _ in range(_MOST):
        answer = _largest_step(residual)
        if answer is None:
            break
        residual = ResidualRecord(residual.record, residual.taken + answer)
    return residual


def _largest_step(residual: ResidualRecord) -> Floats | None:
    """Speed (samples,) by the step that stands out most, rad/s; None where none does.

    All times are tried at once by a matched filter (Turin 1960, IRE Transactions on Information Theory 6, 311–329).
    """
    rate, s = residual.record.rate, residual.s
    answer = -residual.moved_from_bit * rate / s
    weighted = np.where(residual.inside, np.conj(answer) / np.maximum(residual.noise, np.finfo(float).tiny), 0.0)
    matched = irfft(weighted * rfft(residual.left * residual.taper), residual.samples) * residual.samples
    deviation = float(np.sqrt(2 * np.sum((weighted * answer).real)))
    place = int(np.argmax(np.abs(matched)))
    if not abs(matched[place]) > TORQUE_STEP * deviation:
        return None
    step = irfft(answer * np.exp(-s * place / rate), residual.samples)
    seen = residual.whitened(step)
    return np.asarray(step * (seen @ residual.error) / (seen @ seen), dtype=float)

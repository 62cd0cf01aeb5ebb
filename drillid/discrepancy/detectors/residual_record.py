"""The residual record of a window, and the noise against which detections are tested.

The part of the speed that is periodic with the sweep is subtracted first: the linear response, correctly modelled or
not, and the part of any distortion that a linear model can absorb. The residual record holds noise, and whatever
changes in time or does not follow the sweep.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from drillid.arrays import Booleans, Complex, Floats
from drillid.discrepancy.rules import TORQUE_STEP
from drillid.errors import EstimationError
from drillid.physics.eight_parameters import KnownEquipment, command_mobility_with_derivatives, drilling_system
from drillid.physics.equipment import DrillingSystem
from drillid.physics.responses import bit_speed_ratio, command_mobility, laplace
from drillid.physics.top_drive import control, drive
from drillid.records.roughness import HELD, Roughness
from drillid.records.slower_samples import Samples, released
from drillid.spectra.periodic import whole_periods

_BAND = (0.02, 10.0)
"""Hz, band in which the model is valid."""
_HIGHEST = 0.3
"""Share of the samples' rate up to which the band reaches."""
TAPER_S = 10.0
"""Cosine taper at either end, s."""
_SPARE = 1.1
"""Samples of a whitened series, relative to the fewest that hold the band."""
_NOISE_LINES = 61
"""Lines between harmonics whose median gives the noise."""
_BIT_BANDWIDTH = 2.0
"""Hz, usual corner of the torque noise at the bit."""
_ABOVE_FLOOR = 10.0
"""Power relative to the sensor noise above which a line measures the bit's noise."""
_LEAST_PERIODS = 2
_LEAST_POWER, _BEYOND_SWEEP = 1e-4, 1.25
"""Share of the sweep's largest line power below which a line counts as unexcited; harmonics are removed up to this
factor times the highest excited frequency."""

_MOST_STEPS = 4
"""Largest number of torque steps subtracted from a window; a torque that steps more often is no change of rock."""


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
    """N m, total torque command, sweep included; NaN where it is not logged."""
    rate: float
    """Samples per s."""
    period: float
    """s, period of the sweep; 0 where it is not periodic."""
    fitted: Floats
    """(8,) parameters fitted to this window, in the order of the schema."""
    known: KnownEquipment
    """Controller and collars held fixed in that fit."""
    sample_rate: float = np.inf
    """Samples of the control per s; infinite where the rows do not show them."""
    samples: Samples | None = None
    """Samples through which sweep, speed and command, where it is logged, are curves; None where they are the rows."""

    def __post_init__(self) -> None:
        if not self.sweep.shape == self.speed.shape == self.command.shape or self.sweep.ndim != 1:
            raise EstimationError("window's record", "its channels differ in length", "Cut them at the same samples")
        if not all(np.isfinite(values).all() for values in (self.sweep, self.speed, self.fitted)):
            raise EstimationError("window's record", "sweep, speed or fit is not finite", "Leave the window out")

    def released(self) -> "WindowRecord":
        """The record with its rows' samples on smooth curves; itself where the rows are even."""
        channels = np.stack([self.sweep, self.speed, self.command])
        smooth = released(channels, self.rate)
        if np.isnan(smooth.interval):
            return self
        sweep, speed, command = smooth.channels
        return replace(
            self, sweep=sweep, speed=speed, command=command, sample_rate=1 / smooth.interval, samples=smooth.samples
        )

    @property
    def has_command(self) -> bool:
        """Whether the torque command is logged."""
        return bool(np.isfinite(self.command).all())


class ResidualRecord:
    """A window's speed less everything periodic with its sweep, and the density of its noise.

    Where the sweep is not periodic, the response of the fitted model is subtracted instead.

    Parameters
    ----------
    subtracted : (samples,) rad/s, speed that is already explained, such as by torque steps; zero where not given
    """

    def __init__(self, record: WindowRecord, subtracted: Floats | None = None) -> None:
        self.record = record
        periods = whole_periods(record.speed.size, record.rate, record.period) if record.period > 0 else 0
        self.periods = periods if periods >= _LEAST_PERIODS else 0
        self.samples = round(periods * record.period * record.rate) if self.periods else record.speed.size
        self.subtracted: Floats = np.zeros(self.samples) if subtracted is None else subtracted
        self.time: Floats = np.arange(self.samples) / record.rate
        self.elapsed: Floats = (np.arange(self.samples) + 0.5) / self.samples
        self.frequency: Floats = rfftfreq(self.samples, 1 / record.rate)
        self.system: DrillingSystem = drilling_system(record.fitted, record.known)
        self.sample_rate = min(record.rate, record.sample_rate)
        self.highest = min(_BAND[1], _HIGHEST * self.sample_rate)
        self.inside = (self.frequency >= _BAND[0]) & (self.frequency <= self.highest)
        ramp = np.minimum(self.time, self.time[::-1]) / TAPER_S
        self.taper: Floats = np.sin(np.pi / 2 * np.minimum(ramp + 0.5 / record.rate / TAPER_S, 1.0)) ** 2

    @cached_property
    def s(self) -> Complex:
        """Laplace variable of all lines; the line of the mean, which is never used, has that of the first line."""
        return laplace(np.maximum(self.frequency, self.frequency[1]))

    @cached_property
    def mobility(self) -> Complex:
        """Command mobility of the fitted model at all lines, 0 at the mean."""
        return np.asarray(np.ravel(command_mobility(self.system, self.s)) * (self.frequency > 0), dtype=complex)

    @cached_property
    def derivatives(self) -> Complex:
        """Derivatives of the mobility with respect to the model's eight parameters, (8, line)."""
        return command_mobility_with_derivatives(self.record.fitted, self.record.known, self.s)[1]

    @cached_property
    def top_mobility(self) -> Complex:
        """Driving-point mobility: speed per torque at the top drive at all lines, rad/(N m s), 0 at the mean."""
        return self.mobility / np.ravel(drive(self.system.top_drive, self.s))

    @cached_property
    def transfer_mobility(self) -> Complex:
        """Transfer mobility: speed at the top per torque at the bit, by reciprocity speed at the bit per torque at the
        top.
        """
        return self.top_mobility * np.ravel(bit_speed_ratio(self.system, self.s))

    @property
    def sweep(self) -> Floats:
        """N m, over an integer number of periods."""
        return self.record.sweep[: self.samples]

    @property
    def speed(self) -> Floats:
        """rad/s, over an integer number of periods."""
        return self.record.speed[: self.samples]

    @cached_property
    def command(self) -> Floats:
        """N m; where it is not logged, reconstructed from the known control, without its course below the sweep's band:
        the integral makes that from a difference of speed and set point which the speed alone does not show.
        """
        if self.record.has_command:
            return self.record.command[: self.samples]
        response = control(self.system.top_drive.controller, self.s) * (self.frequency >= self.excited[0])
        return self.sweep - self.filtered(response, self.without_trend(self.speed))

    @cached_property
    def time_error(self) -> float:
        """Standard deviation of the rows' time stamps, s: the sweep's part too rough for its band, per unit of slope.

        Rows that hold the last sample of a slower control, or lie on lines between its samples, are of different ages.
        The median over blocks leaves out the jump at the end of a sweep's period.
        """
        return Roughness(self.sweep, HELD).unevenness / self.record.rate

    def filtered(self, transfer: Complex, series: Floats) -> Floats:
        """A series (..., samples) filtered by a transfer function (line,), the window taken as periodic."""
        return np.asarray(irfft(transfer * rfft(series), self.samples), dtype=float)

    def response_to_sweep(self, transfer: Complex) -> Floats:
        """Response to the sweep of a transfer function (..., line), about its mean, (..., samples)."""
        return self.filtered(transfer * (self.frequency > 0), self.sweep)

    def without_trend(self, series: Floats) -> Floats:
        """A series (..., samples) less its linear trend."""
        centred = self.time - self.time.mean()
        slope = series @ centred / (centred @ centred)
        return np.asarray(series - series.mean(axis=-1, keepdims=True) - np.multiply.outer(slope, centred), dtype=float)

    def without_sweep(self, series: Floats) -> Floats:
        """A series (..., samples) less its linear trend and, in the sweep's band, its part periodic with the sweep."""
        series = self.without_trend(series)
        if not self.periods:
            return series
        return np.asarray(series - self._repeated(series * self.period_weight), dtype=float)

    def _repeated(self, weighted: Floats) -> Floats:
        """Mean over periods, repeated, in the sweep's band; of a weighted series (..., samples)."""
        length, odd = divmod(self.samples, self.periods)
        if odd:
            lines = rfft(weighted)
            lines[..., ~self.harmonics] = 0
            return np.asarray(irfft(lines, self.samples) * (self.periods / (self.periods - 1)), dtype=float)
        # the harmonics are the lines of one period
        lines = rfft(weighted.reshape(*weighted.shape[:-1], self.periods, length).sum(axis=-2))
        lines[..., ~self.harmonics[:: self.periods]] = 0
        once = irfft(lines, length) / (self.periods - 1)
        return np.tile(once, self.periods)

    @cached_property
    def excited(self) -> tuple[float, float]:
        """Lowest and highest frequency that the sweep excites, Hz."""
        power = np.abs(rfft(self.sweep - self.sweep.mean())) ** 2
        found = self.frequency[power > _LEAST_POWER * power.max()]
        return float(found[0]), float(found[-1])

    @cached_property
    def harmonics(self) -> Booleans:
        """Mask (line,) of the harmonics of the sweep's period in the band that the sweep excites."""
        low = (self.frequency > 0) & (self.frequency < _BEYOND_SWEEP * self.excited[1])
        return np.asarray(~self.off_harmonics & low, dtype=bool)

    @cached_property
    def period_weight(self) -> Floats:
        """Weight (samples,) of each sample in the mean over periods, tapered over the first and the last period.

        The weights of all samples of one phase sum to the number of periods less one, and the mean is continuous where
        periods meet: noise is not periodic, and a jump there would have power at all frequencies.
        """
        share = np.minimum(self.time, self.time[-1] - self.time) * self.periods / self.time[-1]
        return np.asarray(np.sin(np.pi / 2 * np.minimum(share, 1.0)) ** 2, dtype=float)

    @cached_property
    def speed_residual(self) -> Floats:
        """Speed less its response to the sweep and less what has been subtracted, rad/s."""
        speed = self.speed - self.subtracted
        return self.without_sweep(speed if self.periods else speed - self.filtered(self.mobility, self.sweep))

    @cached_property
    def modelled_noise(self) -> Floats:
        """Power spectrum of torque noise at the bit as it reaches the top, plus a floor of sensor noise, (line,).

        Torque noise at the bit is modelled as low-pass filtered white noise, sensor noise as white; their levels are
        medians over lines.
        """
        transmitted = np.abs(self.transfer_mobility) ** 2 / (1 + (self.frequency / _BIT_BANDWIDTH) ** 2)
        power, floor = self.power, self.sensor_floor
        loud = self.off_harmonics & self.inside & (power > _ABOVE_FLOOR * floor) & (transmitted > 0)
        level = float(np.median(power[loud] / transmitted[loud])) if loud.any() else 0.0
        transmitted[0] = transmitted[1]
        return np.asarray(level * transmitted + floor + np.finfo(float).tiny, dtype=float)

    @cached_property
    def sensor_floor(self) -> float:
        """Squared modulus of the sensor's noise in a line of the tapered record: that above the model's band."""
        above = (self.frequency > self.highest) & (self.frequency <= self.sample_rate / 2) & self.off_harmonics
        return float(np.median(self.power[above])) / np.log(2) if above.any() else 0.0

    @cached_property
    def power(self) -> Floats:
        """Squared modulus of the tapered residual record's lines, (line,)."""
        return np.asarray(np.abs(rfft(self.speed_residual * self.taper)) ** 2, dtype=float)

    @property
    def off_harmonics(self) -> Booleans:
        """Mask (line,) of the lines that are not harmonics of the sweep's period."""
        lines = np.arange(self.frequency.size)
        return (lines > 0) if not self.periods else lines % self.periods != 0

    @cached_property
    def noise(self) -> Floats:
        """Expected squared modulus of each line of the tapered residual record, shape (line,).

        The modelled noise, scaled by a running median over the lines between harmonics, so that single tones do not
        raise it.
        """
        from scipy.ndimage import median_filter

        lines = np.flatnonzero(self.off_harmonics)
        ratio = self.power[lines] / self.modelled_noise[lines]
        level = median_filter(ratio, _NOISE_LINES, mode="reflect") / np.log(2)
        return np.asarray(np.interp(np.arange(self.frequency.size), lines, level) * self.modelled_noise, dtype=float)

    @cached_property
    def weight(self) -> Floats:
        """Factors that whiten the lines up to the highest of the band; 0 below the band."""
        inside, noise = self.inside[: self.lines], np.maximum(self.noise[: self.lines], np.finfo(float).tiny)
        return np.where(inside, np.sqrt(self.samples / noise), 0.0)

    def whitened(self, series: Floats) -> Floats:
        """A series (..., samples) in rad/s, less its part periodic with the sweep, whitened: (..., whitened samples).

        This record's noise then has a density of about one.
        """
        return self.weighted(self.without_sweep(series))

    def weighted(self, series: Floats) -> Floats:
        """A series (..., samples) in rad/s, tapered and whitened, (..., whitened samples)."""
        return self.of_band(self.weighted_lines(series))

    def weighted_lines(self, series: Floats) -> Complex:
        """The lines up to the highest of the band of a series (..., samples), tapered and whitened."""
        return np.asarray(rfft(series * self.taper)[..., : self.lines] * self.weight, dtype=complex)

    @cached_property
    def lines(self) -> int:
        """Number of lines up to the highest of the band."""
        return int(np.count_nonzero(self.frequency <= self.highest))

    @cached_property
    def whitened_samples(self) -> int:
        """Number of samples of whitened series, which have nothing beyond the band."""
        return min(int(next_fast_len(round(2 * _SPARE * self.lines), real=True)), self.samples)

    def of_band(self, lines: Complex) -> Floats:
        """A series (..., whitened samples) from its lines up to the highest of the band; the sum of products of two is
        the same as it would be with all samples.
        """
        count = self.whitened_samples
        return np.asarray(irfft(lines, count) * np.sqrt(count / self.samples), dtype=float)

    @cached_property
    def error(self) -> Floats:
        """The whitened residual record, (whitened samples,)."""
        return self.weighted(self.speed_residual)

    def whitened_lines(self, series: Floats) -> Complex:
        """Lines up to the highest of the band of a series (..., samples) as `whitened`.

        The sum of products of two whitened series is 2/samples times the real part of that of their lines (Parseval).
        """
        return self.weighted_lines(self.without_sweep(series))

    @cached_property
    def error_lines(self) -> Complex:
        """Lines up to the highest of the band of the whitened residual record."""
        return self.weighted_lines(self.speed_residual)

    @cached_property
    def inflation(self) -> float:
        """Variance of a sum over the noise relative to that estimated from the residual record, which lacks the mean
        over periods.
        """
        if not self.periods:
            return 1.0
        share = self.period_weight / (self.periods - 1)
        mean_share = float(np.sum(share**2)) / self.samples * self.periods
        return 1 / float(np.average(1 - 2 * share + mean_share, weights=self.taper))


def without_steps(residual: ResidualRecord) -> ResidualRecord:
    """The residual record with the speed's responses to steps of the bit torque subtracted, largest first."""
    for _ in range(_MOST_STEPS):
        response = _step_response(residual)
        if response is None:
            break
        residual = ResidualRecord(residual.record, residual.subtracted + response)
    return residual


def _step_response(residual: ResidualRecord) -> Floats | None:
    """Speed response (samples,) to the most significant step of the bit torque, rad/s; None where none is significant.

    All times are tested at once by a matched filter (Turin 1960, IRE Transactions on Information Theory 6, 311–329).
    """
    rate, s = residual.record.rate, residual.s
    response = -residual.transfer_mobility * rate / s
    weighted = np.where(residual.inside, np.conj(response) / np.maximum(residual.noise, np.finfo(float).tiny), 0.0)
    matched = irfft(weighted * rfft(residual.speed_residual * residual.taper), residual.samples) * residual.samples
    deviation = float(np.sqrt(2 * np.sum((weighted * response).real)))
    place = int(np.argmax(np.abs(matched)))
    if not abs(matched[place]) > TORQUE_STEP * deviation:
        return None
    step = irfft(response * np.exp(-s * place / rate), residual.samples)
    whitened = residual.whitened(step)
    return np.asarray(step * (whitened @ residual.error) / (whitened @ whitened), dtype=float)

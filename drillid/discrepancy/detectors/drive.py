"""Detections of a drive that does not deliver the commanded torque: limits of torque and of its rate, varying delay.

The missing torque is computed from the command for a range of limits, and is sought in the speed, which responds to it
as to the sweep. Through the control, the noise in the speed is in the command too; but only a linear part of the
missing torque is correlated with it, whose filter is the mean derivative of the missing torque with respect to the
command (Bussgang 1952, MIT Research Laboratory of Electronics, report 216; Stein 1981, Annals of Statistics 9,
1135–1151). Less that part, the missing torque is uncorrelated with Gaussian noise.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import numpy as np
from scipy.fft import irfft, rfft
from scipy.interpolate import CubicSpline
from scipy.special import stdtr

from drillid.arrays import Booleans, Complex, Floats
from drillid.discrepancy.detectors.delivered import limit_by_delivery
from drillid.discrepancy.detectors.detector import Detector, Inspection, is_clear
from drillid.discrepancy.detectors.residual_record import ResidualRecord
from drillid.discrepancy.detectors.score import Candidate, Score, normal_of_p_value
from drillid.discrepancy.rules import CLEAR_DETECTION, STAMPED_TO, STEPPED_ROWS, UNEVEN_ROWS
from drillid.physics.limits import lacking_after_steps, rate_limited
from drillid.records.quality import quantisation_step

_BEYOND = np.array([0.003, 0.006, 0.012, 0.025, 0.05, 0.09, 0.15, 0.25, 0.4, 0.6, 0.8, 0.92])
"""Shares of the record's time that the command is beyond each of the limits tried."""
_BEYOND_SLOPES = np.array([16.0, 8.0, 4.0, 2.0])
"""Rates tried that only the steps of a held command exceed, relative to the largest one that its slopes exceed."""
_NEGLIGIBLE = 1e-9
"""Missing torque, relative to the largest command, that counts as none."""

_JITTER_BAND = (1.0, 0.4)
"""Lowest frequency, Hz, and highest, as a share of the samples' rate."""
_SAME = 1e-6
"""Relative difference below which two samples are the same, where a series has no quantisation step."""
_BLOCK_S = 4.0
_NEIGHBOURS = 6
"""Blocks over which errors are correlated, as the noise level changes slowly."""


class LimitDetector(Detector):
    """Torque that a limit withholds from a drive.

    The size of the limit is unknown where the command is reconstructed, as that lacks its mean, of which only the sign
    is known, and does not show changes between samples.
    """

    acts_beyond = True
    memory: ClassVar[bool]
    """Whether the delivered torque depends on what was delivered before."""

    def limits(self, residual: ResidualRecord) -> Floats:
        """Limits (limits,) that the command reaches within the record, the highest first; a coarsely rounded one has
        few different values.
        """
        limits = np.unique(np.quantile(self.reached(residual), 1 - _BEYOND))[::-1]
        # about an unknown mean a limit may lie below it; one of zero is none
        return np.ascontiguousarray(limits[limits != 0])

    def delivered(self, residual: ResidualRecord, limits: Floats) -> Floats:
        """Torque (limits, samples) that limits (limits,) let pass, N m."""
        raise NotImplementedError

    def reached(self, residual: ResidualRecord) -> Floats:
        """Quantity (samples,) that the limit bounds from above, from the unlimited command."""
        raise NotImplementedError

    def candidate(self, name: str, inspection: Inspection) -> Candidate | None:
        """Speed response to the torque missing under each of a range of limits; None where the command has none."""
        residual = inspection.residual
        found = self.columns(residual)
        if found is None:
            return None
        columns, limits = found
        sizes = limits if residual.record.has_command else np.full(limits.size, np.nan)
        return Candidate(name, columns, sizes, one_sided=True, at_unit_amplitude=self.memory)

    def columns(self, residual: ResidualRecord) -> tuple[Floats, Floats] | None:
        """Speed response (limits, samples) and the limits (limits,); None where the command reaches none."""
        limits = self.limits(residual)
        if not limits.size:
            return None
        missing = self.delivered(residual, limits) - residual.command
        return _response_to_missing(residual, missing, memory=self.memory), limits

    @classmethod
    def reviewed(
        cls, detectors: Mapping[str, Detector], scores: dict[str, Score], inspection: Inspection
    ) -> dict[str, Score]:
        """Scores with the sizes of clearly detected limits from the delivered torque, where that determines them."""
        for name, detector in detectors.items():
            if isinstance(detector, LimitDetector) and is_clear(scores[name]):
                scores = scores | {name: detector.by_delivery(scores[name], inspection.residual)}
        return scores

    def by_delivery(self, score: Score, residual: ResidualRecord) -> Score:
        """The score with the limit under which the speed follows the delivered torque, whatever the model's errors."""
        limits = self.all_limits(residual)
        if not residual.record.has_command or not limits.size:
            return score
        found = limit_by_delivery(residual, limits, lambda limit: self.exactly(residual, limit))
        return score if found is None else replace(score, size=found[0], size_error=found[1])

    def all_limits(self, residual: ResidualRecord) -> Floats:
        """Limits (limits,) that may show, including any that the recorded command does not exceed."""
        return self.limits(residual)

    def exactly(self, residual: ResidualRecord, limit: float) -> Floats:
        """Torque (samples,) that a limit lets pass, N m."""
        return np.asarray(self.delivered(residual, np.array([limit]))[0], dtype=float)


class TorqueLimitDetector(LimitDetector):
    """Torque beyond a limit, which is missing."""

    memory = False

    def delivered(self, residual: ResidualRecord, limits: Floats) -> Floats:
        """The command clipped at each limit; about an unknown mean, on the side of the torque that turns the string."""
        lowest = -limits[:, None] if residual.record.has_command else -np.inf
        turning = np.sign(residual.speed.mean())
        return np.asarray(turning * np.clip(turning * residual.command, lowest, limits[:, None]), dtype=float)

    def reached(self, residual: ResidualRecord) -> Floats:
        """The command."""
        turning = np.sign(residual.command if residual.record.has_command else residual.speed.mean())
        return np.asarray(turning * residual.command, dtype=float)

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Flat tops of the logged command, where it is logged behind its limit; else None."""
        if not inspection.residual.record.has_command:
            return None
        command = inspection.logged.command
        return _clearest(ceiling_score(command), ceiling_score(-command))


class TorqueRateLimitDetector(LimitDetector):
    """Torque that lags behind its command as its rate is limited.

    However small they are, the steps of a command that the control holds take time as well. The torque missing
    meanwhile has harmonics of the sweep beyond its band, by which it is sought, computed from the sweep's part of the
    command alone, which is not correlated with the noise. Even rows show no interval; the control may hold its command
    for each of them.
    """

    memory = True
    accuracy = 0.03

    def candidate(self, name: str, inspection: Inspection) -> Candidate | None:
        """As for any limit, in even rows; else None."""
        return None if inspection.residual.time_error > STEPPED_ROWS else super().candidate(name, inspection)

    def columns(self, residual: ResidualRecord) -> tuple[Floats, Floats] | None:
        """As for any limit, preceded by the responses to the torque that is missing in steps alone."""
        found = super().columns(residual)
        if found is None or not residual.periods:
            return found
        columns, limits = found
        repeated = residual.command - residual.without_sweep(residual.command)
        rates = self.all_limits(residual)
        lacking = np.array([_lacking(residual, repeated, rate) for rate in rates[: -limits.size]])
        of_steps = residual.filtered(-residual.mobility, lacking - lacking.mean(axis=1)[:, None])
        return np.vstack([of_steps, columns]), rates

    def delivered(self, residual: ResidualRecord, limits: Floats) -> Floats:
        """The command, with no step between samples larger than each limit allows."""
        return rate_limited(np.ascontiguousarray(residual.command), limits / residual.record.rate)

    def all_limits(self, residual: ResidualRecord) -> Floats:
        """Rates, N m/s, first those that only the steps of a held command exceed."""
        limits = self.limits(residual)
        return np.append(np.outer(limits[:1], _BEYOND_SLOPES), limits)

    def exactly(self, residual: ResidualRecord, limit: float) -> Floats:
        """The command as far as the rate follows it, or the steps of a held one."""
        if not _is_held(residual) and limit <= self.reached(residual).max():
            return super().exactly(residual, limit)
        return np.asarray(residual.command - _lacking(residual, residual.command, limit), dtype=float)

    def reached(self, residual: ResidualRecord) -> Floats:
        """Rate of the command."""
        return np.abs(np.gradient(residual.command)) * residual.record.rate

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Constant slopes of the logged command, where it is logged behind its limit, in even rows; else None."""
        if not inspection.residual.record.has_command or inspection.logged.time_error > STEPPED_ROWS:
            return None
        found = ceiling_score(np.abs(np.diff(inspection.logged.command)))
        rate = inspection.residual.record.rate
        return found and replace(found, size=found.size * rate, size_error=found.size_error * rate)


class DelayJitterDetector(Detector):
    """Jitter of the delay: noise whose power grows with the square of the command's slope."""

    needs_periods = True
    accuracy, least = 0.15, STAMPED_TO**2
    # coarse quantisation, contact of gear teeth and a limited drive also make noise that grows with the sweep
    excluded_by = ("quantisation", "gear_backlash", "torque_limit", "torque_rate_limit")

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Regression of the noise power on the square of the command's slope; None where the samples are uneven."""
        if inspection.residual.time_error > UNEVEN_ROWS:
            return None
        return jitter_score(inspection.residual, inspection.unexplained)


def ceiling_score(series: Floats) -> Score | None:
    """Score of a level that a series reaches again and again and never exceeds; None where it is not clear.

    The density of a series without a limit falls towards its largest value. So of the times at which it comes within
    two quantisation steps of that value, no more than half come within one. The binomial p-value counts times
    between which the series is lower, as successive samples are not independent.
    """
    from scipy.stats import binom

    top = float(series.max())
    step = quantisation_step(series) or _SAME * max(abs(top), float(np.ptp(series)))
    reached, near = _times(series > top - step / 2), _times((series > top - 3 * step / 2) & (series <= top - step / 2))
    normal = normal_of_p_value(float(binom.sf(reached - 1, reached + near, 0.5)))
    if normal < CLEAR_DETECTION:
        return None
    return Score(normal, top, step / np.sqrt(12), normal**2 / 2)


def _times(inside: Booleans) -> int:
    """How often a condition (samples,) begins to hold."""
    return int(np.count_nonzero(inside[1:] & ~inside[:-1]) + inside[0])


def _clearest(*scores: Score | None) -> Score | None:
    found = [score for score in scores if score is not None]
    return max(found, key=lambda score: score.normal, default=None)


def _is_held(residual: ResidualRecord) -> bool:
    """Whether the rows show at which interval the control holds its command."""
    return bool(np.isfinite(residual.record.sample_rate))


def _lacking(residual: ResidualRecord, command: Floats, rate: float) -> Floats:
    """Torque (samples,) by which a drive of limited rate falls short of a held command, N m.

    The middle of the hold, which counts as a part of the drive's delay, is the time of the command.
    """
    interval = 1 / (residual.record.sample_rate if _is_held(residual) else residual.record.rate)
    time = np.arange(residual.time[0], residual.time[-1] + interval, interval)
    lacking, centroid = lacking_after_steps(CubicSpline(residual.time, command)(time), rate * interval)
    return np.asarray(CubicSpline(time + (centroid - 0.5) * interval, lacking)(residual.time), dtype=float)


def _response_to_missing(residual: ResidualRecord, missing: Floats, *, memory: bool) -> Floats:
    """Speed response (settings, samples) of the top drive to missing torque less its linear part, rad/s."""
    command = rfft(residual.command - residual.command.mean())
    active = np.abs(missing) > _NEGLIGIBLE * np.abs(residual.command).max()
    transfers = np.array([_linear_part(row, memory=memory) for row in active])
    spectrum = rfft(missing - missing.mean(axis=1)[:, None]) - transfers * command
    return np.asarray(irfft(spectrum * residual.mobility, residual.samples), dtype=float)


def _linear_part(active: Booleans, *, memory: bool) -> Complex:
    """Mean transfer function (line,) from command to missing torque.

    While a drive is at its torque limit, a rise of the command lowers the missing torque by as much. A drive at its
    rate limit has memory: its torque is that commanded when it reached the limit, plus the ramp since.

    Parameters
    ----------
    active : (samples,) whether the limit is active
    memory : whether it is the limit of the rate
    """
    kernel = np.zeros(active.size)
    if memory:
        place = np.arange(active.size)
        since = place - np.maximum.accumulate(np.where(active, 0, place))
        kernel = np.bincount(since[active], minlength=active.size) / active.size
    kernel[0] -= active.mean()
    return np.asarray(rfft(kernel), dtype=complex)


def jitter_score(residual: ResidualRecord, unexplained: Floats) -> Score:
    """Score of noise that grows with the square of the command's slope, where the sweep is periodic.

    A delay in error by ξ makes a torque error of ξ times the command's slope. The noise power, weighted towards the
    frequencies at which jitter is most visible, is regressed on the square of that part of the slope that is periodic
    with the sweep, which is free of noise. The noise's density is that of ξ times the interval of the control, for
    which each delay holds: where rows do not show that interval, the size is unknown.

    Parameters
    ----------
    unexplained : (samples,) rad/s, speed explained by neither the sweep nor other causes
    """
    rate, samples = residual.record.rate, residual.samples
    low, high = _JITTER_BAND[0], _JITTER_BAND[1] * residual.sample_rate
    inside = (residual.frequency > low) & (residual.frequency < high)
    sensitivity = np.where(inside, np.abs(residual.mobility) ** 2 * samples / residual.noise, 0.0)
    weight = np.sqrt(sensitivity / sensitivity.max())
    power = residual.filtered(weight * np.sqrt(samples / residual.noise) * inside, unexplained * residual.taper) ** 2
    slope = residual.filtered(residual.s, residual.command - residual.command.mean())
    periodic_slope = slope - residual.without_sweep(slope)
    size_block = round(_BLOCK_S * rate)
    count = samples // size_block
    blocks = [
        values[: count * size_block].reshape(count, -1).mean(axis=1)
        for values in (power, periodic_slope**2 * residual.taper**2, residual.taper**2)
    ]
    untapered = blocks[2] > 1 - 1e-6
    response, regressor = blocks[0][untapered], blocks[1][untapered]
    hold = 1 / residual.record.sample_rate if np.isfinite(residual.record.sample_rate) else np.nan
    seen = float(np.sum(weight**2 * sensitivity * np.sinc(residual.frequency * hold) ** 2))
    gain = 2 / samples * seen * hold * rate / residual.inflation
    coefficient, error = _regression(regressor - regressor.mean(), response)
    ratio = coefficient / error
    normal = normal_of_p_value(float(stdtr(response.size - 2, -ratio)))
    return Score(normal, coefficient / gain, error / gain, max(normal, 0.0) ** 2 / 2)


def _regression(regressor: Floats, response: Floats) -> tuple[float, float]:
    """Slope on a centred regressor, and its standard error robust to heteroscedasticity and autocorrelation.

    Autocovariances are weighted after Newey and West (1987, Econometrica 55, 703–708).
    """
    energy = float(regressor @ regressor)
    slope = float(regressor @ response) / energy
    residual = response - response.mean() - slope * regressor
    leverage = 1 / regressor.size + regressor**2 / energy
    products = regressor * residual / (1 - leverage)
    total = float(products @ products)
    for lag in range(1, _NEIGHBOURS + 1):
        total += 2 * (1 - lag / (_NEIGHBOURS + 1)) * float(products[lag:] @ products[:-lag])
    return slope, float(np.sqrt(max(total, 0.1 * float(products @ products)))) / energy

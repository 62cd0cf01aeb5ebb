"""Detections of a drive that does not give the torque that it is asked for: limits of torque and of its rate.

The torque that such a drive leaves out is computed from the command for a range of limits, and is looked for in the
speed, which it must move as the sweep does. The noise in the speed is in the command too, through the control; but
of what is left out only a linear part goes with it in the mean, whose filter is the mean derivative of what is left
out to the command (Bussgang 1952, MIT Research Laboratory of Electronics, report 216; Stein 1981, Annals of
Statistics 9, 1135–1151). Less that part, what is left out goes with Gaussian noise no more than by chance.
"""

import numpy as np
from scipy.fft import irfft, rfft
from scipy.special import stdtr

from drillid.arrays import Booleans, Complex, Floats
from drillid.discrepancy.detectors.detector import Detector, Inspection
from drillid.discrepancy.detectors.residual_record import ResidualRecord
from drillid.discrepancy.detectors.score import Candidate, Score, normal_of_p_value

_BEYOND = np.array([0.003, 0.006, 0.012, 0.025, 0.05, 0.09, 0.15, 0.25, 0.4, 0.6, 0.8, 0.92])
"""Shares of the record's time beyond the limits that are tried."""
_NOTHING = 1e-9
"""Of the command's largest value, below which nothing counts as left out."""

_JITTER_BAND = (1.0, 0.4)
"""Lowest frequency, Hz, and highest, as a share of the rate."""
_HOLD_S = 0.02
"""s, for which each delay of a jittering drive is taken to hold."""
_BLOCK_S = 4.0
_NEIGHBOURS = 6
"""Blocks over which the noise's level stays much the same."""


class TorqueLimitDetector(Detector):
    """Torque beyond a limit, which is then missing; the limit is unknown where the command is reconstructed.

    A reconstructed command lacks its mean.
    """

    def candidate(self, name: str, inspection: Inspection) -> Candidate:
        """Speed by the torque beyond each of a range of limits."""
        residual = inspection.residual
        limits = np.quantile(np.abs(residual.command), 1 - _BEYOND)
        missing = np.clip(residual.command, -limits[:, None], limits[:, None]) - residual.command
        moved = _moved(residual, missing, remembers=False)
        return Candidate(name, moved, _known(limits, residual), one_sided=True)


class TorqueRateLimitDetector(Detector):
    """Torque that comes late as its rate is limited; the limit is unknown where the command is reconstructed.

    A reconstructed command does not show how it changes between the samples of the record.
    """

    def candidate(self, name: str, inspection: Inspection) -> Candidate:
        """Speed by the torque left out under each of a range of limits of the rate."""
        residual, rate = inspection.residual, inspection.residual.record.rate
        limits = np.quantile(np.abs(np.gradient(residual.command) * rate), 1 - _BEYOND)
        missing = rate_limited(residual.command, limits / rate) - residual.command
        moved = _moved(residual, missing, remembers=True)
        return Candidate(name, moved, _known(limits, residual), one_sided=True, whole=True)


class DelayJitterDetector(Detector):
    """Noise that grows with the square of the command's slope."""

    needs_periods = True
    # coarse steps and teeth that meet are noise that grows with the sweep, as jitter is
    excluded_by = ("quantisation", "gear_backlash")

    def score(self, name: str, inspection: Inspection) -> Score:
        """Regression of the noise's power on the square of the slope."""
        return jitter_score(inspection.residual, inspection.unexplained)


def _known(limits: Floats, residual: ResidualRecord) -> Floats:
    return limits if residual.record.has_command else np.full(limits.size, np.nan)


def rate_limited(series: Floats, steps: Floats) -> Floats:
    """A series (samples,) that changes by no more than each of some steps from sample to sample, (steps, samples)."""
    given = np.empty((series.size, steps.size))
    now = np.full(steps.size, series[0])
    for sample, asked in enumerate(series.tolist()):
        now = np.minimum(np.maximum(asked, now - steps), now + steps)
        given[sample] = now
    return np.ascontiguousarray(given.T)


def _moved(residual: ResidualRecord, missing: Floats, *, remembers: bool) -> Floats:
    """Speed (settings, samples) by which torque left out moves the top drive, less its linear part, rad/s."""
    command = rfft(residual.command - residual.command.mean())
    active = np.abs(missing) > _NOTHING * np.abs(residual.command).max()
    transfers = np.array([_linear_part(row, remembers=remembers) for row in active])
    spectrum = rfft(missing - missing.mean(axis=1)[:, None]) - transfers * command
    return np.asarray(irfft(spectrum * residual.mobility, residual.samples), dtype=float)


def _linear_part(active: Booleans, *, remembers: bool) -> Complex:
    """Transfer (line,) from command to torque left out, in the mean.

    While a drive is at its limit, what it leaves out falls by as much as the command rises; a drive at the limit of
    its rate still gives what was asked for when it came to that limit, and what it has added since.
    """
    kernel = np.zeros(active.size)
    if remembers:
        place = np.arange(active.size)
        since = place - np.maximum.accumulate(np.where(active, 0, place))
        kernel = np.bincount(since[active], minlength=active.size) / active.size
    kernel[0] -= active.mean()
    return np.asarray(rfft(kernel), dtype=complex)


def jitter_score(residual: ResidualRecord, left: Floats) -> Score:
    """Score of noise that grows with the square of the command's slope, where the sweep repeats.

    A delay off by ξ leaves out the torque ξ times the command's slope. The noise's power, weighted by where jitter
    shows best, is regressed on the square of the slope that repeats with the sweep, in which noise has no part.

    Parameters
    ----------
    left : (samples,) rad/s, what neither the sweep nor other causes account for
    """
    rate, samples = residual.record.rate, residual.samples
    low, high = _JITTER_BAND[0], _JITTER_BAND[1] * rate
    inside = (residual.frequency > low) & (residual.frequency < high)
    shown = np.where(inside, np.abs(residual.mobility) ** 2 * samples / residual.noise, 0.0)
    weight = np.sqrt(shown / shown.max())
    power = residual.filtered(weight * np.sqrt(samples / residual.noise) * inside, left * residual.taper) ** 2
    slope = residual.filtered(residual.s, residual.command - residual.command.mean())
    repeated = slope - residual.without_sweep(slope)
    size_block = round(_BLOCK_S * rate)
    count = samples // size_block
    blocks = [
        values[: count * size_block].reshape(count, -1).mean(axis=1)
        for values in (power, repeated**2 * residual.taper**2, residual.taper**2)
    ]
    whole = blocks[2] > 1 - 1e-6
    response, driver = blocks[0][whole], blocks[1][whole]
    gain = 2 / samples * float(np.sum(weight**2 * shown)) * _HOLD_S * rate / residual.inflation
    slope_found, error = _regression(driver - driver.mean(), response)
    ratio = slope_found / error
    normal = normal_of_p_value(float(stdtr(response.size - 2, -ratio)))
    return Score(normal, slope_found / gain, error / gain, max(normal, 0.0) ** 2 / 2)


def _regression(driver: Floats, response: Floats) -> tuple[float, float]:
    """Slope on a centred driver and its standard error, whatever the variances are and if neighbours go together.

    Covariances of neighbours are weighted after Newey and West (1987, Econometrica 55, 703–708).
    """
    energy = float(driver @ driver)
    slope = float(driver @ response) / energy
    residual = response - response.mean() - slope * driver
    leverage = 1 / driver.size + driver**2 / energy
    products = driver * residual / (1 - leverage)
    total = float(products @ products)
    for lag in range(1, _NEIGHBOURS + 1):
        total += 2 * (1 - lag / (_NEIGHBOURS + 1)) * float(products[lag:] @ products[:-lag])
    return slope, float(np.sqrt(max(total, 0.1 * float(products @ products)))) / energy

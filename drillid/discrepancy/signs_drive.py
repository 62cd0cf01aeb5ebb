"""Signs of a drive that does not give the torque that it is asked for: limits of torque and of its rate.

The torque that such a drive leaves out is reckoned from the command for a range of limits, and is looked for in the
speed, which it must move as the sweep does. The noise in the speed is in the command too, through the control; but
of what is left out only a linear part goes with it in the mean, whose filter is the mean derivative of what is left
out to the command (Bussgang 1952, MIT Research Laboratory of Electronics, report 216; Stein 1981, Annals of
Statistics 9, 1135–1151). Less that part, what is left out goes with Gaussian noise no more than by chance.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft

from drillid.discrepancy.signs_record import Remainder
from drillid.discrepancy.signs_score import Candidate

Floats = NDArray[np.float64]

_BEYOND = np.array([0.003, 0.006, 0.012, 0.025, 0.05, 0.09, 0.15, 0.25, 0.4, 0.6, 0.8, 0.92])
"""Shares of the record's time beyond the limits that are tried."""
_NOTHING = 1e-9
"""Of the command's largest value, below which nothing counts as left out."""


def drive_candidates(remainder: Remainder) -> list[Candidate]:
    """Missing torque of both limits; they are unknown where the command is reckoned.

    Its mean is not known then, nor how it jerks between the samples of the record.
    """
    command, rate = remainder.command, remainder.record.rate
    levels = np.quantile(np.abs(command), 1 - _BEYOND)
    cut = np.clip(command, -levels[:, None], levels[:, None]) - command
    rates = np.quantile(np.abs(np.gradient(command) * rate), 1 - _BEYOND)
    slowed = rate_limited(command, rates / rate) - command
    if not remainder.record.has_command:
        levels, rates = np.full(levels.size, np.nan), np.full(rates.size, np.nan)
    return [
        Candidate("torque_limit", _moved(remainder, cut, remembers=False), levels, one_sided=True),
        Candidate("torque_rate_limit", _moved(remainder, slowed, remembers=True), rates, one_sided=True, whole=True),
    ]


def rate_limited(series: Floats, steps: Floats) -> Floats:
    """A series (samples,) that changes by no more than each of some steps from sample to sample, (steps, samples)."""
    given = np.empty((series.size, steps.size))
    now = np.full(steps.size, series[0])
    for sample, asked in enumerate(series.tolist()):
        now = np.minimum(np.maximum(asked, now - steps), now + steps)
        given[sample] = now
    return np.ascontiguousarray(given.T)


def _moved(remainder: Remainder, missing: Floats, *, remembers: bool) -> Floats:
    """Speed (settings, samples) by which torque left out moves the top drive, less its linear part, rad/s."""
    command = rfft(remainder.command - remainder.command.mean())
    active = np.abs(missing) > _NOTHING * np.abs(remainder.command).max()
    transfers = np.array([_linear_part(row, remembers=remembers) for row in active])
    spectrum = rfft(missing - missing.mean(axis=1)[:, None]) - transfers * command
    return np.asarray(irfft(spectrum * remainder.mobility, remainder.samples), dtype=float)


def _linear_part(active: NDArray[np.bool_], *, remembers: bool) -> NDArray[np.complex128]:
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

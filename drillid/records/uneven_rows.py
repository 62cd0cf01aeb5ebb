"""Rows that each show samples of a control that is not in step with them, at an interval at which no row is repeated.

The part of the injected torque that is too rough for its own band is the rows' error, see `drillid.records.roughness`:
the interval is the one at which such errors fit.
"""

from __future__ import annotations

import numpy as np
from scipy.fft import irfft, rfft, rfftfreq

from drillid.arrays import Floats
from drillid.records.roughness import HELD, ON_LINES, TAPERED, Kind, Roughness, Step, rough_share

_LEAST_ROWS = 256
"""Least number of rows of a record whose interval is sought."""
_PADDED = 4
"""Factor by which the spectrum in which the interval is sought is finer than the record's own resolution."""
_SHORTEST, _HARMONICS = 0.2, 4
"""Shortest interval that is sought, rows, and highest harmonic of its rate that the strongest line may be."""
_LOWEST = 0.004
"""Lowest frequency of that line, cycles per row."""
_CLEAR = 150.0
"""Least power of that line relative to the mean: noise and rounding reach up to 40, rows out of step 600 or more."""
_PART, _FEW = 8, 5
"""Part of the record, one in this many, in which steps are compared, and number of those compared over all of it."""
_TOLD = 0.1
"""Largest misfit relative to that of even rows, median over the parts, at which an interval is accepted."""


def aged_samples(channels: Floats) -> tuple[Floats, float] | None:
    """Places (row,) of the samples that rows hold and the control's interval, both in rows; None where they hold none.

    Parameters
    ----------
    channels : shape (channel, time), finite, all recorded alike; the first is the one with the least noise
    """
    from scipy.signal import detrend

    found = _step(channels, HELD)
    if found is None:
        return None
    step, rows = found[0], channels.shape[1]
    # the roughness does not show a slow change of all ages, which would be a drift of the clock
    return np.arange(rows) - detrend(step.fraction(rows) * step.interval), step.interval


def off_their_lines(channels: Floats) -> tuple[Floats, float] | None:
    """Channels corrected for the curvature that rows on lines between samples miss, and the control's interval in rows;
    None where rows are not on such lines.

    Parameters
    ----------
    channels : as for `aged_samples`
    """
    found = _step(channels, ON_LINES)
    if found is None:
        return None
    step, highest = found
    error = ON_LINES.error(step.fraction(channels.shape[1]), step.interval)
    return channels - error * np.stack([_curvature(channel, highest) for channel in channels]), step.interval


def _curvature(channel: Floats, highest: float) -> Floats:
    """Second derivative (row,) of a channel's content up to a frequency, cycles per row."""
    ends = max(1, round(TAPERED * channel.size))
    lines = rfft(np.pad(channel, ends, "reflect", reflect_type="odd"))
    frequency = rfftfreq(channel.size + 2 * ends)
    lines = -((2 * np.pi * frequency) ** 2) * (1 - rough_share(frequency, highest)) * lines
    curved = irfft(lines, channel.size + 2 * ends)
    return np.asarray(curved[ends:-ends], dtype=float)


def _step(channels: Floats, kind: Kind) -> tuple[Step, float] | None:
    """Step of the control relative to rows of a kind, and highest frequency of the first channel, cycles per row; None
    where rows are even, or not all channels are of this kind.
    """
    from scipy.optimize import minimize

    if channels.shape[1] < _LEAST_ROWS:
        return None
    rough = Roughness(channels[0], kind)
    if rough.unevenness < kind.even:
        return None
    start, rows = _start(channels[0], rough), channels.shape[1]
    if start is None:
        return None
    # the sawtooth must not slip along the record
    found = minimize(
        lambda moved: rough.misfit(Step(start.frequency + moved[0] / rows, start.phase + moved[1])),
        np.zeros(2),
        method="Nelder-Mead",
        options={"initial_simplex": [[0.0, 0.0], [0.2, 0.0], [0.0, 0.1]], "xatol": 1e-3, "fatol": 1e-4},
    )
    step = Step(start.frequency + found.x[0] / rows, start.phase + found.x[1])
    if not rough.median_misfit(step) < _TOLD:
        return None
    others = [Roughness(channel, kind, rough.highest) for channel in channels[1:]]
    return None if any(other.contradicts(step) for other in others) else (step, rough.highest)


def _start(channel: Floats, rough: Roughness) -> Step | None:
    """The likely step that fits best, of the few that fit best where the derivative is largest; None without any."""
    likely = _likely(rough)
    if not likely:
        return None
    length = rough.rows // _PART
    large = np.cumsum(np.append(0.0, rough.derivative**2))
    first = int(np.argmax(large[length:] - large[:-length]))
    part = Roughness(channel[first : first + length], rough.kind)
    best = sorted(likely, key=lambda each: part.misfit(Step(each.frequency, each.phase + each.frequency * first)))
    return min(best[:_FEW], key=rough.misfit)


def _likely(rough: Roughness) -> list[Step]:
    """Steps of which the strongest line of the rows' errors may be a harmonic; none where no line stands out.

    The n-th harmonic of the errors is proportional to cos 2π (n (f k + φ) + turn) at row k, and the line is n f, less a
    whole number, or that with its sign reversed.
    """
    size, errors = _PADDED * rough.rows, rough.errors()
    lowest = round(_LOWEST * size)
    power = np.abs(rfft(errors, size)) ** 2
    place = lowest + int(np.argmax(power[lowest:-1]))
    before, at, after = power[place - 1 : place + 2]
    if at < _CLEAR * power[lowest:].mean():
        return []
    line = (place + 0.5 * (before - after) / (before - 2 * at + after)) / size
    turn = float(np.angle(errors @ np.exp(-2j * np.pi * line * np.arange(rough.rows)))) / (2 * np.pi)
    likely = []
    for harmonic in range(1, _HARMONICS + 1):
        for sign in (1, -1):
            frequencies = (np.arange(harmonic / _SHORTEST + 1) + sign * line) / harmonic
            phases = (sign * turn - rough.kind.turn + np.arange(harmonic)) / harmonic
            likely += [Step(each, p) for each in frequencies[frequencies > 1 / rough.kind.longest] for p in phases]
    return likely

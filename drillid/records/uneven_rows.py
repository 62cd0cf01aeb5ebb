"""Rows that each show the samples of a control that is not in step with them, at an interval that no row repeats.

Where the control reads every h seconds and a row is written every T, a row falls at a fraction of the control's
interval that is a sawtooth in time of period h, read every T. A row that holds the last sample is off by its age times
the slope; one on a line between two samples is off by what the line leaves of the curvature. What of the injected
torque is too rough for its own band is that error.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.fft import irfft, rfft, rfftfreq
from scipy.optimize import minimize
from scipy.signal import detrend

from drillid.arrays import Complex, Floats, Integers

_MOST_POWER, _SMOOTH, _ROUGH = 0.98, 1.25, 1.5
"""Share of the torque's power that lies below its highest frequency; how far above that a channel is smooth, and from
where it is rough. Between the two it is in part either, so that jumps of the torque ring briefly."""
_USUAL = 0.95
"""Quantile of a derivative's square up to which it counts."""
_BLOCKS = 128
"""Parts of a record whose misfits are compared, so that a jump of the torque disturbs some of them alone."""
_TAPERED = 0.02
"""Share of the record at either end that is tapered."""
_PADDED = 4
"""Finer than a record's own resolution by this factor is the spectrum in which the interval is sought."""
_SHORTEST, _HARMONICS = 0.2, 4
"""Rows, shortest interval that is sought, and harmonics of its rate of which the strongest line may be one."""
_LOWEST = 0.004
"""Cycles a row, lowest frequency of that line."""
_PART, _FEW = 8, 5
"""Part of the record, one in so many, in which steps are compared, and the number of those compared over all of it."""
_LEAST_SHARE, _SURE = 0.5, 3.0
"""Share of the expected roughness that another channel must have, within so many standard errors."""
_TOLD = 0.1
"""Largest misfit relative to that of even rows, in the median over the parts, at which an interval is believed."""


class Kind(NamedTuple):
    """How a row follows from the samples about it."""

    order: int
    """Of the derivative that its error is proportional to."""
    error: Callable[[Floats, float], Floats]
    """Error per derivative at fractions (row,) of an interval, both in rows."""
    turn: float
    """Phase of the error's harmonics at the first sample, in turns: that of a cosine is zero."""
    longest: float
    """Rows, interval beyond which the samples show themselves."""
    even: float
    """Error per derivative below which rows are as good as even."""


HELD = Kind(1, lambda fraction, interval: (0.5 - fraction) * interval, -0.25, 1.0, 0.01)
"""The last sample; relative to its mean age."""
ON_LINES = Kind(2, lambda fraction, interval: fraction * (1 - fraction) * interval**2 / 2, 0.5, 2.0, 0.006)
"""The line from the last sample to the next."""


class Step(NamedTuple):
    """How the control steps past the rows."""

    frequency: float
    """Samples a row."""
    phase: float
    """Fraction of the interval at which the first row falls."""

    @property
    def interval(self) -> float:
        """Rows between samples."""
        return 1 / self.frequency

    def fraction(self, rows: int) -> Floats:
        """Fraction (row,) of the interval at which each row falls."""
        return np.asarray(np.mod(np.arange(rows) * self.frequency + self.phase, 1.0), dtype=float)


def aged_samples(channels: Floats) -> tuple[Floats, float] | None:
    """Places (row,) of the samples that rows hold and the control's interval, both in rows; None where they hold none.

    Parameters
    ----------
    channels : shape (channel, time), finite, all recorded alike; the first is that with the least noise
    """
    step = _step(channels, HELD)
    if step is None:
        return None
    rows = channels.shape[1]
    # the roughness does not tell a slow change of all ages, which would be a drift of the clock
    return np.arange(rows) - detrend(step.fraction(rows) * step.interval), step.interval


def off_their_lines(channels: Floats) -> tuple[Floats, float] | None:
    """Channels of rows on lines between samples less what the lines leave of their curves, and the control's interval
    in rows; None where rows are on no such lines.

    Parameters
    ----------
    channels : as for `aged_samples`
    """
    step = _step(channels, ON_LINES)
    if step is None:
        return None
    error = ON_LINES.error(step.fraction(channels.shape[1]), step.interval)
    highest = Roughness(channels[0], ON_LINES).highest
    return channels - error * np.stack([_curvature(channel, highest) for channel in channels]), step.interval


def _curvature(channel: Floats, highest: float) -> Floats:
    """Second derivative (row,) of a channel's content up to a frequency, cycles a row."""
    ends = max(1, round(_TAPERED * channel.size))
    lines = rfft(np.pad(channel, ends, "reflect", reflect_type="odd"))
    frequency = rfftfreq(channel.size + 2 * ends)
    lines = -((2 * np.pi * frequency) ** 2) * (1 - _roughness(frequency, highest)) * lines
    curved = irfft(lines, channel.size + 2 * ends)
    return np.asarray(curved[ends:-ends], dtype=float)


def _roughness(frequency: Floats, highest: float) -> Floats:
    """Share (line,) of a channel that is too rough for a band up to the highest frequency, cycles a row."""
    place = (frequency / max(highest, np.finfo(float).tiny) - _SMOOTH) / (_ROUGH - _SMOOTH)
    return np.asarray(np.sin(np.pi / 2 * np.clip(place, 0.0, 1.0)) ** 2, dtype=float)


def _step(channels: Floats, kind: Kind) -> Step | None:
    """How the control steps past rows of a kind; None where they are even, or not all channels are of this kind."""
    rough = Roughness(channels[0], kind)
    if not rough.uneven:
        return None
    start, rows = _start(channels[0], rough), channels.shape[1]
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
    return None if any(other.contradicts(step) for other in others) else step


class Roughness:
    """What of a channel (time,) is too rough for its band, and the derivative within it that a row's error goes with.

    Parameters
    ----------
    highest : cycles a row, of the band; by default that of the channel itself
    """

    def __init__(self, channel: Floats, kind: Kind, highest: float | None = None) -> None:
        self.rows, self.kind = channel.size, kind
        ends = max(1, round(_TAPERED * self.rows))
        ramp = np.minimum(np.arange(self.rows), np.arange(self.rows)[::-1]) / ends
        taper = np.sin(np.pi / 2 * np.minimum(ramp, 1.0)) ** 2
        frequency = rfftfreq(self.rows)
        lines: Complex = rfft((channel - channel.mean()) * taper)
        if highest is None:
            power = np.cumsum(np.abs(lines) ** 2)
            highest = float(frequency[np.searchsorted(power, _MOST_POWER * power[-1])])
        self.highest = highest
        self._rough_lines = _roughness(frequency, highest)
        self.rough = self._without_smooth(lines)
        derived = lines * (2j * np.pi * frequency) ** kind.order * (1 - self._rough_lines)
        self.derivative = np.asarray(irfft(derived, self.rows), dtype=float)
        self.power = self._in_blocks(self.rough)

    @property
    def uneven(self) -> bool:
        """Whether there is more roughness than even rows have; not where the channel has no band of its own."""
        steep = self._in_blocks(self.derivative)
        inside = steep > 0
        return bool(inside.any() and np.median(self.power[inside] / steep[inside]) > self.kind.even**2)

    def errors(self) -> Floats:
        """Apparent error (time,) of each row per derivative, weighted with its square, of which jumps have no more than
        other rows.
        """
        share = self.rough / np.where(self.derivative == 0, np.inf, self.derivative)
        weight = np.minimum(self.derivative**2, np.quantile(self.derivative**2, _USUAL))
        return np.asarray(np.clip(share, -0.5, 0.5) * weight, dtype=float)

    def misfit(self, step: Step) -> float:
        """Mean over the parts of what such steps leave of the roughness, as a share of it."""
        return float(np.minimum(self._misfits(step), 1.0).mean())

    def median_misfit(self, step: Step) -> float:
        """Median over the parts of the same."""
        return float(np.median(self._misfits(step)))

    def contradicts(self, step: Step) -> bool:
        """Whether the channel surely has less than half of the roughness that such steps would make."""
        expected, starts = self._expected(step), self._starts()
        power, product = (np.add.reduceat(expected * series, starts) for series in (expected, self.rough))
        share = product.sum() / max(power.sum(), np.finfo(float).tiny)
        error = np.sqrt(np.sum((product - share * power) ** 2)) / max(power.sum(), np.finfo(float).tiny)
        return bool(share + _SURE * error < _LEAST_SHARE)

    def _misfits(self, step: Step) -> Floats:
        left = self._in_blocks(self.rough - self._expected(step))
        return np.asarray(left / np.where(self.power > 0, self.power, np.inf), dtype=float)

    def _expected(self, step: Step) -> Floats:
        error = self.kind.error(step.fraction(self.rows), step.interval)
        return self._without_smooth(rfft(error * self.derivative))

    def _without_smooth(self, lines: Complex) -> Floats:
        return np.asarray(irfft(lines * self._rough_lines, self.rows), dtype=float)

    def _in_blocks(self, series: Floats) -> Floats:
        return np.asarray(np.add.reduceat(series**2, self._starts()), dtype=float)

    def _starts(self) -> Integers:
        return np.arange(0, self.rows, max(1, self.rows // _BLOCKS))


def _start(channel: Floats, rough: Roughness) -> Step:
    """The likely step that fits best, of the few that do where the derivative is largest."""
    length = rough.rows // _PART
    large = np.cumsum(np.append(0.0, rough.derivative**2))
    first = int(np.argmax(large[length:] - large[:-length]))
    part = Roughness(channel[first : first + length], rough.kind)
    best = sorted(
        _likely(rough), key=lambda each: part.misfit(Step(each.frequency, each.phase + each.frequency * first))
    )
    return min(best[:_FEW], key=rough.misfit)


def _likely(rough: Roughness) -> list[Step]:
    """Steps of which the strongest line of the rows' errors may be a harmonic.

    The n-th harmonic of the errors is proportional to cos 2π (n (f k + φ) + turn) at row k, and the line is n f, less a
    whole number, or that with its sign reversed.
    """
    size, errors = _PADDED * rough.rows, rough.errors()
    lowest = round(_LOWEST * size)
    power = np.abs(rfft(errors, size)) ** 2
    place = lowest + int(np.argmax(power[lowest:-1]))
    before, at, after = power[place - 1 : place + 2]
    line = (place + 0.5 * (before - after) / (before - 2 * at + after)) / size
    turn = float(np.angle(errors @ np.exp(-2j * np.pi * line * np.arange(rough.rows)))) / (2 * np.pi)
    likely = []
    for harmonic in range(1, _HARMONICS + 1):
        for sign in (1, -1):
            frequencies = (np.arange(harmonic / _SHORTEST + 1) + sign * line) / harmonic
            phases = (sign * turn - rough.kind.turn + np.arange(harmonic)) / harmonic
            likely += [Step(each, p) for each in frequencies[frequencies > 1 / rough.kind.longest] for p in phases]
    return likely

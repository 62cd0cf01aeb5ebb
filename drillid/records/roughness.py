"""What of a channel is too rough for its own band, and what rows that are not in step with the control make of it.

Where the control reads every h seconds and a row is written every T, a row falls at a fraction of the control's
interval that is a sawtooth in time of period h, read every T. A row that holds the last sample is off by its age times
the slope; one on a line between two samples is off by what the line leaves of the curvature.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.fft import irfft, rfft, rfftfreq

from drillid.arrays import Complex, Floats, Integers

_MOST_POWER, _SMOOTH, _ROUGH = 0.98, 1.25, 1.5
"""Share of a channel's power that lies below its highest frequency; how far above that it is smooth, and from where it
is rough. Between the two it is in part either, so that jumps of a torque ring briefly."""
_USUAL = 0.95
"""Quantile of a derivative's square up to which it counts."""
_BLOCKS = 128
"""Parts of a record whose misfits are compared, so that a jump of the torque disturbs some of them alone."""
TAPERED = 0.02
"""Share of the record at either end that is tapered."""
_LEAST_SHARE, _SURE = 0.5, 3.0
"""Share of the expected roughness that another channel must have, within so many standard errors."""


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


def rough_share(frequency: Floats, highest: float) -> Floats:
    """Share (line,) of a channel that is too rough for a band up to the highest frequency, cycles a row."""
    place = (frequency / max(highest, np.finfo(float).tiny) - _SMOOTH) / (_ROUGH - _SMOOTH)
    return np.asarray(np.sin(np.pi / 2 * np.clip(place, 0.0, 1.0)) ** 2, dtype=float)


class Roughness:
    """What of a channel (time,) is too rough for its band, and the derivative within it that a row's error goes with.

    Parameters
    ----------
    highest : cycles a row, of the band; by default that of the channel itself
    """

    def __init__(self, channel: Floats, kind: Kind, highest: float | None = None) -> None:
        self.rows, self.kind = channel.size, kind
        ends = max(1, round(TAPERED * self.rows))
        ramp = np.minimum(np.arange(self.rows), np.arange(self.rows)[::-1]) / ends
        taper = np.sin(np.pi / 2 * np.minimum(ramp, 1.0)) ** 2
        frequency = rfftfreq(self.rows)
        lines: Complex = rfft((channel - channel.mean()) * taper)
        if highest is None:
            power = np.cumsum(np.abs(lines) ** 2)
            highest = float(frequency[np.searchsorted(power, _MOST_POWER * power[-1])])
        self.highest = highest
        self._rough_lines = rough_share(frequency, highest)
        self.rough = self._without_smooth(lines)
        derived = lines * (2j * np.pi * frequency) ** kind.order * (1 - self._rough_lines)
        self.derivative = np.asarray(irfft(derived, self.rows), dtype=float)
        self.power = self._in_blocks(self.rough)

    @property
    def unevenness(self) -> float:
        """Root mean square of the rows' errors per derivative, in the median over the parts; 0 where the channel has no
        band of its own.
        """
        steep = self._in_blocks(self.derivative)
        inside = steep > 0
        return float(np.sqrt(np.median(self.power[inside] / steep[inside]))) if inside.any() else 0.0

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

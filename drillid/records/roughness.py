"""The part of a channel that is too rough for its own band, and what rows out of step with the control make of it.

Where the control samples every h seconds and a row is written every T, the place of a row within the control's
interval is a sawtooth in time of period h, sampled every T. A row that holds the last sample is off by its age times
the slope; one on a line between two samples is off by the curvature that the line misses.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.fft import irfft, rfft, rfftfreq

from drillid.arrays import Complex, Floats, Integers

_MOST_POWER, _SMOOTH, _ROUGH = 0.98, 1.25, 1.5
"""Share of a channel's power that lies below its highest frequency; multiples of that up to which it is smooth, and
from which it is rough. Between the two it is partly each, so that jumps of a torque ring only briefly."""
_USUAL = 0.95
"""Quantile at which the square of a derivative is limited."""
_BLOCKS = 128
"""Number of parts of a record whose misfits are compared, so that a jump of the torque disturbs only some of them."""
TAPERED = 0.02
"""Share of the record that is tapered at either end."""
_LEAST_SHARE, _SURE = 0.5, 3.0
"""Least share of the expected roughness in another channel, and the standard errors that it is allowed."""


class Kind(NamedTuple):
    """How a row follows from the samples around it."""

    order: int
    """Order of the derivative to which its error is proportional."""
    error: Callable[[Floats, float], Floats]
    """Error per unit of the derivative, from the fractions (row,) of the interval and the interval in rows."""
    turn: float
    """Phase of the error's harmonics at the first sample, in turns; zero for a cosine."""
    longest: float
    """Interval beyond which the rows show the samples directly, rows."""
    even: float
    """Error per unit of the derivative below which rows count as even."""


HELD = Kind(1, lambda fraction, interval: (0.5 - fraction) * interval, -0.25, 1.0, 0.01)
"""Rows that hold the last sample; errors are relative to its mean age."""
ON_LINES = Kind(2, lambda fraction, interval: fraction * (1 - fraction) * interval**2 / 2, 0.5, 2.0, 0.006)
"""Rows on the line from the last sample to the next."""


class Step(NamedTuple):
    """Step of the control relative to the rows."""

    frequency: float
    """Samples per row."""
    phase: float
    """Fraction of the interval at which the first row falls."""

    @property
    def interval(self) -> float:
        """Interval between samples, rows."""
        return 1 / self.frequency

    def fraction(self, rows: int) -> Floats:
        """Fraction (row,) of the interval at which each row falls."""
        return np.asarray(np.mod(np.arange(rows) * self.frequency + self.phase, 1.0), dtype=float)


def rough_share(frequency: Floats, highest: float) -> Floats:
    """Share (line,) of each spectral line that is too rough for a band up to `highest`; both cycles per row."""
    place = (frequency / max(highest, np.finfo(float).tiny) - _SMOOTH) / (_ROUGH - _SMOOTH)
    return np.asarray(np.sin(np.pi / 2 * np.clip(place, 0.0, 1.0)) ** 2, dtype=float)


class Roughness:
    """The part of a channel (time,) too rough for its band, and the derivative within it that sets the rows' errors.

    Parameters
    ----------
    highest : highest frequency of the band, cycles per row; by default that of the channel itself
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
        """Root mean square of the rows' errors per unit of the derivative, median over the parts; 0 where the channel
        has no band of its own.
        """
        steep = self._in_blocks(self.derivative)
        inside = steep > 0
        return float(np.sqrt(np.median(self.power[inside] / steep[inside]))) if inside.any() else 0.0

    def errors(self) -> Floats:
        """Apparent error (time,) of each row per unit of the derivative, weighted with its square, which is limited so
        that jumps weigh no more than other rows.
        """
        share = self.rough / np.where(self.derivative == 0, np.inf, self.derivative)
        weight = np.minimum(self.derivative**2, np.quantile(self.derivative**2, _USUAL))
        return np.asarray(np.clip(share, -0.5, 0.5) * weight, dtype=float)

    def misfit(self, step: Step) -> float:
        """Share of the roughness that such steps leave unexplained, mean over the parts."""
        return float(np.minimum(self._misfits(step), 1.0).mean())

    def median_misfit(self, step: Step) -> float:
        """The same share, median over the parts."""
        return float(np.median(self._misfits(step)))

    def contradicts(self, step: Step) -> bool:
        """Whether the channel certainly has less than half of the roughness that such steps would make."""
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

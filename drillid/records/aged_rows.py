"""Rows that each hold the last sample of a faster control, which is older in one row than in the next.

Where the control reads every h seconds and a row is written every T > h, the age of the rows' samples is a sawtooth in
time of period h, read every T. What of the injected torque is too rough for its own band is that age times its slope.
"""

from __future__ import annotations

import numpy as np
from scipy.fft import irfft, rfft, rfftfreq
from scipy.optimize import minimize
from scipy.signal import detrend

from drillid.arrays import Booleans, Complex, Floats, Integers

_MOST_POWER, _SMOOTH = 0.95, 1.5
"""Share of the torque's power that lies below its highest frequency, and how far above that its edges reach."""
_EVEN = 0.01
"""Rows, standard deviation of their ages below which they are even."""
_BLOCKS = 128
"""Parts of a record whose misfits are compared, so that a jump of the torque disturbs some of them alone."""
_TAPERED = 0.02
"""Share of the record at either end that is tapered."""
_PADDED = 4
"""Finer than a record's own resolution by this factor is the spectrum in which the interval is sought."""
_SHORTEST, _HARMONICS = 0.15, 4
"""Rows, shortest interval that is sought, and harmonics of its rate of which the strongest line may be one."""
_PART = 8
"""Part of the record, one in so many, in which intervals are compared."""
_LEAST_SHARE, _SURE = 0.5, 3.0
"""Share of the expected roughness that another channel must have, within so many standard errors."""
_TOLD = 0.1
"""Largest misfit relative to that of even rows, in the median over the parts, at which the ages are believed."""


def aged_samples(channels: Floats) -> tuple[Floats, float] | None:
    """Places (row,) of the rows' samples and the control's interval, both in rows; None where the rows are even, or the
    other channels are not of the same ages.

    Parameters
    ----------
    channels : shape (channel, time), finite; the first is that with the least noise
    """
    rough = Roughness(channels[0])
    if not rough.uneven:
        return None
    frequency, phase = _start(channels[0], rough)
    rows = channels.shape[1]
    # the sawtooth must not slip along the record
    found = minimize(
        lambda scaled: rough.misfit(frequency + scaled[0] / rows, phase + scaled[1]),
        np.zeros(2),
        method="Nelder-Mead",
        options={"initial_simplex": [[0.0, 0.0], [0.2, 0.0], [0.0, 0.1]], "xatol": 1e-3, "fatol": 1e-4},
    )
    frequency, phase = frequency + found.x[0] / rows, phase + found.x[1]
    if not rough.median_misfit(frequency, phase) < _TOLD:
        return None
    others = [Roughness(channel, rough.highest) for channel in channels[1:]]
    if any(other.contradicts(frequency, phase) for other in others):
        return None
    # the roughness does not tell a slow change of all ages, which would be a drift of the clock
    return np.arange(rows) - detrend(_age(rows, frequency, phase)), 1 / frequency


class Roughness:
    """What of a channel (time,) is too rough for its band, and its slope within it.

    Parameters
    ----------
    highest : cycles a row, of the band; by default that of the channel itself
    """

    def __init__(self, channel: Floats, highest: float | None = None) -> None:
        self.rows = channel.size
        ends = max(1, round(_TAPERED * self.rows))
        ramp = np.minimum(np.arange(self.rows), np.arange(self.rows)[::-1]) / ends
        taper = np.sin(np.pi / 2 * np.minimum(ramp, 1.0)) ** 2
        frequency = rfftfreq(self.rows)
        lines: Complex = rfft((channel - channel.mean()) * taper)
        if highest is None:
            power = np.cumsum(np.abs(lines) ** 2)
            highest = _SMOOTH * float(frequency[np.searchsorted(power, _MOST_POWER * power[-1])])
        self.highest = highest
        self._rough_lines: Booleans = frequency > highest
        self.rough = self._without_smooth(lines)
        self.slope = np.asarray(irfft(lines * 2j * np.pi * frequency * ~self._rough_lines, self.rows), dtype=float)
        self.power = self._in_blocks(self.rough)

    @property
    def uneven(self) -> bool:
        """Whether the roughness is that of ages that differ; not where the channel has no band of its own."""
        steep = self._in_blocks(self.slope)
        inside = steep > 0
        return bool(inside.any() and np.median(self.power[inside] / steep[inside]) > _EVEN**2)

    def ages(self) -> Floats:
        """Apparent age (time,) of each row, about its mean, weighted with the square of the slope."""
        return np.asarray(-np.clip(self.rough / np.where(self.slope == 0, np.inf, self.slope), -1, 1) * self.slope**2)

    def misfit(self, frequency: float, phase: float) -> float:
        """Mean over the parts of what such ages leave of the roughness, as a share of it."""
        return float(np.minimum(self._misfits(frequency, phase), 1.0).mean())

    def median_misfit(self, frequency: float, phase: float) -> float:
        """Median over the parts of the same."""
        return float(np.median(self._misfits(frequency, phase)))

    def contradicts(self, frequency: float, phase: float) -> bool:
        """Whether the channel surely has less than half of the roughness that such ages would make."""
        expected = self._expected(frequency, phase)
        starts = self._starts()
        power, product = (np.add.reduceat(expected * series, starts) for series in (expected, self.rough))
        share = product.sum() / max(power.sum(), np.finfo(float).tiny)
        error = np.sqrt(np.sum((product - share * power) ** 2)) / max(power.sum(), np.finfo(float).tiny)
        return bool(share + _SURE * error < _LEAST_SHARE)

    def _misfits(self, frequency: float, phase: float) -> Floats:
        left = self._in_blocks(self.rough - self._expected(frequency, phase))
        return np.asarray(left / np.where(self.power > 0, self.power, np.inf), dtype=float)

    def _expected(self, frequency: float, phase: float) -> Floats:
        late = _age(self.rows, frequency, phase) - 0.5 / frequency
        return self._without_smooth(rfft(-late * self.slope))

    def _without_smooth(self, lines: Complex) -> Floats:
        return np.asarray(irfft(lines * self._rough_lines, self.rows), dtype=float)

    def _in_blocks(self, series: Floats) -> Floats:
        return np.asarray(np.add.reduceat(series**2, self._starts()), dtype=float)

    def _starts(self) -> Integers:
        return np.arange(0, self.rows, max(1, self.rows // _BLOCKS))


def _age(rows: int, frequency: float, phase: float) -> Floats:
    """Age (rows,) of the last sample, rows; samples are `frequency` a row, and `phase` of them before the first."""
    return np.asarray(np.mod(np.arange(rows) * frequency + phase, 1.0) / frequency, dtype=float)


def _start(channel: Floats, rough: Roughness) -> tuple[float, float]:
    """Samples a row and phase of the first; which of those that are likely shows where the channel is steepest."""
    length = rough.rows // _PART
    steep = np.cumsum(np.append(0.0, rough.slope**2))
    first = int(np.argmax(steep[length:] - steep[:-length]))
    part = Roughness(channel[first : first + length])
    return min(_likely(rough), key=lambda each: part.misfit(each[0], each[1] + each[0] * first))


def _likely(rough: Roughness) -> list[tuple[float, float]]:
    """Samples a row and phase of the first by the strongest line of the ages.

    The n-th harmonic of a sawtooth of age is −h/(π n) sin(2π n (f k + φ)) at row k, and the line is n f, less a whole
    number, or that with its sign reversed.
    """
    size = _PADDED * rough.rows
    lines = rfft(rough.ages(), size)
    place = 2 * _PADDED + int(np.argmax(np.abs(lines[2 * _PADDED :])))
    line, turn = place / size, float(np.angle(lines[place])) / (2 * np.pi)
    likely = []
    for harmonic in range(1, _HARMONICS + 1):
        for sign in (1, -1):
            frequencies = (np.arange(harmonic, harmonic / _SHORTEST) + sign * line) / harmonic
            phases = sign * (turn - sign * 0.25 + np.arange(harmonic)) / harmonic
            likely += [(each, phase) for each in frequencies[frequencies > 1] for phase in phases]
    return likely

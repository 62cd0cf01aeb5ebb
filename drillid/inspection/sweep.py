"""The injected sweep among a log's columns, found by its signal: it has no mean, and repeats or fills a band."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.signal import periodogram

from drillid.arrays import Floats, Integers
from drillid.errors import LogError
from drillid.records.clock import place_rows
from drillid.spectra.period import sweep_period
from drillid.units import to_si_factor

_PIECE_S = 600.0
"""Length of the piece of the log that is looked at, s."""
_SHORTEST_S = 20.0
_VISIBLE, _OFF_S = 0.05, 5.0
"""A sweep is off where it stays below this share of its usual amplitude for this time, s."""
_MEAN_SHARE = 0.2
"""Largest mean of a sweep over its root mean square; the mean of measured torque is many times its changes."""
_POWER_OUTSIDE = 0.01
"""Share of the power below the band, and above it."""
_LOWEST_HZ, _HIGHEST_HZ = 0.02, 20.0
"""Limits between which sweeps of torsional dynamics lie."""
_NARROWEST = 1.3
"""Ratio of the highest to the lowest frequency below which a signal is a tone and not a sweep."""
_NAMED = re.compile(r"sweep|inj|excit|dither|perturb|chirp|prbs|multisine|probing|stimul|testtorque", re.IGNORECASE)


@dataclass(frozen=True)
class Sweep:
    """The injected sweep of a log.

    column : its name
    period_s : 0 where it does not repeat within half of a piece of ten minutes
    low_hz, high_hz : band that holds 98 % of its power
    rms : while it is on, in the column's unit
    on_share : share of the log's time during which it is on
    """

    column: str
    period_s: float
    low_hz: float
    high_hz: float
    rms: float
    on_share: float

    def __str__(self) -> str:
        repeats = f"repeats every {self.period_s:.4g} s" if self.period_s else "does not repeat"
        return f"{repeats}, {self.low_hz:.3g} to {self.high_hz:.3g} Hz, on {100 * self.on_share:.0f} % of the time"


def find_sweep(
    columns: Mapping[str, Floats],
    units: Mapping[str, str],
    stamps: Integers,
    rate: float,
    gaps: Integers | None = None,
) -> Sweep | None:
    """The column that holds the sweep; None where none looks like it.

    Of several, one that repeats itself exactly, which measured signals do not, comes before one that only fills a band;
    its name decides between equals.

    Parameters
    ----------
    columns : values in order of time, each shape (row,)
    units : of the columns, as the file states them; a column in another unit than one of torque is not a sweep
    stamps : of the rows, ns, shape (row,)
    rate : rows per second
    gaps : rows behind which samples are missing
    """
    gaps = np.empty(0, dtype=np.int64) if gaps is None else gaps
    found = []
    for name, values in columns.items():
        named = _NAMED.search(re.sub(r"[\W_]", "", name)) is not None
        in_torque = None if name not in units else _is_torque(units[name])
        sweep = None if in_torque is False else _as_sweep(name, values, stamps, rate, gaps)
        # a signal that neither repeats nor is named like a sweep may be any signal with zero mean
        if sweep is not None and (sweep.period_s > 0 or named):
            found.append(((sweep.period_s > 0) + 2 * named + bool(in_torque), sweep))
    return max(found, key=lambda scored: scored[0])[1] if found else None


def _is_torque(unit: str) -> bool:
    try:
        to_si_factor(unit, "N m")
    except ValueError:
        return False
    return True


def _as_sweep(name: str, values: Floats, stamps: Integers, rate: float, gaps: Integers) -> Sweep | None:
    """A column as a sweep; None where it has a mean, does not oscillate, or is a tone."""
    known = np.nan_to_num(values)
    usual = float(np.quantile(np.abs(known), 0.99))
    part = _longest_part(known, usual, rate, gaps)
    piece = known[part]
    rms = float(np.sqrt(np.mean(piece**2))) if piece.size else 0.0
    if piece.size < max(_SHORTEST_S * rate, 2) or abs(np.mean(piece)) > _MEAN_SHARE * rms:
        return None
    piece, clock = _on_its_clock(values[part], stamps[part], rate)
    frequency, density = periodogram(piece, clock, window="hann")
    share = np.cumsum(density) / np.sum(density)
    low, high = (float(frequency[np.searchsorted(share, edge)]) for edge in (_POWER_OUTSIDE, 1 - _POWER_OUTSIDE))
    if low < _LOWEST_HZ or high > min(_HIGHEST_HZ, 0.45 * clock) or high < _NARROWEST * low:
        return None
    period = sweep_period(piece, clock, max(low, 1 / _SHORTEST_S))
    return Sweep(name, period, low, high, rms, _on_share(known, usual, rate))


def _on_its_clock(values: Floats, stamps: Integers, rate: float) -> tuple[Floats, float]:
    """A part of a column at all ticks of the recorder's clock, and its rate: missing rows would shift the period."""
    held = np.flatnonzero(np.isfinite(values))
    try:
        ticks = place_rows(stamps[held], values[held], values[held])
    except LogError:
        return np.nan_to_num(values), rate
    ordered = values[held][ticks.rows]
    return np.interp(np.arange(ticks.tick[0], ticks.tick[-1] + 1), ticks.tick, ordered), ticks.rate


def _longest_part(values: Floats, usual: float, rate: float, gaps: Integers) -> slice:
    """Rows of the longest part without gaps during which a signal is on, up to ten minutes of it."""
    on = np.flatnonzero(np.abs(values) > _VISIBLE * usual)
    if not usual > 0 or on.size == 0:
        return slice(0, 0)
    in_gaps = np.searchsorted(on, gaps, side="right") - 1
    breaks = np.union1d(np.flatnonzero(np.diff(on) > _OFF_S * rate), in_gaps[(in_gaps >= 0) & (in_gaps < on.size - 1)])
    first, last = on[np.concatenate([[0], breaks + 1])], on[np.concatenate([breaks, [on.size - 1]])]
    longest = int(np.argmax(last - first))
    return slice(int(first[longest]), min(int(last[longest]) + 1, int(first[longest]) + int(_PIECE_S * rate)))


def _on_share(values: Floats, usual: float, rate: float) -> float:
    """Share of intervals of five seconds in which the sweep is visible."""
    width = max(int(_OFF_S * rate), 1)
    whole = values[: values.size // width * width].reshape(-1, width)
    return float(np.mean(np.max(np.abs(whole), axis=1) > _VISIBLE * usual)) if whole.size else 1.0

"""The channels of one log on their grid: short holes interpolated, everything else flagged and noted."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drillid.arrays import Array, Booleans, Floats, Integers
from drillid.config.settings import RecordsSettings
from drillid.datasets.codes import RecordFlag
from drillid.records.channels import FAST_CHANNELS
from drillid.records.grid import CHECK_RECORDER, MOST_APART, Grid, Note, first_and_last, seconds_text
from drillid.records.quality import runs, spikes, stuck

_SPLINE_BLOCK = 100_000
"""Knots of a spline processed at once."""
_SPLINE_REACH = 50
"""Knots beyond which a knot has no effect on a cubic spline: it falls by a factor 3.7 from each to the next."""
_SLOW_HOLD = 5.0
"""A slow channel is interpolated over up to this many of its own intervals."""


class Repair:
    """Repairs one channel after the other and collects flags, shape (time,), and notes."""

    def __init__(self, grid: Grid, rate: float, settings: RecordsSettings) -> None:
        self.grid, self.rate, self.settings = grid, rate, settings
        self.flags = grid.flags.copy()
        self.notes: list[Note] = []

    def channel(self, name: str, rows: Array) -> NDArray[np.float32]:
        """One channel's rows, shape (row,), as its samples, shape (time,); NaN where they are unknown."""
        samples = self.grid.first_values(rows)
        filled = self._fast(name, samples) if name in FAST_CHANNELS else self._slow(samples)
        return filled.astype(np.float32, copy=False)

    def _fast(self, name: str, samples: Array) -> Array:
        """Spikes and short holes replaced by a cubic spline through the good samples, long holes left as gaps."""
        missing, tick = np.isnan(samples), self.grid.tick
        spiky = spikes(_bridged(tick, samples, missing), self.rate, self.settings.spike_error_rate) & ~missing
        holes = missing | spiky
        short = _short(tick, holes, int(self.settings.interpolate_up_to_s * self.rate + 1e-9))
        if np.any(short):
            samples[short] = spline(tick[~holes], samples[~holes], tick[short])
        samples[holes & ~short] = np.nan
        self._flag(spiky, RecordFlag.SPIKE)
        self._flag(short & ~spiky, RecordFlag.INTERPOLATED)
        self._flag(holes & ~short, RecordFlag.GAP)
        if np.any(spiky):
            first = self.grid.at(int(np.flatnonzero(spiky)[0]))
            self._note(f"{int(np.sum(spiky))} spikes in {name} replaced, the first at {first}", CHECK_RECORDER)
        cells = int(np.sum(missing[self.grid.position[self.grid.first]]))
        if cells:
            self._note(f"{cells} rows hold no {name}", CHECK_RECORDER)
        return samples

    def _slow(self, samples: Array) -> Array:
        """Linear interpolation between the channel's own values, which may be far fewer than the rows."""
        missing = np.isnan(samples)
        known = np.flatnonzero(~missing)
        own = float(np.median(np.diff(known))) if known.size > 1 else 1.0
        longest = max(self.settings.interpolate_up_to_s * self.rate, _SLOW_HOLD * own)
        filled = _bridged(self.grid.tick, samples, missing)
        for first, stop in runs(missing):
            if stop - first > longest:
                filled[first:stop] = np.nan
        return filled

    def find_stuck(self, channels: dict[str, Array]) -> None:
        """Flag fast channels that keep one value while another fast channel moves."""
        known = [name for name in FAST_CHANNELS if name in channels]
        moves = {name: np.concatenate([[False], np.abs(np.diff(channels[name])) > 0]) for name in known}
        for name in known:
            others = np.any([moves[other] for other in known if other != name], axis=0)
            unchanged = stuck(channels[name], others, self.rate, self.settings.stuck_s)
            self._flag(unchanged, RecordFlag.STUCK)
            remedy = "These samples are flagged and left out of the windows; check the sensor"
            times, seconds = runs(unchanged)[:, 0].tolist(), np.diff(runs(unchanged))[:, 0] / self.rate
            if len(times) > MOST_APART:
                longer = f"{name} does not change for {seconds.min():.1f} to {seconds.max():.1f} s {len(times)} times"
                self._note(f"{longer}, {seconds.sum():.1f} s in all, {first_and_last(self.grid, times)}", remedy)
                continue
            for first, length in zip(times, seconds, strict=True):
                self._note(f"{name} does not change for {length:.1f} s from {self.grid.at(first)}", remedy)

    def note_holes(self) -> None:
        """Note the number of missing rows, and each gap."""
        empty = np.ones(self.grid.size, dtype=bool)
        empty[self.grid.position] = False
        filled = int(np.sum(empty & ((self.flags & np.uint8(RecordFlag.INTERPOLATED)) > 0)))
        if filled:
            self._note(f"{filled} rows missing, filled by interpolation", CHECK_RECORDER)
        gaps = runs((self.flags & np.uint8(RecordFlag.GAP)) > 0)
        seconds, places = np.diff(gaps)[:, 0] / self.rate, gaps[:, 0].tolist()
        self._note_gaps(
            seconds, places, "at", "It is not filled and no window contains it; check the recorder if this recurs"
        )
        seconds, places = (
            np.array([length for _, length in self.grid.omitted_gaps]),
            [at for at, _ in self.grid.omitted_gaps],
        )
        self._note_gaps(seconds, places, "after", "No samples are stored there; check the recorder if this recurs")

    def _note_gaps(self, seconds: Floats, places: list[int], preposition: str, remedy: str) -> None:
        """A note for each, or one note where there are more than a few."""
        if len(places) > MOST_APART:
            lengths = (
                f"{len(places)} gaps of {seconds.min():.1f} to {seconds.max():.1f} s, {seconds.sum():.1f} s in all"
            )
            self._note(f"{lengths}, {first_and_last(self.grid, places)}", remedy)
            return
        for length, place in zip(seconds, places, strict=True):
            self._note(f"gap of {seconds_text(length)} s {preposition} {self.grid.at(place)}", remedy)

    def _flag(self, where: Booleans, flag: RecordFlag) -> None:
        self.flags[where] |= np.uint8(flag)

    def _note(self, what: str, remedy: str) -> None:
        self.notes.append((what, remedy))


def spline(known: Array, values: Array, wanted: Array) -> Floats:
    """Cubic spline through `values` at `known`, shape (knot,), at `wanted`, shape (place,); both ascend.

    It is computed block by block, each with enough knots on either side to equal the whole spline
    to rounding, because the whole one takes a hundred bytes per knot.
    """
    from scipy.interpolate import CubicSpline

    result = np.empty(wanted.size)
    starts = np.arange(0, known.size, _SPLINE_BLOCK)
    edges = [0, *np.searchsorted(wanted, known[starts[1:]]).tolist(), wanted.size]
    for start, first, stop in zip(starts.tolist(), edges[:-1], edges[1:], strict=True):
        if first < stop:
            knots = slice(max(0, start - _SPLINE_REACH), start + _SPLINE_BLOCK + _SPLINE_REACH)
            result[first:stop] = CubicSpline(known[knots], values[knots])(wanted[first:stop])
    return result


def _bridged(tick: Integers, samples: Array, missing: Booleans) -> Array:
    """Samples at ticks with linear interpolation where they are missing, shape (time,)."""
    whole = samples.copy()
    whole[missing] = np.interp(tick[missing], tick[~missing], samples[~missing])
    return whole


def _short(tick: Integers, holes: Booleans, longest: int) -> Booleans:
    """Holes of up to `longest` ticks that have good samples on both sides, shape (time,)."""
    short = np.zeros_like(holes)
    for first, stop in runs(holes):
        if first > 0 and stop < holes.size:
            short[first:stop] = tick[stop] - tick[first - 1] - 1 <= longest
    return short

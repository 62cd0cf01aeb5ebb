"""Slow logs beside fast ones: depth and weight at 1 Hz in one file, torque and speed at 50 Hz in another.

The slow channels are interpolated to the rows of the fast log, never the other way. A channel that both logs hold shows
how far their clocks are apart.
"""

from __future__ import annotations

import functools
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drillid.arrays import Array, Integers
from drillid.config.rig import CHANNELS, REQUIRED_CHANNELS, Channel, Rig
from drillid.errors import LogError
from drillid.formats import Dialect, TimeColumn, column_in, headers
from drillid.formats.mnemonics import surely
from drillid.records.channels import FAST_CHANNELS, RawChannels, read_channels
from drillid.records.clock_offset import FARTHEST_S, clock_offset
from drillid.records.grid import Note
from drillid.records.mapping import MappedColumn, dialect_of, layout_of

_TOGETHER = "Record sweep, torque and speed together"
_LONGEST_HOLE_S = 60.0
"""Slow channels are interpolated over holes up to this long, or a few of their intervals, s."""
_LONGEST_HOLE = 5
_KEPT = 4
"""Number of slow logs in memory at once."""
_SURE = 3.0
"""Standard errors beyond which a clock offset is significant."""
_SAME_TIME_NS = 1_000_000
"""Largest difference between the stamps of two logs for their samples to be simultaneous, ns."""
_SHARED: tuple[Channel, ...] = (
    *("speed", "torque_command", "hook_load", "weight_on_bit", "standpipe_pressure", "flow", "bit_depth", "hole_depth"),
)
"""Channels that may show the offset, the likeliest first."""


Known = Callable[[str, Path, Callable[[], Any]], Any]
"""Returns a finding about a file (its kind, the file, what finds it) from an earlier run, or has it found."""


LIST_ONCE = "List each log once; if this one corrects an earlier one, remove that from the sheet"
LIST_APART = "List logs that do not overlap"
"""Remedies for a log that earlier ones cover entirely, or in part."""


def found_now(_kind: str, _path: Path, find: Callable[[], Any]) -> Any:
    """The finding where no earlier run is looked at."""
    return find()


@dataclass(frozen=True, eq=False)
class Source:
    """A log file, or one table of it, with the rig description that holds for it.

    channels : channels that its columns hold, by the rig description or by their mnemonics
    """

    path: Path
    rig: Rig
    channels: frozenset[Channel]

    @property
    def layout(self) -> tuple[TimeColumn, str, Dialect, list[str]]:
        """Arguments of `formats.first_stamp` after the path."""
        return layout_of(self.rig)


@dataclass(frozen=True)
class SlowLog:
    """A slow log in memory.

    stamps : ns since 1970 UTC, increasing, shape (row,)
    channels : SI units, shape (row,)
    columns : column and unit of each channel
    notes : what was decided
    """

    path: Path
    stamps: Integers
    channels: Mapping[str, Array]
    columns: Mapping[Channel, MappedColumn]
    notes: Sequence[Note]

    @classmethod
    def of(cls, source: Source) -> SlowLog:
        """Read a slow log."""
        raw = read_channels(source.path, source.rig, CHANNELS).at_distinct_stamps(source.path.name)
        return cls(source.path, raw.stamps, raw.channels, raw.columns, raw.notes)

    @property
    def span(self) -> tuple[int, int]:
        """First and last stamp, ns."""
        return int(self.stamps[0]), int(self.stamps[-1])

    @property
    def interval(self) -> float:
        """Usual time between its rows, s."""
        return float(np.median(np.diff(self.stamps))) * 1e-9 if self.stamps.size > 1 else np.inf


@dataclass(eq=False)
class _Slow:
    """What is known about a slow log: the log itself while it is in memory, and why it cannot be read."""

    source: Source
    log: SlowLog | None = None
    refused: LogError | None = None


class SlowLogs:
    """The slow logs of a well, only a few of which are in memory at once.

    channels : channels that any of them holds
    """

    def __init__(self, sources: Sequence[Source] = (), known: Known = found_now) -> None:
        self.channels = frozenset(name for source in sources for name in source.channels)
        self._known = known
        self._logs = [_Slow(source) for source in sources]
        self._held: list[_Slow] = []

    def around(self, first: int, last: int) -> list[SlowLog]:
        """Slow logs that cover part of a time span (ns), even if their clocks are an hour off."""
        return [self._read(slow) for slow in self._of(first, last)]

    def files_around(self, first: int, last: int) -> list[Path]:
        """Files of these slow logs."""
        return [slow.source.path for slow in self._of(first, last)]

    def problems(self, times: Sequence[tuple[int, int]]) -> list[LogError]:
        """Slow logs that cannot be read, and those that overlap no fast log (first and last stamp of each, ns)."""
        remedy = "List a log with the sweep at that time, or remove this one from the logs sheet"
        used = {slow for first, last in times for slow in self._of(first, last)}
        found = list[LogError]()
        for slow in self._logs:
            self._span(slow)
            if slow.refused is not None:
                found.append(slow.refused)
            elif slow not in used:
                what = "holds no torque_sweep, and no log of the well that does covers its time; not used"
                found.append(LogError(str(slow.source.path), what, remedy))
        return found

    def _of(self, first: int, last: int) -> list[_Slow]:
        slack = round(FARTHEST_S * 1e9)
        spans = [(slow, self._span(slow)) for slow in self._logs]
        return [slow for slow, span in spans if span and span[0] - slack <= last and span[1] + slack >= first]

    def _span(self, slow: _Slow) -> tuple[int, int] | None:
        """First and last stamp, ns; None where it cannot be read."""
        if slow.refused is not None:
            return None
        kind = f"span of {slow.source.rig.file.table}"
        try:
            first, last = self._known(kind, slow.source.path, lambda: self._read(slow).span)
        except LogError as error:
            slow.refused = error
            return None
        return first, last

    def _read(self, slow: _Slow) -> SlowLog:
        if slow.log is None:
            slow.log = SlowLog.of(slow.source)
            self._held.append(slow)
            if len(self._held) > _KEPT:
                self._held.pop(0).log = None
        return slow.log


def sources(logs: Sequence[Path], rig: Rig, known: Known = found_now) -> tuple[list[Source], SlowLogs]:
    """The logs that hold the sweep, one per file, and the slow ones, which hold other channels only.

    Without a sweep in any log, all are taken as fast ones, so that each is reported with what it lacks; so is one that
    cannot be read, or holds no channel at all.
    """
    fast, slow = list[Source](), list[Source]()
    for path in logs:
        own = rig.for_log(path)
        try:
            tables: list[tuple[str, list[Channel]]] = known("tables", path, functools.partial(_tables, path, own))
        except Exception:  # reported when the log is read
            fast.append(Source(path, own, frozenset()))
            continue
        with_sweep = [(table, channels) for table, channels in tables if "torque_sweep" in channels]
        if len(with_sweep) > 1:
            # the reader of the log takes the one with most of the channels
            fast.append(Source(path, own, frozenset(name for _, channels in tables for name in channels)))
            continue
        others = [(table, channels) for table, channels in tables if channels and "torque_sweep" not in channels]
        if with_sweep or not others:
            fast.append(_source(path, own, with_sweep[0] if with_sweep else tables[0], len(tables)))
        slow += [_source(path, own, table, len(tables)) for table in others]
    if fast:
        return fast, SlowLogs(slow, known)
    return [Source(path, rig.for_log(path), frozenset()) for path in logs], SlowLogs()


def _source(path: Path, rig: Rig, chosen: tuple[str, list[Channel]], tables: int) -> Source:
    """A table of a log, stated where the log has several."""
    name, channels = chosen
    if tables > 1:
        rig = rig.model_copy(update={"file": rig.file.model_copy(update={"table": name})})
    return Source(path, rig, frozenset(channels))


def _tables(path: Path, rig: Rig) -> list[tuple[str, list[Channel]]]:
    """Tables of a log with the channels that they hold, by the rig description or by their mnemonics."""
    found = []
    for table in headers(path, dialect_of(rig.file)):
        held = list[Channel]()
        for name in CHANNELS:
            column = rig.channels.get(name)
            own = None if column is None else column_in(table, column.column)
            if own is not None or (name not in rig.channels and surely(name, table.columns) is not None):
                held.append(name)
        found.append((table.table, held))
    return found


def joined(raw: RawChannels, slow: SlowLogs, path: Path) -> RawChannels:
    """A fast log with the channels that it lacks, interpolated from the slow logs of its time.

    Raises
    ------
    LogError
        If it still lacks a channel that is needed.
    """
    channels, columns, notes = dict(raw.channels), dict(raw.columns), list(raw.notes)
    lacking = [name for name in CHANNELS if name not in raw.channels and name in slow.channels]
    apart = dict[Channel, str]()
    taken = defaultdict[Channel, list[tuple[Integers, Array, float]]](list)
    for log in slow.around(int(raw.stamps.min()), int(raw.stamps.max())) if lacking else ():
        wanted = [name for name in lacking if name in log.channels]
        offset, why = _offset_of(log, raw)
        at = raw.stamps + round(offset * 1e9)
        coarse = [name for name in wanted if name in FAST_CHANNELS and not _sampled_together(log, at)]
        if coarse:
            what = (
                f"{' and '.join(coarse)} of {log.path.name} cannot be joined: their samples are not at this log's times"
            )
            notes.append((what, _TOGETHER))
            apart |= dict.fromkeys(coarse, what)
        wanted = [name for name in wanted if name not in coarse]
        for name in wanted:
            values, known = _interpolated(log.stamps, log.channels[name], log.interval, at), channels.get(name)
            channels[name] = values if known is None else np.where(np.isfinite(known), known, values)
            columns[name] = log.columns[name]
            taken[name].append((log.stamps - round(offset * 1e9), log.channels[name], log.interval))
        if wanted:
            what = f"{', '.join(wanted)} taken from {log.path.name} at {1 / log.interval:.4g} Hz; {why}"
            notes.append((what, "Compare the clocks of both recorders if that is wrong"))
            notes += [note for note in log.notes if note not in notes]
    for name, logs in taken.items():
        channels[name] = _across(logs, channels[name], raw.stamps)
    _check_complete(channels, path, apart)
    return RawChannels(raw.stamps, channels, notes, columns)


def _check_complete(channels: Mapping[str, Array], path: Path, apart: Mapping[Channel, str]) -> None:
    """Refuse a log that lacks a needed channel; `apart` tells why some cannot be joined."""
    for name in REQUIRED_CHANNELS:
        if name in channels and np.any(np.isfinite(channels[name])):
            continue
        if name in apart:
            raise LogError(str(path), f"holds no {name}; {apart[name]}", _TOGETHER)
        what = f"holds no {name}, and no other log of the well does at its time"
        raise LogError(str(path), what, f"List the log that holds {name}, or map its column under channels.{name}")


def _sampled_together(log: SlowLog, at: Integers) -> bool:
    """Whether a log holds a sample at nearly each of the given times."""
    behind = np.clip(np.searchsorted(log.stamps, at), 1, log.stamps.size - 1)
    apart = np.minimum(np.abs(log.stamps[behind] - at), np.abs(log.stamps[behind - 1] - at))
    return bool(np.mean(apart <= _SAME_TIME_NS) > 0.5)


def _across(logs: Sequence[tuple[Integers, Array, float]], found: Array, at: Integers) -> Array:
    """A channel that is also interpolated between the end of a slow log and the beginning of the next, shape (row,).

    Parameters
    ----------
    logs : stamps, values and usual interval of each
    found : the channel as each log gives it
    """
    missing = ~np.isfinite(found)
    if len(logs) < 2 or not missing.any():
        return found
    stamps, values = (np.concatenate([log[place] for log in logs]) for place in (0, 1))
    order = np.argsort(stamps, kind="stable")
    filled = found.copy()
    filled[missing] = _interpolated(stamps[order], values[order], max(log[2] for log in logs), at[missing])
    return filled


def _interpolated(stamps: Integers, values: Array, interval: float, at: Integers) -> Array:
    """A slow channel at given times, NaN where its samples are too far apart, of its own precision, shape (row,)."""
    good = np.isfinite(values)
    if np.sum(good) < 2:
        return np.full(at.size, np.nan, dtype=values.dtype)
    stamps = stamps[good]
    start = stamps[0]
    found = np.interp(at - start, stamps - start, values[good].astype(float), left=np.nan, right=np.nan)
    behind = np.clip(np.searchsorted(stamps, at, side="right"), 1, stamps.size - 1)
    hole = (stamps[behind] - stamps[behind - 1]) * 1e-9
    found[hole > max(_LONGEST_HOLE_S, _LONGEST_HOLE * interval)] = np.nan
    return np.asarray(found.astype(values.dtype))


def _offset_of(log: SlowLog, raw: RawChannels) -> tuple[float, str]:
    """How far the slow log's clock is ahead, s, and how that was found."""
    shared = [name for name in _SHARED if name in raw.channels and name in log.channels]
    for name in shared:
        found = clock_offset(raw.stamps, raw.channels[name], log.stamps, log.channels[name])
        if found is None:
            continue
        value = f"{found.seconds:+.2f} s, standard error {found.error:.2g} s"
        if abs(found.seconds) > max(log.interval, _SURE * found.error):
            return (
                found.seconds,
                f"its clock differs from this log's by {value}, as {name} in both logs shows; corrected",
            )
        return 0.0, f"the clocks agree, as {name} in both logs shows ({value})"
    reason = f"no offset is visible in {' and '.join(shared)} of both logs" if shared else "no channel is in both logs"
    return 0.0, f"{reason}, so the clocks are assumed to agree"

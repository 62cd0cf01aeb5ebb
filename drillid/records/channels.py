"""A raw log's stamps and channels in SI units, without values that no rig can have recorded."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from drillid.arrays import Array, Booleans, Floats, Integers
from drillid.config.rig import CHANNEL_UNITS, REQUIRED_CHANNELS, Channel, Rig
from drillid.errors import LogError
from drillid.formats import Log, read_log
from drillid.records.clock import FEWEST_ROWS, too_few_rows
from drillid.records.grid import Note
from drillid.records.mapping import MappedColumn, Mapping, mapped
from drillid.records.order import FIRST_YEAR, LAST_YEAR, outside_years, stray
from drillid.records.plausibility import possible_values
from drillid.records.shared_stamps import differing_note, first_values, one_by_one
from drillid.units import to_si_factor

FAST_CHANNELS: tuple[Channel, ...] = ("torque_command", "torque_sweep", "speed")
"""Channels that carry the dynamics; the others are slow and only determine the rig's state."""


_HAVE_OWN = "The nearer sample has values of its own; export slow channels with the samples"


@dataclass(frozen=True)
class RawChannels:
    """One log as read.

    stamps : ns since 1970 UTC, shape (row,), in the file's order
    channels : SI units, NaN for missing values, shape (row,); fast ones float64, the others float32
    notes : what was decided and left out (sentence, remedy)
    columns : column and unit of each channel
    """

    stamps: Integers
    channels: dict[str, Array]
    notes: list[Note]
    columns: dict[Channel, MappedColumn]

    def in_whole_rows(self, log: str) -> RawChannels:
        """The same with a row for each stamp, where rows that share one hold the fast channels one by one.

        Parameters
        ----------
        log : name of the log
        """
        fast = [self.channels[name] for name in FAST_CHANNELS if name in self.channels]
        whole = self.at_distinct_stamps(log) if one_by_one(self.stamps, fast) else self
        return whole._with_slow_rows_joined()

    def _with_slow_rows_joined(self) -> RawChannels:
        """The same with the values of rows between two samples of the fast channels, which have none of these, in the
        row of the nearer sample where it lacks them.
        """
        fast = np.zeros(self.stamps.size, dtype=bool)
        for name in FAST_CHANNELS:
            fast |= np.isfinite(self.channels[name]) if name in self.channels else False
        if np.all(fast) or np.count_nonzero(fast) < FEWEST_ROWS:
            return self
        order = np.argsort(self.stamps[fast], kind="stable")
        times, slow = self.stamps[fast][order], np.flatnonzero(~fast)
        after = np.clip(np.searchsorted(times, self.stamps[slow]), 1, times.size - 1)
        # in a longer step a row of the fast channels is missing, and this one is in its place
        between = times[after] - times[after - 1] < 1.5 * np.median(np.diff(times))
        slow, after = slow[between], after[between]
        nearer = after - (self.stamps[slow] - times[after - 1] < times[after] - self.stamps[slow])
        rows = np.flatnonzero(fast)[order[nearer]]
        kept = np.ones(fast.size, dtype=bool)
        kept[slow] = False
        channels, left_out = dict[str, Array](), 0
        for channel in list(self.channels):
            values = self.channels.pop(channel)
            known, taken = np.isfinite(values[slow]), np.isfinite(values[rows])
            put = known & ~taken
            values[rows[put]] = values[slow[put]]
            left_out += int(np.count_nonzero(known & taken))
            channels[channel] = values[kept]
        told = [(f"{left_out} values in rows between two samples are left out", _HAVE_OWN)] if left_out else []
        return replace(self, stamps=self.stamps[kept], channels=channels, notes=[*self.notes, *told])

    def at_distinct_stamps(self, log: str) -> RawChannels:
        """The same with a row for each stamp, which holds the first value of each channel there; this is used up.

        Parameters
        ----------
        log : name of the log
        """
        stamps, channels, differing = first_values(self.stamps, self.channels)
        notes = [differing_note(log, self.stamps, differing)] if differing else []
        return replace(self, stamps=stamps, channels=channels, notes=[*self.notes, *notes])


def read_channels(path: Path, rig: Rig, elsewhere: Collection[Channel] = ()) -> RawChannels:
    """Read the channels of a log; an optional one that is empty or impossible is omitted.

    Parameters
    ----------
    path : the log
    rig : description of the rig
    elsewhere : channels that other logs of the well may hold, so that this one may lack them

    Raises
    ------
    LogError
        If the log cannot be read, is too short, its stamps are not times of a rig, or a required channel holds too few
        values or impossible ones.
    """
    mapping = mapped(path, rig, elsewhere)
    names: dict[str, list[Channel]] = {}
    for name, mapped_column in mapping.columns.items():
        names.setdefault(mapped_column.column, []).append(name)
    log = read_log(path, mapping.time, list(names), dialect=mapping.dialect)
    stamps = log.stamps.view(np.int64)
    if stamps.size < FEWEST_ROWS:
        raise too_few_rows(str(path), stamps.size)
    kept, left_out = usable_rows(stamps, path)
    notes = [*mapping.notes, *left_out]
    whole = bool(np.all(kept))
    channels: dict[str, Array] = {}
    for column, same_column in names.items():
        values, noted = _values_of(log, column, same_column, mapping)
        notes += noted
        if values is None:
            continue
        values = values if whole else values[kept]
        needed = [name for name in same_column if name in REQUIRED_CHANNELS and name not in elsewhere]
        _check_held(column, values, needed, path)
        for name in same_column:
            found, noted = _in_si(name, values, mapping.columns[name], path)
            notes += noted
            if found is not None:
                channels[name] = found
    return RawChannels(stamps if whole else stamps[kept], channels, [*log.notes, *notes], mapping.columns)


def _values_of(log: Log, column: str, names: list[Channel], mapping: Mapping) -> tuple[Floats | None, list[Note]]:
    """A column's values; None and a note where it is not a column of numbers and nobody asked for it."""
    try:
        return log.pop(column), []
    except LogError as error:
        if not mapping.by_mnemonic.issuperset(names) or not set(names).isdisjoint(REQUIRED_CHANNELS):
            raise
        return None, [(f"column '{column}' is not used for {', '.join(names)}: {error.what}", error.remedy)]


def usable_rows(stamps: Integers, path: Path) -> tuple[Booleans, list[Note]]:
    """Rows whose stamps are times of a rig, and a note on the others."""
    outside = outside_years(stamps)
    if np.mean(outside) > 0.5:
        when = np.datetime_as_string(np.median(stamps[outside]).astype(np.int64).astype("datetime64[ns]"), unit="D")
        raise LogError(
            str(path),
            f"its stamps read as {when}, and no rig logs before {FIRST_YEAR} or after {LAST_YEAR}",
            "State the unit or format of the time column in the rig description, or export the log again",
        )
    kept = ~outside
    kept[kept] = ~stray(stamps[kept])
    notes = list[Note]()
    if not np.all(kept):
        row = int(np.argmin(kept))
        when = np.datetime_as_string(stamps[row : row + 1].astype("datetime64[ns]"), unit="ms")[0]
        what = f"{int(np.sum(~kept))} rows are stamped far from their neighbours, the first {when} in row {row + 1}"
        notes.append((f"{what}; they are not used", "Export the log again; the file may be damaged"))
    if np.sum(kept) < FEWEST_ROWS:
        raise too_few_rows(str(path), int(np.sum(kept)))
    return kept, notes


def _check_held(column: str, values: Floats, needed: list[Channel], path: Path) -> None:
    """Reject a log that lacks the values of a channel that it needs."""
    held = int(np.sum(np.isfinite(values)))
    if held < FEWEST_ROWS and needed:
        number = f"only {held} values of the {FEWEST_ROWS} needed" if held else "no values"
        remedy = "Correct the rig description's columns, or the export"
        raise LogError(str(path), f"column '{column}' holds {number}", remedy)


def _in_si(name: Channel, values: Floats, column: MappedColumn, path: Path) -> tuple[Array | None, list[Note]]:
    """A channel in SI units, None where it holds hardly any possible value, and notes."""
    if np.sum(np.isfinite(values)) < FEWEST_ROWS:
        return None, []
    with np.errstate(over="ignore", invalid="ignore"):
        converted = values * to_si_factor(column.unit, CHANNEL_UNITS[name])
    possible, notes = possible_values(name, converted, column, str(path))
    if possible is None:
        return None, notes
    if np.sum(np.isfinite(possible)) < FEWEST_ROWS:
        if name in REQUIRED_CHANNELS:
            what, remedy = notes[0]
            raise LogError(str(path), what, remedy)
        return None, notes
    return possible.astype(np.float64 if name in FAST_CHANNELS else np.float32, copy=False), notes

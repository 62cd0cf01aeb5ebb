"""TDMS files of LabVIEW, with a channel of times or with waveforms."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from drillid.formats.arrow_tables import check_size, table_of
from drillid.formats.description import Dialect, Header, Note, Unusable
from drillid.formats.header_rows import unique
from drillid.formats.mnemonics import is_no_unit, split_unit, time_among

SUFFIXES = (".tdms",)
_Changes = dict[str, list[tuple[int, dict[str, Any]]]]
"""By the path of a channel: row numbers, and what is stated of its timing from each on."""
_UNITS = ("unit_string", "NI_UnitDescription", "Unit", "unit", "Units", "units", "unit_description")
_WAVEFORM_TIME = "Time"
_TIMING = ("wf_start_time", "wf_start_offset", "wf_increment")
_MOST_STARTS = 4
_NEEDS_LITTLE = 2**26
"""Size of a file that any machine has the memory to read, bytes."""
_ALIKE = 0.01
"""Share of the sampling interval within which channels are sampled together."""


@dataclass(frozen=True)
class _Waveform:
    """Times of equally spaced samples.

    starts : first row of each recording, of which an appended file has several, and its time, ns since 1970
    interval : between rows, s
    """

    starts: tuple[tuple[int, int], ...]
    interval: float

    def times(self, rows: int) -> Any:
        """UTC times of the samples, shape (row,)."""
        at = np.arange(rows)
        first, start = (np.array(each) for each in zip(*self.starts, strict=True))
        of = np.searchsorted(first, at, side="right") - 1
        since = np.rint((at - first[of]) * (self.interval * 1e9)).astype(np.int64)
        return (start[of] + since).astype("datetime64[ns]")

    def is_like(self, other: _Waveform) -> bool:
        """Whether two waveforms are sampled at the same times to within a small part of the interval."""
        (first, start), (others, other_start) = (zip(*each.starts, strict=True) for each in (self, other))
        near = np.abs(np.subtract(start, other_start)) if first == others else np.inf
        return self.interval == other.interval and bool(np.all(near <= _ALIKE * self.interval * 1e9))


@dataclass(frozen=True)
class _Layout:
    """Group and channel of every column, and the waveform that times them, if any."""

    channels: dict[str, tuple[str, str]]
    waveform: _Waveform | None
    rows: int


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """The file with its channels, and the `changes` that it states."""
    import struct

    from nptdms import TdmsFile

    class File(TdmsFile):  # type: ignore[misc]
        def _read_file(self, reader: Any, *how: bool) -> None:
            self.changes = _changes(reader)
            super()._read_file(reader, *how)

    try:
        with path.open("rb") as content, File(content, read_metadata_only=True, keep_open=True) as file:
            yield file
    except (struct.error, KeyError, IndexError, TypeError, AttributeError, OverflowError) as error:
        raise ValueError(f"it is damaged: {type(error).__name__} {error}") from error
    except MemoryError as error:
        if path.stat().st_size > _NEEDS_LITTLE:
            raise
        raise ValueError("it is damaged: it states lengths beyond the memory of this machine") from error


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """A table for the channels of a group that are equally long and equally timed.

    Raises
    ------
    Unusable
        If appended parts of a channel state times that do not follow those before them.
    ValueError
        If the file is damaged or holds no channels with values.
    """
    with _opened(path) as file:
        if dialect.table is not None and dialect.table in [group.name for group in file.groups()]:
            groups = [file[dialect.table]]
        else:
            groups = file.groups()
        size = path.stat().st_size
        found = [header for group in groups for header in _of_group(group, file.changes, len(groups) > 1, size)]
    if not found:
        raise ValueError("it holds no channels with values")
    if len(found) == 1:
        return [replace(found[0], table=dialect.table or "")]
    names = unique([header.table for header in found])
    return [replace(header, table=name) for header, name in zip(found, names, strict=True)]


def _changes(reader: Any) -> _Changes:
    """What each segment states about the timing of waveforms, filled in as the library's reader reads the metadata.

    The library keeps only what the last segment states.
    """
    rows, changes, update = dict[str, int](), _Changes(), reader._update_object_properties

    def updated(properties: Any) -> None:
        nonlocal rows
        update(properties)
        for name, stated in (properties or {}).items():
            timing = {key: value for key, value in stated if key in _TIMING}
            if timing:
                changes.setdefault(name, []).append((rows.get(name, 0), timing))
        rows = {name: channel.num_values for name, channel in reader.object_metadata.items()}

    reader._update_object_properties = updated
    return changes


def _of_group(group: Any, changes: _Changes, several: bool, file_size: int) -> list[Header]:
    alike: list[tuple[int, list[_Waveform | None], list[Any]]] = []
    for channel in group.channels():
        if len(channel) == 0:
            continue
        waveform = _waveform(channel, changes.get(channel.path, []))
        for rows, waveforms, channels in alike:
            if rows == len(channel) and _are_alike(waveforms[0], waveform):
                waveforms.append(waveform)
                channels.append(channel)
                break
        else:
            alike.append((len(channel), [waveform], [channel]))
    check_size(sum(rows * len(channels) for rows, _, channels in alike), file_size)
    return [
        _header(group.name, channels, rows, waveforms, several or len(alike) > 1, len(alike) > 1)
        for rows, waveforms, channels in alike
    ]


def _are_alike(one: _Waveform | None, other: _Waveform | None) -> bool:
    return one == other if one is None or other is None else one.is_like(other)


def _header(
    group: str, channels: list[Any], rows: int, waveforms: list[_Waveform | None], named: bool, numbered: bool
) -> Header:
    waveform = waveforms[0]
    names = unique([channel.name.strip() for channel in channels])
    units = {}
    for name, channel in zip(names, channels, strict=True):
        unit = next((str(channel.properties[key]) for key in _UNITS if channel.properties.get(key)), "")
        unit = unit or split_unit(name)[1]
        if not is_no_unit(unit):
            units[name] = unit
    places = {name: (group, channel.name) for name, channel in zip(names, channels, strict=True)}
    time = next((name for name, channel in zip(names, channels, strict=True) if channel.dtype.kind == "M"), None)
    layout, notes = _Layout(places, None, rows), list[Note]()
    if time is None and waveform is not None and time_among(names) is None:
        notes = list(_notes_on(waveforms))
        time, names, layout = _WAVEFORM_TIME, (_WAVEFORM_TIME, *names), _Layout(places, waveform, rows)
    rate = "" if waveform is None or not numbered else f", {1 / waveform.interval:g} Hz"
    table = f"{group}{rate or (f', {rows} rows' if numbered else '')}" if named else ""
    return Header(names, units, table=table, time=time, layout=layout, notes=tuple(notes), rows=rows)


def _notes_on(waveforms: Sequence[_Waveform | None]) -> Iterator[Note]:
    """What was decided about the times of channels that are read together."""
    found = [waveform for waveform in waveforms if waveform is not None]
    starts = [waveform.starts[0][1] for waveform in found]
    apart = round((max(starts) - min(starts)) / 1e3)
    if apart:
        what = f"its channels start up to {apart} us apart, and are read as if sampled together"
        yield what, "None needed if they were; otherwise write groups that are sampled together into files of their own"
    if len(found[0].starts) > 1:
        later = [_written(start) for _, start in found[0].starts[1:]]
        more = f" and {len(later) - _MOST_STARTS} more" if len(later) > _MOST_STARTS else ""
        what = (
            f"recordings were appended, which are placed at their own starts: {', '.join(later[:_MOST_STARTS])}{more}"
        )
        yield what, "Write a channel of times if that is wrong"


def _waveform(channel: Any, changes: Sequence[tuple[int, Mapping[str, Any]]]) -> _Waveform | None:
    """The times that a channel's properties state; a waveform needs a start after LabVIEW's zero of 1904.

    Raises
    ------
    Unusable
        If appended recordings have other intervals, or times that do not follow those before them.
    """
    starts, intervals, state = dict[int, int](), dict[int, float](), dict[str, Any]()
    for row, stated in changes:
        state |= stated
        timing = _timing(state)
        if timing is not None:
            starts[row], intervals[row] = timing
    if len(set(starts.values())) <= 1 and len(set(intervals.values())) <= 1:
        return _Waveform(((0, next(iter(starts.values()))),), next(iter(intervals.values()))) if starts else None
    interval = next(iter(intervals.values()))
    found = [next(iter(starts.items()))]
    for row, start in starts.items():
        end = found[-1][1] + (row - found[-1][0]) * interval * 1e9
        if start == found[-1][1] or abs(start - end) <= _ALIKE * interval * 1e9:
            continue
        if row == len(channel) or start < end - interval * 1e9 / 2:
            raise _unclear(
                channel, f"starts at {_written(start)} and at {_written(found[-1][1])}, of which one is wrong"
            )
        found.append((row, start))
    if set(intervals.values()) != {interval} or found[0][0] != 0:
        raise _unclear(channel, f"intervals {', '.join(f'{each:g} s' for each in intervals.values())}")
    return _Waveform(tuple(found), interval)


def _unclear(channel: Any, what: str) -> Unusable:
    return Unusable(
        f"states of channel '{channel.name}' in parts that were appended {what}",
        "Write each recording into a file of its own, or a channel of times",
    )


def _timing(state: Mapping[str, Any]) -> tuple[int, float] | None:
    """Start, ns since 1970, and interval, s, that properties state."""
    interval, start = state.get("wf_increment"), state.get("wf_start_time")
    if interval is None or start is None or not float(interval) > 0:
        return None
    time = start.as_datetime64("ns") if hasattr(start, "as_datetime64") else start
    begin = int(np.datetime64(time, "ns").astype(np.int64))
    offset = float(state.get("wf_start_offset", 0.0) or 0.0)
    return None if begin < 0 else (begin + round(offset * 1e9), float(interval))


def _written(time: int) -> str:
    return str(np.datetime_as_string(np.datetime64(round(time / 1e6), "ms")))


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns as an Arrow table; times of a waveform are made here, in UTC."""
    layout: _Layout = header.layout
    count = layout.rows if rows is None else min(rows, layout.rows)
    with _opened(path) as file:
        arrays = {}
        for name in columns:
            if layout.waveform is not None and name == _WAVEFORM_TIME and name not in layout.channels:
                arrays[name] = layout.waveform.times(count)
            else:
                group, channel = layout.channels[name]
                arrays[name] = file[group][channel][:count]
    return _in_utc(table_of(arrays, text))


def _in_utc(table: Any) -> Any:
    """LabVIEW's times are UTC."""
    import pyarrow as pa

    for position, field in enumerate(table.schema):
        if pa.types.is_timestamp(field.type):
            table = table.set_column(position, field.name, table.column(position).cast(pa.timestamp("ns", "UTC")))
    return table

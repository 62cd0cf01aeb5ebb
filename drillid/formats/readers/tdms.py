"""TDMS files of LabVIEW, with a channel of times or with waveforms."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drillid.formats.arrow_tables import check_size, table_of
from drillid.formats.description import Dialect, Header
from drillid.formats.header_rows import unique
from drillid.formats.mnemonics import is_no_unit, split_unit, time_among

SUFFIXES = (".tdms",)
_UNITS = ("unit_string", "NI_UnitDescription", "Unit", "unit", "Units", "units", "unit_description")
_WAVEFORM_TIME = "Time"


@dataclass(frozen=True)
class _Waveform:
    """Times of equally spaced samples: ns since 1970 of the first, and s between them."""

    start: int
    interval: float

    def times(self, rows: int) -> Any:
        """UTC times of the samples, shape (row,)."""
        since = np.rint(np.arange(rows) * (self.interval * 1e9)).astype(np.int64)
        return (self.start + since).astype("datetime64[ns]")


@dataclass(frozen=True)
class _Layout:
    """Group and channel of every column, and the waveform that times them, if any."""

    channels: dict[str, tuple[str, str]]
    waveform: _Waveform | None
    rows: int


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    import struct

    from nptdms import TdmsFile

    try:
        with path.open("rb") as content, TdmsFile.open(content) as file:
            yield file
    except (struct.error, KeyError, IndexError, TypeError, AttributeError, OverflowError) as error:
        raise ValueError(f"it is damaged: {type(error).__name__} {error}") from error


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """A table for the channels of a group that are equally long and equally timed."""
    with _opened(path) as file:
        if dialect.table is not None and dialect.table in [group.name for group in file.groups()]:
            groups = [file[dialect.table]]
        else:
            groups = file.groups()
        found = [header for group in groups for header in _of_group(group, len(groups) > 1, path.stat().st_size)]
    if not found:
        raise ValueError("it holds no channels with values")
    return found if len(found) > 1 else [Header(**{**vars(found[0]), "table": dialect.table or ""})]


def _of_group(group: Any, several: bool, file_size: int) -> list[Header]:
    alike: dict[tuple[int, _Waveform | None], list[Any]] = {}
    for channel in group.channels():
        if len(channel) > 0:
            alike.setdefault((len(channel), _waveform(channel)), []).append(channel)
    check_size(sum(key[0] * len(channels) for key, channels in alike.items()), file_size)
    return [
        _header(group.name, channels, rows, waveform, several or len(alike) > 1, len(alike) > 1)
        for (rows, waveform), channels in alike.items()
    ]


def _header(
    group: str, channels: list[Any], rows: int, waveform: _Waveform | None, named: bool, numbered: bool
) -> Header:
    names = unique([channel.name.strip() for channel in channels])
    units = {}
    for name, channel in zip(names, channels, strict=True):
        unit = next((str(channel.properties[key]) for key in _UNITS if channel.properties.get(key)), "")
        unit = unit or split_unit(name)[1]
        if not is_no_unit(unit):
            units[name] = unit
    places = {name: (group, channel.name) for name, channel in zip(names, channels, strict=True)}
    time = next((name for name, channel in zip(names, channels, strict=True) if channel.dtype.kind == "M"), None)
    layout = _Layout(places, None, rows)
    if time is None and waveform is not None and time_among(names) is None:
        time, names, layout = _WAVEFORM_TIME, (_WAVEFORM_TIME, *names), _Layout(places, waveform, rows)
    rate = "" if waveform is None or not numbered else f", {1 / waveform.interval:g} Hz"
    table = f"{group}{rate or (f', {rows} rows' if numbered else '')}" if named else ""
    return Header(names, units, table=table, time=time, layout=layout, rows=rows)


def _waveform(channel: Any) -> _Waveform | None:
    """The times that a channel's properties state; a waveform needs a start after LabVIEW's zero of 1904."""
    interval, start = channel.properties.get("wf_increment"), channel.properties.get("wf_start_time")
    if interval is None or start is None or not float(interval) > 0:
        return None
    begin = np.datetime64(start, "ns").astype(np.int64).item()
    if begin < 0:
        return None
    offset = float(channel.properties.get("wf_start_offset", 0.0) or 0.0)
    return _Waveform(begin + round(offset * 1e9), float(interval))


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

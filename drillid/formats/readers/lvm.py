"""LabVIEW Measurement files: text with a header for each segment, times in columns or by a start and an interval."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drillid.arrays import Floats
from drillid.formats.counted_times import from_numbers
from drillid.formats.description import Dialect, Header, Note, Unusable
from drillid.formats.header_rows import unique
from drillid.formats.lvm_document import Segment, X, segments_of
from drillid.formats.mnemonics import is_no_unit, split_unit
from drillid.formats.numbers_in_text import with_numbers

SUFFIXES = (".lvm",)
STREAMS = True
TIME = "Time"
_ALIKE = 0.01
"""Share of the sampling interval within which channels start together."""
_SINCE_1904 = 2e9
"""Larger times in s count from 1904, in UTC."""
_APART = "Write channels that are sampled together into a file of their own"


@dataclass(frozen=True)
class _Layout:
    """How the rows of a table are read.

    encoding : of the file
    segments : numbers of the segments that hold its rows
    dated : whether they have starts, so that the times are stamps; else they are seconds from an unknown start
    """

    encoding: str | None
    segments: frozenset[int]
    dated: bool


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """A table for all segments with the same channels in the same units.

    Raises
    ------
    Unusable
        If channels of a segment are not sampled together.
    ValueError
        If it is cut short or holds no rows.
    """
    found: dict[tuple[tuple[str, ...], tuple[tuple[str, str], ...]], list[Segment]] = {}
    for segment in segments_of(path, dialect.encoding):
        if segment.rows and segment.channels:
            _check_together(segment)
            names = _names(segment)
            found.setdefault((names, tuple(_units(segment, names).items())), []).append(segment)
    if not found:
        raise ValueError("it holds no rows of channels")
    tables = list(found.items())
    return [
        _header(names, dict(units), segments, f"segment {segments[0].number}" if len(tables) > 1 else "", dialect)
        for (names, units), segments in tables
    ]


def _header(
    names: tuple[str, ...], units: dict[str, str], segments: Sequence[Segment], table: str, dialect: Dialect
) -> Header:
    dated = all(_is_dated(segment) for segment in segments)
    if not dated and len(segments) > 1:
        raise Unusable(
            "has several segments, of which some state no date and time of their start",
            "Export each into a file of its own",
        )
    layout = _Layout(dialect.encoding, frozenset(segment.number for segment in segments), dated)
    time = unique([*names, TIME])[-1]
    rows = sum(len(segment.rows) for segment in segments)
    own = units if dated else units | {time: "s"}
    return Header((time, *names), own, table, time, layout=layout, notes=tuple(_notes(segments)), rows=rows)


def _notes(segments: Sequence[Segment]) -> Iterator[Note]:
    """A note that appended recordings cannot be recognised, where one header without times covers all rows."""
    first = segments[0]
    if first.setting("Multi_Headings") == "no" and first.times_of(first.channels[0]) is None:
        what = "all rows have one header and no times, and are read as one recording without gaps"
        yield what, "Write a header for each segment, or a column of times, where recordings are appended to the file"


def _names(segment: Segment) -> tuple[str, ...]:
    return unique([segment.names[at] for at in segment.channels])


def _units(segment: Segment, names: Sequence[str]) -> dict[str, str]:
    stated = (segment.of("Y_Unit_Label", at) for at in segment.channels)
    found = {name: unit or split_unit(name)[1] for name, unit in zip(names, stated, strict=True)}
    return {name: unit for name, unit in found.items() if not is_no_unit(unit)}


def _is_dated(segment: Segment) -> bool:
    return segment.start(segment.channels[0]) is not None or _since_1904(segment)


def _since_1904(segment: Segment) -> bool:
    """Whether the first time in a column counts from 1904."""
    at = segment.times_of(segment.channels[0])
    if at is None:
        return False
    cells = segment.rows[0].split(segment.delimiter)
    try:
        return float(cells[at].replace(",", ".")) > _SINCE_1904
    except (ValueError, IndexError):
        return False


def _check_together(segment: Segment) -> None:
    """Refuse channels whose start or interval differs from that of the first."""
    first, *others = segment.channels
    spaced = segment.times_of(first) is None
    interval = segment.number_of("Delta_X", first)
    if spaced and not (interval and interval > 0):
        raise Unusable(
            f"has no times and no interval between samples, Delta_X, above line {segment.line}",
            "Write a column of times",
        )
    for other in others:
        start, its_start = segment.start(first), segment.start(other)
        apart = 0.0 if start is None or its_start is None else abs(its_start - start) * 1e-9
        if spaced:
            apart += abs((segment.number_of("X0", other) or 0.0) - (segment.number_of("X0", first) or 0.0))
        if apart > _ALIKE * abs(interval or 0.0):
            raise Unusable(f"has channels that start {apart:g} s apart, above line {segment.line}", _APART)
        if spaced and segment.number_of("Delta_X", other) != interval:
            raise Unusable(f"has channels with different intervals, Delta_X, above line {segment.line}", _APART)


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns of all segments of the table, concatenated; times with a start are stamps."""
    import pyarrow as pa

    layout: _Layout = header.layout
    numeric = [name for name in columns if name not in text]
    parts, last, count = list[Any](), None, 0
    for segment in segments_of(path, layout.encoding):
        if segment.number not in layout.segments:
            continue
        table = _cells(segment, header.columns[1:])
        stamps = _times(segment, table, layout.dated)
        if layout.dated and last is not None and stamps[0] <= last:
            raise Unusable(
                f"has a segment, with the names in line {segment.line}, that starts before the one above ends",
                "Export each into a file of its own",
            )
        last = stamps[-1]
        own = table.append_column(header.columns[0], _column(stamps, layout.dated, _since_1904(segment)))
        parts.append(own.select(list(columns)))
        count += len(segment.rows)
        if rows is not None and count >= rows:
            break
    whole = pa.concat_tables(parts) if parts else pa.table({name: pa.array([], pa.string()) for name in columns})
    named = [name for name in numeric if pa.types.is_string(whole.column(name).type)]
    return with_numbers(whole if rows is None else whole.slice(0, rows), named, ".", None, "\t")


def _column(times: Any, dated: bool, in_utc: bool) -> Any:
    import pyarrow as pa

    if not dated:
        return pa.array(times)
    return pa.array(times.view("datetime64[ns]"), pa.timestamp("ns", "UTC" if in_utc else None))


def _cells(segment: Segment, names: Sequence[str]) -> Any:
    """Cells of the channels as text; the columns of times are named by their places."""
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    width = len(segment.names)
    called = dict(zip(segment.channels, names, strict=True))
    own = [called.get(at, f"\x1f{at}") for at in range(width)]
    lines = [_of_width(row, segment.delimiter, width) for row in segment.rows]
    content = "\n".join(lines)
    if segment.delimiter != ",":
        content = content.replace(",", ".")
    return arrow_csv.read_csv(
        io.BytesIO(content.encode()),
        read_options=arrow_csv.ReadOptions(column_names=own),
        parse_options=arrow_csv.ParseOptions(delimiter=segment.delimiter, quote_char=False, ignore_empty_lines=False),
        convert_options=arrow_csv.ConvertOptions(
            column_types=dict.fromkeys(own, pa.string()), strings_can_be_null=True, timestamp_parsers=[]
        ),
    )


def _of_width(row: str, delimiter: str, width: int) -> str:
    """A row without its comment, and with the empty cells that a writer omits at its end."""
    cells = row.split(delimiter, width)[:width]
    return delimiter.join(cells) + delimiter * (width - len(cells))


def _times(segment: Segment, table: Any, dated: bool) -> Any:
    """Times of the rows: ns since 1970, or s from an unknown start; shape (row,)."""
    seconds = _seconds(segment, table)
    back = np.flatnonzero(~(np.diff(seconds) > 0))
    if back.size:
        raise Unusable(
            f"has times that do not advance in line {segment.lines[int(back[0]) + 1]}; recordings may have been "
            "appended without a header of their own",
            "Write one header for each segment, or each recording into a file of its own",
        )
    if not dated:
        return seconds
    if _since_1904(segment):
        return from_numbers(seconds, "labview", None, None).since
    return from_numbers(seconds, "s", (segment.start(segment.channels[0]) or 0, False), None).since


def _seconds(segment: Segment, table: Any) -> Floats:
    """Times as written, or by the sampling interval, s; shape (row,)."""
    first, *others = segment.channels
    at = segment.times_of(first)
    if at is None:
        offset, interval = (segment.number_of(key, first) or 0.0 for key in ("X0", "Delta_X"))
        return np.asarray(offset + interval * np.arange(len(segment.rows)), dtype=np.float64)
    seconds = _written(segment, table, at)
    for place in {segment.times_of(other) for other in others} - {at, None}:
        if place is not None and not np.array_equal(_written(segment, table, place), seconds):
            raise Unusable(
                f"has channels whose times, in columns '{X}', differ from those of the first channel", _APART
            )
    return seconds


def _written(segment: Segment, table: Any, at: int) -> Floats:
    import pyarrow as pa

    column = with_numbers(table.select([f"\x1f{at}"]), [f"\x1f{at}"], ".", None, "\t").column(0)
    if not pa.types.is_floating(column.type) or column.null_count or not np.all(np.isfinite(column.to_numpy())):
        raise Unusable(f"has rows without a time in a column '{X}' under line {segment.line}", _APART)
    return np.asarray(column.to_numpy())

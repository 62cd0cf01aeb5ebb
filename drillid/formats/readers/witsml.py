"""WITSML log objects, 1.3.1.1 and 1.4.1.1, over time; read as a stream."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from drillid.formats.cells import NULL_VALUES
from drillid.formats.description import Dialect, Header, Note, Unusable
from drillid.formats.header_rows import unique
from drillid.formats.mnemonics import is_no_unit, split_unit
from drillid.formats.numbers_in_text import with_numbers
from drillid.formats.since import stated_start
from drillid.formats.streams import Closed
from drillid.formats.witsml_document import LogObject, documents

SUFFIXES = (".xml", ".witsml")
STREAMS = True


@dataclass(frozen=True)
class _Columns:
    """Names of the cells of a block's rows, and what they hold.

    start : time that an index of elapsed seconds counts from, and whether it is UTC
    """

    names: tuple[str, ...]
    units: dict[str, str]
    nulls: dict[str, tuple[float, ...]]
    time: str
    aliases: dict[str, str]
    start: tuple[np.datetime64, bool] | None


@dataclass
class _Table:
    """Blocks of data whose rows are read as one table.

    blocks : their places in the document
    without : columns that some of the blocks lack
    """

    name: str
    columns: _Columns
    blocks: set[tuple[int, int]]
    without: dict[str, None] = field(default_factory=dict)

    def difference(self, other: _Columns) -> str:
        """How the rows of a block differ from those of the table; empty where they can be joined."""
        for name, unit in other.units.items():
            if self.columns.units.get(name, unit) != unit:
                return f"the unit of '{name}', '{unit}' and '{self.columns.units[name]}'"
        for name in other.names:
            if name in self.columns.names and self.columns.nulls.get(name) != other.nulls.get(name):
                return f"the value of '{name}' for missing values"
        return "" if self.columns.start == other.start else "the start of their elapsed times"

    def add(self, place: tuple[int, int], other: _Columns) -> None:
        """Join a block's rows."""
        mine = self.columns
        self.without |= dict.fromkeys(sorted({*mine.names} ^ {*other.names}))
        self.blocks.add(place)
        self.columns = replace(
            mine,
            names=tuple(dict.fromkeys([*mine.names, *other.names])),
            units=mine.units | other.units,
            nulls=mine.nulls | other.nulls,
            aliases=mine.aliases | other.aliases,
        )


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """One table for all logs over time with the same curves, units, null values and start.

    Raises
    ------
    ValueError
        If the document is not a WITSML log, or holds only logs over depth.
    """
    logs: dict[int, list[tuple[LogObject, _Columns]]] = {}
    depths = []
    for log, _ in documents(path, lines=False):
        if log.over_time:
            logs.setdefault(log.place[0], []).append((log, _columns(log)))
        else:
            depths.append(log.index_curve or next((curve.mnemonic for curve in log.ordered()), ""))
    if not logs and any(depths):
        index = next(filter(None, depths))
        raise Unusable(f"holds logs over depth only, with the index '{index}'", "Export the logs over time")
    if not logs:
        raise Unusable("holds log objects without curves, such as a query to a server", "Save the server's response")
    tables, notes = _tables(list(logs.values()))
    names = unique([table.name for table in tables]) if len(tables) > 1 else [""]
    named = zip(names, tables, strict=True)
    return [_header(name, table, [*notes, *_notes(table)]) for name, table in named]


def _header(name: str, table: _Table, notes: Sequence[Note]) -> Header:
    columns = table.columns
    start, is_utc = columns.start or (None, False)
    return Header(
        columns.names,
        columns.units,
        table=name,
        time=columns.time,
        start=start,
        start_is_utc=is_utc,
        nulls=columns.nulls,
        layout=frozenset(table.blocks),
        notes=tuple(notes),
        aliases=columns.aliases,
    )


def _tables(logs: Sequence[Sequence[tuple[LogObject, _Columns]]]) -> tuple[list[_Table], list[Note]]:
    """Tables of the logs, each of which may have several blocks; and notes on those that are kept apart."""
    by_curves: dict[frozenset[str], list[_Table]] = {}
    notes = list[Note]()
    for blocks in logs:
        alike = by_curves.setdefault(frozenset(name for _, columns in blocks for name in columns.names), [])
        for log, columns in blocks:
            differences = [table.difference(columns) for table in alike]
            if "" in differences:
                alike[differences.index("")].add(log.place, columns)
                continue
            if differences:
                notes.append(_kept_apart(log, alike[0], differences[0]))
            alike.append(_Table(log.called, columns, {log.place}))
    return [table for tables in by_curves.values() for table in tables], notes


def _kept_apart(log: LogObject, table: _Table, difference: str) -> Note:
    what = f"the log '{log.called}' is not part of the table of '{table.name}', from which it differs in {difference}"
    return what, "Export them in the same form, or to separate files, as one table of a file is read"


def _notes(table: _Table) -> list[Note]:
    if not table.without:
        return []
    listed = ", ".join(f"'{name}'" for name in table.without)
    what = f"blocks of data of the log '{table.name}' list different curves; some have no values of {listed}"
    return [(what, "None needed if these curves were recorded for only part of the time")]


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns of all logs of the table, concatenated in the order of the document."""
    import pyarrow as pa

    numeric = [name for name in columns if name not in text]
    schema = pa.schema([(name, pa.string() if name in text else pa.float64()) for name in columns])
    parts: list[Any] = []
    count = 0
    for log, lines in documents(path, lines=True):
        if log.place not in header.layout or not lines:
            continue
        lines = lines if rows is None else lines[: rows - count]
        parts.append(_parsed(lines, log.delimiter, _columns(log).names, columns, numeric))
        count += len(lines)
        if rows is not None and count >= rows:
            break
    whole = [part for part in parts if part.schema == schema]
    if len(whole) == len(parts):
        return pa.concat_tables(parts) if parts else schema.empty_table()
    return pa.concat_tables([_as_text(part, columns) for part in parts])


def _as_text(table: Any, columns: Sequence[str]) -> Any:
    import pyarrow as pa

    return table.cast(pa.schema([(name, pa.string()) for name in columns]))


def _parsed(lines: list[str], delimiter: str, names: Sequence[str], columns: Sequence[str], numeric: list[str]) -> Any:
    """Lines of cells as an Arrow table; a column with a cell that is not a number stays text."""
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    as_text = dict.fromkeys(columns, pa.string())

    def read(types: dict[str, Any]) -> Any:
        return arrow_csv.read_csv(
            pa.PythonFile(Closed(io.BytesIO("\n".join(lines).encode()), delimiter, len(names)), mode="r"),
            read_options=arrow_csv.ReadOptions(column_names=list(names)),
            parse_options=arrow_csv.ParseOptions(delimiter=delimiter),
            convert_options=arrow_csv.ConvertOptions(
                include_columns=list(columns),
                include_missing_columns=True,
                column_types=types,
                strings_can_be_null=True,
                timestamp_parsers=[],
            ),
        )

    try:
        return read(as_text | dict.fromkeys(numeric, pa.float64()))
    except pa.ArrowInvalid:
        lines = [_of_width(line, delimiter, len(names)) for line in lines]
        return with_numbers(read(as_text), numeric, ".", None, delimiter)


def _of_width(line: str, delimiter: str, width: int) -> str:
    """A line with as many cells as there are curves, as writers omit empty cells at its end, or add some."""
    missing = width - 1 - line.count(delimiter)
    if missing >= 0:
        return line + delimiter * missing
    return line[:missing] if line.endswith(delimiter * -missing) else line


def _columns(log: LogObject) -> _Columns:
    """Names of a log's cells."""
    curves = log.ordered()
    if not curves:
        raise ValueError(f"its log '{log.name}' names no curves")
    names = unique([curve.mnemonic.strip() or f"column {at}" for at, curve in enumerate(curves, 1)])
    units = {}
    for name, curve in zip(names, curves, strict=True):
        unit = curve.unit.strip() or split_unit(name)[1]
        if not is_no_unit(unit):
            units[name] = unit
    index = log.index_curve.strip()
    time = index if index in names else names[min(max(log.index_column - 1, 0), len(names) - 1)]
    stated = {name: _number(curve.null or log.null) for name, curve in zip(names, curves, strict=True)}
    # null values common to all recorders apply everywhere and need no mention
    nulls: dict[str, tuple[float, ...]] = {
        name: (null,) for name, null in stated.items() if null is not None and null not in NULL_VALUES
    }
    aliases = {curve.alias: name for name, curve in zip(names, curves, strict=True) if curve.alias}
    return _Columns(names, units, nulls, time, aliases, _start(log))


def _start(log: LogObject) -> tuple[np.datetime64, bool] | None:
    """The time that an index of elapsed seconds counts from, and whether it is UTC."""
    return stated_start(log.start) if log.over_elapsed_time else None


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None

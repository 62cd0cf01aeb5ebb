"""WITSML log objects, 1.3.1.1 and 1.4.1.1, over time; read as a stream, documents with a DTD refused."""

from __future__ import annotations

import csv
import io
import itertools
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, Any

import numpy as np

from drillid.formats.description import Dialect, Header, Note, Unusable
from drillid.formats.header_rows import unique
from drillid.formats.mnemonics import is_no_unit, split_unit, time_among
from drillid.formats.numbers_in_text import with_numbers
from drillid.formats.packing import opened
from drillid.formats.since import stated_start

SUFFIXES = (".xml", ".witsml")
STREAMS = True

_BLOCK = 2**18
_LINES = 20_000
_OF_VERSION_2 = ("ChannelSet", "ChannelIndex")
_DECLARATION = re.compile(r"^\s*<\?xml[^>]*\?>")
_TIME_INDEX, _ELAPSED_INDEX = "date time", "elapsed time"


@dataclass
class _Curve:
    mnemonic: str = ""
    alias: str = ""
    unit: str = ""
    null: str = ""
    column: int = 0
    kind: str = ""


@dataclass
class _Log:
    """One log object, filled while it is read.

    place : its number and that of its block of data in the document
    start : of its index, as text
    mnemonics, units : beside its data, which name the order of the cells
    """

    place: tuple[int, int] = (0, 0)
    name: str = ""
    uid: str = ""
    index_type: str = ""
    index_curve: str = ""
    index_column: int = 0
    start: str = ""
    null: str = ""
    delimiter: str = ","
    curves: list[_Curve] = field(default_factory=list)
    mnemonics: list[str] = field(default_factory=list)
    units: list[str] = field(default_factory=list)

    @property
    def called(self) -> str:
        """Its name, or what it can be told by."""
        return self.name or self.uid or f"log {self.place[0]}"

    @property
    def over_time(self) -> bool:
        """Whether the index is a time; of a log that does not say, what its index is called."""
        if self.index_type:
            return self.index_type.replace("_", " ").strip().lower() in (_TIME_INDEX, "datetime", _ELAPSED_INDEX)
        ordered = self.ordered()
        index = self.index_curve or (ordered[0].mnemonic if ordered else "")
        return "TIME" in index.upper() or time_among([index]) is not None

    def ordered(self) -> list[_Curve]:
        """Curves in the order of the cells."""
        if self.mnemonics:
            by_name: dict[str, _Curve] = {}
            for curve in self.curves:
                by_name.setdefault(curve.mnemonic, curve)
            found = [by_name.get(name) or _Curve(name) for name in self.mnemonics]
            units = itertools.chain(self.units, itertools.repeat(""))
            return [replace(curve, unit=curve.unit or unit) for curve, unit in zip(found, units, strict=False)]
        if self.curves and all(curve.column for curve in self.curves):
            return sorted(self.curves, key=lambda curve: curve.column)
        return self.curves


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
        """What the rows of a block have otherwise than those of the table; empty where they can be joined."""
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
        If the document is no WITSML log, or holds logs over depth only.
    """
    logs: dict[int, list[tuple[_Log, _Columns]]] = {}
    depths = []
    for log, _ in _documents(path, lines=False):
        if log.over_time:
            logs.setdefault(log.place[0], []).append((log, _columns(log)))
        else:
            depths.append(log.index_curve or log.name)
    if not logs and depths:
        raise Unusable(f"holds logs over depth only, with the index '{depths[0]}'", "Export the logs over time")
    if not logs:
        raise ValueError("it is no WITSML document with a log")
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


def _tables(logs: Sequence[Sequence[tuple[_Log, _Columns]]]) -> tuple[list[_Table], list[Note]]:
    """Tables of the logs, each of which may have several blocks; notes on those that are kept apart."""
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


def _kept_apart(log: _Log, table: _Table, difference: str) -> Note:
    what = f"the log '{log.called}' is no part of the table of '{table.name}', from which it differs in {difference}"
    return what, "Export them alike, or to files of their own, as one table of a file is read"


def _notes(table: _Table) -> list[Note]:
    if not table.without:
        return []
    listed = ", ".join(f"'{name}'" for name in table.without)
    what = f"blocks of data of the log '{table.name}' list different curves; some have no values of {listed}"
    return [(what, "None needed where these curves were recorded for a part of the time only")]


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns of all logs of the table, one behind the other, in the order of the document."""
    import pyarrow as pa

    numeric = [name for name in columns if name not in text]
    schema = pa.schema([(name, pa.string() if name in text else pa.float64()) for name in columns])
    parts: list[Any] = []
    count = 0
    for log, lines in _documents(path, lines=True):
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
    """Lines of cells as an Arrow table; a column with a cell that is no number stays text."""
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    as_text = dict.fromkeys(columns, pa.string())

    def read(types: dict[str, Any]) -> Any:
        return arrow_csv.read_csv(
            io.BytesIO("\n".join(lines).encode()),
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
    """A line with as many cells as there are curves, as writers leave empty cells at its end out, or add some."""
    missing = width - 1 - line.count(delimiter)
    if missing >= 0:
        return line + delimiter * missing
    return line[:missing] if line.endswith(delimiter * -missing) else line


def _columns(log: _Log) -> _Columns:
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
    nulls: dict[str, tuple[float, ...]] = {name: (null,) for name, null in stated.items() if null is not None}
    aliases = {curve.alias: name for name, curve in zip(names, curves, strict=True) if curve.alias}
    return _Columns(names, units, nulls, time, aliases, _start(log))


def _start(log: _Log) -> tuple[np.datetime64, bool] | None:
    """The time that an index of elapsed seconds counts from, and whether it is UTC."""
    return stated_start(log.start) if _is_elapsed(log.index_type) else None


def _is_elapsed(index_type: str) -> bool:
    return index_type.replace("_", " ").strip().lower() == _ELAPSED_INDEX


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _documents(path: Path, lines: bool) -> Iterator[tuple[_Log, list[str]]]:
    """Logs of a document with pieces of their lines of data.

    A log is yielded once for each piece, or once without lines where only headers are wanted.
    """
    from defusedxml import DefusedXmlException
    from defusedxml.expatreader import DefusedExpatParser

    def new_parser(handler: Any) -> Any:
        parser = DefusedExpatParser(forbid_dtd=True)
        parser.setContentHandler(handler)
        return parser

    handler = _handler(lines, new_parser)
    parser = new_parser(handler)
    try:
        with opened(path) as content:
            yield from _fed(parser, handler, content, path)
    except DefusedXmlException as error:
        raise Unusable(
            "declares entities or a document type, which no WITSML log needs and attacks use",
            "Export the log again without them",
        ) from error


def _fed(parser: Any, handler: Any, content: IO[bytes], path: Path) -> Iterator[tuple[_Log, list[str]]]:
    from xml.sax import SAXException, SAXParseException

    try:
        while block := content.read(_BLOCK):
            parser.feed(block)
            yield from handler.taken()
        parser.close()
    except SAXParseException as error:
        raise ValueError(f"line {error.getLineNumber()}: {error.getMessage()}") from error
    except (SAXException, AssertionError) as error:
        raise ValueError(str(error)) from error
    yield from handler.taken()


def _handler(lines: bool, new_parser: Callable[[Any], Any]) -> Any:
    """A handler of XML events that collects logs; made here so that the library is imported late."""
    from xml.sax.handler import ContentHandler

    class Handler(ContentHandler):
        """Fills logs from elements, whatever their namespace."""

        def __init__(self) -> None:
            super().__init__()
            self.log: _Log | None = None
            self.curve: _Curve | None = None
            self.text: list[str] | None = None
            self.rows: list[str] = []
            self.ready: list[tuple[_Log, list[str]]] = []
            self.seen = False
            self.number = 0

        def taken(self) -> list[tuple[_Log, list[str]]]:
            """What is complete since the last time."""
            if self.log is not None and len(self.rows) >= _LINES:
                self._hand_over()
            ready, self.ready = self.ready, []
            return ready

        def _hand_over(self) -> None:
            assert self.log is not None
            self.ready.append((self.log, self.rows))
            self.rows, self.seen = [], True

        def startElement(self, name: str, attrs: Any) -> None:
            """Begin of an element."""
            local = name.rpartition(":")[2]
            if local in _OF_VERSION_2:
                raise Unusable("is of version 2 of WITSML", "Export it as WITSML 1.4.1.1")
            if local == "log":
                self.number += 1
                self.log, self.seen = _Log((self.number, 0), uid=attrs.get("uid", "")), False
            elif local == "logCurveInfo":
                self.curve = _Curve(attrs.get("uid", ""))
            elif local == "indexCurve" and self.log is not None:
                self.log.index_column = int(attrs.get("columnIndex", "0") or 0) if "columnIndex" in attrs else 0
            self.text = []

        def characters(self, content: str) -> None:
            """Text of an element, in pieces."""
            if self.text is not None:
                self.text.append(content)

        def endElement(self, name: str) -> None:
            """End of an element."""
            local = name.rpartition(":")[2]
            text, self.text = "".join(self.text or ()), None
            if local == "XMLout":
                # the answer of a WITSML server holds the document as text
                inner = new_parser(self)
                inner.feed(_DECLARATION.sub("", text, count=1).encode())
                inner.close()
            if self.log is None:
                return
            if local == "mnemonicList" and self.log.mnemonics:
                # further data of the log, which may list other curves
                self._hand_over()
                number, block = self.log.place
                self.log, self.seen = replace(self.log, place=(number, block + 1), units=[]), False
            if local == "data":
                if lines:
                    self.rows.append(text.strip())
            elif local == "log":
                if self.rows or not self.seen:
                    self._hand_over()
                self.log = None
            elif local == "logCurveInfo":
                if self.curve is not None:
                    self.log.curves.append(self.curve)
                self.curve = None
            elif self.curve is not None:
                _fill_curve(self.curve, local, text.strip())
            else:
                _fill_log(self.log, local, text.strip())

    return Handler()


def _fill_curve(curve: _Curve, element: str, text: str) -> None:
    if element == "mnemonic":
        curve.mnemonic = text
    elif element == "mnemAlias":
        curve.alias = text
    elif element == "unit":
        curve.unit = text
    elif element == "nullValue":
        curve.null = text
    elif element == "columnIndex" and text.isdigit():
        curve.column = int(text)
    elif element == "typeLogData":
        curve.kind = text


def _listed(text: str) -> list[str]:
    """Cells of a list of names or units, which damage may spread over lines."""
    return [cell.strip() for cell in next(csv.reader([text.replace("\r", " ").replace("\n", " ")]), [])]


def _fill_log(log: _Log, element: str, text: str) -> None:
    if element == "name":
        log.name = text
    elif element == "indexType":
        log.index_type = text
    elif element == "indexCurve":
        log.index_curve = text
    elif element == "startDateTimeIndex":
        log.start = text
    elif element == "nullValue":
        log.null = text
    elif element == "dataDelimiter" and text:
        log.delimiter = text
    elif element == "mnemonicList":
        log.mnemonics = _listed(text)
    elif element == "unitList":
        log.units = _listed(text)

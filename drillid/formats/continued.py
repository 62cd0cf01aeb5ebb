"""Tables of one file that continue one another, as sheets of a full workbook do: read as one."""

from __future__ import annotations

import itertools
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from drillid.formats.arrow_tables import notes_of, with_notes
from drillid.formats.description import Dialect, Header, LogFormat
from drillid.formats.places import shortened
from drillid.formats.time_columns import Stamps

_ROWS = b"drillid rows"
"""Key, in the metadata of a table's schema, of the number of rows of each part."""
_LONGEST_LIST = 120


@dataclass(frozen=True)
class _Parts:
    """Layout kept for a table that consists of others."""

    headers: tuple[Header, ...]


class Continuing:
    """Reader interface whose tables may each consist of several."""

    def __init__(self, reader: LogFormat) -> None:
        self.reader, self.SUFFIXES = reader, reader.SUFFIXES
        self.LEAVES_ROWS_OUT = bool(getattr(reader, "LEAVES_ROWS_OUT", False))

    def headers(self, path: Path, dialect: Dialect) -> list[Header]:
        """Header of each table of the file."""
        return self.reader.headers(path, dialect)

    def read_columns(
        self, path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
    ) -> Any:
        """Columns as an Arrow table; `rows` limits each part."""
        if not isinstance(header.layout, _Parts):
            return self.reader.read_columns(path, header, columns, text, rows)
        parts = [each for each in header.layout.headers if each.rows != 0]
        tables = [self.reader.read_columns(path, each, columns, text, rows) for each in parts]
        whole = with_notes(_concatenated(tables), [note for table in tables for note in notes_of(table)])
        counts = json.dumps([table.num_rows for table in tables]).encode()
        return whole.replace_schema_metadata({**(whole.schema.metadata or {}), _ROWS: counts})

    def line_of(self, path: Path, header: Header, row: int) -> int:
        """Line of a row of data, counted from 1; 0 for formats without lines and for several tables read as one."""
        line_of = getattr(self.reader, "line_of", None)
        return 0 if line_of is None or isinstance(header.layout, _Parts) else int(line_of(path, header, row))


def as_one(tables: Sequence[Header]) -> Header | None:
    """Tables as one, in their order; None where they differ in more than names, number of rows and order of columns."""
    first = tables[0]
    if any(_without_rows(each) != _without_rows(first) for each in tables[1:]):
        return None
    rows = None if any(each.rows is None for each in tables) else sum(each.rows or 0 for each in tables)
    names = shortened(", ".join(f"'{each.table}'" for each in tables), _LONGEST_LIST)
    what = f"its {len(tables)} tables {names} have the same columns and continue one another; they are read as one"
    note = what, "State the one to read as file.table in the rig description if that is wrong"
    notes = tuple(dict.fromkeys([*(each for table in tables for each in table.notes), note]))
    name = " + ".join(each.table for each in tables)
    return replace(first, table=name, layout=_Parts(tuple(tables)), notes=notes, rows=rows)


def names_of(header: Header) -> tuple[str, ...]:
    """Names of the tables of the file that a table consists of."""
    parts = header.layout.headers if isinstance(header.layout, _Parts) else (header,)
    return tuple(each.table for each in parts)


def overlap(table: Any, stamps: Stamps) -> bool:
    """Whether the times of tables that are read as one interleave, so that none continues the other.

    Parameters
    ----------
    table : as `Continuing.read_columns` returns it
    stamps : its times, shape (row,)
    """
    counts = json.loads((table.schema.metadata or {}).get(_ROWS, b"[]"))
    parts = np.split(stamps, np.cumsum(counts)[:-1].astype(int)) if counts else []
    spans = sorted((part.min(), part.max()) for part in parts if part.size)
    return any(later < end for (_, end), (later, _) in itertools.pairwise(spans))


def _without_rows(header: Header) -> Header:
    return replace(header, columns=tuple(sorted(header.columns)), table="", layout=None, notes=(), rows=None)


def _concatenated(tables: Sequence[Any]) -> Any:
    """Tables below one another; columns of different types become text."""
    import pyarrow as pa

    for name in tables[0].column_names:
        if len({table.column(name).type for table in tables}) > 1:
            tables = [_with_text(table, name) for table in tables]
    return pa.concat_tables(tables)


def _with_text(table: Any, name: str) -> Any:
    import pyarrow as pa

    return table.set_column(table.column_names.index(name), name, table.column(name).cast(pa.string()))

"""Apache Parquet."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from drillid.formats.arrow_tables import with_floats
from drillid.formats.description import Dialect, Header
from drillid.formats.header_rows import unique
from drillid.formats.stated_units import units_of

SUFFIXES = (".parquet", ".pq")
_UNITS = (b"unit", b"units")


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """The one table of the file; units stand in the names, or in the metadata of the columns or of the file."""
    from pyarrow import parquet

    return [header_of(parquet.read_schema(path), parquet.read_metadata(path).num_rows)]


def header_of(schema: Any, rows: int | None = None) -> Header:
    """The header of an Arrow schema."""
    noted = {key.lower(): value for key, value in (schema.metadata or {}).items()}
    names = unique(schema.names)
    units, notes = units_of(next((noted[key] for key in _UNITS if key in noted), None), names)
    for name, field in zip(names, schema, strict=True):
        own = {key.lower(): value for key, value in (field.metadata or {}).items()}
        unit = next((own[key].decode("utf-8", "replace") for key in _UNITS if key in own), "")
        if unit:
            units[name] = unit
    return Header(names, units, notes=notes, rows=rows)


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns as an Arrow table; numbers of any width become float64."""
    import pyarrow as pa
    from pyarrow import parquet

    if rows is None:
        table = parquet.read_table(path, columns=list(columns), page_checksum_verification=True)
    else:
        with parquet.ParquetFile(path, page_checksum_verification=True) as file:
            batches = file.iter_batches(batch_size=rows, columns=list(columns))
            table = pa.Table.from_batches(
                itertools.islice(batches, 1), file.schema_arrow.empty_table().select(list(columns)).schema
            )
    return with_floats(table, text)

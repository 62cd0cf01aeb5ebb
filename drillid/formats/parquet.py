"""Apache Parquet."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

SUFFIXES = (".parquet",)


def header(path: Path) -> list[str]:
    """Names of the file's columns."""
    from pyarrow import parquet

    return list(parquet.read_schema(path).names)


def read_columns(path: Path, columns: Sequence[str], text: Sequence[str], rows: int | None = None) -> Any:
    """The columns as an Arrow table; numbers of any width become float64."""
    import pyarrow as pa
    from pyarrow import parquet

    if rows is None:
        table = parquet.read_table(path, columns=list(columns))
    else:
        with parquet.ParquetFile(path) as file:
            batches = file.iter_batches(batch_size=rows, columns=list(columns))
            table = pa.Table.from_batches(
                itertools.islice(batches, 1), file.schema_arrow.empty_table().select(list(columns)).schema
            )
    for position, field in enumerate(table.schema):
        number = pa.types.is_integer(field.type) or pa.types.is_floating(field.type) or pa.types.is_decimal(field.type)
        if field.name not in text and number:
            table = table.set_column(position, field.name, table.column(position).cast(pa.float64()))
    return table

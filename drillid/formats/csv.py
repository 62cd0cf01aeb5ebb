"""Comma-separated text with one header line, plain or gzipped."""

from __future__ import annotations

import csv
import gzip
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

SUFFIXES = (".csv", ".csv.gz")


def header(path: Path) -> list[str]:
    """Names in the first line."""
    try:
        with gzip.open(path, "rt") if path.name.lower().endswith(".gz") else path.open() as lines:
            return [name.strip() for name in next(csv.reader([lines.readline().lstrip("\ufeff")]), [])]
    except zlib.error as error:
        raise ValueError(str(error)) from error


def read_columns(path: Path, columns: Sequence[str], text: Sequence[str]) -> Any:
    """The columns as an Arrow table; a numeric column with a cell that is no number stays text as a whole."""
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    names = header(path)

    def read(types: dict[str, Any]) -> Any:
        return arrow_csv.read_csv(
            path,
            read_options=arrow_csv.ReadOptions(column_names=names, skip_rows=1),
            convert_options=arrow_csv.ConvertOptions(
                include_columns=list(columns), column_types=types, strings_can_be_null=True, timestamp_parsers=[]
            ),
        )

    as_text = dict.fromkeys(columns, pa.string())
    try:
        return read(as_text | {name: pa.float64() for name in columns if name not in text})
    except pa.ArrowInvalid:
        return read(as_text)

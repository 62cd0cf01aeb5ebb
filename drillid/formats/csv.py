"""Comma-separated text with one header line, plain or gzipped."""

from __future__ import annotations

import csv
import gzip
import itertools
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

SUFFIXES = (".csv", ".csv.gz")


def header(path: Path) -> list[str]:
    """Names in the first line, in UTF-8 or else Latin-1."""
    line = _lines(path, 1)
    try:
        text = line.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = line.decode("latin-1")
    if any(character < " " and character not in "\t\r\n" for character in text):
        raise ValueError("its first line is not text")
    return [name.strip() for name in next(csv.reader([text]), [])]


def _lines(path: Path, count: int) -> bytes:
    """The first lines of the file, unparsed."""
    try:
        with gzip.open(path) if path.name.lower().endswith(".gz") else path.open("rb") as lines:
            return b"".join(itertools.islice(lines, count))
    except zlib.error as error:
        raise ValueError(str(error)) from error


def read_columns(path: Path, columns: Sequence[str], text: Sequence[str], rows: int | None = None) -> Any:
    """The columns as an Arrow table; a numeric column with a cell that is not a number stays text."""
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    names = header(path)

    def read(types: dict[str, Any]) -> Any:
        return arrow_csv.read_csv(
            path if rows is None else pa.BufferReader(_lines(path, rows + 1)),
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

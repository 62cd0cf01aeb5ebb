"""Arrow tables from arrays, for formats that hold arrays."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from drillid.formats.description import Note

_NOTES = b"drillid"
"""Key of the notes in the metadata of a table's schema."""
_EXCESS_BYTES = 2**30
_LARGEST_RATIO = 1000
"""A file may claim arrays of 1 GiB, or of this many times its own size; more means damage, not compression."""


def table_of(arrays: Mapping[str, Any], text: Sequence[str]) -> Any:
    """Columns from one-dimensional arrays: those in `text` unchanged, the others as float64 where possible."""
    import pyarrow as pa

    return pa.table({name: _column(np.asarray(values), name in text) for name, values in arrays.items()})


def with_floats(table: Any, text: Sequence[str]) -> Any:
    """An Arrow table with numbers of any width as float64, except for the columns in `text`."""
    import pyarrow as pa

    for position, field in enumerate(table.schema):
        kind = field.type
        if field.name not in text and _is_number(kind) and kind != pa.float64():
            table = table.set_column(position, field.name, table.column(position).cast(pa.float64()))
    return table


def _is_number(kind: Any) -> bool:
    import pyarrow as pa

    kinds = (pa.types.is_integer, pa.types.is_floating, pa.types.is_decimal, pa.types.is_null)
    return any(test(kind) for test in kinds)


def with_notes(table: Any, notes: Sequence[Note]) -> Any:
    """An Arrow table whose schema carries the decisions taken while reading its rows."""
    return table.replace_schema_metadata({_NOTES: json.dumps(notes)}) if notes else table


def notes_of(table: Any) -> list[Note]:
    """The notes attached by `with_notes`."""
    held = (table.schema.metadata or {}).get(_NOTES)
    return [] if held is None else [(what, remedy) for what, remedy in json.loads(held)]


def check_size(cells: float, file_size: int) -> None:
    """Refuse arrays that are absurdly larger than their file, before memory is taken for them.

    Raises
    ------
    ValueError
        If they are larger.
    """
    if 8 * cells > max(_EXCESS_BYTES, _LARGEST_RATIO * file_size):
        raise ValueError(f"it claims {cells:.3g} values, far more than a file of its size holds")


def by_length(lengths: Mapping[str, int]) -> list[list[str]]:
    """Names of arrays longer than 1, grouped by equal length, the longest first."""
    found: dict[int, list[str]] = {}
    for name, length in lengths.items():
        if length > 1:
            found.setdefault(length, []).append(name)
    return [found[length] for length in sorted(found, reverse=True)]


def as_text(values: Iterable[Any]) -> list[str | None]:
    """Cells as text; bytes are decoded as UTF-8, else as Latin-1."""
    return [None if value is None else _decoded(value) for value in values]


def _column(values: Any, as_it_is: bool) -> Any:
    import pyarrow as pa

    if values.dtype.kind == "M":
        return pa.array(values.astype("datetime64[ns]"))
    if values.dtype.kind in "SUO":
        return pa.array(as_text(values.tolist()), pa.string())
    if values.dtype.kind == "m":
        return pa.array(values.astype("timedelta64[ns]"))
    native = values.astype(values.dtype.newbyteorder("="), copy=False)
    if as_it_is and native.dtype.kind in "iuf":
        return pa.array(native.astype(np.float64) if native.dtype == np.float16 else native)
    return pa.array(native.astype(np.float64))


def _decoded(value: Any) -> str:
    if not isinstance(value, bytes):
        return str(value)
    try:
        return value.decode()
    except UnicodeDecodeError:
        return value.decode("latin-1")

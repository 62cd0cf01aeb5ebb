"""HDF5 files: arrays of one length in a group, or an array of records."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drillid.formats.arrow_tables import as_text, by_length, check_size, table_of
from drillid.formats.description import Dialect, Header, Unusable
from drillid.formats.header_rows import unique
from drillid.formats.mnemonics import is_no_unit, split_unit
from drillid.formats.since import start_of

SUFFIXES = (".h5", ".hdf5", ".hdf", ".he5")
FRAGILE = True
_UNITS = ("units", "unit", "Units", "Unit", "UNITS", "UNIT")
_NAMES = ("columns", "column_names", "names", "fields", "channels", "headers")
_STARTS = ("start", "start_time", "epoch", "t0", "reference_time")
_MOST_NAMES = 1000
_KINDS = "iufSOVM"


@dataclass(frozen=True)
class Source:
    """Where the values of a column are: a data set, or a field or column of one."""

    dataset: str
    field: str | int | None = None


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """The open file; faults of the library become `ValueError`."""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            yield file
    except (RuntimeError, KeyError, TypeError, AttributeError, OverflowError) as error:
        raise ValueError(f"it is damaged: {error}") from error


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """A table for the equally long arrays of each group, and for each array of records."""
    with opened(path) as file:
        return named_tables(list(_tables(file, path.stat().st_size)))


def named_tables(found: list[Header]) -> list[Header]:
    """Tables that can be chosen by name; one alone needs none.

    Raises
    ------
    Unusable
        If there is none.
    """
    if not found:
        raise Unusable("holds no arrays of equal length that could be a log", "Save each channel as an array")
    return found if len(found) > 1 else [Header(**{**vars(found[0]), "table": ""})]


def _tables(file: Any, file_size: int) -> Iterator[Header]:
    import h5py

    groups: dict[str, dict[str, Any]] = {}

    def visit(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.shape and item.dtype.kind in _KINDS and not name.startswith("#"):
            parent, _, own = name.rpartition("/")
            groups.setdefault(parent, {})[own] = item

    file.visititems(visit)
    check_size(sum(float(np.prod(item.shape)) for items in groups.values() for item in items.values()), file_size)
    for parent, items in groups.items():
        for name, item in items.items():
            if item.dtype.names:
                yield _of_records(parent, name, item)
            elif item.ndim == 2 and (names := _names_beside(item, items)):
                yield _of_matrix(parent, name, item, names)
        lengths = {name: _length(item) for name, item in items.items() if not _is_apart(item)}
        for alike in by_length(lengths):
            if len(alike) > 1:
                yield _of_arrays(parent, {name: items[name] for name in alike}, len(set(lengths.values()) - {0, 1}) > 1)


def _is_apart(item: Any) -> bool:
    """Whether an array is no column: one of records, of references, or a text of MATLAB."""
    import h5py

    return bool(item.dtype.names or h5py.check_ref_dtype(item.dtype) or item.attrs.get("MATLAB_class") == b"char")


def _length(item: Any) -> int:
    """Number of values of an array that is a column, in one dimension or as MATLAB writes it in two; else 0."""
    if item.dtype.kind == "V":
        return 0
    long = [size for size in item.shape if size > 1]
    return int(long[0]) if len(long) == 1 and item.ndim <= 2 else 0


def _of_arrays(parent: str, items: Mapping[str, Any], numbered: bool) -> Header:
    names = tuple(items)
    units = {name: unit for name, item in items.items() if (unit := unit_of(name, item.attrs))}
    start = next((found for item in items.values() if (found := _start(item.attrs)) is not None), None)
    start = start if start is not None else _start(next(iter(items.values())).parent.attrs)
    rows = _length(next(iter(items.values())))
    layout = {name: Source(item.name) for name, item in items.items()}
    table = (parent or "/") + (f", {rows} rows" if numbered else "")
    nulls = {name: (value,) for name, item in items.items() if (value := _null(item.attrs)) is not None}
    return Header(names, units, table=table, start=start, start_is_utc=True, nulls=nulls, layout=layout, rows=rows)


def _of_records(parent: str, name: str, item: Any) -> Header:
    layout: dict[str, Source] = {}
    for field in item.dtype.names:
        kind = item.dtype.fields[field][0]
        if kind.shape and len(kind.shape) == 1:
            own = _text_list(item.attrs.get(f"{field}_kind")) or [f"{field}:{at + 1}" for at in range(kind.shape[0])]
            layout |= {column: Source(item.name, f"{field}\0{at}") for at, column in enumerate(own)}
        elif not kind.shape:
            layout[field] = Source(item.name, field)
    units = {name: unit for name in layout if (unit := split_unit(name)[1])}
    return Header(tuple(layout), units, table=f"{parent}/{name}".lstrip("/"), layout=layout, rows=item.shape[0])


def _of_matrix(parent: str, name: str, item: Any, names: list[str]) -> Header:
    columns = unique(names)
    across = item.shape[1] == len(names)
    layout = {column: Source(item.name, at if across else -1 - at) for at, column in enumerate(columns)}
    units = {column: unit for column in columns if (unit := split_unit(column)[1])}
    rows = item.shape[0 if across else 1]
    table, start = f"{parent}/{name}".lstrip("/"), _start(item.attrs)
    return Header(columns, units, table=table, start=start, start_is_utc=True, layout=layout, rows=rows)


def _names_beside(item: Any, items: Mapping[str, Any]) -> list[str] | None:
    """Names of a matrix' columns, from its attributes or from an array of text beside it."""
    stated = [_text_list(item.attrs.get(key)) for key in _NAMES]
    stated += [
        _text_list(_dereferenced(items[key])) for key in _NAMES if key in items and items[key].dtype.kind in "SO"
    ]
    return next((names for names in stated if names and len(names) in item.shape), None)


def _dereferenced(item: Any) -> Any:
    """An array of text; of references, as MATLAB writes cells, the texts that they lead to."""
    import h5py

    if not h5py.check_ref_dtype(item.dtype):
        return item[...]
    texts = (np.ravel(item.file[reference][...]) for reference in np.ravel(item[...])[:_MOST_NAMES])
    return np.array(["".join(map(chr, text)) for text in texts])


def _text_list(value: Any) -> list[str] | None:
    if value is None or isinstance(value, str | bytes):
        return None
    cells = np.ravel(np.asarray(value))
    return [str(cell) for cell in as_text(cells.tolist())] if cells.dtype.kind in "SUO" else None


def unit_of(name: str, attributes: Any) -> str:
    """Unit of an array, by its attributes or its name; empty where there is none."""
    stated = next((attributes[key] for key in _UNITS if key in attributes), "")
    unit = str(as_text(np.ravel(np.asarray(stated)).tolist())[0]) if np.size(stated) else ""
    unit = unit or split_unit(name)[1]
    return "" if is_no_unit(unit) else unit


def _start(attributes: Any) -> np.datetime64 | None:
    """The time that an array counts from, by 'seconds since …' or an attribute of its own."""
    texts = [attributes[key] for key in (*_UNITS, *_STARTS) if key in attributes]
    for text in as_text(cell for value in texts for cell in np.ravel(np.asarray(value)).tolist()):
        found = start_of(str(text))
        if found is not None:
            return found
    return None


def _null(attributes: Any) -> float | None:
    value = next((attributes[key] for key in ("_FillValue", "missing_value", "null_value") if key in attributes), None)
    try:
        return None if value is None else float(np.ravel(value)[0])
    except (ValueError, TypeError):
        return None


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns as an Arrow table."""
    with opened(path) as file:
        return table_of({name: values_of(file, header.layout[name], rows) for name in columns}, text)


def values_of(file: Any, source: Source, rows: int | None) -> Any:
    """Values of one column, shape (row,)."""
    item = file[source.dataset]
    stop = slice(None) if rows is None else slice(0, rows)
    if isinstance(source.field, str):
        field, _, at = source.field.partition("\0")
        values = item.fields(field)[stop]
        return values[:, int(at)] if at else values
    if isinstance(source.field, int):
        return item[stop, source.field] if source.field >= 0 else item[-1 - source.field, stop]
    if item.ndim == 2:
        return np.ravel(item[...])[stop]
    return item[stop]

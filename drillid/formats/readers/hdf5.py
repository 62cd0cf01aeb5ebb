"""HDF5 files: arrays of one length in a group, or an array of records."""

from __future__ import annotations

import re
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
from drillid.formats.places import shortened
from drillid.formats.since import stated_start, unit_since
from drillid.formats.stated_units import units_of

SUFFIXES = (".h5", ".hdf5", ".hdf", ".he5")
FRAGILE = True
_UNITS = ("units", "unit")
_NAMES = ("columns", "columnnames", "names", "fields", "channels", "headers")
_STARTS = ("start", "starttime", "epoch", "t0", "referencetime")
_FILLS = ("fillvalue", "missingvalue", "nullvalue")
"""Names of attributes and of arrays beside a matrix, in lower case and without punctuation."""
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
                yield _of_matrix(parent, name, item, names, items)
        lengths = {name: _length(item) for name, item in items.items() if not _is_apart(item)}
        for alike in by_length(lengths):
            if len(alike) > 1:
                yield _of_arrays(parent, {name: items[name] for name in alike}, len(set(lengths.values()) - {0, 1}) > 1)


def _is_apart(item: Any) -> bool:
    """Whether an array is not a column: one of records, of references, or a text of MATLAB."""
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
    group = next(iter(items.values())).parent
    beside, notes = units_of(_units_beside(group), names)
    units = beside | {name: unit for name, item in items.items() if (unit := unit_of(name, item.attrs))}
    start, is_utc = start_among(*(item.attrs for item in items.values()), *_attributes_above(group))
    rows = _length(next(iter(items.values())))
    layout = {name: Source(item.name) for name, item in items.items()}
    table = (parent or "/") + (f", {rows} rows" if numbered else "")
    return Header(names, units, table=table, start=start, start_is_utc=is_utc, layout=layout, notes=notes, rows=rows)


def _of_records(parent: str, name: str, item: Any) -> Header:
    layout: dict[str, Source] = {}
    for field in item.dtype.names:
        kind = item.dtype.fields[field][0]
        if kind.shape and len(kind.shape) == 1:
            own = _text_list(item.attrs.get(f"{field}_kind")) or [f"{field}:{at + 1}" for at in range(kind.shape[0])]
            layout |= {column: Source(item.name, f"{field}\0{at}") for at, column in enumerate(own)}
        elif not kind.shape:
            layout[field] = Source(item.name, field)
    units, notes = units_of(stated(item.attrs, _UNITS), tuple(layout))
    start, is_utc = start_among(item.attrs, *_attributes_above(item.parent))
    table, rows = f"{parent}/{name}".lstrip("/"), item.shape[0]
    return Header(
        tuple(layout), units, table=table, start=start, start_is_utc=is_utc, layout=layout, notes=notes, rows=rows
    )


def _of_matrix(parent: str, name: str, item: Any, names: list[str], items: Mapping[str, Any]) -> Header:
    columns = unique(names)
    across = item.shape[1] == len(names)
    layout = {column: Source(item.name, at if across else -1 - at) for at, column in enumerate(columns)}
    own = stated(item.attrs, _UNITS)
    beside = next((_text_list(_dereferenced(items[key])) for key in items if _is_text(items[key], key, _UNITS)), None)
    units, notes = units_of(own if own is not None else beside, columns)
    rows = item.shape[0 if across else 1]
    table = f"{parent}/{name}".lstrip("/")
    start, is_utc = start_among(item.attrs, *_attributes_above(item.parent))
    return Header(columns, units, table=table, start=start, start_is_utc=is_utc, layout=layout, notes=notes, rows=rows)


def _names_beside(item: Any, items: Mapping[str, Any]) -> list[str] | None:
    """Names of a matrix's columns, from its attributes or from an array of text beside it."""
    found = [_text_list(stated(item.attrs, (key,))) for key in _NAMES]
    found += [_text_list(_dereferenced(items[key])) for key in items if _is_text(items[key], key, _NAMES)]
    return next((names for names in found if names and len(names) in item.shape), None)


def _is_text(item: Any, name: str, names: Sequence[str]) -> bool:
    """Whether an array has one of the given names and holds text."""
    return plain(name) in names and item.dtype.kind in "SO"


def _units_beside(group: Any) -> dict[str, str] | None:
    """Texts in a group that is named like units, in the columns' group or in one above it, by their names."""
    import h5py

    while True:
        for found in (group.get(name) for name in group if plain(name) in _UNITS):
            texts = {key: _one_text(item) for key, item in found.items()} if isinstance(found, h5py.Group) else {}
            if any(texts.values()):
                return texts
        if group.name == "/":
            return None
        group = group.parent


def _one_text(item: Any) -> str:
    """The text in an array, which MATLAB writes as the numbers of its characters; empty where it holds none."""
    import h5py

    if not isinstance(item, h5py.Dataset) or item.size > _MOST_NAMES:
        return ""
    if item.attrs.get("MATLAB_class") == b"char":
        return "".join(map(chr, np.ravel(item[()])))
    is_text = item.size == 1 and h5py.check_string_dtype(item.dtype) is not None
    return str(as_text(np.ravel(item[()]).tolist())[0]) if is_text else ""


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


def plain(name: str) -> str:
    """A name in lower case and without punctuation."""
    return re.sub(r"[\W_]", "", name).lower()


def stated(attributes: Any, names: Sequence[str]) -> Any:
    """The attribute with the first of the names that is found, in any case and punctuation; None without one."""
    by_name = {plain(key): key for key in attributes}
    return next((attributes[by_name[name]] for name in names if name in by_name), None)


def unit_of(name: str, attributes: Any) -> str:
    """Unit of an array, by its attributes or its name; empty where there is none."""
    found = stated(attributes, _UNITS)
    unit = str(as_text(np.ravel(np.asarray(found)).tolist())[0]) if found is not None and np.size(found) else ""
    unit = unit or split_unit(name)[1]
    return "" if is_no_unit(unit) else unit


def _attributes_above(group: Any) -> Iterator[Any]:
    """Attributes of a group and of those that hold it."""
    yield group.attrs
    while group.name != "/":
        group = group.parent
        yield group.attrs


def start_among(*attributes: Any) -> tuple[np.datetime64 | None, bool]:
    """The time that a table counts from, by 'seconds since …' or an attribute of its own, and whether that is UTC."""
    for each in attributes:
        texts = [value for key in (*_UNITS, *_STARTS) if (value := stated(each, (key,))) is not None]
        for text in as_text(cell for value in texts for cell in np.ravel(np.asarray(value))[:_MOST_NAMES].tolist()):
            found = stated_start(str(text))
            if found is not None:
                # by convention, times after 'since' are UTC without a zone as well
                return found[0], found[1] or unit_since(str(text)) != text
    return None, False


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns as an Arrow table."""
    with opened(path) as file:
        return table_of({name: values_of(file, header.layout[name], rows) for name in columns}, text)


def values_of(file: Any, source: Source, rows: int | None) -> Any:
    """Values of one column, shape (row,), scaled by the attributes of its array; NaN where these call them missing."""
    item = file[source.dataset]
    return _scaled(_stored(item, source, rows), item)


def _scaled(values: Any, item: Any) -> Any:
    """Numbers that are packed by the conventions for climate and forecast: value = scale * stored + offset.

    Raises
    ------
    Unusable
        If a scale or an offset is not a number.
    """
    if values.dtype.kind not in "iuf" or item.dtype.names:
        return values
    fills = [float(cell) for key in _FILLS for cell in np.ravel(stated(item.attrs, (key,))) if _is_number(cell)]
    missing = np.isin(values, np.array(fills, dtype=values.dtype if values.dtype.kind == "f" else float))
    scale, offset = _number(item, "scale_factor", 1.0), _number(item, "add_offset", 0.0)
    if (scale, offset) == (1.0, 0.0) and not np.any(missing):
        return values
    return np.where(missing, np.nan, scale * values.astype(np.float64) + offset)


def _is_number(cell: Any) -> bool:
    return isinstance(cell, int | float | np.number)


def _number(item: Any, name: str, default: float) -> float:
    """The number in an attribute."""
    cells = np.ravel(item.attrs.get(name, default))
    if cells.size != 1 or not _is_number(cells[0]) or not np.isfinite(cells[0]):
        what = f"states {shortened(cells.tolist())} as '{name}' of '{item.name}', which is not one number"
        raise Unusable(what, "Correct that attribute, or write the values themselves")
    return float(cells[0])


def _stored(item: Any, source: Source, rows: int | None) -> Any:
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

"""MATLAB files: of version 7.3, which are HDF5, and older ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from drillid.formats.arrow_tables import as_text, by_length, table_of
from drillid.formats.description import Dialect, Header, Unusable
from drillid.formats.header_rows import unique
from drillid.formats.mnemonics import is_no_unit, split_unit
from drillid.formats.readers import hdf5

SUFFIXES = (".mat",)
FRAGILE = True
_HDF5 = b"\x89HDF\r\n\x1a\n"
_NAMES = ("columns", "column_names", "names", "channels", "header", "headers", "colheaders", "varnames", "labels")
_UNITS = ("units", "unit", "Units", "Unit")
_VALUES = ("data", "values", "value", "samples")
"""Fields of a structure of one channel."""
_ADVICE = "Save the columns as plain arrays, such as t = posixtime(T.Time); rpm = T.RPM; save('log.mat', 't', 'rpm')"


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """A table for the equally long arrays at the top of the file or in a structure, and for matrices with names.

    Raises
    ------
    ValueError
        If it holds no such arrays; objects such as timetables cannot be read.
    """
    if _is_hdf5(path):
        try:
            return hdf5.headers(path, dialect)
        except Unusable as error:
            raise Unusable(error.what, f"Of objects such as timetables: {_ADVICE}") from error
    content = _content(path)
    found = list(_tables("", content))
    if not found:
        objects = (
            any(type(value).__name__ == "MatlabOpaque" for value in content.values())
            or "__function_workspace__" in content
        )
        what = "holds objects such as a timetable" if objects else "holds no arrays of equal length"
        raise Unusable(f"{what}, which cannot be read", _ADVICE)
    return hdf5.named_tables(found)


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns as an Arrow table."""
    if _is_hdf5(path):
        return hdf5.read_columns(path, header, columns, text, rows)
    content = _content(path)
    arrays = {}
    for name in columns:
        place, at = header.layout[name]
        value: Any = content
        for key in place:
            value = value[key]
        column = value if at is None else np.take(value, at, axis=1)
        cells = np.asarray(column)[: len(column) if rows is None else rows]
        if cells.dtype.kind == "O":
            cells = np.array(["" if _is_empty(cell) else cell for cell in cells], dtype=object)
        arrays[name] = cells
    return table_of(arrays, text)


def _is_hdf5(path: Path) -> bool:
    with path.open("rb") as file:
        start = file.read(520)
    return start.startswith(_HDF5) or start[512:520] == _HDF5


def _content(path: Path) -> dict[str, Any]:
    """Variables of the file, structures as dictionaries."""
    from scipy.io import loadmat

    try:
        content: dict[str, Any] = loadmat(path, simplify_cells=True, chars_as_strings=True)
    except MemoryError:
        raise
    except Exception as error:  # scipy raises whatever it meets in a damaged file
        raise ValueError(f"it is no MATLAB file, or damaged: {error}") from error
    return {
        name: _channels(value) or value
        for name, value in content.items()
        if name == "__function_workspace__" or not name.startswith("__")
    }


def _channels(value: Any) -> dict[str, Any] | None:
    """An array of structures with the name and the values of a channel each, as arrays by their names; else None."""
    if not isinstance(value, list | np.ndarray) or not len(value) or not all(isinstance(one, Mapping) for one in value):
        return None
    found, units = {}, {}
    for one in value:
        fields = {key.lower(): field for key, field in one.items()}
        samples = next((fields[key] for key in _VALUES if key in fields), None)
        if not isinstance(fields.get("name"), str) or samples is None:
            return None
        found[fields["name"]] = samples
        units[fields["name"]] = next((str(fields[key]) for key in ("unit", "units") if key in fields), "")
    return {**found, "units": units}


def _tables(
    name: str, content: Mapping[str, Any], place: tuple[str, ...] = (), above: Mapping[str, Any] | None = None
) -> Iterator[Header]:
    units = next((content[key] for key in _UNITS if isinstance(content.get(key), Mapping)), above or {})
    lengths = {}
    for key, value in content.items():
        if isinstance(value, Mapping):
            if key not in _UNITS and len(place) < 4:
                yield from _tables(f"{name}.{key}".lstrip("."), value, (*place, key), units)
        elif isinstance(value, np.ndarray) and value.ndim == 2 and value.dtype.kind in "iuf":
            names = _names_of(content, value.shape[1])
            if names is not None:
                yield _of_matrix(f"{name}.{key}".lstrip("."), (*place, key), value, names)
        elif isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "iufUO" and _plain(value):
            lengths[key] = value.size
    groups = [alike for alike in by_length(lengths) if len(alike) > 1]
    for alike in groups:
        stated = {key: unit for key in alike if (unit := _unit(key, units))}
        table = (name or "variables") + (f", {lengths[alike[0]]} rows" if len(groups) > 1 else "")
        layout = {key: ((*place, key), None) for key in alike}
        yield Header(tuple(alike), stated, table=table, layout=layout, rows=lengths[alike[0]])


def _plain(values: Any) -> bool:
    """Whether an array holds numbers or text only."""
    return values.dtype.kind != "O" or all(isinstance(value, str | float | int) or _is_empty(value) for value in values)


def _is_empty(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.size == 0


def _names_of(content: Mapping[str, Any], width: int) -> list[str] | None:
    """Names of a matrix' columns, in an array of text beside it."""
    for key, value in content.items():
        if key.lower() in _NAMES and isinstance(value, np.ndarray | list) and len(value) == width > 1:
            return [str(cell).strip() for cell in as_text(list(value))]
    return None


def _of_matrix(table: str, place: tuple[str, ...], value: Any, names: list[str]) -> Header:
    columns = unique(names)
    units = {column: unit for column in columns if (unit := split_unit(column)[1])}
    layout = {column: (place, at) for at, column in enumerate(columns)}
    return Header(columns, units, table=table, layout=layout, rows=value.shape[0])


def _unit(name: str, units: Mapping[str, Any]) -> str:
    unit = str(units.get(name, "")) or split_unit(name)[1]
    return "" if is_no_unit(unit) else unit

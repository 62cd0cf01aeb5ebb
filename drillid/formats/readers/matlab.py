"""MATLAB files: of version 7.3, which are HDF5, and older ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from drillid.formats.arrow_tables import as_text, by_length, table_of
from drillid.formats.description import Dialect, Header, Unusable
from drillid.formats.header_rows import unique
from drillid.formats.mnemonics import date_among, is_no_unit, split_unit, time_among
from drillid.formats.readers import hdf5
from drillid.formats.stated_units import units_of

SUFFIXES = (".mat",)
FRAGILE = True
_HDF5 = b"\x89HDF\r\n\x1a\n"
_NAMES = ("columns", "columnnames", "names", "channels", "header", "headers", "colheaders", "varnames", "labels")
_UNITS = ("units", "unit")
_RATES = ("fs", "samplerate", "samplingrate", "samplefrequency", "samplingfrequency")
_INTERVALS = ("dt", "sampletime", "sampleinterval", "samplinginterval", "samplingtime")
"""Names of variables, in lower case and without punctuation; rates in Hz, intervals in s."""
_MADE_TIME = "Time"
_VALUES = ("data", "values", "value", "samples")
"""Fields that hold the values in a structure of one channel."""
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
        if isinstance(place, float):
            count = header.rows or 0
            arrays[name] = np.arange(count if rows is None else min(rows, count)) / place
            continue
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
        raise ValueError(f"it is not a MATLAB file, or is damaged: {error}") from error
    return {
        name: _channels(value) or _simulink(value) or value
        for name, value in content.items()
        if name == "__function_workspace__" or not name.startswith("__")
    }


def _channels(value: Any) -> dict[str, Any] | None:
    """An array of structures, each with a channel's name and values, as arrays by their names; None of any other."""
    if not isinstance(value, list | np.ndarray) or not len(value) or not all(isinstance(one, Mapping) for one in value):
        return None
    found, units = dict[str, Any](), dict[str, str]()
    for one in value:
        fields = {key.lower(): field for key, field in one.items()}
        samples = next((fields[key] for key in _VALUES if key in fields), None)
        if not isinstance(fields.get("name"), str) or samples is None:
            return None
        found[fields["name"]] = samples
        units[fields["name"]] = next((str(fields[key]) for key in ("unit", "units") if key in fields), "")
    return {**found, "units": units}


def _simulink(value: Any) -> dict[str, Any] | None:
    """A structure with time, as Simulink logs signals, as arrays by the signals' labels; None of anything else."""
    if not isinstance(value, Mapping) or not {"time", "signals"} <= set(value):
        return None
    signals = [value["signals"]] if isinstance(value["signals"], Mapping) else value["signals"]
    if not isinstance(signals, list | np.ndarray) or not all(isinstance(one, Mapping) for one in signals):
        return None
    names, arrays = list[str](), list[Any]()
    for number, one in enumerate(signals, 1):
        own = next((str(one[key]) for key in ("label", "blockName") if np.size(one.get(key, ())) and one[key]), "")
        columns = np.asarray(one.get("values", ()))
        if columns.shape[:1] != np.shape(value["time"]) or columns.ndim > 2:
            return None
        columns = columns.reshape(len(columns), -1)
        names += [own or f"signal {number}"] * columns.shape[1]
        arrays += list(columns.T)
    return dict(zip(unique(["time", *names]), [value["time"], *arrays], strict=True))


def _tables(
    name: str, content: Mapping[str, Any], place: tuple[str, ...] = (), above: Mapping[str, Any] | None = None
) -> Iterator[Header]:
    stated = hdf5.stated(content, _UNITS)
    units = stated if isinstance(stated, Mapping) else above or {}
    lengths = {}
    for key, value in content.items():
        if isinstance(value, Mapping):
            if hdf5.plain(key) not in _UNITS and len(place) < 4:
                yield from _tables(f"{name}.{key}".lstrip("."), value, (*place, key), units)
        elif isinstance(value, np.ndarray) and value.ndim == 2 and value.dtype.kind in "iuf":
            names = _names_of(content, value.shape[1])
            if names is not None:
                yield _of_matrix(f"{name}.{key}".lstrip("."), (*place, key), value, names, units or stated)
        elif isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "iufUO" and _plain(value):
            lengths[key] = value.size
    groups = [alike for alike in by_length(lengths) if len(alike) > 1]
    for alike in groups:
        in_file = {key: unit for key in alike if (unit := _unit(key, units))}
        table = (name or "variables") + (f", {lengths[alike[0]]} rows" if len(groups) > 1 else "")
        layout = {key: ((*place, key), None) for key in alike}
        yield _timed(Header(tuple(alike), in_file, table=table, layout=layout, rows=lengths[alike[0]]), content)


def _timed(header: Header, content: Mapping[str, Any]) -> Header:
    """A table without times, with those that a sampling rate or interval beside it gives, if there is one."""
    rate, interval = (_one_number(hdf5.stated(content, names)) for names in (_RATES, _INTERVALS))
    if time_among(header.columns) is not None or date_among(header.columns) is not None or not (rate or interval):
        return header
    start, is_utc = hdf5.start_among(content)
    rate = rate or 1 / interval
    note = (
        f"no column holds times; they are made of {rate:g} rows a second, as the file states",
        ("Write a column of times if that is wrong"),
    )
    return replace(
        header,
        columns=(_MADE_TIME, *header.columns),
        units=header.units | {_MADE_TIME: "s"},
        time=_MADE_TIME,
        start=start,
        start_is_utc=is_utc,
        layout={**header.layout, _MADE_TIME: (rate, None)},
        notes=(*header.notes, note),
    )


def _one_number(value: Any) -> float:
    """A number above zero; 0 for anything else."""
    return float(value) if isinstance(value, int | float | np.number) and value > 0 else 0.0


def _plain(values: Any) -> bool:
    """Whether an array holds only numbers or text."""
    return values.dtype.kind != "O" or all(isinstance(value, str | float | int) or _is_empty(value) for value in values)


def _is_empty(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.size == 0


def _names_of(content: Mapping[str, Any], width: int) -> list[str] | None:
    """Names of a matrix's columns, in an array of text beside it."""
    for key, value in content.items():
        if hdf5.plain(key) in _NAMES and isinstance(value, np.ndarray | list) and len(value) == width > 1:
            return [str(cell).strip() for cell in as_text(list(value))]
    return None


def _of_matrix(table: str, place: tuple[str, ...], value: Any, names: list[str], stated: Any) -> Header:
    columns = unique(names)
    units, notes = units_of(stated, columns)
    layout = {column: (place, at) for at, column in enumerate(columns)}
    return Header(columns, units, table=table, layout=layout, notes=notes, rows=value.shape[0])


def _unit(name: str, units: Mapping[str, Any]) -> str:
    unit = str(units.get(name, "")) or split_unit(name)[1]
    return "" if is_no_unit(unit) else unit

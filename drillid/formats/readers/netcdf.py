"""netCDF files, opened by xarray; channels lie at the root or in groups."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from drillid.formats.arrow_tables import check_size, table_of
from drillid.formats.description import Dialect, Header
from drillid.formats.mnemonics import is_no_unit, split_unit
from drillid.formats.readers.hdf5 import named_tables

SUFFIXES = (".nc", ".nc4", ".cdf", ".netcdf")
FRAGILE = True
_CLASSIC = b"CDF"
Groups = Mapping[str, Any]
"""Xarray datasets by the paths of their groups; that of the root is empty."""


@contextmanager
def _opened(path: Path) -> Iterator[Groups]:
    with path.open("rb") as file:
        engine: Any = "scipy" if file.read(3) == _CLASSIC else "h5netcdf"
    try:
        with opened_groups(path, engine=engine, mask_and_scale=True, cache=False) as groups:
            yield groups
    except MemoryError:
        raise
    except (RuntimeError, KeyError, TypeError, AttributeError, OverflowError, IndexError, AssertionError) as error:
        raise ValueError(f"it is damaged: {error}") from error


@contextmanager
def opened_groups(path: Path, engine: Any, **options: Any) -> Iterator[Groups]:
    """Every group of a file or store; `options` are those of `xarray.open_groups`."""
    import xarray as xr

    with ExitStack() as opened:
        if engine == "scipy":
            found = {"": xr.open_dataset(path, engine=engine, decode_timedelta=False, **options)}
        else:
            found = xr.open_groups(path, engine=engine, decode_timedelta=False, **options)
        yield {group.strip("/"): opened.enter_context(dataset) for group, dataset in sorted(found.items())}


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """A table for the variables of each group along each dimension."""
    with _opened(path) as groups:
        return tables_of(groups, path.stat().st_size)


def tables_of(groups: Groups, size: int) -> list[Header]:
    """A table for the variables of each group along each dimension, named by group, dimension or both, as needed."""
    along = {group: _along_dimensions(groups, group) for group in groups}
    cells = sum(float(max(rows, 0)) * len(names) for found in along.values() for rows, names in found.values())
    check_size(cells, size)
    tables = []
    for group, found in along.items():
        usable = {dimension: each for dimension, each in found.items() if len(each[1]) > 1 and each[0] > 0}
        for dimension, (rows, names) in usable.items():
            table = dimension if not group else group if len(usable) == 1 else f"{group}, {dimension}"
            tables.append(_table(groups, group, table, rows, names))
    return named_tables(tables)


def _along_dimensions(groups: Groups, group: str) -> dict[str, tuple[int, list[str]]]:
    """Length of each dimension of a group and the columns along it, from the group itself or those that hold it."""
    found: dict[str, tuple[int, list[str]]] = {}
    for name, variable in groups[group].variables.items():
        if _is_column(variable):
            dimension = str(variable.dims[0])
            found.setdefault(dimension, (int(groups[group].sizes[dimension]), []))[1].append(str(name))
    for above in _above(group):
        for name, variable in groups[above].variables.items() if above in groups else ():
            rows, names = found.get(str(variable.dims[0]), (-1, [])) if _is_column(variable) else (-1, [])
            if rows == variable.size and str(name) not in names:
                names.append(str(name))
    return found


def _is_column(variable: Any) -> bool:
    return bool(variable.ndim == 1 and variable.dtype.kind in "iufMSUObT")


def _above(group: str) -> list[str]:
    """Groups that hold a group, the nearest first."""
    parts = group.split("/") if group else []
    return ["/".join(parts[:count]) for count in range(len(parts) - 1, -1, -1)]


def _table(groups: Groups, group: str, table: str, rows: int, names: Sequence[str]) -> Header:
    layout = {name: next(each for each in (group, *_above(group)) if name in groups[each].variables) for name in names}
    variables = {name: groups[layout[name]].variables[name] for name in names}
    units = {name: unit for name in names if (unit := _unit(name, variables[name].attrs))}
    time = next((name for name in names if variables[name].dtype.kind == "M"), None)
    columns = tuple(sorted(names, key=lambda name: name != time))
    return Header(columns, units, table=table, time=time, layout=layout, rows=rows)


def _unit(name: str, attributes: Any) -> str:
    unit = str(attributes.get("units", attributes.get("unit", ""))) or split_unit(name)[1]
    return "" if is_no_unit(unit) else unit


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns as an Arrow table; calendar times are UTC, by convention."""
    with _opened(path) as groups:
        return columns_of(groups, header, columns, text, rows)


def columns_of(groups: Groups, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None) -> Any:
    """Variables of xarray datasets as an Arrow table; times are UTC."""
    import pyarrow as pa

    stop = header.rows if rows is None else rows
    arrays = {name: groups[header.layout[name]].variables[name][:stop].values for name in columns}
    table = table_of(arrays, text)
    for position, field in enumerate(table.schema):
        if pa.types.is_timestamp(field.type):
            table = table.set_column(position, field.name, table.column(position).cast(pa.timestamp("ns", "UTC")))
    return table

"""netCDF files, opened by xarray."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from drillid.formats.arrow_tables import check_size, table_of
from drillid.formats.description import Dialect, Header
from drillid.formats.mnemonics import is_no_unit, split_unit
from drillid.formats.readers.hdf5 import named_tables

SUFFIXES = (".nc", ".nc4", ".cdf", ".netcdf")
FRAGILE = True
_CLASSIC = b"CDF"


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    import xarray as xr

    with path.open("rb") as file:
        engine: Any = "scipy" if file.read(3) == _CLASSIC else "h5netcdf"
    try:
        with xr.open_dataset(path, engine=engine, decode_timedelta=False, mask_and_scale=True, cache=False) as dataset:
            yield dataset
    except MemoryError:
        raise
    except (RuntimeError, KeyError, TypeError, AttributeError, OverflowError, IndexError, AssertionError) as error:
        raise ValueError(f"it is damaged: {error}") from error


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """A table for the variables along each dimension."""
    with _opened(path) as dataset:
        return tables_of(dataset, path.stat().st_size)


def tables_of(dataset: Any, size: int) -> list[Header]:
    """A table for the variables of an xarray dataset along each dimension."""
    along: dict[str, list[str]] = {}
    for name, variable in dataset.variables.items():
        if variable.ndim == 1 and variable.dtype.kind in "iufMSUObT":
            along.setdefault(str(variable.dims[0]), []).append(str(name))
    check_size(float(sum(dataset.sizes[dimension] * len(names) for dimension, names in along.items())), size)
    found = []
    for dimension, names in along.items():
        if len(names) < 2 or dataset.sizes[dimension] < 1:
            continue
        units = {name: unit for name in names if (unit := _unit(name, dataset.variables[name].attrs))}
        time = next((name for name in names if dataset.variables[name].dtype.kind == "M"), None)
        columns = tuple(sorted(names, key=lambda name: name != time))
        rows = int(dataset.sizes[dimension])
        found.append(Header(columns, units, table=dimension, time=time, layout=None, rows=rows))
    return named_tables(found)


def _unit(name: str, attributes: Any) -> str:
    unit = str(attributes.get("units", attributes.get("unit", ""))) or split_unit(name)[1]
    return "" if is_no_unit(unit) else unit


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns as an Arrow table; times of a calendar are UTC, as the conventions have it."""
    with _opened(path) as dataset:
        return columns_of(dataset, header, columns, text, rows)


def columns_of(dataset: Any, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None) -> Any:
    """Variables of an xarray dataset as an Arrow table; times are UTC."""
    import pyarrow as pa

    stop = header.rows if rows is None else rows
    table = table_of({name: dataset.variables[name][:stop].values for name in columns}, text)
    for position, field in enumerate(table.schema):
        if pa.types.is_timestamp(field.type):
            table = table.set_column(position, field.name, table.column(position).cast(pa.timestamp("ns", "UTC")))
    return table

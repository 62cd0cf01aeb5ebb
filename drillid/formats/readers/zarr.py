"""Zarr stores in a folder, opened by xarray; channels lie at the root or in groups."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from drillid.formats.description import Dialect, Header, Unusable
from drillid.formats.readers.netcdf import Groups, columns_of, opened_groups, tables_of

SUFFIXES = (".zarr",)


@contextmanager
def _opened(path: Path) -> Iterator[Groups]:
    import warnings

    if not path.exists():
        raise FileNotFoundError(path)
    if not path.is_dir():
        raise ValueError("it is not a folder, as a zarr store is")
    try:
        with warnings.catch_warnings():
            # stores need no consolidated metadata, and zarr's newer types are read all the same
            warnings.simplefilter("ignore")
            with opened_groups(path, engine="zarr", chunks=None, create_default_indexes=False) as groups:
                yield groups
    except FileNotFoundError as error:
        raise ValueError(f"it is not a zarr store, or is damaged: {error}") from error
    except (OSError, MemoryError, Unusable):
        raise
    except Exception as error:  # zarr and its codecs raise whatever they meet in a damaged store
        raise ValueError(f"it is not a zarr store, or is damaged: {error}") from error


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """A table for the variables of each group along each dimension."""
    with _opened(path) as groups:
        return tables_of(groups, sum(file.stat().st_size for file in path.rglob("*") if file.is_file()))


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns as an Arrow table.

    Raises
    ------
    ValueError
        If a chunk of them is missing, which zarr itself treats as empty.
    """
    with _opened(path) as groups:
        _check_chunks(path, {name: f"{header.layout[name]}/{name}".lstrip("/") for name in columns})
        return columns_of(groups, header, columns, text, rows)


def _check_chunks(path: Path, columns: Mapping[str, str]) -> None:
    import zarr

    group = zarr.open_group(path, mode="r")
    for name, place in columns.items():
        array: Any = group[place]
        if array.nchunks_initialized < array.nchunks:
            missing = array.nchunks - array.nchunks_initialized
            raise ValueError(f"{missing} of the {array.nchunks} chunks of '{name}' are missing")

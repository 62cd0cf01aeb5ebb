"""Datasets on disk: one zarr store each, written whole under a temporary name, then renamed."""

import contextlib
import os
import shutil
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np
import pandas as pd
import xarray as xr

from drillid.datasets.checksums import SUFFIX, check, checksum, stamps, write_checksums, write_listing
from drillid.datasets.registry import DATASETS, PROBLEM_COLUMNS
from drillid.datasets.tables import read_table, write_table
from drillid.errors import DrillidError, is_of_machine

_MEMO = "memo.txt"
_SERIES_CHUNK = 60_000
"""Samples in a chunk of a long series; ten minutes at 100 Hz."""


@dataclass(frozen=True)
class Problem:
    """One rejected item: a row of the problems table."""

    where: str
    what: str
    remedy: str
    again: bool = False
    """Whether the machine may be at fault, so that the next run tries again; no part of the row."""

    @classmethod
    def of(cls, error: DrillidError) -> Self:
        """The problem that an error stands for."""
        return cls(error.where, error.what, error.remedy, is_of_machine(error))


def window_place(windows: xr.Dataset, row: int) -> str:
    """How a problem names the window in a row of any dataset with WINDOW_COORDINATES."""
    return f"window {int(windows['window'][row])} at {float(windows['hole_depth'][row]):.1f} m"


def windows_place(windows: xr.Dataset, rows: Sequence[int]) -> str:
    """The same for some of the windows, `rows` in order: successive ones as from … to …."""
    if len(rows) == 1:
        return window_place(windows, rows[0])
    numbers, depth = windows["window"].values[rows], windows["hole_depth"].values[rows]
    runs = np.split(numbers, np.flatnonzero(np.diff(numbers) != 1) + 1)
    listed = ", ".join(f"{run[0]} to {run[-1]}" if run.size > 1 else f"{run[0]}" for run in runs)
    return f"windows {listed} at {depth.min():.1f} to {depth.max():.1f} m"


@dataclass(frozen=True)
class WellFolders:
    """Where one well's datasets are: `<results>/<stage>/<well>/<dataset>.zarr`."""

    results: Path
    well: str
    """Folder of the well below that of each stage."""
    basis: str = ""
    """Hash of code, settings and rig description that the stage at work uses: a part of the key of all its rows."""
    name: str = ""
    """What people call the well, which the datasets say; by default as its folder is called."""
    provenance: Mapping[str, str] = field(default_factory=dict)
    """Attributes of all datasets that the stage at work writes: what they come from."""

    def stage(self, stage: str) -> Path:
        """Folder of one stage's outputs for this well."""
        return self.results / stage / self.well

    def aside(self, stage: str) -> Path:
        """Folder of what the stage made of this well before, while it is made again."""
        return self.results / stage / ".previous" / self.well

    def read(self, stage: str, name: str, variables: Collection[str] | None = None) -> xr.Dataset:
        """Open a dataset lazily; a long series without an index of its times, which would load all of them.

        Parameters
        ----------
        variables : those to open, which takes less time where there are few; by default all

        Raises
        ------
        DamageError
            If a file of it is missing or has changed, at once or when its values are read.
        """
        return _opened(self.stage(stage), stage, name, variables)

    def earlier(self, stage: str, name: str) -> xr.Dataset | None:
        """The same of what the stage made before, for rows that need not be made again; None where there is none."""
        there = (self.aside(stage) / f"{name}.zarr").exists()
        return _opened(self.aside(stage), stage, name) if there else None

    def earlier_memo(self, stage: str) -> dict[str, str]:
        """The memo of what the stage made before, see `drillid.datasets.reuse.Memo`: JSON by its keys.

        It is empty where there is none, and where the file is damaged.
        """
        try:
            expected, _, content = (self.aside(stage) / _MEMO).read_bytes().partition(b"\n")
            if checksum(content).encode() != expected:
                return {}
            return dict(line.split(" ", 1) for line in content.decode().splitlines())
        except (OSError, ValueError):
            return {}

    def write_memo(self, stage: str, content: Mapping[str, str]) -> None:
        """Write the stage's memo for the runs to come: a checksum, then a line with key and JSON for each entry."""
        path = self.stage(stage) / _MEMO
        path.parent.mkdir(parents=True, exist_ok=True)
        lines = "".join(f"{key} {content[key]}\n" for key in sorted(content)).encode()
        path.write_bytes(checksum(lines).encode() + b"\n" + lines)

    def has(self, stage: str, name: str) -> bool:
        """Whether the stage wrote the dataset; it did not where the well failed before."""
        return (self.stage(stage) / f"{name}.zarr").exists()

    def write(self, stage: str, name: str, dataset: xr.Dataset, **attributes: Any) -> None:
        """Conform a dataset to its schema and write it; a half-written store never has the final name."""
        path = self.stage(stage) / f"{name}.zarr"
        path.parent.mkdir(parents=True, exist_ok=True)
        conformed = DATASETS[name].conform(dataset, well=self.name or self.well, **self.provenance, **attributes)
        _write_whole(conformed, path, path.with_suffix(SUFFIX))

    @contextlib.contextmanager
    def appending(
        self, stage: str, name: str, kept: int = 0, **attributes: Any
    ) -> Iterator[Callable[[xr.Dataset], None]]:
        """Write a long series piece by piece along time, so that memory holds one piece only.

        Yields a function that appends the next piece. The store gets its final name when the
        block ends without an error; without any piece there is no store.

        Parameters
        ----------
        kept : samples that the earlier series begins with and the new one too; they are not written again, and the
            earlier series is used up
        """
        path = self.stage(stage) / f"{name}.zarr"
        temporary = path.with_suffix(".part")
        shutil.rmtree(temporary, ignore_errors=True)
        path.parent.mkdir(parents=True, exist_ok=True)
        earlier, untouched = self.aside(stage) / f"{name}{SUFFIX}", None
        if kept:
            os.replace(self.aside(stage) / f"{name}.zarr", temporary)
            untouched = stamps(temporary)
            _cut(temporary, kept, {"well": self.name or self.well, **self.provenance, **attributes})

        def append(piece: xr.Dataset) -> None:
            from drillid.datasets.direct import DirectStore, without_threads

            conformed = DATASETS[name].conform(piece, well=self.name or self.well, **self.provenance, **attributes)
            begun = temporary.exists()
            how: dict[str, Any] = {"append_dim": "time"} if begun else {"encoding": _series_encoding(conformed)}
            with without_threads():
                conformed.to_zarr(DirectStore(temporary), mode="a" if begun else "w", consolidated=False, **how)

        yield append
        if temporary.exists():
            from drillid.datasets.direct import DirectStore

            _consolidate(DirectStore(temporary))
            write_checksums(temporary, path.with_suffix(SUFFIX), earlier, untouched)
            _rename(temporary, path)
        else:
            shutil.rmtree(path, ignore_errors=True)

    def write_table(self, stage: str, name: str, table: pd.DataFrame) -> None:
        """Write a table of a stage, whole or not at all."""
        path = self.stage(stage) / f"{name}.csv"
        write_table(table, path)
        write_listing({path.name: checksum(path.read_bytes())}, path.with_suffix(SUFFIX))

    def read_table(self, stage: str, name: str, **options: Any) -> pd.DataFrame:
        """Read a table of a stage; `options` are those of `pandas.read_csv`.

        Raises
        ------
        FileNotFoundError
            If the stage wrote none.
        DamageError
            If it is missing or has changed since.
        """
        path = self.stage(stage) / f"{name}.csv"
        check(path, stage)
        return read_table(path, **options)


def write_store(dataset: xr.Dataset, path: Path) -> None:
    """Write one zarr store whole, replacing an older one."""
    _write_whole(dataset, path)


def _write_whole(dataset: xr.Dataset, path: Path, sums: Path | None = None) -> None:
    """The same, with a file for the checksums of the store.

    It is put together in memory, as zarr hands every file of a store on disk to a thread, which takes twice the time.
    """
    from zarr.storage import MemoryStore

    from drillid.datasets.direct import DirectZstd

    held: dict[str, Any] = {}
    store, codec, dataset = MemoryStore(held), DirectZstd(), dataset.copy(deep=False)
    for variable in dataset.variables.values():
        variable.encoding = {"compressors": (codec,), **variable.encoding}
    dataset.to_zarr(store, mode="w", consolidated=False)
    _consolidate(store)
    files = {name: held[name].to_bytes() for name in sorted(held)}
    temporary = path.with_suffix(".part")
    shutil.rmtree(temporary, ignore_errors=True)
    for folder in {os.path.dirname(os.path.join(temporary, name)) for name in files}:
        os.makedirs(folder, exist_ok=True)
    for name, content in files.items():
        (temporary / name).write_bytes(content)
    if sums is not None:
        write_listing({name: checksum(content) for name, content in files.items()}, sums)
    _rename(temporary, path)


def _consolidate(store: Any) -> None:
    """Consolidate the metadata, so that `xarray.open_zarr(path)` needs no options."""
    import zarr

    with warnings.catch_warnings():
        # zarr warns that other programs may not read consolidated metadata; they find all of it in place as well
        warnings.simplefilter("ignore", zarr.errors.ZarrUserWarning)
        zarr.consolidate_metadata(store)


def _rename(temporary: Path, path: Path) -> None:
    """Give a store that is complete its name, in the place of an older one."""
    shutil.rmtree(path, ignore_errors=True)
    os.replace(temporary, path)


def _opened(folder: Path, stage: str, name: str, variables: Collection[str] | None = None) -> xr.Dataset:
    from drillid.datasets.checked_store import CheckedStore
    from drillid.datasets.direct import without_threads

    long = "time" in DATASETS[name].variables
    store = CheckedStore(folder / f"{name}.zarr", stage)
    dropped = [] if variables is None else [each for each in DATASETS[name].variables if each not in variables]
    # without dask, whose graph takes longer than the reading of a window's samples
    with without_threads():
        dataset: xr.Dataset = xr.open_zarr(store, chunks=None, create_default_indexes=not long, drop_variables=dropped)
    return dataset


def _cut(path: Path, samples: int, attributes: Mapping[str, str]) -> None:
    """Shorten a series in place; its last chunk is filled up as that of a series which never was longer."""
    import zarr

    from drillid.datasets.direct import DirectStore

    group = zarr.open_group(DirectStore(path), mode="r+", use_consolidated=False)
    group.attrs.update(attributes)
    for _, array in group.arrays():
        whole = -(-samples // array.chunks[0]) * array.chunks[0]
        if array.shape[0] > samples:
            array[samples:whole] = array.fill_value
            array.resize((samples,))


def _series_encoding(series: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Chunks along time and the compression that suits rig channels; times as whole nanoseconds."""
    from drillid.datasets.direct import DirectBlosc

    codec = DirectBlosc(cname="zstd", clevel=1, shuffle="bitshuffle")
    encoding: dict[str, dict[str, Any]] = {
        str(name): {"chunks": (_SERIES_CHUNK,), "compressors": (codec,)} for name in series.variables
    }
    encoding["time"] |= {"units": "nanoseconds since 1970-01-01", "dtype": "int64"}
    return encoding


def problems_table(well: str, stage: str, problems: Sequence[Problem]) -> pd.DataFrame:
    """The rows of a stage's problems.csv."""
    rows = [(well, stage, problem.where, problem.what, problem.remedy) for problem in problems]
    return pd.DataFrame(rows, columns=list(PROBLEM_COLUMNS))

"""One well's datasets in memory: those of stages that are wanted without its folders, and those that are read once."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr

from drillid.datasets.registry import DATASETS
from drillid.datasets.store import WellFolders
from drillid.datasets.tables import read_table


@dataclass(frozen=True)
class WellReadOnce(WellFolders):
    """Each dataset on disk is opened, and its values read, once for all who ask for it, none of whom may change it."""

    opened: dict[tuple[str, str], xr.Dataset] = field(default_factory=dict)
    """By stage and name."""

    def read(self, stage: str, name: str, variables: Collection[str] | None = None) -> xr.Dataset:
        """A dataset with all of its variables; see `WellFolders.read`."""
        if (stage, name) not in self.opened:
            self.opened[stage, name] = super().read(stage, name)
        return self.opened[stage, name]


@dataclass(frozen=True)
class WellInMemory(WellFolders):
    """What stages write stays here, as they would read it from disk; there is no earlier run to take rows from."""

    results: Path = Path()
    well: str = "well"
    datasets: dict[tuple[str, str], xr.Dataset] = field(default_factory=dict)
    """By stage and name."""
    tables: dict[tuple[str, str], str] = field(default_factory=dict)
    """The same for tables, as CSV."""

    def read(self, stage: str, name: str, variables: Collection[str] | None = None) -> xr.Dataset:
        """A dataset that a stage wrote with all of its variables; a copy, so that nobody changes what another reads."""
        return self.datasets[stage, name].copy()

    def earlier(self, stage: str, name: str) -> None:
        """Nothing: no run was before."""

    def earlier_memo(self, stage: str) -> dict[str, str]:
        """Nothing: no run was before."""
        return {}

    def write_memo(self, stage: str, content: Mapping[str, str]) -> None:
        """Nothing: no run will be after."""

    def has(self, stage: str, name: str) -> bool:
        """Whether the stage wrote the dataset."""
        return (stage, name) in self.datasets

    def write(self, stage: str, name: str, dataset: xr.Dataset, **attributes: Any) -> None:
        """Conform a dataset to its schema and keep it."""
        self.datasets[stage, name] = DATASETS[name].conform(dataset, well=self.name or self.well, **attributes)

    @contextlib.contextmanager
    def appending(
        self, stage: str, name: str, kept: int = 0, **attributes: Any
    ) -> Iterator[Callable[[xr.Dataset], None]]:
        """Keep a long series that comes piece by piece along time; see `WellFolders.appending`."""
        pieces: list[xr.Dataset] = []

        def append(piece: xr.Dataset) -> None:
            conformed = DATASETS[name].conform(piece, well=self.name or self.well, **attributes)
            pieces.append(conformed.drop_indexes("time"))

        yield append
        if pieces:
            self.datasets[stage, name] = xr.concat(pieces, "time", combine_attrs="override")

    def write_table(self, stage: str, name: str, table: pd.DataFrame) -> None:
        """Keep a table."""
        self.tables[stage, name] = table.to_csv(index=False)

    def read_table(self, stage: str, name: str, **options: Any) -> pd.DataFrame:
        """A table that a stage wrote; see `drillid.datasets.tables.read_table`."""
        return read_table(io.StringIO(self.tables[stage, name]), **options)

"""The fleet's tables: parameters and verdicts of all wells."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from drillid.datasets.identified import FLEET
from drillid.datasets.store import WellFolders, write_store
from drillid.datasets.tables import write_table
from drillid.discrepancy.sets import read_verdicts, verdict_table


def write_fleet(results: Path, wells: Sequence[str]) -> None:
    """All wells' parameters along one dimension in `<results>/fleet.zarr`, all verdicts in `verdicts.csv`."""
    tables = []
    for well in wells:
        folders = WellFolders(results, well)
        if folders.has("depth", "depth"):
            depth = folders.read("depth", "depth", FLEET.variables).load()
            row = depth.reset_coords().rename_dims(depth="row").drop_vars("row", errors="ignore")
            name = depth.attrs.get("well", well)
            tables.append(row.assign(well=("row", np.full(depth.sizes["depth"], name, dtype=object))))
    fleet = xr.concat(tables, "row", join="exact") if tables else FLEET.empty()
    write_store(FLEET.conform(fleet), Path(results) / "fleet.zarr")
    write_table(fleet_verdicts(results, wells), Path(results) / "verdicts.csv")


def fleet_verdicts(results: Path, wells: Sequence[str]) -> pd.DataFrame:
    """The verdicts of all wells, in their order."""
    fleet = [WellFolders(results, well) for well in wells]
    tables = [read_verdicts(well) for well in fleet if (well.stage("discrepancy") / "verdicts.csv").exists()]
    filled = [table for table in tables if len(table)]
    return pd.concat(filled, ignore_index=True) if filled else verdict_table("", [])

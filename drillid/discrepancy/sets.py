"""A well's windows as sets, one for each bottom-hole-assembly run, and the engine's verdicts on each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drillid.arrays import Indices
from drillid.discrepancy.base_rates import BaseRates
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.gather import gather_well
from drillid.discrepancy.verdicts.engine import examine
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.intervals import runs
from drillid.discrepancy.verdicts.verdict import NONE, Verdict

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    import xarray as xr

    from drillid.config.rig import Rig
    from drillid.datasets.store import WellFolders


@dataclass(frozen=True, eq=False)
class WellData:
    """Datasets of one well that the engine examines; all but the records hold the same windows."""

    rig: Rig
    records: xr.Dataset
    windows: xr.Dataset
    spectra: xr.Dataset
    mobility: xr.Dataset
    fits: xr.Dataset

    def at(self, rows: Indices) -> WellData:
        """A selection of the windows."""
        chosen = (dataset.isel(window=rows) for dataset in (self.windows, self.spectra, self.mobility, self.fits))
        return WellData(self.rig, self.records, *chosen)


@dataclass(frozen=True, eq=False)
class ExaminedSet:
    """Windows of one run with their examination."""

    rows: Indices
    """Their rows in the well."""
    examination: Examination


def window_sets(rig: Rig, windows: xr.Dataset, fits: xr.Dataset) -> list[Indices]:
    """Rows of the windows with a fit, one set for each run that has any."""
    run = runs(rig, windows["bit_depth"].values)
    fitted = np.isfinite(fits["value"].values).all(axis=1)
    return [rows for number in np.unique(run) if (rows := np.flatnonzero((run == number) & fitted)).size]


def examine_well(data: WellData, error_rate: float, base_rates: BaseRates | None = None) -> list[ExaminedSet]:
    """Examine every set of a well.

    Parameters
    ----------
    error_rate : probability that a well in which nothing is wrong gets a verdict other than none; the sets share it
    base_rates : of causes, before the data are looked at
    """
    sets = window_sets(data.rig, data.windows, data.fits)
    return [
        ExaminedSet(rows, examine(evidence_of(data.at(rows)), error_rate=error_rate / len(sets), base_rates=base_rates))
        for rows in sets
    ]


def evidence_of(data: WellData) -> Evidence:
    """Evidence from the windows of one run."""
    return gather_well(data.rig, data.records, data.windows, data.spectra, data.mobility, data.fits)


COLUMNS = (
    *("well", "from_m", "to_m", "verdict", "family", "class", "cause", "probability", "evidence_nats"),
    "location_m",
    *("size", "size_low", "size_high", "unit"),
    *("predictive_gain", "predictive_gain_low", "predictive_gain_high", "held_out_windows"),
    *("what_would_separate", "evidence"),
)
"""Columns of verdicts.csv. The size is that of `cause`, the most likely member of the class."""


def verdict_table(well: str, verdicts: Sequence[Verdict]) -> pd.DataFrame:
    """One row for each verdict, in order of depth."""
    import pandas as pd

    rows = [
        vars(verdict) | {"well": well, "class": "|".join(verdict.members)}
        for verdict in sorted(verdicts, key=lambda verdict: (verdict.from_m, verdict.to_m))
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def all_verdicts(sets: Sequence[ExaminedSet], changes: Sequence[Verdict]) -> list[Verdict]:
    """Verdicts on sets and on intervals; the verdict none stays only where no interval of the set has a verdict."""

    def is_contradicted(verdict: Verdict) -> bool:
        overlaps = any(verdict.from_m <= change.to_m and change.from_m <= verdict.to_m for change in changes)
        return verdict.verdict == NONE and overlaps

    verdicts = [verdict for examined in sets for verdict in examined.examination.verdicts]
    return [*(verdict for verdict in verdicts if not is_contradicted(verdict)), *changes]


def read_verdicts(folders: WellFolders) -> pd.DataFrame:
    """The well's table as it was written; empty texts stay texts."""
    texts = ("well", "verdict", "family", "class", "cause", "unit", "what_would_separate", "evidence")
    empty = {name: [""] for name in COLUMNS if name not in texts}
    types = dict.fromkeys(texts, str)
    return folders.read_table("discrepancy", "verdicts", dtype=types, keep_default_na=False, na_values=empty)


def window_verdicts(
    sets: Sequence[ExaminedSet], changes: Sequence[Verdict], windows: xr.Dataset
) -> NDArray[np.object_]:
    """Verdicts that hold in each window, joined by +; empty where the window is in no set.

    Parameters
    ----------
    changes : verdicts on intervals of the well, beside those of the sets
    """
    joined = np.full(windows.sizes["window"], "", dtype=object)
    depth = windows["hole_depth"].values
    for examined in sets:
        verdicts = [verdict for verdict in (*examined.examination.verdicts, *changes) if verdict.verdict != NONE]
        for row in examined.rows:
            valid = (verdict.verdict for verdict in verdicts if verdict.from_m <= depth[row] <= verdict.to_m)
            joined[row] = " + ".join(valid) or NONE
    return joined

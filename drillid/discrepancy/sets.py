"""A well's windows as sets, one a bottom-hole-assembly run, and what the engine says about each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drillid.arrays import Indices
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.gather import gather_well
from drillid.discrepancy.verdicts.engine import examine
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.intervals import runs
from drillid.discrepancy.verdicts.verdict import NONE, Verdict

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import pandas as pd
    import xarray as xr

    from drillid.config.rig import Rig


@dataclass(frozen=True, eq=False)
class WellData:
    """Datasets of one well that the engine looks at; every one but the records holds the same windows."""

    rig: Rig
    records: xr.Dataset
    windows: xr.Dataset
    spectra: xr.Dataset
    mobility: xr.Dataset
    fits: xr.Dataset

    def at(self, rows: Indices) -> WellData:
        """Some of the windows."""
        chosen = (one.isel(window=rows) for one in (self.windows, self.spectra, self.mobility, self.fits))
        return WellData(self.rig, self.records, *chosen)


@dataclass(frozen=True, eq=False)
class ExaminedSet:
    """Windows of one run with what the engine says about them."""

    rows: Indices
    """Their rows in the well."""
    examination: Examination


def window_sets(rig: Rig, windows: xr.Dataset, fits: xr.Dataset) -> list[Indices]:
    """Rows of the windows with a fit, a set for each run that has any."""
    run = runs(rig, windows["bit_depth"].values)
    fitted = np.isfinite(fits["value"].values).all(axis=1)
    return [rows for number in np.unique(run) if (rows := np.flatnonzero((run == number) & fitted)).size]


def examine_well(data: WellData, error_rate: float) -> list[ExaminedSet]:
    """Examine every set of a well.

    Parameters
    ----------
    error_rate : chance that a well in which nothing is wrong gets any verdict but none; the sets share it
    """
    sets = window_sets(data.rig, data.windows, data.fits)
    return [ExaminedSet(rows, examine(evidence_of(data.at(rows)), error_rate=error_rate / len(sets))) for rows in sets]


def evidence_of(data: WellData) -> Evidence:
    """Evidence from the windows of one run."""
    return gather_well(data.rig, data.records, data.windows, data.spectra, data.mobility, data.fits)


COLUMNS = (
    *("well", "from_m", "to_m", "verdict", "family", "class", "cause", "probability", "location_m"),
    *("size", "size_low", "size_high", "unit"),
    *("predictive_gain", "predictive_gain_low", "predictive_gain_high", "held_out_windows"),
    *("what_would_separate", "evidence"),
)
"""Of verdicts.csv. The size is that of `cause`, the most likely member of the class."""


def verdict_table(well: str, verdicts: Sequence[Verdict]) -> pd.DataFrame:
    """One row a verdict, in order of depth."""
    import pandas as pd

    rows = [
        vars(one) | {"well": well, "class": "|".join(one.members)}
        for one in sorted(verdicts, key=lambda one: (one.from_m, one.to_m))
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def all_verdicts(sets: Sequence[ExaminedSet], changes: Sequence[Verdict]) -> list[Verdict]:
    """Verdicts of sets and on intervals; none is said only of a set in which no interval has a verdict either."""
    said = [each for one in sets for each in one.examination.verdicts]
    overlapped = [any(each.from_m <= change.to_m and change.from_m <= each.to_m for change in changes) for each in said]
    kept = [each for each, over in zip(said, overlapped, strict=True) if each.verdict != NONE or not over]
    return [*kept, *changes]


def read_verdicts(path: Path) -> pd.DataFrame:
    """The table as it was written; texts that are empty stay texts."""
    import pandas as pd

    texts = ("well", "verdict", "family", "class", "cause", "unit", "what_would_separate", "evidence")
    empty = {name: [""] for name in COLUMNS if name not in texts}
    return pd.read_csv(path, dtype=dict.fromkeys(texts, str), keep_default_na=False, na_values=empty)


def window_verdicts(
    sets: Sequence[ExaminedSet], changes: Sequence[Verdict], windows: xr.Dataset
) -> NDArray[np.object_]:
    """Verdicts that hold in each window, joined by +; empty where the window is in no set.

    Parameters
    ----------
    changes : verdicts on intervals of the well, beside those of the sets
    """
    said = np.full(windows.sizes["window"], "", dtype=object)
    depth = windows["hole_depth"].values
    for one in sets:
        found = [each for each in (*one.examination.verdicts, *changes) if each.verdict != NONE]
        for row in one.rows:
            said[row] = " + ".join(each.verdict for each in found if each.from_m <= depth[row] <= each.to_m) or NONE
    return said

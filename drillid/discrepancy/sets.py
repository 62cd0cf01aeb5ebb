"""A well's windows as sets of successive windows of one bottom-hole-assembly run, and the verdicts on each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from drillid.arrays import Floats, Indices
from drillid.datasets.tables import read_table
from drillid.discrepancy.base_rates import BaseRates
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.gather import gather_well
from drillid.discrepancy.learning.examined_law import with_linear_or_law
from drillid.discrepancy.verdicts.engine import examine
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.intervals import runs
from drillid.discrepancy.verdicts.verdict import NONE, Verdict
from drillid.windows.channels import sample_rate, window_channels

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd
    import xarray as xr

    from drillid.config.rig import Rig
    from drillid.datasets.reuse import Memo
    from drillid.datasets.store import WellFolders

SET_WINDOWS = 24
"""Windows of a set: the most that the sealed cases have, by which probabilities are calibrated."""


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

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """Verdicts of the examination."""
        return self.examination.verdicts


class VerdictsOnSet(Protocol):
    """Windows of one run with the verdicts on them."""

    @property
    def rows(self) -> Indices:
        """Their rows in the well."""

    @property
    def verdicts(self) -> tuple[Verdict, ...]:
        """The verdicts."""


def window_sets(rig: Rig, windows: xr.Dataset, fits: xr.Dataset) -> list[Indices]:
    """Rows of the windows with a fit, in sets of successive windows of one run.

    A set has as many windows as the sets by which the engine's probabilities are calibrated, the last one of a run
    between half and one and a half times as many. So a well that grows has sets that stay as they are.
    """
    run = runs(rig, windows["bit_depth"].values)
    fitted = np.isfinite(fits["value"].values).all(axis=1)
    found = []
    for number in np.unique(run):
        rows = np.flatnonzero((run == number) & fitted)
        ends = SET_WINDOWS * np.arange(1, max((rows.size + SET_WINDOWS // 2) // SET_WINDOWS, 1))
        found += [part for part in np.split(rows, ends) if part.size]
    return found


def shared_error_rate(error_rate: float, sets: int) -> float:
    """Error rate of each set of a well, whose number is rounded up to a power of two.

    So verdicts on sets that have not changed are reconsidered only where the number of sets passes the next power.
    """
    return error_rate / (1 << max(sets - 1, 0).bit_length())


def examine_set(
    data: WellData, rows: Indices, error_rate: float, base_rates: BaseRates | None = None, memo: Memo | None = None
) -> ExaminedSet:
    """Examine one set of a well, and learn what no cause explains.

    Parameters
    ----------
    rows : of its windows
    error_rate : probability that a set in which nothing is wrong gets a verdict other than none
    base_rates : of causes, before the data are looked at
    memo : of detections in windows that have not changed since
    """
    examination = examine(evidence_of(data.at(rows), memo), error_rate=error_rate, base_rates=base_rates)

    def channels(row: int) -> tuple[Floats, Floats]:
        sweep, speed = window_channels(data.records, data.windows, int(rows[row]), ("torque_sweep", "speed"))
        return sweep, speed

    return ExaminedSet(rows, with_linear_or_law(examination, channels, sample_rate(data.records), error_rate))


def evidence_of(data: WellData, memo: Memo | None = None) -> Evidence:
    """Evidence from the windows of one set; `memo` as in `gather_well`."""
    return gather_well(data.rig, data.records, data.windows, data.spectra, data.mobility, data.fits, memo)


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


def all_verdicts(sets: Sequence[VerdictsOnSet], changes: Sequence[Verdict]) -> list[Verdict]:
    """Verdicts on sets and on intervals; the verdict none stays only where no interval of the set has a verdict."""

    def is_contradicted(verdict: Verdict) -> bool:
        overlaps = any(verdict.from_m <= change.to_m and change.from_m <= verdict.to_m for change in changes)
        return verdict.verdict == NONE and overlaps

    verdicts = [verdict for examined in sets for verdict in examined.verdicts]
    return [*(verdict for verdict in verdicts if not is_contradicted(verdict)), *changes]


def read_verdicts(source: WellFolders | Path) -> pd.DataFrame:
    """The table of a well, or that of a fleet by its path, as it was written; empty texts stay texts."""
    texts = ("well", "verdict", "family", "class", "cause", "unit", "what_would_separate", "evidence")
    empty = {name: [""] for name in COLUMNS if name not in texts}
    options: dict[str, Any] = {"dtype": dict.fromkeys(texts, str), "keep_default_na": False, "na_values": empty}
    if isinstance(source, Path):
        return read_table(source, **options)
    return source.read_table("discrepancy", "verdicts", **options)


def window_verdicts(
    sets: Sequence[VerdictsOnSet], changes: Sequence[Verdict], windows: xr.Dataset
) -> NDArray[np.object_]:
    """Verdicts that hold in each window, joined by +; empty where the window is in no set.

    Parameters
    ----------
    changes : verdicts on intervals of the well, beside those of the sets
    """
    joined = np.full(windows.sizes["window"], "", dtype=object)
    depth = windows["hole_depth"].values
    for examined in sets:
        verdicts = [verdict for verdict in (*examined.verdicts, *changes) if verdict.verdict != NONE]
        for row in examined.rows:
            valid = (verdict.verdict for verdict in verdicts if verdict.from_m <= depth[row] <= verdict.to_m)
            joined[row] = " + ".join(valid) or NONE
    return joined

"""All wells together: which of them share what, and the tables of what they have in common."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from drillid.common_causes.pooling import SetStatistics
from drillid.common_causes.verdicts import CommonVerdict, Judged, OwnVerdict, Standing, judge
from drillid.datasets.store import WellFolders
from drillid.datasets.tables import write_table
from drillid.discrepancy.base_rates import BaseRates
from drillid.discrepancy.inference.shared_likelihood import SharedLikelihood
from drillid.discrepancy.rules import LEFT_UNEXPLAINED
from drillid.discrepancy.sets import read_verdicts, shared_error_rate
from drillid.discrepancy.verdicts.verdict import UNKNOWN
from drillid.errors import DamageError

if TYPE_CHECKING:
    import xarray as xr

    from drillid.config.settings import CommonCausesSettings

COMMON_CAUSES, STANDINGS = "common_causes.csv", "well_standings.csv"
SHARED = ("rig", "section", "tool")
"""What wells may have in common."""
LEFT_OUT = "left out"


@dataclass(frozen=True, eq=False)
class WellEvidence:
    """What the fleet reads of one well."""

    name: str
    shares: Mapping[str, str]
    """Names of its rig, section and tool, by what they are; empty where it has none."""
    sets: tuple[SetStatistics, ...]
    verdicts: tuple[OwnVerdict, ...]
    left_out: tuple[str, ...]
    """Reasons why sets of it are left out."""


def write_common_causes(results: Path, wells: Mapping[str, Mapping[str, str]], settings: CommonCausesSettings) -> int:
    """Write `<results>/common_causes.csv` and `well_standings.csv`; returns the number of verdicts other than none.

    Parameters
    ----------
    wells : section and tool of each well, by its folder
    """
    evidence = []
    for folder, shares in wells.items():
        folders = WellFolders(results, folder)
        # a damaged dataset is told, and computed again, where the fleet is gathered
        with contextlib.suppress(DamageError, FileNotFoundError):
            if folders.has("discrepancy", "examination"):
                evidence.append(read_well(folders, shares))
    judged = judge_fleet(evidence, settings) if settings.enabled else []
    write_table(common_table([each.verdict for each in judged]), Path(results) / COMMON_CAUSES)
    standings = [standing for each in judged for standing in each.standings]
    write_table(standing_table([*standings, *_left_out(evidence)]), Path(results) / STANDINGS)
    return sum(bool(each.verdict.cause) for each in judged)


def read_well(folders: WellFolders, shares: Mapping[str, str]) -> WellEvidence:
    """Evidence of one well from its stored examinations and verdicts."""
    examination = folders.read("discrepancy", "examination")
    well, rig = (str(examination.attrs.get(name, folders.well)) for name in ("well", "rig"))
    kept, reasons = [], []
    for number in range(examination.sizes["set"]):
        of_set = examination.isel(set=number)
        if _is_unexplained(of_set):
            depth = f"{float(of_set['from_m']):.0f} to {float(of_set['to_m']):.0f} m"
            reasons.append(f"{depth}: something that no cause of the catalogue explains is wrong there")
            continue
        kept.append(_statistics(of_set, well, rig))
    table = read_verdicts(folders)
    named = table[table["cause"].fillna("").astype(str) != ""]
    # a cause that several sets name counts once, at its largest size
    largest = named.sort_values("size", key=abs, ascending=False, kind="stable").drop_duplicates("class").sort_index()
    verdicts = tuple(
        OwnVerdict(tuple(str(row["class"]).split("|")), str(row["cause"]), float(row["size"]))
        for row in largest.to_dict("records")
    )
    return WellEvidence(well, {"rig": rig, **shares}, tuple(kept), verdicts, tuple(reasons))


def _statistics(of_set: xr.Dataset, well: str, rig: str) -> SetStatistics:
    """The stored statistics of one set."""
    kept: dict[str, Any] = {field.name: of_set[f"shared_{field.name}"].values[()] for field in fields(SharedLikelihood)}
    return SetStatistics(**kept, well=well, rig=rig)


def _is_unexplained(of_set: xr.Dataset) -> bool:
    """Whether the verdict is unknown and something unknown explains the set better than any cause."""
    if UNKNOWN not in str(of_set["verdict"].values).split(" + "):
        return False
    causes = of_set["log_evidence"].values
    best = float(np.nanmax(causes)) if np.isfinite(causes).any() else -np.inf
    return float(np.max(of_set["unknown_evidence"].values)) > best + LEFT_UNEXPLAINED


def groups(evidence: Sequence[WellEvidence]) -> Iterator[tuple[str, str, list[WellEvidence]]]:
    """What several wells have in common, its name, and these wells; in the order of the wells."""
    for shared in SHARED:
        for name in dict.fromkeys(well.shares.get(shared, "") for well in evidence):
            members = [well for well in evidence if name and well.shares.get(shared, "") == name and well.sets]
            if len(members) > 1:
                yield shared, name, members


def judge_fleet(evidence: Sequence[WellEvidence], settings: CommonCausesSettings) -> list[Judged]:
    """Verdicts on all rigs, sections and tools that several wells have in common; they share the error rate."""
    found = list(groups(evidence))
    error_rate, base_rates = shared_error_rate(settings.error_rate, len(found)), BaseRates(settings.base_rate)
    return [
        judge(
            shared,
            name,
            [each for well in members for each in well.sets],
            {well.name: well.verdicts for well in members},
            error_rate,
            base_rates,
        )
        for shared, name, members in found
    ]


def _left_out(evidence: Sequence[WellEvidence]) -> list[Standing]:
    return [
        Standing("rig", well.shares["rig"], well.name, UNKNOWN, LEFT_OUT, float("nan"), float("nan"), reason)
        for well in evidence
        for reason in well.left_out
    ]


def common_table(verdicts: Sequence[CommonVerdict]) -> pd.DataFrame:
    """One row for each rig, section or tool."""
    columns = [each.name for each in fields(CommonVerdict)]
    return pd.DataFrame([asdict(verdict) for verdict in verdicts], columns=columns)


def standing_table(standings: Sequence[Standing]) -> pd.DataFrame:
    """One row for each well and cause that is compared with the other wells."""
    columns = [each.name for each in fields(Standing)]
    return pd.DataFrame([asdict(standing) for standing in standings], columns=columns)

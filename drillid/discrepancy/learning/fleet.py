"""What was learnt in all wells of a fleet, side by side: which of it is the same thing."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from drillid.datasets.store import WellFolders
from drillid.datasets.tables import write_table
from drillid.discrepancy.learning.fingerprint import SAME, Fingerprint

LEARNT = "learnt.csv"
COLUMNS = ("well", "rig", "from_m", "to_m", "resembles", "gain_nats", "same_as", "least_p_value", "sentence")
"""Columns of the fleet's table; `same_as` holds the other wells with the same, joined by '|', and `least_p_value` the
smallest p-value of these being the same."""
_OF_SET = ("from_m", "to_m", "fingerprint")
"""What is read of a well's examination."""


@dataclass(frozen=True, eq=False)
class LearntInWell:
    """What was learnt in one set of windows of a well."""

    well: str
    rig: str
    from_m: float
    to_m: float
    fingerprint: Fingerprint


def write_learnt(results: Path, wells: Sequence[str]) -> None:
    """Write `<results>/learnt.csv`: a row for each set of windows in which something was learnt."""
    found = [each for well in wells for each in learnt_in(WellFolders(results, well))]
    write_table(learnt_table(found), Path(results) / LEARNT)


def learnt_in(folders: WellFolders) -> list[LearntInWell]:
    """What is stored of the extensions that a well was offered."""
    if not folders.has("discrepancy", "examination"):
        return []
    examination = folders.read("discrepancy", "examination", _OF_SET)
    well, rig = (str(examination.attrs.get(name, folders.well)) for name in ("well", "rig"))
    found = []
    for number in np.flatnonzero(examination["fingerprint"].values != ""):
        of_set = examination.isel(set=number)
        content = json.loads(str(of_set["fingerprint"].values))
        begin, end = (float(of_set[name].values) for name in ("from_m", "to_m"))
        found.append(LearntInWell(well, rig, begin, end, Fingerprint.of(content)))
    return found


def learnt_table(found: Sequence[LearntInWell]) -> pd.DataFrame:
    """The fleet's table, each set compared with those of all other wells."""
    rows = []
    for own in found:
        alike: dict[LearntInWell, float] = {}
        for other in found:
            if other.well != own.well and (p_value := own.fingerprint.likeness(other.fingerprint)) >= SAME:
                alike[other] = p_value
        others = list(dict.fromkeys(other.well for other in alike))
        rows.append(
            (
                *(own.well, own.rig, own.from_m, own.to_m, own.fingerprint.resembles, own.fingerprint.gain),
                *("|".join(others), min(alike.values(), default=float("nan")), _sentence(own, list(alike))),
            )
        )
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _sentence(own: LearntInWell, alike: Sequence[LearntInWell]) -> str:
    """What it resembles, and in which wells of this rig and of others the same was learnt."""
    told = [f"resembles {own.fingerprint.resembles}"]
    of_rig = list(dict.fromkeys(other.well for other in alike if other.rig == own.rig))
    elsewhere = list(dict.fromkeys(other.well for other in alike if other.rig != own.rig))
    for wells, whose in ((of_rig, "this rig"), (elsewhere, "other rigs")):
        if wells:
            told.append(f"the same as in {'wells' if len(wells) > 1 else 'well'} {_listed(wells)} of {whose}")
    return "; ".join(told)


def _listed(names: Sequence[str]) -> str:
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last

"""What the fleet's page tells of each measured start of rotation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drillid.datasets.store import WellFolders
from drillid.report.quantities import MISSING, digits
from drillid.start_ups.judging import DESCRIBED
from drillid.units import RPM

if TYPE_CHECKING:
    import pandas as pd

    from drillid.config.sheets import Listing


def start_up_rows(results: Path, listings: Mapping[str, Listing], problems: pd.DataFrame) -> list[dict[str, Any]]:
    """A row for each start of rotation; one that failed has the reason as its verdict."""
    rows = []
    for folder, listing in listings.items():
        folders = WellFolders(results, folder)
        own = problems[(problems["well"] == listing.name) & (problems["stage"] == "start_ups")]
        row = {"name": listing.name, "depth": f"{listing.stated['depth_m']:g}", "problems": len(own), "figure": ""}
        if folders.has("start_ups", "start_ups"):
            row |= _judged(folders)
        else:
            why = f"failed: {own['where'].iloc[0]}: {own['what'].iloc[0]}" if len(own) else "not finished"
            row |= {"verdict": why, "torque": MISSING, "bit": MISSING}
        rows.append(row)
    return rows


def _judged(folders: WellFolders) -> dict[str, str]:
    dataset = folders.read("start_ups", "start_ups").load()
    held, kept = dataset.isel(span=-1), int(np.flatnonzero(dataset["kept"].values)[0])
    name, first, last = str(dataset["model"].values[kept]), held.isel(model=0), held.isel(model=kept)
    low, high = (float(dataset[end].values[kept]) for end in ("gain_low", "gain_high"))
    best = f"the {name} model is kept: it saves {digits(low)} to {digits(high)} of the held-out squared error"
    verdict = "the description is kept: nothing fitted predicts better" if name == DESCRIBED else best
    figure = folders.stage("start_ups") / "start_up.png"
    return {
        "verdict": verdict,
        "torque": _both(float(first["torque_rms"]) / 1e3, float(last["torque_rms"]) / 1e3),
        "bit": _both(float(first["bit_rms"]) / RPM, float(last["bit_rms"]) / RPM),
        "figure": figure.relative_to(folders.results).as_posix() if figure.exists() else "",
    }


def _both(before: float, after: float) -> str:
    """Error of the description and of the model that is kept."""
    if not np.isfinite(before):
        return MISSING
    return f"{digits(before)} → {digits(after)}"

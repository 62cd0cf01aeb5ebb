"""What the fleet's page tells of each measured start of rotation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from drillid.datasets.store import WellFolders
from drillid.report.quantities import MISSING, QUANTITIES
from drillid.start_ups.judging import DESCRIBED

if TYPE_CHECKING:
    import pandas as pd

    from drillid.config.listing import Listing


def start_up_rows(results: Path, listings: Mapping[str, Listing], problems: pd.DataFrame) -> list[dict[str, Any]]:
    """A row for each start of rotation; one that failed has the reason as its verdict."""
    rows = []
    for folder, listing in listings.items():
        folders = WellFolders(results, folder)
        own = problems[(problems["well"] == listing.name) & (problems["stage"] == "start_ups")]
        depth = float(listing.stated["depth_m"])
        row = {
            "name": listing.name,
            "depth": QUANTITIES["depth"].text(depth) if depth else MISSING,
            "problems": len(own),
            "figure": "",
        }
        if folders.has("start_ups", "start_ups"):
            row |= _judged(folders)
        else:
            why = f"failed: {own['where'].iloc[0]}: {own['what'].iloc[0]}" if len(own) else "not finished"
            row |= {"verdict": why, "torque": MISSING, "bit": MISSING}
        rows.append(row)
    return rows


def _judged(folders: WellFolders) -> dict[str, Markup | str]:
    dataset = folders.read("start_ups", "start_ups").load()
    held, kept = dataset.isel(span=-1), int(np.flatnonzero(dataset["kept"].values)[0])
    name, first, last = str(dataset["model"].values[kept]), held.isel(model=0), held.isel(model=kept)
    low, high = (float(dataset[end].values[kept]) for end in ("gain_low", "gain_high"))
    saved = f"{100 * low:.0f} to {100 * high:.0f} % of the squared error on the part that was held out"
    best = f"the {name} model is kept: it removes {saved} (90 % interval)"
    verdict = "the description is kept: no fitted model predicts better" if name == DESCRIBED else best
    figure = folders.stage("start_ups") / "start_up.png"
    return {
        "verdict": verdict,
        "torque": _both("torque", float(first["torque_rms"]), float(last["torque_rms"])),
        "bit": _both("rotation", float(first["bit_rms"]), float(last["bit_rms"])),
        "figure": figure.relative_to(folders.results).as_posix() if figure.exists() else "",
    }


def _both(quantity: str, before: float, after: float) -> Markup | str:
    """Error of the description and of the model that is kept, SI; once where they are the same."""
    if not np.isfinite(before):
        return MISSING
    if after == before:
        return QUANTITIES[quantity].text(before, more=1)
    return QUANTITIES[quantity].text(before, after, joint=" → ", more=1)

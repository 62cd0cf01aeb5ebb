"""What the fleet's page tells of each well, and what is new since the last report; all of it as JSON can hold it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup

from drillid.datasets.registry import CHANGES
from drillid.depth.changes import has_earlier_report, read_changes
from drillid.discrepancy.catalogue import words_of
from drillid.figures.captions import share
from drillid.figures.data import WellResults
from drillid.report.attention import NOTE, URGENCY, Item, items
from drillid.report.quantities import MISSING, QUANTITIES, number
from drillid.report.sentences import data_sheet_verdict
from drillid.report.thumbnails import depth_track
from drillid.report.well_report import WellReport

_STATUS = {"flagged": "stands out", "failed": "no result", "clear": "nothing stands out"}


def summary(well: WellReport, results: WellResults | None) -> dict[str, Any]:
    """The well's row and its items that need attention; texts are HTML."""
    found, curve = items(well), _curve(results)
    rows = [
        {
            "level": item.level,
            "kind": item.kind,
            "lead": str(item.lead),
            "more": str(item.more),
            "depths": str(item.depths),
            "strength": float(item.strength),
            "anchor": item.anchor,
            "track": str(_track(well, curve, [item])),
        }
        for item in found
    ]
    marked = [item for item in found if item.level < NOTE and item.kind != "Stick-slip"]
    drilled, identified = well.drilled, well.identified
    return {
        "name": well.name,
        "folder": well.folder,
        "description": well.description,
        "status": _STATUS[well.status],
        "level": min((item.level for item in found), default=4),
        "newest": "" if drilled.newest is None else f"{drilled.newest:%Y-%m-%d %H:%M} UTC",
        "from_m": _or_none(drilled.from_m),
        "depths": str(QUANTITIES["depth"].text(drilled.from_m, drilled.to_m)),
        "metres": drilled.metres,
        "hours": drilled.hours,
        "windows": identified.windows if identified else 0,
        "window_hours": identified.hours if identified else 0.0,
        "accepted": identified.accepted if identified else 0,
        "accepted_share": share(identified.accepted, identified.windows) if identified else MISSING,
        "chi2": number(identified.chi2[0], 2) if identified else MISSING,
        "verdicts": [verdict.title for verdict in well.wrong],
        "intervals": len(identified.intervals) if identified else 0,
        "sheets": data_sheet_verdict(identified.comparisons) if identified else MISSING,
        "problems": len(well.problems),
        "items": rows,
        "track": str(_track(well, curve, marked)),
    }


def _or_none(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _curve(results: WellResults | None) -> tuple[Any, Any]:
    """Depth and BHA damping from all windows together, of each on its own where there is none, in order of depth."""
    if results is None:
        return np.array([]), np.array([])
    alone = np.where(results.depth["accepted"].values.astype(bool), results.depth["damping_bha"].values, np.nan)
    joint = results.joint["value"].sel(parameter="damping_bha").values
    order = np.argsort(results.depth["depth"].values, kind="stable")
    return results.depth["depth"].values[order], np.where(np.isfinite(joint), joint, alone)[order]


def _track(well: WellReport, curve: tuple[Any, Any], marked: Sequence[Item]) -> Markup:
    words = f"Depth track of {well.name}: BHA damping, and the depths that stand out"
    return depth_track(*curve, [(item.from_m, item.to_m, URGENCY[item.level]) for item in marked], words)


def totals(wells: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Sums over the fleet."""
    added = ("metres", "hours", "windows", "window_hours", "accepted")
    sums = {name: sum(well[name] for well in wells) for name in added}
    urgent = sum(item["level"] == 1 for well in wells for item in well["items"])
    return {
        **sums,
        "urgent": urgent,
        "attention": sum(well["level"] <= 2 for well in wells),
        "failed": sum(well["status"] == _STATUS["failed"] for well in wells),
        "problems": sum(well["problems"] for well in wells),
    }


def new_since(results: Path) -> list[dict[str, Any]] | None:
    """What has changed since the last report, in words; None where there is no earlier one to compare with."""
    found = [_change(row) for row in read_changes(results).to_dict("records")] if _has_changes(results) else []
    return found if found or has_earlier_report(results) else None


def _has_changes(results: Path) -> bool:
    return (Path(results) / "changes.csv").exists()


def _change(row: Mapping[Any, Any]) -> dict[str, Any]:
    kind = str(row["change"])
    depths = QUANTITIES["depth"].text(row["from_m"], row["to_m"]) if np.isfinite(row["from_m"]) else Markup("")
    words = what = kind.replace("_", " ")
    if not pd.isna(row["count"]):
        number_of = int(row["count"])
        what = f"{number_of} {words.removesuffix('s')}{'s' if number_of != 1 else ''}"
    # names of causes are spoken; those of files and columns are kept
    spoken = words_of if kind.endswith("verdict") else str
    texts = [spoken(str(row[name])) for name in ("before", "now") if str(row[name])]
    return {
        "well": str(row["well"]),
        "kind": words,
        "meaning": CHANGES.get(kind, ""),
        "what": what,
        "depths": str(depths),
        "text": " → ".join(texts),
        "where": str(row["where"]),
        "reason": str(row["reason"]),
        "since": "" if pd.isna(row["since"]) else f"{row['since']:%Y-%m-%d %H:%M} UTC",
    }

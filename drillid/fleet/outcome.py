"""What became of the wells of a run: done, without windows, failed, or not finished."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from drillid.datasets.store import WellFolders
from drillid.fleet.manifest import stored
from drillid.fleet.stages import STAGES

_NAMED = 5
"""Failed wells that the closing line names."""


def failed_wells(results: Path, wells: Sequence[str]) -> dict[str, str]:
    """Reason of each well that failed in a stage or has not gone through all of them."""
    reasons = {well: _reason(WellFolders(results, well)) for well in wells}
    return {well: reason for well, reason in reasons.items() if reason}


def closing_line(wells: Sequence[str], failed: dict[str, str]) -> str:
    """The run in one sentence, with the failed wells and the remedy's place."""
    if not failed:
        return f"{len(wells)} of {len(wells)} wells done."
    named = [f"{well} ({reason})" for well, reason in list(failed.items())[:_NAMED]]
    more = [f"and {len(failed) - _NAMED} more"] if len(failed) > _NAMED else []
    return f"{len(failed)} of {len(wells)} wells failed: {', '.join(named + more)}. See problems.csv for the remedies."


def _reason(folders: WellFolders) -> str:
    for stage in STAGES:
        folder = folders.stage(stage)
        key = stored(folder)
        if key.get("status") == "failed" or not key:
            return f"{stage}: {_first_problem(folder / 'problems.csv')}"
    return ""


def _first_problem(path: Path) -> str:
    try:
        table = pd.read_csv(path, dtype=str, keep_default_na=False)
    except (OSError, ValueError):
        return "not finished"
    return f"{table['where'].iloc[0]}: {table['what'].iloc[0]}" if len(table) else "not finished"

"""What became of the wells of a run: done, without windows, failed, or not finished."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from drillid.datasets.store import WellFolders
from drillid.errors import SettingsError
from drillid.fleet.manifest import PROBLEMS, stored
from drillid.fleet.stages import STAGES, START_UPS
from drillid.formats.remote import states, url_of

_NAMED = 5
"""Failed wells, or missing logs, that the closing line names."""


def stored_name(folders: WellFolders) -> str:
    """The well's name, which its rows of problems hold; the keys of its stages state it where its folder differs."""
    return next((str(key["name"]) for key in map(stored, _folders(folders).values()) if "name" in key), folders.well)


def failed_wells(results: Path, wells: Sequence[str]) -> dict[str, str]:
    """Reason for each well that failed in a stage."""
    reasons = {well: _reason(_folders(WellFolders(results, well))) for well in wells}
    return {well: reason for well, reason in reasons.items() if reason}


def failed_start_ups(results: Path, start_ups: Sequence[str]) -> dict[str, str]:
    """Reason for each start of rotation that failed; one that no run has reached does not count."""
    reasons = {name: _reason({START_UPS.name: _start_up_folder(results, name)}) for name in start_ups}
    return {name: reason for name, reason in reasons.items() if reason}


def unfinished_start_ups(results: Path, start_ups: Sequence[str]) -> list[str]:
    """Starts of rotation without a key: no run has reached them, or they failed for an unforeseen reason."""
    return [name for name in start_ups if not stored(_start_up_folder(results, name))]


def unfinished_wells(results: Path, wells: Sequence[str]) -> list[str]:
    """Wells without a key in some stage: they failed for an unforeseen reason, or no run has got that far."""
    return [well for well in wells if not all(map(stored, _folders(WellFolders(results, well)).values()))]


def missing_logs(logs: Sequence[Path]) -> list[str]:
    """Listed logs, files or URLs, that do not exist; logs in a store that does not answer are not counted."""
    elsewhere = dict.fromkeys(filter(url_of, logs), "unknown")
    with contextlib.suppress(SettingsError):
        elsewhere = states(logs)
    return [url_of(log) or str(log) for log in logs if not _is_there(log, elsewhere)]


def _is_there(log: Path, elsewhere: Mapping[Path, str]) -> bool:
    return bool(elsewhere[log]) if log in elsewhere else os.path.exists(log)


def missing_logs_line(missing: Sequence[str]) -> str:
    """The sentence on listed logs that do not exist; empty if all do."""
    if not missing:
        return ""
    more = f" and {len(missing) - _NAMED} more" if len(missing) > _NAMED else ""
    return f"Listed logs that are not there: {len(missing)} ({', '.join(missing[:_NAMED])}{more})."


def closing_line(
    names: Sequence[str], failed: Mapping[str, str], unfinished: Sequence[str] = (), kind: str = "wells"
) -> str:
    """What became of the wells, or starts of rotation, in one line, with reasons and where to find the remedies."""
    waiting = [name for name in unfinished if name not in failed]
    total = len(names)
    if not failed:
        return (
            f"{total - len(waiting)} of {total} {kind} have gone through all stages, none failed."
            if waiting
            else f"{total} of {total} {kind} done."
        )
    named = [f"{name} ({reason})" for name, reason in list(failed.items())[:_NAMED]]
    more = [f"and {len(failed) - _NAMED} more"] if len(failed) > _NAMED else []
    rest = f" {len(waiting)} have not gone through all stages." if waiting else ""
    return (
        f"{len(failed)} of {total} {kind} failed: {', '.join(named + more)}. See problems.csv for the remedies.{rest}"
    )


def _start_up_folder(results: Path, name: str) -> Path:
    return WellFolders(results, name).stage(START_UPS.name)


def _folders(folders: WellFolders) -> dict[str, Path]:
    return {stage: folders.stage(stage) for stage in STAGES}


def _reason(places: Mapping[str, Path]) -> str:
    """The first failure in the stages' folders; an unforeseen one has a row but no key."""
    keys = {stage: stored(folder) for stage, folder in places.items()}
    failed = [stage for stage, key in keys.items() if key.get("status") == "failed"]
    without_key = [stage for stage, key in keys.items() if not key]
    for stage in (*failed, *without_key):
        row = _first_problem(places[stage] / PROBLEMS)
        if row or stage in failed:
            return f"{stage}: {row or 'not finished'}"
    return ""


def _first_problem(path: Path) -> str:
    try:
        table = pd.read_csv(path, dtype=str, keep_default_na=False)
    except (OSError, ValueError):
        return ""
    return f"{table['where'].iloc[0]}: {table['what'].iloc[0]}" if len(table) else ""

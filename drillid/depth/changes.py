"""What is new since the last report: windows, joint fits, verdicts, wells that failed or recovered, problems.

The last report is remembered in `<results>/reported.json`, which holds what the wells were like when it was written and
what they are like now. A run that ends before its report leaves the reported state as it is, so that the next report
covers that run's changes too; a report that is written again for the same wells gives the same changes again.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from drillid.datasets.registry import CHANGE_COLUMNS
from drillid.datasets.store import WellFolders
from drillid.datasets.tables import read_table, write_table
from drillid.depth.joint_levels import joint_levels, moved_levels
from drillid.depth.origin import origin, reason
from drillid.discrepancy.sets import read_verdicts
from drillid.fleet.manifest import write_whole
from drillid.fleet.outcome import stored_name

_STATE = "reported.json"
_MUCH = 0.1
"""Change of a verdict's probability that is reported."""
_WITH_SIZE = ("size", "size_low", "size_high")
_KEPT: dict[str, Any] = {"windows": {}, "verdicts": [], "joint": {}, "origin": {}}
"""What is kept of a well that fails: windows by their starts, verdicts, the joint fit in brief, and their origin."""
_VERDICT = ("verdict", "cause", "from_m", "to_m", "probability", *_WITH_SIZE, "unit")

Row = dict[str, Any]
State = Mapping[str, Any]
"""One well: its name, why it failed, its problems, and those items of `_KEPT` that it has."""


def write_changes(results: Path, wells: Sequence[str], problems: pd.DataFrame, failed: Mapping[str, str]) -> None:
    """Write `<results>/changes.csv`; without an earlier report it has no rows.

    Parameters
    ----------
    wells : folders of the wells
    problems : of all wells
    failed : reason for each failure, by the well's folder
    """
    path = Path(results) / _STATE
    remembered = _read(path)
    before, now = remembered.get("before"), remembered.get("now")
    found = _through_json({well: _state(results, well, problems, failed, (now or {}).get(well)) for well in wells})
    if found != now:
        before = now if remembered.get("reported") else before
        write_whole(path, json.dumps({"reported": False, "before": before, "now": found}))
    rows = [] if before is None else list(_changes(before, found))
    write_table(pd.DataFrame(rows, columns=list(CHANGE_COLUMNS)), Path(results) / "changes.csv")


def mark_reported(results: Path) -> None:
    """Record that the report covers the wells as they are now."""
    path = Path(results) / _STATE
    remembered = _read(path)
    if remembered and not remembered["reported"]:
        write_whole(path, json.dumps({**remembered, "reported": True}))


def has_earlier_report(results: Path) -> bool:
    """Whether there was an earlier report with which to compare the wells."""
    return _read(Path(results) / _STATE).get("before") is not None


def read_changes(results: Path) -> pd.DataFrame:
    """The table of changes as it was written; texts are empty where they do not apply, times are UTC."""
    texts = ("well", "change", "stage", "where", "before", "now", "reason")
    times, numbers = ["from_time", "to_time", "since"], ("from_m", "to_m", "count")
    table = read_table(
        Path(results) / "changes.csv",
        dtype=dict.fromkeys(texts, str),
        keep_default_na=False,
        na_values={name: [""] for name in (*numbers, *times)},
    )
    # a table written by an earlier version may lack columns
    lacking = {name: "" for name in texts if name not in table}
    return table.assign(**{name: pd.to_datetime(table[name]) for name in times}, **lacking)


def _read(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) and {"reported", "before", "now"} <= content.keys() else {}


def _through_json(content: Any) -> Any:
    return json.loads(json.dumps(content))


def _state(
    results: Path, well: str, problems: pd.DataFrame, failed: Mapping[str, str], earlier: State | None
) -> dict[str, Any]:
    """State of a well now; one that failed keeps the results that it had."""
    folders = WellFolders(results, well)
    name = stored_name(folders)
    own = problems[problems["well"] == name]
    rows = own[["stage", "where", "what"]].astype(str).values.tolist()
    return _kept(folders, well in failed, earlier or {}) | {
        "name": name,
        "failed": failed.get(well, ""),
        "problems": rows,
    }


def _kept(folders: WellFolders, has_failed: bool, earlier: State) -> dict[str, Any]:
    if has_failed:
        return {key: earlier.get(key, nothing) for key, nothing in _KEPT.items()}
    return {
        "windows": _windows(folders),
        "verdicts": _verdicts(folders),
        "joint": joint_levels(folders),
        "origin": origin(folders),
    }


def _windows(folders: WellFolders) -> dict[str, list[Any]]:
    """End and depths of each window by its start; times in ns since 1970."""
    if not folders.has("windows", "windows"):
        return {}
    windows = folders.read("windows", "windows", ("start", "end", "depth_from", "depth_to"))
    start, end = (windows[name].values.astype("datetime64[ns]").astype(np.int64) for name in ("start", "end"))
    depths = ([_or_none(depth) for depth in windows[name].values.tolist()] for name in ("depth_from", "depth_to"))
    rows = zip(end.tolist(), *depths, strict=True)
    return {str(first): list(row) for first, row in zip(start.tolist(), rows, strict=True)}


def _verdicts(folders: WellFolders) -> list[Row]:
    if not (folders.stage("discrepancy") / "verdicts.csv").exists():
        return []
    table = read_verdicts(folders)[list(_VERDICT)]
    return [{str(name): _or_none(value) for name, value in row.items()} for row in table.to_dict("records")]


def _or_none(value: Any) -> Any:
    """None in place of NaN, which is not equal to itself."""
    return None if pd.isna(value) else value


def _changes(before: Mapping[str, State], now: Mapping[str, State]) -> Iterator[Row]:
    for well in [*now, *(well for well in before if well not in now)]:
        old, new = before.get(well), now.get(well)
        common = {"well": (new or old or {})["name"], "since": _newest(old)}
        for row in _changes_of_well(old, new):
            yield common | row


def _changes_of_well(old: State | None, new: State | None) -> Iterator[Row]:
    if new is None:
        yield {"change": "removed_well"}
        return
    if old is None:
        yield {"change": "new_well"}
        old = {"failed": "", "problems": []}
    # the state saved by an earlier version lacks what was not kept then
    old = _KEPT | dict(old)
    if new["failed"] and new["failed"] != old["failed"]:
        yield {"change": "failed", "before": old["failed"], "now": new["failed"]}
    if old["failed"] and not new["failed"]:
        yield {"change": "recovered", "before": old["failed"]}
    for stage, rows in (
        ("windows", _changed_windows(old["windows"], new["windows"])),
        ("fits", moved_levels(old["joint"], new["joint"])),
        ("discrepancy", _changed_verdicts(old["verdicts"], new["verdicts"])),
    ):
        why = reason(old["origin"], new["origin"], stage)
        yield from (row | {"reason": why} for row in rows)
    yield from _new_problems(old["problems"], new["problems"])


def _newest(state: State | None) -> Any:
    """End of the newest window in the last report; empty for a well that was not in it."""
    ends = [row[0] for row in state["windows"].values()] if state else []
    return _time(max(ends)) if ends else ""


def _changed_windows(old: Mapping[str, list[Any]], new: Mapping[str, list[Any]]) -> Iterator[Row]:
    groups = {
        "new_windows": {start: row for start, row in new.items() if start not in old},
        "changed_windows": {start: row for start, row in new.items() if start in old and old[start] != row},
        "removed_windows": {start: row for start, row in old.items() if start not in new},
    }
    for change, windows in groups.items():
        if windows:
            depths = pd.DataFrame([row[1:3] for row in windows.values()], dtype=float)
            yield {
                "change": change,
                "count": len(windows),
                "from_m": depths.min(axis=None),
                "to_m": depths.max(axis=None),
                "from_time": _time(min(map(int, windows))),
                "to_time": _time(max(row[0] for row in windows.values())),
            }


def _changed_verdicts(old: Sequence[Row], new: Sequence[Row]) -> Iterator[Row]:
    """Verdicts are matched by name where their depths overlap, as the depths of a set grow with its windows."""
    left, unmatched = list(old), list[Row]()
    for row in new:
        same = next((other for other in left if _overlap(row, other) and other["verdict"] == row["verdict"]), None)
        if same is None:
            unmatched.append(row)
            continue
        left.remove(same)
        if _moved(same, row):
            yield _depths(row) | {"change": "changed_verdict", "before": _words(same), "now": _words(row)}
    for row in unmatched:
        instead = next((other for other in left if _overlap(row, other)), None)
        if instead is not None:
            left.remove(instead)
            yield _depths(row) | {"change": "changed_verdict", "before": _words(instead), "now": _words(row)}
        else:
            yield _depths(row) | {"change": "new_verdict", "now": _words(row)}
    for row in left:
        yield _depths(row) | {"change": "withdrawn_verdict", "before": _words(row)}


def _overlap(one: Row, other: Row) -> bool:
    return bool(one["from_m"] <= other["to_m"] and other["from_m"] <= one["to_m"])


def _moved(old: Row, new: Row) -> bool:
    """Whether the probability has changed much, or the size lies outside its earlier interval."""
    if abs(new["probability"] - old["probability"]) >= _MUCH:
        return True
    size, low, high = new["size"], old["size_low"], old["size_high"]
    return None not in (size, low, high) and not low <= size <= high


def _depths(row: Row) -> Row:
    return {"from_m": row["from_m"], "to_m": row["to_m"]}


def _words(row: Row) -> str:
    words = f"{row['verdict']} (probability {row['probability']:.2f}"
    if row["size"] is not None:
        words += f", size {row['size']:.3g} {row['unit'] if row['unit'] != '1' else ''}".rstrip()
    return f"{words})"


def _new_problems(old: Iterable[Sequence[str]], new: Iterable[Sequence[str]]) -> Iterator[Row]:
    """One row for each kind of problem; problems of one kind differ in their numbers only."""
    known = {(stage, _place(where), _kind(what)) for stage, where, what in old}
    kinds: dict[tuple[str, str], list[tuple[str, str]]] = {}
    for stage, where, what in new:
        if (stage, _place(where), _kind(what)) not in known:
            kinds.setdefault((stage, _kind(what)), []).append((where, what))
    for (stage, _), rows in kinds.items():
        yield {"change": "new_problem", "stage": stage, "where": rows[0][0], "now": rows[0][1], "count": len(rows)}


def _kind(what: str) -> str:
    return re.sub(r"\d[\d.]*(e[+-]?\d+)?", "…", what)


def _place(where: str) -> str:
    """The place without the numbers of windows, which change when a late log adds windows before them."""
    return re.sub(r"windows? [\d, to]+ at", "window at", where)


def _time(nanoseconds: int) -> str:
    return str(np.datetime64(nanoseconds, "ns").astype("datetime64[s]"))

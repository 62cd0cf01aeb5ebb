"""What is new since the last report, over runs that end with a report or before it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from drillid.datasets.registry import CHANGE_COLUMNS, CHANGES, PROBLEM_COLUMNS
from drillid.datasets.store import WellFolders
from drillid.datasets.tables import write_table
from drillid.depth.changes import mark_reported, read_changes, write_changes
from drillid.discrepancy.sets import verdict_table
from drillid.discrepancy.verdicts.verdict import Verdict
from drillid.fits.joint.coordinates import GAINS, SHARED, WALKING
from drillid.fits.joint.dataset import STATE, _nothing
from drillid.fleet.stages import STAGES
from drillid.physics.parameters import PARAMETERS
from tests.synthetic_well import windows_of

KEY = {"source": "1", "settings": {"windows": {"length_s": 600.0}}, "rig": "1", "versions": {"numpy": "2.1"}}
INPUTS = {"/rigs/r.yaml": "r", "/raw/a.csv": "a", "/raw/b.csv": "b"}
PROBLEM = ("W1", "windows", "sample 3", "is 7.5 too many", "Mend it")


def verdict(name: str = "none", probability: float = 0.9, to_m: float = 1009.0, **size: Any) -> Verdict:
    return Verdict(verdict=name, family="", probability=probability, from_m=1000.0, to_m=to_m, **size)


def make(results: Path, well: str = "W1", windows: int = 3, verdicts: tuple[Verdict, ...] = (verdict(),)) -> None:
    """What the table is made from."""
    folders = WellFolders(results, well)
    folders.write("windows", "windows", windows_of(windows))
    table = verdict_table(well, verdicts)
    folders.stage("discrepancy").mkdir(parents=True, exist_ok=True)
    write_table(table, folders.stage("discrepancy") / "verdicts.csv")


def make_keys(results: Path, inputs: dict[str, str] = INPUTS, **other: dict[str, Any]) -> None:
    """Keys of all stages; `other` has what differs in some."""
    for stage in STAGES:
        folder = WellFolders(results, "W1").stage(stage)
        folder.mkdir(parents=True, exist_ok=True)
        content = {"key": "k", **KEY, **({} if STAGES[stage].reads else {"inputs": inputs}), **other.get(stage, {})}
        (folder / "key.json").write_text(json.dumps(content))


def make_joint(results: Path, first: int = 0, **shift: float) -> None:
    """A joint fit over 300 m with bands of 10 % on either side, and parameters shifted by a share from 100 m down.

    Its windows begin with the one of number `first`.
    """
    joint = _nothing(31)
    level = np.array([150.0, 2.5e8, 0.0, 1e-5, 0.04, 1100.0, 20.0, 60.0]) * np.ones((31, 1))
    level[:, 2] = 950.0 + 10 * np.arange(31)
    for name, share in shift.items():
        level[10:, list(PARAMETERS).index(name)] *= 1 + share
    for name, half in (("value", 0.0), ("lower", -0.1), ("upper", 0.1)):
        band = np.where(np.arange(8) == 2, 10.0, level)
        joint[name] = (("window", "parameter"), level + half * band)
    start = np.datetime64("2025-05-01", "ns") + np.arange(31) * np.timedelta64(600, "s")
    rows = {"window": np.arange(31), "hole_depth": 1000.0 + 10 * np.arange(31), "start": start, "end": start}
    names = {"parameter": list(PARAMETERS), "shared": [*SHARED, *GAINS], "random_walk": STATE[: len(WALKING)]}
    coordinates: dict[str, Any] = {name: ("window", values) for name, values in rows.items()}
    joint = joint.assign_coords(**coordinates, **names, state=STATE, state_=STATE)
    WellFolders(results, "W1").write("fits", "joint", joint.isel(window=slice(first, None)))


def changes(
    results: Path,
    *wells: str,
    problems: tuple[tuple[str, ...], ...] = (),
    failed: dict[str, str] | None = None,
    reported: bool = True,
) -> list[dict[str, Any]]:
    """Rows of the table after a run, without what does not apply."""
    rows = pd.DataFrame(list(problems), columns=list(PROBLEM_COLUMNS))
    write_changes(results, wells or ("W1",), rows, failed or {})
    table = read_changes(results)
    assert list(table.columns) == list(CHANGE_COLUMNS)
    assert set(table["change"]) <= CHANGES.keys()
    if reported:
        mark_reported(results)
    return [
        {str(name): value for name, value in row.items() if value != "" and not pd.isna(value)}
        for row in table.to_dict("records")
    ]


def kinds(rows: list[dict[str, Any]]) -> list[str]:
    return [row["change"] for row in rows]


def test_the_first_report_has_nothing_to_compare_with(tmp_path: Path) -> None:
    make(tmp_path)
    assert changes(tmp_path, problems=(PROBLEM,)) == []


def test_new_windows_have_number_depths_and_times(tmp_path: Path) -> None:
    make(tmp_path)
    changes(tmp_path)
    make(tmp_path, windows=5)
    assert changes(tmp_path) == [
        {
            "well": "W1",
            "change": "new_windows",
            "count": 2,
            "from_m": 1009.0,
            "to_m": 1015.0,
            "from_time": pd.Timestamp("2025-05-01T06:30"),
            "to_time": pd.Timestamp("2025-05-01T06:50"),
            "since": pd.Timestamp("2025-05-01T06:30"),
        }
    ]


def test_windows_of_a_corrected_log_and_windows_that_are_gone(tmp_path: Path) -> None:
    make(tmp_path, windows=5)
    changes(tmp_path)
    corrected = windows_of(4)
    corrected["depth_to"] = corrected["depth_to"] + np.array([0.0, 0.5, 0.0, 0.0])
    WellFolders(tmp_path, "W1").write("windows", "windows", corrected)
    rows = changes(tmp_path)
    assert [(row["change"], row["count"], row["from_m"]) for row in rows] == [
        ("changed_windows", 1, 1003.0),
        ("removed_windows", 1, 1012.0),
    ]


@pytest.mark.parametrize(
    ("now", "change", "words"),
    [
        ((verdict(to_m=1012.0),), "", ""),
        ((verdict(probability=0.85),), "", ""),
        ((verdict(probability=0.7),), "changed_verdict", "none (probability 0.70)"),
        ((verdict("bit_noise", size=2.0, unit="N m"),), "changed_verdict", "bit_noise (probability 0.90, size 2 N m)"),
        ((verdict(), verdict("unknown")), "new_verdict", "unknown (probability 0.90)"),
        ((), "withdrawn_verdict", None),
    ],
    ids=["the set grew", "hardly", "less sure", "another", "one more", "gone"],
)
def test_verdicts_that_differ_are_told(
    now: tuple[Verdict, ...], change: str, words: str | None, tmp_path: Path
) -> None:
    make(tmp_path)
    changes(tmp_path)
    make(tmp_path, verdicts=now)
    rows = changes(tmp_path)
    assert kinds(rows) == [change] * bool(change)
    assert [row.get("now") for row in rows] == [words] * bool(change)


def test_a_size_outside_of_its_earlier_interval_is_told(tmp_path: Path) -> None:
    make(tmp_path, verdicts=(verdict("tail", size=2.0, size_low=1.5, size_high=2.5),))
    changes(tmp_path)
    make(tmp_path, verdicts=(verdict("tail", size=2.4, size_low=2.2, size_high=2.6),))
    assert changes(tmp_path) == []
    make(tmp_path, verdicts=(verdict("tail", size=2.7, size_low=2.5, size_high=2.9),))
    assert kinds(changes(tmp_path)) == ["changed_verdict"]


def test_failing_and_recovering(tmp_path: Path) -> None:
    make(tmp_path)
    changes(tmp_path)
    WellFolders(tmp_path, "W1").write("windows", "windows", windows_of(0))
    [row] = changes(tmp_path, failed={"W1": "records: log.csv: cannot be read"})
    assert (row["change"], row["now"]) == ("failed", "records: log.csv: cannot be read")
    assert changes(tmp_path, failed={"W1": "records: log.csv: cannot be read"}) == [row]
    make(tmp_path, windows=4)
    rows = changes(tmp_path)
    assert [(row["change"], row.get("count")) for row in rows] == [("recovered", None), ("new_windows", 1)]


def test_wells_that_come_and_go(tmp_path: Path) -> None:
    for well in ("W1", "W2"):
        make(tmp_path, well)
    changes(tmp_path, "W1")
    rows = changes(tmp_path, "W2")
    assert [(row["well"], row["change"]) for row in rows] == [
        ("W2", "new_well"),
        ("W2", "new_windows"),
        ("W2", "new_verdict"),
        ("W1", "removed_well"),
    ]


def test_problems_that_differ_in_their_numbers_are_one_kind(tmp_path: Path) -> None:
    make(tmp_path)
    changes(tmp_path, problems=(PROBLEM,))
    more = [("W1", "fits", f"window {row} at {row}.5 m", f"p-value {row}e-7", "Look") for row in range(3)]
    assert changes(tmp_path, problems=(("W1", "windows", "sample 3", "is 8 too many", "Mend it"),)) == []
    [row] = changes(tmp_path, problems=(PROBLEM, *more))
    assert (row["change"], row["stage"], row["where"], row["count"]) == ("new_problem", "fits", "window 0 at 0.5 m", 3)


@pytest.mark.parametrize("finished", [STAGES, list(STAGES)[1:]], ids=["all", "all but records"])
def test_a_well_whose_name_is_the_folder_of_another_keeps_its_problems(tmp_path: Path, finished: list[str]) -> None:
    """W2 has the folder W1, and W1 the folder W3; problems and keys hold the names."""
    for name, folder in (("W2", "W1"), ("W1", "W3")):
        make(tmp_path, folder)
        for stage in finished:
            path = WellFolders(tmp_path, folder).stage(stage) / "key.json"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps({"key": "k", **KEY, "name": name}))
    changes(tmp_path, "W1", "W3")
    other = ("W2", "records", "row 7", "is damaged", "Copy it again")
    rows = changes(tmp_path, "W1", "W3", problems=(PROBLEM, other))
    assert [(row["well"], row["change"], row["where"]) for row in rows] == [
        ("W2", "new_problem", "row 7"),
        ("W1", "new_problem", "sample 3"),
    ]


def test_numbers_of_windows_that_a_late_log_shifts_are_no_new_problem(tmp_path: Path) -> None:
    make(tmp_path)
    before, after = (
        ("W1", "fits", f"windows {listed} at 1000.0 to 1030.0 m", "refused", "Look")
        for listed in ("2 to 3, 5", "4 to 5, 7")
    )
    changes(tmp_path, problems=(before,))
    assert changes(tmp_path, problems=(after,)) == []


def test_a_run_without_report_is_told_in_the_next_and_a_repeated_report_tells_the_same(tmp_path: Path) -> None:
    make(tmp_path)
    changes(tmp_path)
    make(tmp_path, windows=4)
    changes(tmp_path, reported=False)
    make(tmp_path, windows=5)
    told = changes(tmp_path)
    assert [row["count"] for row in told] == [2]
    assert changes(tmp_path) == told
    make(tmp_path, windows=6)
    assert [row["count"] for row in changes(tmp_path)] == [1]


def test_a_damaged_memory_is_that_of_a_first_report(tmp_path: Path) -> None:
    make(tmp_path)
    changes(tmp_path)
    (tmp_path / "reported.json").write_text('{"reported": tr')
    make(tmp_path, windows=5)
    assert changes(tmp_path) == []
    assert not list(tmp_path.glob("*.part"))


def test_windows_without_depth_do_no_harm(tmp_path: Path) -> None:
    make(tmp_path)
    changes(tmp_path)
    unknown: xr.Dataset = windows_of(4)
    unknown["depth_to"] = unknown["depth_to"] * np.nan
    WellFolders(tmp_path, "W1").write("windows", "windows", unknown)
    rows = changes(tmp_path)
    assert kinds(rows) == ["new_windows", "changed_windows"]
    assert changes(tmp_path) == rows


def test_a_joint_fit_that_moves_is_told_with_depths_values_and_reason(tmp_path: Path) -> None:
    make(tmp_path)
    make_keys(tmp_path)
    make_joint(tmp_path)
    changes(tmp_path)
    make_joint(tmp_path, inertia_td=0.05, kappa=0.2)
    make_keys(tmp_path, fits={"rig": "2"}, records={"source": "2"})
    assert changes(tmp_path) == [
        {
            "well": "W1",
            "change": "changed_joint_fit",
            "stage": "fits",
            "from_m": 1100.0,
            "to_m": 1300.0,
            "before": "external viscous damping of mud and wall 150 N s m-4 (135 to 165)",
            "now": "180 N s m-4 (162 to 198)",
            "reason": "rig description changed (parts read by fits); code of records changed",
            "since": pd.Timestamp("2025-05-01T06:30"),
        }
    ]


def test_a_joint_fit_over_other_windows_of_the_same_depths_has_not_moved(tmp_path: Path) -> None:
    make(tmp_path)
    make_joint(tmp_path)
    changes(tmp_path)
    make_joint(tmp_path, first=3, length=0.0)
    assert changes(tmp_path) == []


@pytest.mark.parametrize(
    ("inputs", "other", "why"),
    [
        (INPUTS, {}, ""),
        (INPUTS | {"/rigs/r.yaml": "other comments"}, {}, ""),
        (INPUTS | {"/raw/b.csv": "c"}, {}, "corrected log b.csv"),
        (INPUTS | {"/raw/c.csv": "c", "/raw/d.csv": "d"}, {}, "new logs c.csv, d.csv"),
        ({"/raw/a.csv": "a"}, {}, "removed log b.csv"),
        ({"/mnt/a.csv": "a", "/mnt/b.csv": "b"}, {}, ""),
        (
            INPUTS,
            {"windows": {"settings": {"windows": {"length_s": 300.0}}}},
            "setting windows.length_s changed from 600.0 to 300.0",
        ),
        (INPUTS, {"figures": {"rig": "2"}}, ""),
        (INPUTS, {"discrepancy": {"versions": {"numpy": "2.2"}}}, 'numpy changed from "2.1" to "2.2"'),
    ],
)
def test_a_verdict_that_moves_has_the_reason_that_the_keys_tell(
    inputs: dict[str, str], other: dict[str, Any], why: str, tmp_path: Path
) -> None:
    make(tmp_path)
    make_keys(tmp_path)
    changes(tmp_path)
    make(tmp_path, verdicts=(verdict(probability=0.6),))
    make_keys(tmp_path, inputs, **other)
    [row] = changes(tmp_path)
    assert (row["change"], row.get("reason", "")) == ("changed_verdict", why)
    assert changes(tmp_path, failed={"W1": "records: b.csv: is bad"})[0]["change"] == "failed"


def test_the_state_and_table_of_an_earlier_version_are_read(tmp_path: Path) -> None:
    make(tmp_path)
    make_keys(tmp_path)
    make_joint(tmp_path)
    changes(tmp_path)
    remembered = json.loads((tmp_path / "reported.json").read_text())
    for part in ("joint", "origin"):
        del remembered["now"]["W1"][part]
    (tmp_path / "reported.json").write_text(json.dumps(remembered))
    make(tmp_path, windows=4)
    assert [(row["change"], row.get("reason")) for row in changes(tmp_path)] == [("new_windows", None)]
    table = pd.read_csv(tmp_path / "changes.csv").drop(columns="reason")
    table.to_csv(tmp_path / "changes.csv", index=False)
    assert read_changes(tmp_path)["reason"].tolist() == [""]

"""A well that grows: detections and examinations of what has not changed are kept, with the bits of one run."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from drillid.datasets.store import WellFolders
from drillid.discrepancy import gather, sets
from drillid.discrepancy.products import kept_sets
from drillid.discrepancy.sets import shared_error_rate, window_sets
from drillid.discrepancy.verdicts.engine import decisions
from drillid.discrepancy.verdicts.examination import Examination
from drillid.fleet.aside import forget_aside, set_aside
from drillid.fleet.manifest import KEY
from tests.nights import files
from tests.simulated import RIG, Processed

READ = (("windows", "windows"), ("spectra", "spectra"), ("mobility", "mobility"), ("fits", "fits"))


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the expensive functions at each call."""
    made: list[str] = []

    def noted(name: str, function: Any) -> Any:
        return lambda *given, **named: made.append(name) or function(*given, **named)

    monkeypatch.setattr(gather, "detect", noted("detect", gather.detect))
    monkeypatch.setattr(kept_sets, "examine_set", noted("examine", kept_sets.examine_set))
    return made


def run(whole: Processed, results: Path, windows: int) -> dict[str, bytes]:
    """The stage over the first windows of a well, after whatever was there before."""
    folders = WellFolders(results, "W1", "basis")
    folders.write("records", "records", whole.dataset("records", "records"))
    for stage, name in READ:
        dataset = whole.dataset(stage, name)
        gains = {key: value for key, value in dataset.attrs.items() if key.startswith("controller_")}
        folders.write(stage, name, dataset.isel(window=slice(windows)), **gains)
    set_aside(folders, "discrepancy")
    Processed(whole.well, folders, whole.settings, {}).run("discrepancy")
    (folders.stage("discrepancy") / KEY).write_text(json.dumps({"key": "1", "status": "done", "basis": "basis"}))
    forget_aside(folders, "discrepancy")
    return files(results, ["discrepancy"])


def test_a_growing_set_is_examined_again_but_its_records_are_not(
    healthy: Processed, tmp_path: Path, calls: list[str]
) -> None:
    run(healthy, tmp_path / "grown", 1)
    calls.clear()
    grown = run(healthy, tmp_path / "grown", 2)
    assert calls == ["examine", "detect"]
    assert grown == run(healthy, tmp_path / "at once", 2)


def test_a_set_that_is_complete_is_kept(
    healthy: Processed, tmp_path: Path, calls: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second set halves the share of the first in the error rate, which decides nothing else."""
    found: list[Examination] = []
    examine = sets.examine
    monkeypatch.setattr(sets, "examine", lambda *given, **named: found.append(examine(*given, **named)) or found[-1])
    monkeypatch.setattr(sets, "SET_WINDOWS", 1)
    run(healthy, tmp_path / "grown", 1)
    calls.clear()
    grown = run(healthy, tmp_path / "grown", 2)
    assert calls == ["examine", "detect"]
    assert grown == run(healthy, tmp_path / "at once", 2)
    calls.clear()
    assert run(healthy, tmp_path / "grown", 2) == grown
    assert calls == []
    # a rate at which every p-value is significant; the search for causes that follows takes long and is of no interest
    monkeypatch.setattr(kept_sets, "shared_error_rate", lambda *_: 1e9)
    monkeypatch.setattr(sets, "examine", lambda *_, **__: found[-1])
    monkeypatch.setattr(sets, "with_linear_or_law", lambda examination, *_: examination)
    run(healthy, tmp_path / "grown", 2)
    assert calls == ["examine", "examine"]


def test_an_examination_depends_on_the_error_rate_by_its_decisions() -> None:
    p_values = 0.01, [1e-4, 0.3]
    found = [decisions(*p_values, rate) for rate in np.geomspace(1e-6, 1e6, 200).tolist()]
    assert found[0] == [False] * 5
    assert found[-1] == [True] * 5
    # each is taken at one rate, from which on it stays
    assert all(np.all(before <= after) for before, after in zip(np.array(found), np.array(found[1:]), strict=False))
    assert decisions(0.5, [], 0.05) == [False]


@pytest.mark.parametrize(
    ("windows", "sizes"), [(1, [1]), (24, [24]), (35, [35]), (37, [24, 13]), (60, [24, 24, 12]), (720, [24] * 30)]
)
def test_sets_hold_about_as_many_windows_as_the_sealed_cases(windows: int, sizes: list[int]) -> None:
    depth = xr.Dataset({"bit_depth": ("window", np.full(windows, 1000.0))})
    fits = xr.Dataset({"value": (("window", "parameter"), np.ones((windows, 8)))})
    assert [rows.size for rows in window_sets(RIG, depth, fits)] == sizes


def test_sets_share_an_error_rate_that_changes_seldom() -> None:
    shares = [shared_error_rate(0.08, sets) for sets in range(1, 9)]
    assert shares == [0.08, 0.04, 0.02, 0.02, 0.01, 0.01, 0.01, 0.01]

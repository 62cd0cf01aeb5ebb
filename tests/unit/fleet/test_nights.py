"""Logs that come night by night: the well ends as if all had come at once, and only what is new is worked on."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from drillid.config.settings import Settings
from tests.nights import files, night, rig_file
from tests.raw_logs import START, drilling, save, standstill

SETTINGS = Settings.checked({"windows": {"length_s": 10.0}}, "test")
STAGES = ("records", "windows")
"""These logs have no sweep; tests/workflow/test_nightly.py takes some that have one through all stages."""


def log(folder: Path, number: int, seed: int = 0) -> Path:
    """A stand on the end of the one before, of which every third ends with a connection."""
    start = START + number * pd.Timedelta(seconds=30)
    table = drilling(30, 100 * seed + number, depth=2000.0 + number, start=start)
    if number % 3 == 2:
        table = pd.concat([table[:-250], standstill(5, start + pd.Timedelta(seconds=25), 2000.0 + number)])
    return save(table, folder / f"{number}.parquet")


@pytest.mark.parametrize("seed", range(2))
def test_any_sequence_of_nights_ends_as_one_run(seed: int, tmp_path: Path) -> None:
    draw, there, rig = np.random.default_rng(seed), dict[int, Path](), rig_file(tmp_path)
    for number in range(4):
        which = int(draw.integers(6))
        there[which] = log(tmp_path, which, seed=number)
        logs = list(there.values())
        assert night(tmp_path / "results", rig, logs, STAGES, SETTINGS) == ["done", "done"]
        night(tmp_path / f"fresh{number}", rig, logs, STAGES, SETTINGS)
        assert files(tmp_path / "results", STAGES) == files(tmp_path / f"fresh{number}", STAGES)


def test_a_window_over_the_end_of_a_log_follows_the_log_that_comes_later(tmp_path: Path) -> None:
    rig, logs = rig_file(tmp_path), [log(tmp_path, number) for number in range(2)]
    night(tmp_path / "results", rig, logs[:1], STAGES, SETTINGS)
    assert night(tmp_path / "results", rig, logs, STAGES, SETTINGS) == ["done", "done"]
    night(tmp_path / "fresh", rig, logs, STAGES, SETTINGS)
    assert files(tmp_path / "results", STAGES) == files(tmp_path / "fresh", STAGES)

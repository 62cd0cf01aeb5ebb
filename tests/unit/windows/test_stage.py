"""Rig states, segments and windows of made-up logs."""

from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from drillid.config.rig import Collars
from drillid.config.settings import Settings
from drillid.datasets.codes import RigState
from drillid.datasets.store import Problem, WellFolders
from drillid.records import stage as records
from drillid.windows import stage as windows
from drillid.windows.channels import window_channels
from drillid.windows.rig_state import _sweep_on
from drillid.windows.segments import steady_parts, window_places
from tests.raw_logs import RATE, RIG, START, drilling, save, standstill

LENGTH = 20.0
COLLARS = {"outer_diameter": "203 mm", "inner_diameter": "71 mm", "length": "500 m"}


def run(
    tmp_path: Path,
    *logs: pd.DataFrame,
    without: tuple[str, ...] = (),
    collars: tuple[Collars, ...] = (),
    **changes: Any,
) -> tuple[xr.Dataset, pd.DataFrame, xr.Dataset, list[Problem]]:
    """Windows, segments, states and problems of a well with these logs."""
    chosen = Settings.checked({"windows": {"length_s": LENGTH, "shortest_share": 1.0, **changes}}, "test")
    channels = {name: column for name, column in RIG.channels.items() if name not in without}
    paths = tuple(save(log, tmp_path / f"{number}.parquet") for number, log in enumerate(logs))
    rig = RIG.model_copy(update={"channels": channels, "collars": collars})
    well: Any = SimpleNamespace(name="W1", rig=rig, logs=paths)
    folders = WellFolders(tmp_path / "results", "W1")
    records.process(well, folders, chosen)
    problems = windows.process(well, folders, chosen)
    table = pd.read_csv(folders.stage("windows") / "segments.csv", keep_default_na=False)
    return folders.read("windows", "windows").load(), table, folders.read("windows", "states").load(), problems


def rows(table: pd.DataFrame) -> list[tuple[str, float, int, str]]:
    return list(zip(table["state"], table["duration_s"], table["windows"], table["reason"], strict=True))


def at(seconds: float) -> pd.Timestamp:
    return START + pd.Timedelta(seconds=seconds)


def test_a_sweep_that_is_on_for_a_small_part_of_a_log_is_told_from_a_flicker_at_rest() -> None:
    rate, count = 10.0, 36_000
    on = (np.arange(count) >= 20_000) & (np.arange(count) < 20_900)
    sweep = np.where(on, 500 * np.sin(2 * np.pi * np.arange(count) / 37.0), 0.0)
    sweep = np.round(sweep + np.random.default_rng(1).normal(0, 0.3, count))
    # spikes are no sweep
    sweep[[3000, 9000]] = 40_000.0
    found = _sweep_on(sweep, np.zeros(count, dtype=bool), rate)
    assert found[on].all()
    assert np.count_nonzero(found & ~on) < 300


def test_a_window_longer_than_a_block_is_read(tmp_path: Path) -> None:
    samples = 300_000
    records = xr.Dataset({name: ("time", np.zeros(samples, dtype=np.uint8)) for name in windows._OF_WINDOW})
    ((block, place),) = windows._loaded(records, [(0, samples)])
    assert (block[1].sizes["time"], place) == (samples, (0, samples))


def test_a_stand_gives_as_many_windows_as_fit_and_the_connection_none(tmp_path: Path) -> None:
    found, table, states, problems = run(tmp_path, drilling(40), standstill(15, at(40), 2000.48))
    assert rows(table) == [("drilling", 40.0, 2, ""), ("connection", 15.0, 0, "connection")]
    assert found["first_sample"].values.tolist() == [0, 1000]
    assert found["samples"].values.tolist() == [1000, 1000]
    assert (states["rig_state"].values == np.r_[[RigState.DRILLING] * 2000, [RigState.CONNECTION] * 750]).all()
    assert problems == []


def test_the_reason_names_the_channel_that_is_missing(tmp_path: Path) -> None:
    log = drilling(60)
    log.loc[25 * RATE : 35 * RATE - 1, ["HOLE", "BIT"]] = np.nan
    _, table, _, _ = run(tmp_path, log)
    (reason,) = set(table["reason"][table["state"] == "unknown"])
    assert reason == "no hole_depth for 10.0 s"


def test_a_hole_no_deeper_than_the_collars_are_long_gives_no_window(tmp_path: Path) -> None:
    shallow = drilling(40)
    shallow[["HOLE", "BIT"]] -= 1600 / 0.3048
    found, table, _, problems = run(tmp_path, shallow, collars=(Collars.model_validate(COLLARS),))
    assert found.sizes["window"] == 0
    ((state, seconds, count, reason),) = rows(table)
    assert (state, seconds, count) == ("drilling", 40.0, 0)
    assert reason == "the drill collars are stated as 500.0 m long in a hole of 400.2 m: there is no pipe"
    assert len(problems) == 1
    later = Collars.model_validate(COLLARS | {"from_depth": "450 m"})
    found, *_ = run(tmp_path, shallow, collars=(later,))
    assert found.sizes["window"] == 2


def test_figures_of_a_window(tmp_path: Path) -> None:
    log = drilling(40)
    found, *_ = run(tmp_path, log)
    window, part = found.isel(window=1), log.iloc[1000:2000]
    assert window["start"].values == part["Time"].iloc[0].to_datetime64()
    assert window["end"].values - window["start"].values == np.timedelta64(20, "s")
    assert float(window["speed"]) == pytest.approx(part["RPM"].mean() * np.pi / 30, rel=1e-6)
    assert float(window["torque"]) == pytest.approx(part["TQ"].mean() * 1e3, rel=1e-6)
    assert float(window["sweep_amplitude"]) == pytest.approx(part["SWEEP"].std(ddof=0) * 1e3, rel=1e-6)
    assert float(window["depth_from"]) == pytest.approx(part["HOLE"].iloc[0] * 0.3048, abs=1e-3)
    assert float(window["depth_to"]) == pytest.approx(part["HOLE"].iloc[-1] * 0.3048, abs=1e-3)
    assert float(window["hole_depth"]) == pytest.approx(part["HOLE"].mean() * 0.3048, abs=1e-3)
    assert float(window["flow"]) == pytest.approx(0.045)
    assert np.isnan(window["weight_on_bit"])
    assert float(window["flagged_share"]) == 0


def test_a_stand_that_follows_a_connection_in_one_log_loses_no_window(tmp_path: Path) -> None:
    log = pd.concat(
        [standstill(15, START, 2000.0), drilling(40, start=at(40)).assign(Time=drilling(40, start=at(15))["Time"])]
    )
    found, table, _, _ = run(tmp_path, log, standstill(10, at(55), 2000.48))
    assert log["SWEEP"].iloc[750] == 0, "the sweep must start at its resting value here"
    assert rows(table)[:2] == [("connection", 15.0, 0, "connection"), ("drilling", 40.0, 2, "")]
    assert found["first_sample"].values.tolist() == [750, 1750]


def test_a_gap_parts_windows_and_every_piece_has_its_reason(tmp_path: Path) -> None:
    found, table, _, _ = run(tmp_path, drilling(50).drop(index=range(700, 950)))
    assert rows(table) == [
        ("drilling", 14.0, 0, "too short: 14.0 s of the 20.0 s needed"),
        ("unknown", 5.0, 0, "gap of 5.0 s"),
        ("drilling", 11.0, 0, "too short: 11.0 s of the 20.0 s needed"),
        ("drilling", 20.0, 1, ""),
    ]
    assert found["first_sample"].values.tolist() == [1500]


@pytest.mark.parametrize("hole", ["gap", "stuck"])
@pytest.mark.parametrize("at_s", [7.0, 20.0, 33.0])
def test_a_hole_costs_little_more_than_itself(tmp_path: Path, hole: str, at_s: float) -> None:
    """A gap or a stuck sensor of 3 s in a stand that two windows would fill."""
    log, first, samples = drilling(43), round(at_s * RATE), round(3.0 * RATE)
    if hole == "gap":
        log = log.drop(index=range(first, first + samples))
    else:
        log.loc[first : first + samples, "RPM"] = log["RPM"].iloc[first]
    found, table, _, _ = run(tmp_path, log, shortest_share=0.25)
    assert found["samples"].values.sum() >= 0.85 * 40 * RATE
    starts = found["first_sample"].values
    assert not np.any((starts <= first + samples // 2) & (first + samples // 2 < starts + found["samples"].values))
    assert all(reason or count for reason, count in zip(table["reason"], table["windows"], strict=True))


def test_sweep_off_is_no_drilling_window(tmp_path: Path) -> None:
    log = drilling(60)
    log.loc[1000:1999, "SWEEP"] = 0.0
    found, table, _, _ = run(tmp_path, log)
    assert rows(table) == [("drilling", 20.0, 1, ""), ("sweep_off", 20.0, 0, "sweep off"), ("drilling", 20.0, 1, "")]
    assert found["first_sample"].values.tolist() == [0, 2000]


def test_reaming_and_off_bottom(tmp_path: Path) -> None:
    log = drilling(60)
    log["HOLE"] = 2000.0 / 0.3048
    lift = np.interp(np.arange(3000) / RATE, [0, 10, 40, 60], [12.0, 12.0, 3.0, 3.0])
    log["BIT"] = log["HOLE"] - lift / 0.3048
    _, table, states, problems = run(tmp_path, log)
    assert [row[0] for row in rows(table)] == ["off_bottom", "reaming", "off_bottom"]
    assert (states["rig_state"].values[[250, 1200, 2800]] == [3, 4, 3]).all()
    assert ["no window" in problem.what for problem in problems] == [True]


def test_no_window_is_a_problem_and_an_empty_dataset(tmp_path: Path) -> None:
    found, table, _, problems = run(tmp_path, standstill(30, START, 2000.0))
    assert found.sizes["window"] == 0
    assert len(problems) == 1
    assert rows(table) == [("connection", 30.0, 0, "connection")]


def test_a_change_of_set_point_parts_windows(tmp_path: Path) -> None:
    log = drilling(50)
    log[["SET", "RPM"]] += np.where(log.index >= 1300, 20.0, 0.0)[:, None]
    found, table, _, _ = run(tmp_path, log)
    assert found["first_sample"].values.tolist() == [300, 1500]
    changed = "too short: {} s of the 20.0 s needed; the set point of the speed changed"
    assert rows(table) == [
        ("drilling", 6.0, 0, changed.format("6.0")),
        ("drilling", 20.0, 1, ""),
        ("drilling", 4.0, 0, changed.format("4.0")),
        ("drilling", 20.0, 1, ""),
    ]


def test_a_change_of_speed_shows_without_the_set_point(tmp_path: Path) -> None:
    log = drilling(200)
    log.loc[5000:, "RPM"] += 20.0
    found, _, _, _ = run(tmp_path, log, without=("speed_set",))
    inside = [first < 5000 - RATE * 30 or first > 5000 - RATE * 20 for first in found["first_sample"].values]
    assert found.sizes["window"] >= 6
    assert all(inside), "a window reaches over the change of speed"


def test_too_many_mended_samples_refuse_a_window(tmp_path: Path) -> None:
    log = drilling(40)
    found, table, _, _ = run(tmp_path, log.drop(index=range(5, 900, 20)))
    assert found["first_sample"].values.tolist() == [1000]
    assert rows(table) == [
        ("drilling", 20.0, 0, "4.5 % of it interpolated or replaced; 2.0 % is allowed"),
        ("drilling", 20.0, 1, ""),
    ]


def test_a_stuck_sensor_makes_no_window(tmp_path: Path) -> None:
    log = drilling(60)
    log.loc[1000:1999, "RPM"] = float(log["RPM"].iloc[1000])
    found, table, _, _ = run(tmp_path, log)
    assert found["first_sample"].values.tolist() == [0, 2000]
    assert rows(table)[1] == ("drilling", 20.0, 0, "a sensor is stuck")


def test_windows_reach_over_logs_only_where_no_time_is_missing(tmp_path: Path) -> None:
    halves = drilling(10), drilling(10, start=at(10), depth=2000.12)
    found, table, _, _ = run(tmp_path, *halves)
    assert found["first_sample"].values.tolist() == [0]
    assert rows(table) == [("drilling", 20.0, 1, "")]
    halves = drilling(10), drilling(10, start=at(10.04), depth=2000.12)
    found, table, _, _ = run(tmp_path, *halves)
    assert found.sizes["window"] == 0
    assert len(table) == 2


@pytest.mark.parametrize(
    "without", [("flow",), ("bit_depth",), ("speed_set", "flow"), ("bit_depth", "flow", "speed_set")], ids="+".join
)
def test_whichever_channels_are_missing(without: tuple[str, ...], tmp_path: Path) -> None:
    logs = drilling(40), standstill(15, at(40), 2000.48)
    _, table, _, _ = run(tmp_path, *logs, without=without)
    assert [(row[0], row[2]) for row in rows(table)] == [("drilling", 2), ("connection", 0)]


def test_without_bit_depth_the_bit_of_a_window_is_at_the_bottom(tmp_path: Path) -> None:
    found, _, _, _ = run(tmp_path, drilling(40), without=("bit_depth",))
    assert found.sizes["window"] == 2
    assert found["bit_depth"].values.tolist() == found["hole_depth"].values.tolist()
    assert found["bit_depth"].values[1] == pytest.approx(2000.36, abs=1e-2)


def test_overlapping_windows(tmp_path: Path) -> None:
    found, table, _, _ = run(tmp_path, drilling(45), overlap=0.5)
    assert found["first_sample"].values.tolist() == [250, 750, 1250]
    assert rows(table) == [("drilling", 5.0, 0, "too short: 5.0 s of the 20.0 s needed"), ("drilling", 40.0, 3, "")]


def test_all_recorded_time_is_in_one_row_each(tmp_path: Path) -> None:
    log = drilling(70).drop(index=[*range(700, 950), *range(2000, 2003)])
    log.loc[2100:2600, "SWEEP"] = 0.0
    log.loc[2700:2900, "RPM"] = 0.0
    _, table, states, _ = run(tmp_path, log, standstill(10, at(70), 2000.84), standstill(10, at(200), 2000.84))
    assert table["duration_s"].sum() == pytest.approx(states.sizes["time"] / RATE)
    moments = [(pd.Timestamp(row.start), pd.Timestamp(row.end)) for row in table.to_records()]
    assert all(before[1] <= after[0] for before, after in pairwise(moments))
    assert all(reason or count for reason, count in zip(table["reason"], table["windows"], strict=True))


@given(st.integers(0, 500), st.integers(1, 100), st.floats(0.1, 1.0), st.sampled_from([0.0, 0.25, 0.5]))
def test_window_places(samples: int, length: int, share: float, overlap: float) -> None:
    shortest, hop = max(round(share * length), 1), max(1, round(length * (1 - overlap)))
    places = window_places(samples, length, shortest, overlap)
    whole = [start for start, size in places if (size == length and start > 0) or size == length == samples]
    for start, size in places:
        assert start >= 0
        assert shortest <= size <= length
        assert start + size <= samples
    if places:
        assert sum(places[-1]) == samples
        assert (np.diff(whole) == hop).all()
    # what no window holds lies at the start, and is shorter than the shortest
    assert (places[0][0] if places else samples) < shortest


@given(st.lists(st.floats(0, 100), min_size=1, max_size=80), st.floats(0.1, 50))
def test_steady_parts_hold_all_samples_and_none_varies_more(values: list[float], largest: float) -> None:
    set_point = np.array(values)
    parts = steady_parts(set_point, largest)
    assert [parts[0][0], *(stop for _, stop in parts)] == [*(first for first, _ in parts), len(values)]
    assert all(np.ptp(set_point[first:stop]) <= largest for first, stop in parts)


def test_channels_of_a_window_are_its_samples_of_the_records(tmp_path: Path) -> None:
    log = drilling(40)
    found, *_ = run(tmp_path, log)
    whole = WellFolders(tmp_path / "results", "W1").read("records", "records")
    speed, flow = window_channels(whole, found, 1, ("speed", "flow"))
    np.testing.assert_array_equal(speed, whole["speed"].values[1000:2000])
    np.testing.assert_array_equal(flow, whole["flow"].values[1000:2000])
    assert window_channels(whole, found, 0).shape == (3, 1000)


def test_a_gap_behind_the_first_sample_changes_no_rate(tmp_path: Path) -> None:
    log = drilling(60)
    log.loc[0, "Time"] -= pd.Timedelta(hours=9)
    found, table, _, _ = run(tmp_path, log)
    assert found["samples"].values.tolist() == [1000, 1000]
    assert table["duration_s"].sum() == pytest.approx(60.0)

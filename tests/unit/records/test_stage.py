"""Raw logs with one defect each → records with that defect mended or flagged, counted, and nothing else touched."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from drillid.config.settings import Settings
from drillid.datasets.codes import RecordFlag
from drillid.datasets.store import Problem, WellFolders
from drillid.errors import LogError
from drillid.records import repair
from drillid.records.quality import runs, spikes
from drillid.records.stage import process, regular_record
from tests.raw_logs import RATE, RIG, START, drilling, save, standstill, sweep_at

SETTINGS = Settings()
SECONDS = 60.0
LOG = drilling(SECONDS)
SPEED = LOG["RPM"].to_numpy() * np.pi / 30
SWEEP = LOG["SWEEP"].to_numpy() * 1e3


def record(log: pd.DataFrame, tmp_path: Path, **clock: Any) -> tuple[xr.Dataset, list[str]]:
    rig = RIG.model_copy(update={"time": RIG.time.model_copy(update=clock)})
    found = regular_record(save(log, tmp_path / "log.parquet"), rig, SETTINGS.records)
    return found.samples, [what for what, _ in found.notes]


def flagged(samples: xr.Dataset, flag: RecordFlag) -> list[int]:
    return np.flatnonzero(samples["flags"].values & np.uint8(flag)).tolist()


def jittered(log: pd.DataFrame, milliseconds: float, seed: int = 3) -> pd.DataFrame:
    jitter = np.random.default_rng(seed).uniform(-milliseconds, milliseconds, len(log))
    return log.assign(Time=(log["Time"] + pd.to_timedelta(np.floor(jitter * 1000), unit="us")).dt.floor("ms"))


def test_an_undamaged_log_is_taken_as_it_is(tmp_path: Path) -> None:
    samples, notes = record(LOG, tmp_path)
    assert notes == []
    assert not samples["flags"].any()
    assert (samples["time"].values == LOG["Time"].to_numpy()).all()
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)
    np.testing.assert_allclose(samples["torque_sweep"], SWEEP, rtol=1e-6, atol=1e-3)
    np.testing.assert_allclose(samples["hole_depth"], LOG["HOLE"] * 0.3048, rtol=1e-6)
    np.testing.assert_allclose(samples["flow"], 0.045, rtol=1e-6)
    assert np.isnan(samples["hook_load"]).all(), "a channel that the rig does not log must be missing throughout"


def test_stamp_jitter_is_taken_off(tmp_path: Path) -> None:
    samples, notes = record(jittered(LOG, 4), tmp_path)
    assert notes == []
    assert (samples["time"].values == LOG["Time"].to_numpy()).all()
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)


def test_real_jitter_of_the_samples_is_interpolated(tmp_path: Path) -> None:
    at = np.arange(len(LOG)) / RATE + np.random.default_rng(4).uniform(-4e-3, 4e-3, len(LOG))
    taken = sweep_at(at) / 1e3
    log = LOG.assign(Time=START + pd.to_timedelta(np.round(at * 1e9), unit="ns"), SWEEP=taken, TQ=7.0 + taken)
    samples, notes = record(log, tmp_path)
    assert notes == ["samples were taken off the regular clock (2.31 ms rms); interpolated to it"]
    ends = slice(5, -5)
    off = samples["torque_sweep"].values - sweep_at(np.arange(len(LOG)) / RATE)
    assert np.std(off[ends]) < 0.1 * np.std(log["SWEEP"] * 1e3 - sweep_at(np.arange(len(LOG)) / RATE))


def test_dropped_rows_are_filled_by_interpolation(tmp_path: Path) -> None:
    gone = [400, 900, 901, 902, 1500]
    samples, notes = record(jittered(LOG.drop(index=gone), 3), tmp_path)
    assert notes == ["5 rows missing, filled by interpolation"]
    assert flagged(samples, RecordFlag.INTERPOLATED) == gone
    assert samples.sizes["time"] == len(LOG)
    np.testing.assert_allclose(samples["torque_sweep"][gone], SWEEP[gone], atol=0.01 * np.ptp(SWEEP))
    others = np.delete(np.arange(len(LOG)), gone)
    np.testing.assert_allclose(samples["speed"][others], SPEED[others], rtol=1e-6)


def test_a_long_gap_stays_open(tmp_path: Path) -> None:
    samples, notes = record(LOG.drop(index=range(1000, 1300)), tmp_path)
    assert notes == ["gap of 6.0 s at 2025-03-03T06:00:20.000"]
    assert flagged(samples, RecordFlag.GAP) == list(range(1000, 1300))
    assert np.isnan(samples["speed"][1000:1300]).all()
    np.testing.assert_allclose(samples["speed"][1300:], SPEED[1300:], rtol=1e-6)


def test_a_gap_of_hours_takes_no_space(tmp_path: Path) -> None:
    log = LOG.copy()
    log.loc[2000:, "Time"] += pd.Timedelta(hours=9)
    samples, notes = record(log, tmp_path)
    assert notes == ["gap of 32400.0 s after 2025-03-03T06:00:39.980"]
    assert samples.sizes["time"] == len(LOG)
    assert samples["time"].values[2000] - samples["time"].values[1999] == np.timedelta64(9 * 3600 * 1000 + 20, "ms")


def test_repeated_rows_count_once(tmp_path: Path) -> None:
    twice = pd.concat([LOG.iloc[:1001], LOG.iloc[970:1001], LOG.iloc[1001:]])
    samples, notes = record(twice, tmp_path)
    assert notes == ["31 rows repeat the time of another row; the first of each is used"]
    assert flagged(samples, RecordFlag.DUPLICATE) == list(range(970, 1001))
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)


def test_two_values_at_one_time_keep_the_first(tmp_path: Path) -> None:
    other = LOG.iloc[[700]].assign(RPM=50.0)
    samples, notes = record(pd.concat([LOG.iloc[:701], other, LOG.iloc[701:]]), tmp_path)
    assert notes == ["1 rows repeat the time of another row; the first of each is used"]
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)


def test_rows_out_of_order_are_sorted(tmp_path: Path) -> None:
    order = np.r_[0:500, 550:600, 500:550, 600 : len(LOG)]
    samples, notes = record(LOG.take(order), tmp_path)
    assert notes == ["100 rows stood out of order and were sorted by time"]
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)


@pytest.mark.parametrize("seconds", [-1.5, -3600.0, 2.3, 3600.0])
def test_a_clock_that_was_set_while_signals_run_on(seconds: float, tmp_path: Path) -> None:
    log = jittered(LOG, 2)
    log.loc[1612:, "Time"] += pd.Timedelta(seconds=seconds)
    samples, notes = record(log, tmp_path)
    assert len(notes) == 1
    assert "the clock was set by " in notes[0]
    assert float(notes[0].split("set by ")[1].split(" s")[0]) == pytest.approx(seconds, abs=0.005)
    assert "run on" in notes[0]
    assert flagged(samples, RecordFlag.CLOCK_STEP) == [1612]
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)


def test_a_clock_set_back_while_time_is_lost_leaves_a_gap(tmp_path: Path) -> None:
    log: pd.DataFrame = LOG.drop(index=range(1500, 1700))
    log.loc[1700:, "Time"] -= pd.Timedelta(seconds=20)
    samples, notes = record(log, tmp_path)
    assert any("the signals break there" in note for note in notes)
    assert any(note.startswith("gap of") for note in notes)
    assert set(flagged(samples, RecordFlag.GAP)) >= {1500, 1501}


def test_spikes_are_replaced(tmp_path: Path) -> None:
    log = LOG.copy()
    log.loc[[53, 1234, 1235, 2000], "RPM"] = 0.0
    log.loc[2500, "TQ"] = 99.0
    samples, notes = record(log, tmp_path)
    assert notes == [
        "1 spikes in torque_command replaced, the first at 2025-03-03T06:00:50.000",
        "4 spikes in speed replaced, the first at 2025-03-03T06:00:01.060",
    ]
    assert flagged(samples, RecordFlag.SPIKE) == [53, 1234, 1235, 2000, 2500]
    np.testing.assert_allclose(samples["speed"], SPEED, atol=0.15)


def test_a_spike_beside_a_dropped_row(tmp_path: Path) -> None:
    log = LOG.copy()
    log.loc[1001, "RPM"] = 0.0
    samples, _ = record(log.drop(index=1000), tmp_path)
    np.testing.assert_allclose(samples["speed"][995:1006], SPEED[995:1006], atol=0.15)
    assert samples["flags"].values[[1000, 1001]].all()


def test_spikes_of_noise_stay_within_the_error_rate() -> None:
    noise = np.random.default_rng(6).normal(size=1_000_000)
    assert spikes(noise, RATE, 1e-4).sum() <= 100 + 4 * 10


@given(height=st.floats(0.5, 1e3), at=st.integers(10, 2980), width=st.integers(1, 3))
@settings(max_examples=60, deadline=None)
def test_steps_and_kinks_are_no_spikes_but_spikes_on_them_are(height: float, at: int, width: int) -> None:
    noise = np.random.default_rng(7).normal(0, 0.01, 3000)
    place = np.arange(3000)
    assert not spikes(np.where(place < at, height, 0.0) + noise, RATE, 1e-6)[max(0, at - 4) : at + 4].any()
    assert not spikes(np.abs(place - at) * height + noise, RATE, 1e-6)[max(0, at - 4) : at + 4].any()
    bump = noise.copy()
    bump[at : at + width] += height
    assert spikes(bump, RATE, 1e-6)[at : at + width].all()


def test_a_stuck_sensor_is_flagged_and_a_sweep_that_is_off_is_not(tmp_path: Path) -> None:
    log = LOG.copy()
    log.loc[1000:1299, "RPM"] = float(LOG["RPM"].iloc[1000])
    log.loc[2000:2300, "SWEEP"] = 0.0
    samples, notes = record(log, tmp_path)
    assert notes == ["speed does not change for 6.0 s from 2025-03-03T06:00:20.000"]
    assert flagged(samples, RecordFlag.STUCK) == list(range(1000, 1300))


def test_slow_channels_are_interpolated_between_their_own_values(tmp_path: Path) -> None:
    log = LOG.copy()
    for column in ("HOLE", "BIT"):
        log[column] = log[column].where(log.index % 50 == 0)
    samples, notes = record(log, tmp_path)
    assert notes == []
    np.testing.assert_allclose(samples["hole_depth"][:2951], LOG["HOLE"][:2951] * 0.3048, atol=1e-6)


def test_empty_cells_of_a_fast_channel_are_counted(tmp_path: Path) -> None:
    log = LOG.copy()
    log.loc[[100, 101], "RPM"] = np.nan
    samples, notes = record(log, tmp_path)
    assert notes == ["2 rows hold no speed"]
    assert flagged(samples, RecordFlag.INTERPOLATED) == [100, 101]


def test_a_needed_column_without_values_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="column 'RPM' holds no values"):
        record(LOG.assign(RPM=np.nan), tmp_path)
    samples, _ = record(LOG.assign(FLOW=np.nan), tmp_path)
    assert np.isnan(samples["flow"]).all()


def test_the_stated_rate_is_checked(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="stamps tell 50 samples per second, the rig description 100"):
        record(LOG, tmp_path, sample_rate=100.0)
    slow = LOG.assign(Time=START + (LOG["Time"] - START) * 1.001)
    samples, notes = record(slow, tmp_path, sample_rate=50.0)
    assert ["-999 parts in a million" in note for note in notes] == [True]
    assert samples.sizes["time"] == len(LOG)


def test_stamps_of_whole_seconds_are_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="coarser than its samples"):
        record(LOG.assign(Time=LOG["Time"].dt.floor("s")), tmp_path)


def test_millisecond_stamps_of_sixty_hertz_are_regular(tmp_path: Path) -> None:
    at = np.arange(len(LOG)) / 60
    samples, notes = record(LOG.assign(Time=(START + pd.to_timedelta(at, unit="s")).floor("ms")), tmp_path)
    assert notes == []
    assert samples.sizes["time"] == len(LOG)
    since = (samples["time"].values - samples["time"].values[0]).astype(np.int64) * 1e-9
    np.testing.assert_allclose(since, at, atol=2e-9)


def test_runs() -> None:
    assert runs(np.array([True, False, True, True])).tolist() == [[0, 1], [2, 4]]
    assert runs(np.zeros(3, dtype=bool)).size == 0


def well(*logs: Path) -> Any:
    return SimpleNamespace(name="W1", rig=RIG, logs=logs)


def run(tmp_path: Path, *logs: Path) -> tuple[xr.Dataset, list[Problem]]:
    folders = WellFolders(tmp_path / "results", "W1")
    problems = process(well(*logs), folders, SETTINGS)
    return folders.read("records", "records").load(), problems


def test_logs_of_any_format_in_any_order_make_one_series(tmp_path: Path) -> None:
    later = START + pd.Timedelta(seconds=30)
    second = save(standstill(20, later, 2000.4), tmp_path / "a.csv.gz")
    first = save(drilling(30), tmp_path / "b.parquet")
    records, problems = run(tmp_path, second, first)
    assert problems == []
    assert np.bincount(records["log"].values).tolist() == [1500, 1000]
    assert (np.diff(records["time"].values) == np.timedelta64(20, "ms")).all()
    assert records["speed"].dtype == np.float32
    assert records["speed"].attrs["units"] == "rad s-1"
    np.testing.assert_allclose(records["speed"][:1500], drilling(30)["RPM"] * np.pi / 30, rtol=1e-6)


def test_a_bad_log_is_a_row_and_the_others_go_on(tmp_path: Path) -> None:
    good = save(drilling(30), tmp_path / "good.csv")
    lacking = save(drilling(30, start=START + pd.Timedelta(hours=1)).drop(columns="RPM"), tmp_path / "lacking.csv")
    broken = tmp_path / "broken.parquet"
    broken.write_bytes(b"nothing")
    records, problems = run(tmp_path, broken, good, lacking, tmp_path / "gone.csv")
    assert records.sizes["time"] == 1500
    assert [(Path(problem.where).name, problem.what.split("; ")[0][:20]) for problem in problems] == [
        ("broken.parquet", "cannot be read (Parq"),
        ("gone.csv", "does not exist"),
        ("lacking.csv", "has no column 'RPM'"),
    ]
    assert all(problem.remedy for problem in problems)


def test_overlapping_logs_are_used_once(tmp_path: Path) -> None:
    first = save(drilling(30), tmp_path / "a.csv")
    second = save(drilling(30, start=START + pd.Timedelta(seconds=20)), tmp_path / "b.csv")
    inside = save(drilling(5, start=START + pd.Timedelta(seconds=5)), tmp_path / "c.csv")
    records, problems = run(tmp_path, first, second, inside)
    assert records.sizes["time"] == 2500
    assert (np.diff(records["time"].values) > np.timedelta64(0)).all()
    assert any("500 samples overlap" in problem.what for problem in problems)
    assert any("wholly within" in problem.what for problem in problems)


def test_another_rate_is_refused(tmp_path: Path) -> None:
    fast = drilling(30, start=START + pd.Timedelta(hours=1))
    fast["Time"] = fast["Time"].iloc[0] + (fast["Time"] - fast["Time"].iloc[0]) / 2
    logs = save(drilling(30), tmp_path / "a.csv"), save(fast, tmp_path / "b.csv")
    records, problems = run(tmp_path, *logs)
    assert records.sizes["time"] == 1500
    assert ["100 Hz, the well's other logs at 50 Hz" in problem.what for problem in problems] == [True]


def test_without_any_usable_log_every_reason_stays_and_there_is_no_store(tmp_path: Path) -> None:
    wrong = drilling(30)
    wrong["RPM"] = wrong["RPM"].astype(str)
    wrong.loc[41, "RPM"] = "n/a!"
    logs = save(wrong, tmp_path / "wrong.csv"), tmp_path / "gone.csv"
    folders = WellFolders(tmp_path / "results", "W1")
    problems = process(well(*logs), folders, SETTINGS)
    assert [(Path(row.where).name, row.what) for row in problems] == [
        ("gone.csv", "does not exist"),
        ("wrong.csv, column 'RPM', row 42", "'n/a!' is no number"),
    ]
    assert all(row.remedy for row in problems)
    assert not folders.has("records", "records")


def test_a_log_of_few_rows_or_values_tells_how_many(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="holds only 8 rows of the 10 needed"):
        record(LOG.iloc[:8], tmp_path)
    with pytest.raises(LogError, match="column 'RPM' holds only 3 values of the 10 needed"):
        record(LOG.assign(RPM=LOG["RPM"].where(LOG.index < 3)), tmp_path)


def test_a_log_in_descending_time_is_told_from_coarse_stamps(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"time stamps go backwards.*in the order of time"):
        record(LOG.iloc[::-1], tmp_path)


def drifting(seconds: float, parts: float, start: pd.Timestamp = START, phase: float = 0.0) -> pd.DataFrame:
    """Drilling whose stamps, to the millisecond, drift by so many parts in a million and begin `phase` s later."""
    log, jitter = drilling(seconds, start=start), np.random.default_rng(8).normal(0, 5e-4, round(seconds * RATE))
    at = np.arange(len(log)) / RATE * (1 + parts * 1e-6) + phase + jitter
    return log.assign(Time=start + pd.to_timedelta(np.round(at * 1e3), unit="ms"))


def follow_on(parts: list[float], minutes: list[float]) -> list[pd.DataFrame]:
    """Logs cut from an unbroken series of samples, whose stamps drift."""
    logs, begin, phase = list[pd.DataFrame](), START, 0.0
    for drift, length in zip(parts, minutes, strict=True):
        logs.append(drifting(60 * length, drift, begin, phase))
        begin, phase = begin + pd.Timedelta(minutes=length), phase + 60 * length * drift * 1e-6
    return logs


@pytest.mark.parametrize("parts", [[50.0] * 4, [-50.0] * 4, [18.0, 20.0, 25.0, 30.0]], ids=["fast", "slow", "mixed"])
def test_logs_whose_clock_drifts_are_all_used_and_join(parts: list[float], tmp_path: Path) -> None:
    minutes = [10.0, 14.0, 18.0, 24.0]
    logs = [save(log, tmp_path / f"{number}.parquet") for number, log in enumerate(follow_on(parts, minutes))]
    records, problems = run(tmp_path, *logs)
    # the kink where the made-up sweep begins anew passes for a spike now and then
    assert [problem for problem in problems if "spikes in speed" not in problem.what] == []
    assert np.bincount(records["log"].values).tolist() == [round(60 * length * RATE) for length in minutes]
    assert (np.diff(records["time"].values) == np.timedelta64(20, "ms")).all()
    assert not (records["flags"].values & ~np.uint8(RecordFlag.SPIKE)).any()


@pytest.mark.parametrize("drift", [-250.0, 250.0])
def test_a_large_drift_is_told_and_hides_no_pause(drift: float, tmp_path: Path) -> None:
    first, second = follow_on([drift, drift], [2.0, 2.0])
    second["Time"] += pd.Timedelta(seconds=4)
    records, problems = run(tmp_path, save(first, tmp_path / "a.parquet"), save(second, tmp_path / "b.parquet"))
    assert len(problems) == 2
    assert all(f"{-drift:+.0f} parts in a million off the rate of 50 Hz" in row.what for row in problems), problems
    assert np.max(np.diff(records["time"].values)) == np.timedelta64(4020, "ms")
    assert records.sizes["time"] == len(first) + len(second)


def test_after_a_long_pause_a_log_goes_by_its_stamps_again(tmp_path: Path) -> None:
    first = drifting(600, -150)
    second = drifting(60, -150, START + pd.Timedelta(hours=1))
    records, _ = run(tmp_path, save(first, tmp_path / "a.parquet"), save(second, tmp_path / "b.parquet"))
    begin = records["time"].values[records["log"].values == 1][0]
    assert abs(begin - second["Time"].iloc[0].to_datetime64()) < np.timedelta64(20, "ms")


@pytest.mark.parametrize("kept", [True, False], ids=["on the new clock", "on the old clock"])
def test_the_log_after_a_set_clock_joins_whichever_clock_it_keeps(kept: bool, tmp_path: Path) -> None:
    first, second = drilling(60), drilling(30, start=START + pd.Timedelta(seconds=60))
    first.loc[1612:, "Time"] -= pd.Timedelta(seconds=20)
    second["Time"] -= pd.Timedelta(seconds=20 * kept)
    records, problems = run(tmp_path, save(first, tmp_path / "a.parquet"), save(second, tmp_path / "b.parquet"))
    assert records.sizes["time"] == 4500
    assert (np.diff(records["time"].values) == np.timedelta64(20, "ms")).all()
    assert ["+20.0 s off its stamp" in problem.what for problem in problems[1:]] == [True] * kept


def test_a_spline_made_block_by_block_is_the_whole_spline(monkeypatch: pytest.MonkeyPatch) -> None:
    random = np.random.default_rng(9)
    place = np.arange(5000)
    gone = np.sort(random.choice(place[1:-1], 700, replace=False))
    known, values = np.setdiff1d(place, gone), random.normal(size=4300)
    whole = CubicSpline(known, values)(gone)
    monkeypatch.setattr(repair, "_SPLINE_BLOCK", 300)
    np.testing.assert_allclose(repair.spline(known, values, gone), whole, rtol=1e-11, atol=1e-11)
    none = np.setdiff1d(gone, np.arange(1000, 3000))
    np.testing.assert_allclose(repair.spline(known, values, none), CubicSpline(known, values)(none), atol=1e-11)


def test_a_bad_stamp_far_down_a_log_is_told_once_with_its_row(tmp_path: Path) -> None:
    log = drilling(60)
    log["Time"] = [stamp.isoformat() + "Z" for stamp in log["Time"]]
    log.loc[2500, "Time"] = "noon"
    log.to_csv(tmp_path / "log.csv", index=False)
    problems = process(well(tmp_path / "log.csv"), WellFolders(tmp_path / "results", "W1"), SETTINGS)
    assert [(Path(row.where).name, row.what) for row in problems] == [
        ("log.csv, column 'Time', row 2501", "'noon' is no time")
    ]

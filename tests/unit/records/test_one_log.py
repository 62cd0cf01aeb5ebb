"""One raw log with one defect → a record with that defect mended or flagged, counted, and nothing else touched."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from drillid.config.settings import Settings
from drillid.datasets.codes import RecordFlag
from drillid.errors import LogError
from drillid.records.stage import regular_record
from tests.raw_logs import RATE, RIG, START, drilling, save, sweep_at

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
    assert notes == ["the sampling times deviate from the regular clock (2.31 ms rms); interpolated to it"]
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
    assert notes == ["31 rows repeat the time of another row; the first value of each channel is used"]
    assert flagged(samples, RecordFlag.DUPLICATE) == list(range(970, 1001))
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)


def test_two_values_at_one_time_keep_the_first(tmp_path: Path) -> None:
    other = LOG.iloc[[700]].assign(RPM=50.0)
    samples, notes = record(pd.concat([LOG.iloc[:701], other, LOG.iloc[701:]]), tmp_path)
    assert notes == ["1 rows repeat the time of another row; the first value of each channel is used"]
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)


@pytest.mark.parametrize("fast_first", [True, False])
def test_rows_of_one_time_may_hold_fast_and_slow_channels_apart(fast_first: bool, tmp_path: Path) -> None:
    apart = [LOG[["Time", "TQ", "SWEEP", "RPM", "SET"]], LOG[["Time", "HOLE", "BIT", "FLOW"]].iloc[::50]]
    log = pd.concat(apart if fast_first else apart[::-1]).sort_values("Time", kind="stable")
    samples, notes = record(log, tmp_path)
    assert notes == []
    assert not samples["flags"].any()
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)
    np.testing.assert_allclose(samples["hole_depth"][:2951], LOG["HOLE"][:2951] * 0.3048, rtol=1e-6)
    # beside rows that do repeat another one's time
    samples, notes = record(pd.concat([log, log.iloc[-5:]]).sort_values("Time", kind="stable"), tmp_path)
    assert len(notes) == 1
    assert notes[0].endswith(" rows repeat the time of another row; the first value of each channel is used")
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)
    np.testing.assert_allclose(samples["hole_depth"][:2951], LOG["HOLE"][:2951] * 0.3048, rtol=1e-6)


def test_rows_of_one_time_may_hold_a_channel_each(tmp_path: Path) -> None:
    rows = [LOG[["Time", name]] for name in LOG if name != "Time"]
    samples, notes = record(pd.concat(rows).sort_values("Time", kind="stable"), tmp_path)
    assert notes == []
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)
    np.testing.assert_allclose(samples["torque_sweep"], SWEEP, rtol=1e-6, atol=1e-3)


def test_nothing_is_interpolated_from_one_side_of_a_gap_of_hours_to_the_other(tmp_path: Path) -> None:
    """Neither the speed at its edges nor the depth, which is logged once a second, though their rows are neighbours."""
    log = LOG.copy()
    log.loc[2000:, "Time"] += pd.Timedelta(hours=9)
    log.loc[2000:, "HOLE"] += 100.0
    log["HOLE"] = log["HOLE"].where(np.arange(len(log)) % 50 == 25)
    log.loc[1998:2000, "RPM"] = np.nan
    samples, notes = record(log, tmp_path)
    assert notes[0] == "3 rows hold no speed"
    assert flagged(samples, RecordFlag.GAP) == [1998, 1999, 2000]
    assert flagged(samples, RecordFlag.INTERPOLATED) == []
    assert np.isnan(samples["speed"][1998:2001]).all()
    depth = samples["hole_depth"].values
    np.testing.assert_allclose(depth[1900:2000], LOG["HOLE"][1900:2000] * 0.3048, atol=0.02)
    np.testing.assert_allclose(depth[2000:2100], (LOG["HOLE"][2000:2100] + 100.0) * 0.3048, atol=0.02)


def test_rows_out_of_order_are_sorted(tmp_path: Path) -> None:
    order = np.r_[0:500, 550:600, 500:550, 600 : len(LOG)]
    samples, notes = record(LOG.take(order), tmp_path)
    assert notes == ["100 rows were out of order and were sorted by time"]
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)


@pytest.mark.parametrize("seconds", [-1.5, -3600.0, 2.3, 3600.0])
def test_a_clock_that_was_set_while_signals_run_on(seconds: float, tmp_path: Path) -> None:
    log = jittered(LOG, 2)
    log.loc[1612:, "Time"] += pd.Timedelta(seconds=seconds)
    samples, notes = record(log, tmp_path)
    assert len(notes) == 1
    assert "the clock was set by " in notes[0]
    assert float(notes[0].split("set by ")[1].split(" s")[0]) == pytest.approx(seconds, abs=0.005)
    assert "signals are continuous" in notes[0]
    assert flagged(samples, RecordFlag.CLOCK_STEP) == [1612]
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)


def test_a_clock_set_back_while_time_is_lost_leaves_a_gap(tmp_path: Path) -> None:
    log: pd.DataFrame = LOG.drop(index=range(1500, 1700))
    log.loc[1700:, "Time"] -= pd.Timedelta(seconds=20)
    samples, notes = record(log, tmp_path)
    assert any("the signals are discontinuous there" in note for note in notes)
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
    with pytest.raises(LogError, match="stamps give 50 samples per second, the rig description 100"):
        record(LOG, tmp_path, sample_rate=100.0)
    slow = LOG.assign(Time=START + (LOG["Time"] - START) * 1.001)
    samples, notes = record(slow, tmp_path, sample_rate=50.0)
    assert ["-999 parts per million" in note for note in notes] == [True]
    assert samples.sizes["time"] == len(LOG)


def test_rows_of_whole_seconds_are_spaced_evenly(tmp_path: Path) -> None:
    samples, notes = record(LOG.assign(Time=LOG["Time"].dt.floor("s")), tmp_path)
    assert [note.partition(",")[0] for note in notes] == ["50 rows share each stamp"]
    assert not samples["flags"].any()
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)
    off = samples["time"].values - LOG["Time"].dt.tz_localize(None).to_numpy()
    assert np.abs(off).max() <= np.timedelta64(20, "ms")


def test_whole_seconds_with_any_number_of_rows_are_refused(tmp_path: Path) -> None:
    kept = np.random.default_rng(2).random(len(LOG)) < 0.4
    with pytest.raises(LogError, match="coarser than its samples"):
        record(LOG.assign(Time=LOG["Time"].dt.floor("s"))[kept], tmp_path)


def test_millisecond_stamps_of_sixty_hertz_are_regular(tmp_path: Path) -> None:
    at = np.arange(len(LOG)) / 60
    samples, notes = record(LOG.assign(Time=(START + pd.to_timedelta(at, unit="s")).floor("ms")), tmp_path)
    assert notes == []
    assert samples.sizes["time"] == len(LOG)
    since = (samples["time"].values - samples["time"].values[0]).astype(np.int64) * 1e-9
    np.testing.assert_allclose(since, at, atol=2e-9)


def test_a_log_of_few_rows_or_values_tells_how_many(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="holds only 8 rows of the 10 needed"):
        record(LOG.iloc[:8], tmp_path)
    with pytest.raises(LogError, match="column 'RPM' holds only 3 values of the 10 needed"):
        record(LOG.assign(RPM=LOG["RPM"].where(LOG.index < 3)), tmp_path)


@pytest.mark.parametrize("order", ["descending", "shuffled"])
def test_a_log_in_another_order_than_that_of_time_is_sorted_and_says_so(order: str, tmp_path: Path) -> None:
    log = jittered(LOG, 2)
    samples, notes = record(log.iloc[::-1] if order == "descending" else log.sample(frac=1, random_state=1), tmp_path)
    assert [note[4:] for note in notes] == [" rows were out of order and were sorted by time"]
    assert not samples["flags"].any()
    np.testing.assert_allclose(samples["speed"], SPEED, rtol=1e-6)


def test_a_log_in_another_order_whose_stamps_are_too_coarse_is_refused(tmp_path: Path) -> None:
    coarse = LOG.assign(Time=LOG["Time"].dt.floor("100ms"))
    for log in (coarse.iloc[::-1], coarse.sample(frac=1, random_state=1)):
        with pytest.raises(LogError, match=r"coarser than its samples|too close together to sort"):
            record(log, tmp_path)


def test_zeroed_stamps_are_left_out_and_said_once(tmp_path: Path) -> None:
    log = LOG.assign(Time=LOG["Time"].mask(LOG.index.isin(range(1000, 1004)), pd.Timestamp(0)))
    log.loc[2000, "Time"] += pd.Timedelta(days=400)
    samples, notes = record(log, tmp_path)
    what = (
        "rows are stamped far from their neighbours, the first 1970-01-01T00:00:00.000 in row 1001; they are not used"
    )
    assert notes == [f"5 {what}", "5 rows missing, filled by interpolation"]
    assert flagged(samples, RecordFlag.INTERPOLATED) == [*range(1000, 1004), 2000]
    np.testing.assert_allclose(samples["speed"], SPEED, atol=0.15)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda stamps: START + (stamps - START) / 1000,
            r"stamps are 2e-05 s apart.*unit or format of the time column",
        ),
        (lambda stamps: START + (stamps - START) * 1000, r"stamps are 20 s apart.*unit or format of the time column"),
        (lambda stamps: stamps + pd.Timedelta(days=208 * 365.25), r"stamps read as 2233-03-0.*unit or format"),
        (lambda stamps: pd.Timestamp(0) + (stamps - START), r"stamps read as 1970-01-01.*unit or format"),
        (
            lambda stamps: stamps + pd.to_timedelta(np.arange(3000) // 2 * 250, "s"),
            r"3000 rows are spread over 187\d+ samples at 50 Hz.*all rows of its recorder",
        ),
        (
            lambda stamps: stamps + pd.to_timedelta(np.random.default_rng(1).permutation(3000) % 30 * 977, "s"),
            "not in order of time|more often than any clock is reset",
        ),
    ],
    ids=["microseconds", "slow", "2233", "1970", "holes", "jumps"],
)
def test_a_time_column_in_a_wrong_unit_or_damaged_is_refused_at_once(
    change: Callable[[pd.Series], pd.Series], message: str, tmp_path: Path
) -> None:
    with pytest.raises(LogError, match=message):
        record(LOG.assign(Time=change(LOG["Time"])), tmp_path)


def in_pieces(count: int, apart: pd.Timedelta) -> pd.DataFrame:
    """The log in so many pieces, the last 2 s of each taken out, and the pause before each prolonged to `apart`."""
    length = len(LOG) // count
    log = LOG[LOG.index % length < length - 100]
    return log.assign(Time=log["Time"] + pd.to_timedelta(log.index // length * (apart.total_seconds() - 2), unit="s"))


def test_gaps_of_months_take_no_space(tmp_path: Path) -> None:
    log = in_pieces(4, pd.Timedelta(days=30))
    samples, notes = record(log, tmp_path)
    assert samples.sizes["time"] == len(log)
    assert [note.split(" after")[0] for note in notes] == ["gap of 2592000.0 s"] * 3
    with pytest.raises(LogError, match=r"stamps span 2\.7 years"):
        record(in_pieces(2, pd.Timedelta(days=1000)), tmp_path)


def test_many_notes_of_one_kind_are_one_row_with_their_number_and_times(tmp_path: Path) -> None:
    first, last = "the first at 2025-03-03T06:00:01.800, the last at", "2025-03-03T06:00:57.800"
    _, notes = record(LOG[LOG.index % 100 < 90], tmp_path)
    assert notes == [f"29 gaps of 0.2 to 0.2 s, 5.8 s in all, {first} {last}"]
    _, notes = record(in_pieces(6, pd.Timedelta(hours=1)), tmp_path)
    when = "the first at 2025-03-03T06:00:07.980, the last at 2025-03-03T10:00:39.980"
    assert notes == [f"5 gaps of 3600.0 to 3600.0 s, 18000.0 s in all, {when}"]
    held = LOG.assign(RPM=LOG["RPM"].where(LOG.index % 500 < 250).ffill())
    _, notes = record(held, tmp_path)
    assert len(notes) == 1
    assert notes[0].startswith(
        "speed does not change for 5.0 to 5.0 s 6 times, 30.1 s in all, the first at 2025-03-03T06:00:0"
    )
    set_often = jittered(LOG, 2)
    for row in range(312, 2300, 400):
        set_often.loc[row:, "Time"] += pd.Timedelta(seconds=1.3)
    _, notes = record(set_often, tmp_path)
    assert [note.split(", the first")[0] for note in notes if "clock" in note] == [
        "the clock was set 4 times, by +1.300 to +1.300 s"
    ]


@pytest.mark.parametrize("known", [10, 60])
def test_hardly_any_speed_is_a_gap_and_no_fault(known: int, tmp_path: Path) -> None:
    samples, notes = record(LOG.assign(RPM=LOG["RPM"].where(LOG.index % (3000 // known) == 0)), tmp_path)
    assert notes[0] == f"{3000 - known} rows hold no speed"
    assert "gaps of" in notes[1]
    assert np.isfinite(samples["speed"]).sum() == known


def test_values_beyond_any_number_are_refused_or_left_out(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"speed, column 'RPM' in rpm, is 1\.2"):
        record(LOG.assign(RPM=LOG["RPM"] * 1e300), tmp_path)
    samples, notes = record(LOG.assign(FLOW=LOG["FLOW"].mask(LOG.index == 5, 1e308), TQ=np.inf), tmp_path)
    assert [note.split(" are outside")[0] for note in notes] == ["1 values of flow"]
    assert np.isnan(samples["torque_command"]).all()
    np.testing.assert_allclose(samples["flow"], 0.045, rtol=1e-6)


def test_constant_channels_and_ten_rows_make_a_record(tmp_path: Path) -> None:
    samples, notes = record(LOG.assign(RPM=120.0, SWEEP=0.0, TQ=3.0), tmp_path)
    assert notes == []
    assert samples.sizes["time"] == len(LOG)
    samples, notes = record(LOG.iloc[:10], tmp_path)
    assert (samples.sizes["time"], notes) == (10, [])


def test_real_jitter_with_stamps_that_do_not_increase_is_interpolated(tmp_path: Path) -> None:
    """Sampling times that overtake each other, and rows without a speed, leave increasing places for the spline."""
    at = np.arange(len(LOG)) / RATE + np.random.default_rng(4).uniform(-4e-3, 4e-3, len(LOG))
    at[100:2900:100] += 0.021
    log = LOG.assign(Time=START + pd.to_timedelta(np.round(at * 1e9), unit="ns"), SWEEP=sweep_at(at) / 1e3)
    log.loc[101:2901:100, "RPM"] = np.nan
    samples, _ = record(log, tmp_path)
    assert np.isfinite(samples["speed"]).sum() > 2900


@pytest.mark.parametrize(("rows", "filled"), [(5, True), (6, False)])
def test_a_hole_is_filled_up_to_the_stated_length_and_open_beyond(rows: int, filled: bool, tmp_path: Path) -> None:
    """0.1 s at 50 Hz is five samples."""
    samples, _ = record(LOG.drop(index=range(1000, 1000 + rows)), tmp_path)
    expected = RecordFlag.INTERPOLATED if filled else RecordFlag.GAP
    assert flagged(samples, expected) == list(range(1000, 1000 + rows))
    assert np.isnan(samples["speed"].values[1000 : 1000 + rows]).all() != filled


def test_slow_rows_between_fast_ones_leave_these_where_they_were_sampled(tmp_path: Path) -> None:
    """A recorder that writes depth once a second, whenever it has it, in rows of their own."""
    fast, at = LOG.drop(columns=["HOLE", "BIT", "FLOW"]), np.arange(round(SECONDS)) * round(RATE)
    late = pd.to_timedelta(np.random.default_rng(0).uniform(0.5, 19.5, at.size), unit="ms")
    slow = LOG.loc[at, ["Time", "HOLE", "BIT", "FLOW"]].assign(Time=lambda rows: rows["Time"] + late)
    whole = pd.concat([fast, slow]).sort_values("Time", kind="stable", ignore_index=True)
    samples, told = record(whole, tmp_path)
    assert not told
    np.testing.assert_allclose(samples["torque_sweep"], SWEEP, rtol=1e-5, atol=1e-2)
    assert not flagged(samples, RecordFlag.DUPLICATE)
    assert not flagged(samples, RecordFlag.INTERPOLATED)
    known = np.isfinite(samples["hole_depth"].values)
    assert np.mean(known) > 0.9


@pytest.mark.parametrize("row", [0, len(LOG) - 1])
def test_a_missing_sample_at_an_end_is_no_gap_of_nothing(tmp_path: Path, row: int) -> None:
    log = LOG.copy()
    log.loc[row, "SWEEP"] = np.nan
    _, told = record(log, tmp_path)
    assert not any(" 0.0 s" in each for each in told)
    assert any("gap of 0.02 s" in each for each in told)

"""Stamps of rows → the places of their samples: jitter, gaps, drift and clocks that were set."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drillid.records.clock import nominal_rate, place_rows, share_of_real_jitter
from tests.raw_logs import RATE, START, sweep_at


@pytest.mark.parametrize("real", [False, True])
def test_share_of_real_jitter(real: bool) -> None:
    at = np.arange(6000) / RATE
    late = np.random.default_rng(5).uniform(-4e-3, 4e-3, at.size)
    sweep = sweep_at(at + late if real else at)
    stamps = np.round((at + late) * 1e9).astype(np.int64)
    ticks = place_rows(stamps, sweep, np.zeros(at.size))
    assert share_of_real_jitter(sweep[ticks.rows], ticks) == pytest.approx(float(real), abs=0.1)


@given(gone=st.sets(st.integers(1, 2998), max_size=60), milliseconds=st.floats(0, 4), phase=st.integers(0, 19_999))
@settings(max_examples=25, deadline=None)
def test_every_row_keeps_its_place_whatever_rows_are_missing(gone: set[int], milliseconds: float, phase: int) -> None:
    at = np.arange(3000) / RATE
    late = np.random.default_rng(len(gone)).uniform(-milliseconds, milliseconds, 3000) * 1e-3 + phase * 1e-6
    kept = np.setdiff1d(np.arange(3000), sorted(gone))
    stamps = START.value + np.round((at + late) * 1e9).astype(np.int64)
    ticks = place_rows(stamps[kept], sweep_at(at)[kept], np.sin(at)[kept])
    assert ticks.rate == RATE
    assert (ticks.tick == kept).all()


def stamped(
    rows: int, seed: int, missing: np.ndarray | None = None, dropped: float = 1e-3
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Numbers, stamps (ns, to the millisecond) and signals of a log whose stamps are 2 ms rms off, at most 8 ms."""
    random = np.random.default_rng(seed)
    at = np.arange(rows) / RATE
    late = np.clip(random.normal(0, 2e-3, rows), -8e-3, 8e-3)
    kept = random.random(rows) >= dropped
    kept[0] = True
    if missing is not None:
        kept[missing] = False
    number = np.flatnonzero(kept)
    stamps = START.value + np.round((at + late)[number] * 1e3).astype(np.int64) * 1_000_000
    rough = np.convolve(random.normal(size=rows + 24), np.hanning(25) / 3, "valid")
    return number, stamps, sweep_at(at)[number], 12.5 + 0.2 * rough[number]


@pytest.mark.parametrize("dropped", [1e-3, 0.02])
@pytest.mark.parametrize("seed", range(3))
def test_gaussian_jitter_moves_no_row_and_sets_no_clock(seed: int, dropped: float) -> None:
    number, stamps, sweep, speed = stamped(72_000, seed, dropped=dropped)
    ticks = place_rows(stamps, sweep, speed)
    assert ticks.rate == RATE
    assert ticks.steps == ()
    assert (ticks.tick == number).all()
    assert np.std(ticks.jitter) == pytest.approx(2.02e-3, rel=0.02)


def test_gaussian_jitter_beside_gaps() -> None:
    gaps = np.r_[5000:5250, 9000:9003, 20_000:21_850]
    number, stamps, sweep, speed = stamped(30_000, 4, missing=gaps)
    ticks = place_rows(stamps, sweep, speed)
    assert ticks.steps == ()
    assert (ticks.tick == number).all()


@pytest.mark.parametrize("seconds", [-3600.0, -0.507, 0.313, 1.5, 86_400.011])
def test_gaussian_jitter_and_a_clock_that_was_set(seconds: float) -> None:
    number, stamps, sweep, speed = stamped(20_000, 5, missing=np.r_[3000:3250])
    place = int(np.searchsorted(number, 12_345))
    stamps[place:] += round(seconds * 1e9)
    ticks = place_rows(stamps, sweep, speed)
    assert [(step.row, step.continues) for step in ticks.steps] == [(place, True)]
    assert ticks.steps[0].seconds == pytest.approx(seconds, abs=1.5e-3)
    assert (ticks.tick == number).all()
    assert ticks.rate == RATE


@pytest.mark.parametrize("late", [0.012, 0.07, -0.3])
def test_a_single_late_stamp_is_no_setting_of_the_clock(late: float) -> None:
    number, stamps, sweep, speed = stamped(10_000, 6, dropped=0.0)
    stamps[[2500, 7777, 7778]] += round(late * 1e9)
    ticks = place_rows(stamps, sweep, speed)
    assert ticks.steps == ()
    assert (ticks.tick == number).all()


def test_a_clock_that_drifts_and_wanders_keeps_its_rows() -> None:
    number, stamps, sweep, speed = stamped(72_000, 7)
    at = number / RATE
    stamps += np.round((20e-6 * at + 0.03 * np.sin(2 * np.pi * at / 900)) * 1e9).astype(np.int64)
    ticks = place_rows(stamps, sweep, speed)
    assert ticks.steps == ()
    assert (ticks.tick == number).all()


@pytest.mark.parametrize("drift", [0.0, 30e-6, -30e-6, 2e-4])
@pytest.mark.parametrize("rate", [100.0, 50.0, 12.5, 62.5, 60.0, 1000 / 30])
def test_the_nominal_rate_of_a_day(rate: float, drift: float) -> None:
    assert nominal_rate(rate * (1 + drift), round(86_400 * rate)) == pytest.approx(rate, rel=1e-12)


def test_a_rate_that_is_not_near_a_round_one_is_kept() -> None:
    assert nominal_rate(99.5, 8_640_000) == 99.5
    assert nominal_rate(50.2, 100) == 50.0, "two seconds do not tell half an interval"


def test_repeated_rows_are_found_wherever_they_stand() -> None:
    number, stamps, sweep, speed = stamped(4000, 10, dropped=0.0)
    again = np.r_[0:4000, 50, 3000]
    ticks = place_rows(stamps[again], sweep[again], speed[again])
    assert number[ticks.rows].tolist() == list(range(4000))
    assert ticks.repeated.tolist() == [50, 3000]

"""Stamps that are coarser than the samples: rows that share one are spaced evenly, where nothing speaks against it."""

import numpy as np
import pytest

from drillid.errors import LogError
from drillid.records.clock import place_rows
from drillid.records.shared_stamps import evenly
from tests.raw_logs import START, sweep_at

NOTHING = np.arange(0)


def coarse(rate: float, unit_s: float, first: int = 0, rows: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Times of samples, s, and their stamps, ns, which are whole units."""
    at = (first + np.arange(rows)) / rate
    unit = round(unit_s * 1e9)
    return at, START.value // unit * unit + (np.round(at * 1e9).astype(np.int64) // unit) * unit


@pytest.mark.parametrize(
    ("rate", "unit_s"), [(2.0, 1.0), (10.0, 1.0), (50.0, 1.0), (100.0, 0.1), (1.0, 60.0), (9.9, 1.0), (33.3, 1.0)]
)
@pytest.mark.parametrize("first", [0, 1, 37])
def test_rows_are_placed_as_they_were_sampled(rate: float, unit_s: float, first: int) -> None:
    at, stamps = coarse(rate, unit_s, first)
    ticks = place_rows(stamps, sweep_at(at), np.sin(at))
    assert ticks.rate == pytest.approx(rate, rel=2e-3)
    assert ticks.tick.tolist() == list(range(at.size))
    assert ticks.steps == ()
    off = (ticks.origin - START.value) * 1e-9 - at[0]
    assert abs(off) <= 1.01 / rate


def test_equal_samples_of_one_stamp_are_no_repeats() -> None:
    at, stamps = coarse(10.0, 1.0)
    held = np.where(at % 7 < 2, 3.0, sweep_at(at))
    ticks = place_rows(stamps, held, np.round(np.sin(at)))
    assert ticks.rows.size == at.size
    assert ticks.repeated.size == 0


def test_a_gap_of_whole_units_stays_one() -> None:
    at, stamps = coarse(10.0, 1.0)
    kept = (at < 120) | (at >= 150)
    ticks = place_rows(stamps[kept], sweep_at(at)[kept], np.sin(at)[kept])
    assert np.max(np.diff(ticks.tick)) == 301


def test_rows_that_are_missing_leave_the_others_in_their_unit() -> None:
    at, stamps = coarse(10.0, 1.0)
    kept = np.ones(at.size, dtype=bool)
    kept[[1003, 1004, 1005]] = False
    ticks = place_rows(stamps[kept], sweep_at(at)[kept], np.sin(at)[kept])
    assert np.max(np.abs(ticks.tick - np.flatnonzero(kept))) <= 3
    assert ticks.tick[-1] == at.size - 1


def test_copies_of_a_sample_are_left_out_as_before() -> None:
    at, stamps = coarse(1.0, 1.0)
    ticks = place_rows(np.repeat(stamps, 10), np.repeat(sweep_at(at), 10), np.repeat(np.sin(at), 10))
    assert ticks.rate == 1
    assert ticks.rows.size == at.size


def test_channels_one_by_one_are_not_taken_for_samples() -> None:
    at, stamps = coarse(1.0, 1.0)
    sweep, speed = np.full(2 * at.size, np.nan), np.full(2 * at.size, np.nan)
    sweep[::2], speed[1::2] = sweep_at(at), np.sin(at)
    assert evenly(np.repeat(stamps, 2), sweep, speed, NOTHING)[1] == 0


def test_irregular_numbers_of_rows_are_refused() -> None:
    random = np.random.default_rng(3)
    counts = random.integers(1, 20, 300)
    stamps = START.value + np.repeat(np.arange(counts.size), counts) * 10**9
    at = np.arange(stamps.size) / 10
    with pytest.raises(LogError, match="than its samples: most rows share a stamp, and not always the same number"):
        place_rows(stamps, sweep_at(at), np.sin(at))


def test_stamps_that_are_fine_enough_are_left_as_they_are() -> None:
    at, stamps = coarse(10.0, 0.001)
    found, usual = evenly(stamps, sweep_at(at), np.sin(at), NOTHING)
    assert usual == 0
    assert np.array_equal(found, stamps)


@pytest.mark.parametrize("share", [1.0, 0.85])
def test_rows_that_are_written_twice_are_no_samples_of_their_own(share: float) -> None:
    at = np.arange(3000) / 50.0
    rows = np.repeat(np.arange(at.size), np.where(np.random.default_rng(0).random(at.size) < share, 2, 1))
    stamps = START.value + np.round(at * 1e9).astype(np.int64)
    ticks = place_rows(stamps[rows], sweep_at(at)[rows], np.sin(at)[rows])
    assert ticks.rate == 50.0
    assert ticks.rows.size == at.size

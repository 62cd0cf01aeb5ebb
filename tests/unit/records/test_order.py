"""Rows in another order than that of time, stamps that no rig wrote, and what is left as it is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drillid.errors import LogError
from drillid.records.clock import place_rows
from drillid.records.order import in_order, outside_years, sorted_if_shuffled, stray
from tests.raw_logs import RATE, START, sweep_at

ROWS = 3000
AT = np.arange(ROWS) / RATE
STAMPS = START.value + np.round(AT * 1e9).astype(np.int64)
HOUR = 3600 * 10**9


@given(st.integers(0, 2**32 - 1), st.sampled_from([10, 400, ROWS]), st.floats(0, 5e-3))
@settings(max_examples=20, deadline=None)
def test_shuffled_rows_are_put_back_in_place(seed: int, within: int, jitter: float) -> None:
    random = np.random.default_rng(seed)
    stamps = STAMPS + np.round(random.uniform(-jitter, jitter, ROWS) * 1e9).astype(np.int64)
    order = np.concatenate([first + random.permutation(min(within, ROWS - first)) for first in range(0, ROWS, within)])
    ticks = place_rows(stamps[order], sweep_at(AT)[order], np.sin(AT)[order])
    assert order[ticks.rows].tolist() == list(range(ROWS))
    assert ticks.tick.tolist() == list(range(ROWS))
    assert (ticks.steps, ticks.repeated.size) == ((), 0)
    assert ticks.reordered == np.sum(order != np.arange(ROWS))


def test_descending_rows_are_turned_round() -> None:
    ticks = place_rows(STAMPS[::-1], sweep_at(AT)[::-1], np.sin(AT)[::-1])
    assert ticks.rows.tolist() == list(range(ROWS))[::-1]
    assert ticks.reordered == ROWS


def test_rows_in_order_or_with_late_stamps_are_left_alone() -> None:
    rows = np.arange(ROWS)
    late = STAMPS + np.random.default_rng(1).integers(-14_000_000, 14_000_000, ROWS)
    for stamps in (STAMPS, late):
        kept, moved = sorted_if_shuffled(stamps, rows, "log")
        assert kept is rows
        assert moved == 0


def test_shuffled_rows_with_stamps_too_rough_to_sort_are_refused() -> None:
    rough = STAMPS + np.random.default_rng(1).integers(-HOUR // 60, HOUR // 60, ROWS)
    with pytest.raises(LogError, match=r"not in order of time, and 29 % of its stamps are too close together"):
        place_rows(rough, sweep_at(AT), np.sin(AT))


def test_blocks_out_of_order_are_sorted_where_that_closes_gaps_and_a_set_clock_is_not() -> None:
    swapped = np.r_[0:500, 600:700, 500:600, 700:ROWS]
    rows, moved = in_order(STAMPS[swapped], np.arange(ROWS), 1 / RATE)
    assert swapped[rows].tolist() == list(range(ROWS))
    assert moved == 200
    set_back = STAMPS - np.where(np.arange(ROWS) >= 1500, HOUR // 360, 0)
    assert in_order(set_back, np.arange(ROWS), 1 / RATE)[1] == 0


@pytest.mark.parametrize(
    ("moment", "wrong"),
    [
        ("1970-01-01", True),
        ("1979-12-31T23:59", True),
        ("1980-01-01", False),
        ("2099-12-31", False),
        ("2100-01-01", True),
    ],
)
def test_years_in_which_no_rig_logs(moment: str, wrong: bool) -> None:
    assert outside_years(np.array([np.datetime64(moment, "ns").astype(np.int64)])).tolist() == [wrong]


@pytest.mark.parametrize(("rows", "found"), [(1, True), (8, True), (20, True), (21, False)])
@pytest.mark.parametrize("off", [-HOUR, HOUR])
def test_a_few_stamps_far_off_are_stray(rows: int, found: bool, off: int) -> None:
    stamps = STAMPS.copy()
    stamps[1000 : 1000 + rows] += off
    assert np.flatnonzero(stray(stamps)).tolist() == (list(range(1000, 1000 + rows)) if found else [])


def test_gaps_of_months_and_clocks_that_are_set_are_not_stray() -> None:
    later = STAMPS + np.where(np.arange(ROWS) >= 1500, 1000 * HOUR, 0)
    assert not stray(later).any()
    assert not stray(STAMPS - np.where(np.arange(ROWS) >= 1500, HOUR, 0)).any()
    assert not stray(np.random.default_rng(2).permutation(STAMPS * 1)).any()


@pytest.mark.parametrize("order", [np.r_[1500:ROWS, 0:1500], np.r_[2000:ROWS, 0:1000, 1000:2000]])
def test_parts_in_another_order_are_sorted(order: np.ndarray) -> None:
    """As by a pattern of names, in which 10 comes before 9."""
    rows, moved = in_order(STAMPS[order], np.arange(ROWS), 1 / RATE)
    assert order[rows].tolist() == list(range(ROWS))
    assert moved > 0

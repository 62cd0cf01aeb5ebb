"""Rows that hold the samples of a slower control."""

import numpy as np
import pytest

from drillid.records.held_rows import released

RATE, INTERVAL, SECONDS = 50.0, 0.0325, 300.0


def channels(time: np.ndarray) -> np.ndarray:
    """Sweep, speed and a command that is not logged."""
    sweep = 500 * np.sin(2 * np.pi * 3.7 * time) + 200 * np.sin(2 * np.pi * 0.11 * time)
    return np.stack([sweep, 10 + 0.01 * np.cos(2 * np.pi * 2.3 * time), np.full(time.size, np.nan)])


def held(time: np.ndarray) -> np.ndarray:
    return channels(np.floor(time / INTERVAL) * INTERVAL)


def test_held_samples_lie_on_their_curve_again() -> None:
    time = np.arange(0, SECONDS, 1 / RATE)
    found = released(held(time), RATE)[:, 50:-50]
    # the rows are late by a constant time
    shifts = np.linspace(-0.02, 0.02, 401)
    misses = [np.abs(found[0] - channels(time[50:-50] + shift)[0]).max() for shift in shifts]
    best = int(np.argmin(misses))
    assert misses[best] < 2.0
    assert np.abs(found[1] - channels(time[50:-50] + shifts[best])[1]).max() < 1e-4
    assert np.isnan(found[2]).all()


def test_two_samples_may_be_the_same() -> None:
    time = np.arange(0, SECONDS, 1 / RATE)
    rows = held(time)
    rows[:2] = np.rint(rows[:2] / np.array([[40.0], [0.005]])) * np.array([[40.0], [0.005]])
    assert np.abs(released(rows, RATE)[0, 50:-50] - released(held(time), RATE)[0, 50:-50]).max() < 60.0


@pytest.mark.parametrize("rows", [channels(np.arange(0, SECONDS, 1 / RATE)), np.full((3, 500), np.nan)])
def test_other_rows_stay_as_they_are(rows: np.ndarray) -> None:
    np.testing.assert_array_equal(released(rows, RATE), rows)


def test_rows_out_of_turn_and_few_samples_do_no_harm() -> None:
    time = np.arange(0, SECONDS, 1 / RATE)
    rows = channels(np.floor(time / 0.042) * 0.042)
    clean = released(rows, RATE)
    rows[:, 1000] += 1.0
    near = np.abs(np.arange(time.size) - 1000) > 50
    assert np.abs(released(rows, RATE) - clean)[:2, near].max() < 1.0
    few = np.repeat(np.arange(5.0), 300)[None]
    np.testing.assert_array_equal(released(few, RATE), few)

"""Rows that hold or interpolate the samples of a control that is not in step with them."""

import numpy as np
import pytest

from drillid.records.slower_samples import released

RATE, INTERVAL, SECONDS = 50.0, 0.0325, 300.0


def channels(time: np.ndarray) -> np.ndarray:
    """Sweep, speed and a command that is not logged."""
    sweep = 500 * np.sin(2 * np.pi * 3.7 * time) + 200 * np.sin(2 * np.pi * 0.11 * time)
    return np.stack([sweep, 10 + 0.01 * np.cos(2 * np.pi * 2.3 * time), np.full(time.size, np.nan)])


def held(time: np.ndarray, interval: float = INTERVAL) -> np.ndarray:
    return channels(np.floor(time / interval + 1e-9) * interval)


@pytest.mark.parametrize("interval", [0.021, 0.0225, 0.025, 0.0265, INTERVAL, 0.04, 0.0425, 0.05])
def test_held_samples_lie_on_their_curve_again(interval: float) -> None:
    time = np.arange(0, SECONDS, 1 / RATE)
    shown = released(held(time, interval), RATE)
    assert shown.interval == pytest.approx(interval, rel=1e-4)
    found = shown.channels[:, 50:-50]
    # the rows are late by a constant time
    shifts = np.linspace(-0.02, 0.02, 401)
    misses = [np.abs(found[0] - channels(time[50:-50] + shift)[0]).max() for shift in shifts]
    best = int(np.argmin(misses))
    assert misses[best] < 2.0
    assert np.abs(found[1] - channels(time[50:-50] + shifts[best])[1]).max() < 1e-4
    assert np.isnan(found[2]).all()


def swept(time: np.ndarray) -> np.ndarray:
    """A torque up to 5 Hz, as in a sweep, and a speed."""
    sweep = 500 * np.sin(2 * np.pi * time * (0.05 + 2.5 * time / SECONDS))
    return np.stack([sweep, 10 + 0.2 * np.cos(2 * np.pi * time * (0.05 + 2.5 * time / SECONDS))])


@pytest.mark.parametrize("interval", [0.0043, 0.0075, 0.0083, 0.0125, 0.015, 0.0175, 0.0191])
@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_rows_of_different_ages_lie_on_their_curve_again(interval: float, noise: float) -> None:
    time = np.arange(0, SECONDS, 1 / RATE)
    rows = swept(np.floor(time / interval + 1e-9) * interval)
    rows[1] += noise * np.random.default_rng(0).standard_normal(time.size)
    shown = released(rows, RATE)
    assert shown.interval == pytest.approx(interval, rel=1e-4)
    # the rows are late by a constant time
    inner, shifts = slice(500, -500), np.linspace(-0.02, 0.0, 401)
    curves = np.array([swept(time[inner] + shift)[0] for shift in shifts])
    before, after = (np.abs(values[0, inner] - curves).max(axis=1).min() for values in (rows, shown.channels))
    assert before > 15.0
    assert after < 0.1 * before


def test_channels_of_other_ages_leave_rows_as_they_are() -> None:
    time = np.arange(0, SECONDS, 1 / RATE)
    rows = np.stack([swept(np.floor(time / 0.0125) * 0.0125)[0], swept(time)[1]])
    np.testing.assert_array_equal(released(rows, RATE).channels, rows)


def test_two_samples_may_be_the_same() -> None:
    time = np.arange(0, SECONDS, 1 / RATE)
    rows = held(time)
    rows[:2] = np.rint(rows[:2] / np.array([[40.0], [0.005]])) * np.array([[40.0], [0.005]])
    found, clean = (released(values, RATE).channels[0, 50:-50] for values in (rows, held(time)))
    assert np.abs(found - clean).max() < 60.0


@pytest.mark.parametrize("interval", [0.0225, 0.0325, 0.0475])
def test_what_is_added_to_a_held_speed_does_not_hide_its_samples(interval: float) -> None:
    time = np.arange(0, SECONDS, 1 / RATE)
    rows, clean = (swept(np.floor(time / interval + 1e-9) * interval) for _ in range(2))
    rows[1] = np.round(rows[1] + 0.001 * np.sin(2 * np.pi * 9.7 * time), 4)
    shown, alone = released(rows, RATE), released(clean, RATE)
    assert shown.interval == pytest.approx(interval, rel=1e-4)
    np.testing.assert_allclose(shown.channels[0], alone.channels[0], atol=0.1)
    assert np.abs(shown.channels[1] - alone.channels[1])[50:-50].max() < 0.003


def test_rows_that_rounding_repeats_hold_no_samples() -> None:
    time = np.arange(0, SECONDS, 1 / RATE)
    random = np.random.default_rng(2).normal(size=(1, time.size))
    for rows in (np.round(random, 1), np.round(swept(time)[1:], 2)):
        assert (np.diff(rows) == 0).mean() > 0.02
        np.testing.assert_array_equal(released(rows, RATE).channels, rows)


def test_a_speed_read_anew_in_each_row_stays_as_it_is_beside_a_held_torque() -> None:
    time = np.arange(0, SECONDS, 1 / RATE)
    rows = np.stack([swept(np.floor(time / INTERVAL + 1e-9) * INTERVAL)[0], swept(time)[1]])
    np.testing.assert_array_equal(released(rows, RATE).channels, rows)


@pytest.mark.parametrize("rows", [channels(np.arange(0, SECONDS, 1 / RATE)), np.full((3, 500), np.nan)])
def test_other_rows_stay_as_they_are(rows: np.ndarray) -> None:
    np.testing.assert_array_equal(released(rows, RATE).channels, rows)


def test_rows_out_of_turn_and_few_samples_do_no_harm() -> None:
    time = np.arange(0, SECONDS, 1 / RATE)
    rows = channels(np.floor(time / 0.042) * 0.042)
    clean = released(rows, RATE).channels
    rows[:, 1000] += 1.0
    near = np.abs(np.arange(time.size) - 1000) > 50
    assert np.abs(released(rows, RATE).channels - clean)[:2, near].max() < 1.0
    few = np.repeat(np.arange(5.0), 300)[None]
    for rows in (np.zeros((2, 3)), np.random.default_rng(0).normal(size=(2, 40))):
        np.testing.assert_array_equal(released(rows, RATE).channels, rows)
    np.testing.assert_array_equal(released(few, RATE).channels, few)


@pytest.mark.parametrize("interval", [0.04, 0.0425, 0.05, 0.0731, 0.2])
@pytest.mark.parametrize("resolution", [0.0, 1.0])
def test_samples_that_rows_interpolate_lie_on_their_curve_again(interval: float, resolution: float) -> None:
    time, late = np.arange(0, SECONDS, 1 / RATE), 0.31 * interval
    samples = np.arange(-1, SECONDS / interval + 2) * interval + late
    slow = 0.4 * samples  # a fifth of the samples' rate at most
    rows = np.stack([np.interp(time, samples, values) for values in channels(slow)])
    if resolution:
        rows[0] = resolution * np.rint(rows[0] / resolution)
    found = released(rows, RATE)
    assert found.interval == pytest.approx(interval, rel=1e-5)
    if interval < 0.1:
        missed = np.abs(found.channels - channels(0.4 * time))[:, 50:-50]
        assert missed[0].max() < 5.0 + resolution
        assert missed[1].max() < 1e-4
    assert np.isnan(found.channels[2]).all()


@pytest.mark.parametrize("rate", [10.0, 50.0, 200.0, 1000.0])
def test_smooth_rough_and_rounded_rows_are_not_on_lines(rate: float) -> None:
    time = np.arange(0, SECONDS, 1 / rate)
    noise = np.random.default_rng(1).normal(size=time.size)
    sweep = 500 * np.sin(2 * np.pi * time * (0.05 + 2.5 * time / SECONDS))
    for series in (sweep, np.rint(sweep), np.rint(sweep / 50) * 50, sweep + noise, noise, np.zeros_like(time)):
        assert np.isnan(released(np.stack([series, noise]), rate).interval)


@pytest.mark.parametrize("interval", [0.011, 0.0125, 0.015, 0.0175, 0.0225, 0.027, 0.0375])
@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_rows_on_lines_between_close_samples_lie_on_their_curve_again(interval: float, noise: float) -> None:
    time = np.arange(0, SECONDS, 1 / RATE)
    samples = (np.arange(-1, SECONDS / interval + 2) + 0.3) * interval
    shown = swept(samples)
    shown[1] += noise * np.random.default_rng(0).standard_normal(samples.size)
    rows = np.stack([np.interp(time, samples, values) for values in shown])
    found, inner = released(rows, RATE), slice(500, -500)
    assert found.interval == pytest.approx(interval, rel=1e-6)
    before, after = (np.abs(values[0] - swept(time)[0])[inner].max() for values in (rows, found.channels))
    assert after < 0.3 * before
    assert noise or np.abs(found.channels[1] - swept(time)[1])[inner].max() < 0.3 * np.abs(rows - swept(time))[1].max()


@pytest.mark.parametrize("interval", [0.0025, 0.005, 0.01, 0.02])
@pytest.mark.parametrize("held", [True, False])
def test_samples_in_step_with_the_rows_leave_them_as_they_are(interval: float, *, held: bool) -> None:
    time, samples = np.arange(0, SECONDS, 1 / RATE), np.arange(-1, SECONDS / interval + 2) * interval
    shown = np.floor(time / interval + 1e-9) * interval
    rows = swept(shown) if held else np.stack([np.interp(time, samples, values) for values in swept(samples)])
    np.testing.assert_array_equal(released(rows, RATE).channels, rows)

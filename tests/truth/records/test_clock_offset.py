"""An offset of clocks that is put in is found again within its stated error."""

import numpy as np
import pytest

from drillid.arrays import Floats
from drillid.records.clock_offset import clock_offset

RATE = 50.0
START = 1_740_981_600 * 10**9


def rotation(seconds: float, seed: int) -> tuple[Floats, Floats]:
    """Times (s) and a speed (rpm) that is set anew now and then, sways and is rough."""
    noise = np.random.default_rng(seed)
    at = np.arange(round(seconds * RATE)) / RATE
    changes = np.sort(noise.uniform(0, seconds, 8))
    level = noise.choice([0.0, 60.0, 90.0, 120.0, 140.0], 9)[np.searchsorted(changes, at)]
    ramp = np.convolve(level, np.full(500, 1 / 500), "same")
    rough = np.convolve(noise.normal(size=at.size), np.hanning(60) / 8, "same")
    return at, ramp + 3 * np.sin(2 * np.pi * 0.2 * at) + rough


def stamps(seconds: Floats) -> np.ndarray:
    return START + np.round(seconds * 1e9).astype(np.int64)


def slow_of(at: Floats, speed: Floats, when: Floats, mean: bool) -> Floats:
    """What a recorder of 1 Hz holds at some times: samples, or means over a second about them."""
    if not mean:
        return np.interp(when, at, speed)
    total = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 / RATE)])
    return np.interp(when + 0.5, at, total) - np.interp(when - 0.5, at, total)


def error_and_stated(seed: int) -> tuple[float, float]:
    noise = np.random.default_rng(1000 + seed)
    at, speed = rotation(1800.0, seed)
    offset = noise.uniform(-3600, 3600)
    begin, end = ((-900.0, 2700.0), (300.0, 2500.0))[seed % 2]
    when = np.arange(begin, end) + noise.uniform()
    slow = slow_of(at, speed, when, mean=seed % 3 == 0) + noise.normal(0, 0.5, when.size)
    found = clock_offset(stamps(at), speed, stamps(when + offset), np.round(slow, seed % 2))
    assert found is not None
    return found.seconds - offset, found.error


def test_the_offset_is_found_within_its_stated_error() -> None:
    errors, stated = np.array([error_and_stated(seed) for seed in range(30)]).T
    assert np.max(stated) < 0.05
    # with 30 draws of a normal error a share within 2 standard errors below 0.8 has a chance of 1e-4
    assert np.mean(np.abs(errors) < 2 * stated) >= 0.8
    assert np.max(np.abs(errors)) < 5 * np.max(stated)


def test_a_sweep_that_repeats_itself_does_not_show_an_offset() -> None:
    at = np.arange(0, 1200, 1 / RATE)
    speed = 120 + 3 * np.sin(2 * np.pi * at / 40) + np.sin(2 * np.pi * at / 8)
    when = np.arange(0.0, 1200.0)
    assert clock_offset(stamps(at), speed, stamps(when + 17.0), np.interp(when, at, speed)) is None


@pytest.mark.parametrize("slow", [np.full(1800, 120.0), np.full(1800, np.nan), np.arange(1800) % 7.0])
def test_a_record_that_has_nothing_in_common_shows_no_offset(slow: Floats) -> None:
    at, speed = rotation(1800.0, 1)
    assert clock_offset(stamps(at), speed, stamps(np.arange(1800.0)), slow) is None

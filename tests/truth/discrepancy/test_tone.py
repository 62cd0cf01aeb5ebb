"""Lines of the record stand out where a tone was added, and neither where harmonics are far apart nor in the rock."""

import numpy as np
import pytest
from scipy.signal import lfilter

from drillid.arrays import Floats
from drillid.discrepancy.detectors.residual_record import ResidualRecord, WindowRecord
from drillid.discrepancy.detectors.tone import SpectralLine, strongest_line
from tests.simulated import RATE, SHALLOW, drilled

PERIOD, SECONDS, WINDOWS = 40.0, 240.0, 8
"""Harmonics 0.025 Hz apart in short windows."""
CHANCE = 3.0
"""Score that one window in 740 exceeds by chance."""


@pytest.fixture(scope="module")
def channels() -> dict[str, Floats]:
    return drilled(SHALLOW, WINDOWS * SECONDS, 1, sweep_period=PERIOD)


def lines(channels: dict[str, Floats], added: Floats | float = 0.0) -> list[SpectralLine]:
    """The strongest line of each window, with something added to the speed (samples,), rad/s."""
    speed, samples = channels["speed"] + added, round(SECONDS * RATE)
    found = []
    for window in range(WINDOWS):
        part = slice(window * samples, (window + 1) * samples)
        sweep, command = channels["torque_sweep"][part], channels["torque_command"][part]
        record = WindowRecord(sweep, speed[part], command, RATE, PERIOD, SHALLOW.parameters, SHALLOW.known)
        line = strongest_line(ResidualRecord(record))
        assert line is not None
        found.append(line)
    return found


def test_no_line_stands_out_of_noise_where_harmonics_are_far_apart(channels: dict[str, Floats]) -> None:
    assert max(line.score.normal for line in lines(channels)) < CHANCE


def test_a_narrow_line_of_the_rocks_noise_is_no_tone(channels: dict[str, Floats]) -> None:
    pole = np.exp(2 * np.pi * (2.3j - 0.03) / RATE)  # 0.03 Hz on either side
    force = np.random.default_rng(2).normal(size=channels["speed"].size)
    swing = lfilter([1.0], [1.0, -2 * pole.real, abs(pole) ** 2], force)
    swing *= channels["speed"].std() / swing.std()
    assert max(line.score.normal for line in lines(channels, swing)) < CHANCE


def test_a_tone_stands_out_at_its_frequency(channels: dict[str, Floats]) -> None:
    time = np.arange(channels["speed"].size) / RATE
    for line in lines(channels, 0.01 * np.sin(2 * np.pi * 2.313 * time)):
        assert line.score.normal > CHANCE
        assert line.place / 2 / SECONDS == pytest.approx(2.313, abs=0.5 / SECONDS)
        assert line.score.size == pytest.approx(0.01, rel=0.3)

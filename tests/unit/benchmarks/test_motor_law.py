"""The coupling's law is learnt from records whose law is known."""

import numpy as np
import pytest

from benchmarks.discoveries.motor import MotorRecord
from benchmarks.discoveries.motor_fit import HIGHEST_HZ, LOWEST_HZ, PERIOD, RATE
from benchmarks.discoveries.motor_law import learn_law, rising_splines, table
from drillid.arrays import Floats

STIFFNESS, LARGEST, PERIODS = 1.1e5, 0.13, 5


def record(softening: float) -> MotorRecord:
    """A load behind a coupling that is softer by a share at the largest twist, with noise on its speed."""
    generator = np.random.default_rng(3)
    lines = np.zeros(PERIOD // 2 + 1, dtype=complex)
    lines[LOWEST_HZ : 2 * HIGHEST_HZ // 3] = np.exp(2j * np.pi * generator.random(2 * HIGHEST_HZ // 3 - LOWEST_HZ))
    shape = np.fft.irfft(lines, PERIOD)
    twist = np.tile(LARGEST * shape / np.abs(shape).max(), (PERIODS, 1))
    torque = STIFFNESS * twist * (1 - softening * (twist / LARGEST) ** 2)
    frequency = np.fft.rfftfreq(PERIOD, 1 / RATE)
    integrated = np.fft.rfft(torque, axis=1) / np.where(frequency > 0, 2j * np.pi * frequency, np.inf)
    speed = np.fft.irfft(integrated, PERIOD, axis=1)
    speed += 0.01 * speed.std() * generator.standard_normal(speed.shape)
    nothing: Floats = np.zeros_like(twist)
    return MotorRecord(nothing, nothing, nothing, speed, twist)


def test_a_softening_coupling_is_learnt_with_its_size() -> None:
    law = learn_law(record(0.05))
    assert law.offered
    assert law.softening == pytest.approx(0.05, abs=0.01)
    truth = STIFFNESS * law.twist * (1 - 0.05 * (law.twist / LARGEST) ** 2)
    assert np.mean(np.abs(law.torque - truth) < 3 * law.error + 1e-3 * STIFFNESS * LARGEST) > 0.95
    assert np.all(np.diff(law.torque) > 0)
    assert "offered" in table(law)


def test_a_spring_is_left_as_it_is() -> None:
    law = learn_law(record(0.0))
    assert not law.offered
    assert law.softening == pytest.approx(0.0, abs=0.01)


def test_splines_rise_and_are_zero_at_no_twist() -> None:
    twist = np.linspace(-1.0, 1.0, 101)
    splines = rising_splines(twist, 1.0, 4)
    assert splines.shape == (6, 101)
    assert np.all(np.diff(splines, axis=1) >= -1e-12)
    assert np.abs(splines[:, 50]).max() < 1e-12
    assert np.linalg.matrix_rank(splines) == 6

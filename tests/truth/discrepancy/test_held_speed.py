"""A recorded speed that holds rarer samples is detected with its interval, and nothing else that images resemble."""

from dataclasses import replace

import numpy as np
import pytest

from drillid.arrays import Floats
from drillid.discrepancy.detectors.detection import Detection
from drillid.discrepancy.detectors.residual_record import WindowRecord
from drillid.simulation.recorder import Recorder
from tests.simulated import RATE
from tests.truth.discrepancy.window_records import (
    RIG,
    SENSOR_NOISE,
    detections_of,
    of_slower_samples,
    recorded,
    records,
)

EXACTLY = 3e-4
"""Relative error of an interval that is told."""


@pytest.fixture(scope="module")
def record() -> WindowRecord:
    return records(RIG, 0)[0]


def with_row_noise(record: WindowRecord, speed: Floats) -> WindowRecord:
    """The same with another speed, read with noise in each row."""
    return replace(record, speed=speed + SENSOR_NOISE * np.random.default_rng(3).standard_normal(speed.size))


def holding(record: WindowRecord, interval: float) -> WindowRecord:
    """The same with a speed that holds samples at an interval, s."""
    return with_row_noise(record, recorded(record, Recorder(1 / RATE, held=interval)).speed)


def held(record: WindowRecord) -> Detection:
    return detections_of(record)["sample_and_hold"]


@pytest.mark.parametrize("interval", [0.0231, 0.057, 0.13, 0.31])
def test_the_interval_of_a_held_speed_is_told(record: WindowRecord, interval: float) -> None:
    found = held(holding(record, interval))
    assert found.score > 5
    assert found.size == pytest.approx(interval, rel=EXACTLY)


def test_without_a_hold_there_is_none(record: WindowRecord) -> None:
    assert held(record).score < 0


def test_a_held_speed_shows_no_other_cause(record: WindowRecord) -> None:
    plain, shown = detections_of(record), detections_of(holding(record, 0.13))
    others = [name for name in plain if name != "sample_and_hold" and plain[name].score < 3]
    assert max(shown[name].score for name in others if name in shown) < 4


def test_a_speed_on_lines_between_rarer_samples_is_no_held_one(record: WindowRecord) -> None:
    on_lines = of_slower_samples(record, 0.13, held=False)
    assert held(with_row_noise(record, on_lines.speed)).score < 0


def test_a_loud_tone_is_no_held_speed(record: WindowRecord) -> None:
    tone = 0.3 * np.sin(2 * np.pi * 7.713 * np.arange(record.speed.size) / RATE)
    assert held(replace(record, speed=record.speed + tone)).score < 0


@pytest.mark.parametrize("is_held", [True, False])
def test_samples_of_a_slower_control_are_told_apart_from_those_of_the_speed(
    record: WindowRecord, is_held: bool
) -> None:
    assert held(of_slower_samples(record, 0.035, held=is_held)).score < 0
    found = held(of_slower_samples(holding(record, 0.1), 0.035, held=is_held))
    assert found.score > 5
    assert found.size == pytest.approx(0.1, rel=EXACTLY)

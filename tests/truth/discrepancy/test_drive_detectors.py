"""Detections of what the top drive does to its command: limits, jitter and play of its gear, of the right size."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import detrend

from drillid.discrepancy.detectors.drive import ceiling_score
from drillid.discrepancy.detectors.gear import Gear as GearSeen
from drillid.discrepancy.detectors.motion import Motion
from drillid.discrepancy.detectors.pooling import detection_gain, pool
from drillid.discrepancy.detectors.residual_record import ResidualRecord, WindowRecord
from drillid.discrepancy.gather import all_detections
from drillid.physics.limits import rate_limited, withheld_by_play
from drillid.physics.nonlinear import DriveLimits, Gear, NonlinearRig
from tests.simulated import RATE, SHALLOW
from tests.truth.discrepancy.window_records import (
    LIGHT,
    RIG,
    alone,
    detections_of,
    has_size,
    of_random_ages,
    of_slower_samples,
    records,
)


def test_torque_limit() -> None:
    rig = replace(RIG, limits=DriveLimits(torque=1950.0))
    assert has_size(alone(records(rig, 50)[0], "torque_limit"), 1950.0)


def test_a_torque_limit_that_one_window_reaches() -> None:
    limited = replace(RIG, limits=DriveLimits(torque=1950.0))
    soft = [records(limited, seed, bit_torque=1200.0)[0] for seed in (54, 55, 56)]
    windows = [*soft, records(limited, 50)[0]]
    assert max(record.command.max() for record in soft) < 1950.0 < windows[-1].command.max()
    detections = all_detections(windows)
    (found,) = (each for each in pool(detections) if each.cause == "torque_limit")
    assert abs(found.size - 1950.0) < 4 * found.size_error < 0.05 * 1950.0
    assert detection_gain([each for each in detections if each.cause == "torque_limit"]).low > 0


@pytest.mark.parametrize(("name", "limit"), [("torque_limit", 1950.0), ("torque_rate_limit", 1500.0)])
@pytest.mark.parametrize("step", [0.0, 2.0])
def test_a_limit_shows_in_a_command_that_is_logged_behind_it(name: str, limit: float, step: float) -> None:
    """The torque follows that command, so that none is missing, and no jitter of the delay takes its evidence."""
    by_torque = name == "torque_limit"
    record = records(replace(RIG, limits=DriveLimits(**{"torque" if by_torque else "rate": limit})), 50)[0]
    command = np.clip(record.command, -limit, limit)
    if not by_torque:
        command = rate_limited(record.command, np.array([limit / record.rate]))[0]
    command = np.round(command / step) * step if step else command
    detections = detections_of(replace(record, command=command))
    assert detections[name].score > 8
    size, error = detections[name].size, detections[name].size_error
    assert abs(size - limit) < max(4 * error, 1e-6 * limit)
    assert error < 0.03 * limit
    assert "delay_jitter" not in detections


def test_a_command_without_a_limit_has_no_ceiling() -> None:
    for seed in (60, 61):
        command = records(RIG, seed)[0].command
        for logged in (command, np.round(command / 10) * 10, np.repeat(command[::5], 5)):
            for series in (logged, -logged, np.abs(np.diff(logged))):
                assert ceiling_score(series) is None


@pytest.mark.parametrize("seed", [52, 53])
def test_rate_limit_that_is_reached_most_of_the_time(seed: int) -> None:
    record = records(replace(RIG, limits=DriveLimits(rate=900.0)), seed)[0]
    assert np.mean(np.abs(np.gradient(record.command)) * RATE > 900.0) > 0.5
    detection = alone(record, "torque_rate_limit")
    assert abs(detection.size - 900.0) < 3 * detection.size_error
    assert detection.size_error < 0.02 * 900.0


def test_torque_limit_without_logged_command() -> None:
    record = records(replace(RIG, limits=DriveLimits(torque=1900.0)), 50)[0]
    detection = detections_of(replace(record, command=np.full_like(record.command, np.nan)))["torque_limit"]
    assert np.isnan(detection.size)


def test_torque_rate_limit() -> None:
    rig = replace(RIG, limits=DriveLimits(rate=1500.0))
    assert has_size(alone(records(rig, 52)[0], "torque_rate_limit"), 1500.0)


def of_steps_at_a_rate(record: WindowRecord, rate: float) -> WindowRecord:
    """The record of a drive that follows each row's command, held until the next one, at a limited rate, N m/s.

    The top drive's inertia alone is the load of what is missing meanwhile.
    """
    fine = 20
    held = np.repeat(record.command, fine)
    missing = rate_limited(held, np.array([rate / (fine * RATE)]))[0] - held
    moved = np.cumsum(missing - missing.mean()) / (fine * RATE) / SHALLOW.top_drive.inertia
    # the middle of the hold, late by the drive's delay
    late = round((SHALLOW.top_drive.delay - 0.5 / RATE) * fine * RATE)
    more = np.interp(np.arange(record.speed.size) * fine - late, np.arange(moved.size), moved)
    return replace(record, speed=record.speed + detrend(more))


def test_a_rate_that_only_the_steps_from_row_to_row_exceed() -> None:
    """Even rows do not show whether the control holds its command from one to the next."""
    (record,) = records(RIG, 52, truth=replace(SHALLOW, bit_noise=10.0, sweep_amplitude=600.0))
    rate = 2.0 * np.abs(np.gradient(record.command)).max() * RATE
    assert has_size(alone(of_steps_at_a_rate(record, rate), "torque_rate_limit"), rate)
    assert detections_of(record)["torque_rate_limit"].score < 2


def test_delay_jitter() -> None:
    top_drive = replace(SHALLOW.top_drive, delay_jitter=0.014)
    rig = replace(RIG, system=replace(SHALLOW.system, top_drive=top_drive))
    (record,) = records(rig, 60)
    assert has_size(alone(replace(record, sample_rate=1 / rig.limits.jitter_interval), "delay_jitter"), 0.014**2)
    assert np.isnan(alone(record, "delay_jitter").size)


def test_rows_that_a_slower_control_wrote_are_no_slew() -> None:
    (record,) = records(RIG, 5)
    assert "torque_rate_limit" not in detections_of(of_random_ages(record))
    for interval in (0.0125, 0.05):
        released = detections_of(of_slower_samples(record, interval, held=True)).get("torque_rate_limit")
        assert released is None or released.score < 3


@pytest.mark.parametrize("interval", [0.0125, 0.0275])
def test_jitter_shows_in_samples_that_held_rows_release(interval: float) -> None:
    top_drive = replace(SHALLOW.top_drive, delay_jitter=0.014)
    rig = replace(RIG, system=replace(SHALLOW.system, top_drive=top_drive))
    rows = of_slower_samples(records(rig, 60)[0], interval, held=True)
    assert alone(rows, "delay_jitter").score > 5


LOOSE = NonlinearRig(LIGHT.system, gear=Gear(0.3, 0.3 * float(SHALLOW.top_drive.inertia), 1e6, 500.0))


def test_play_of_the_gear_shows_with_and_without_a_command_and_has_no_size() -> None:
    record = records(LOOSE, 64, truth=LIGHT, bit_torque=-130.0)[0]
    for each in (record, without_command(record)):
        detection = alone(each, "gear_backlash")
        assert detection.score > 5
        assert np.isnan(detection.size)


def test_a_torque_that_changes_its_sign_without_play_is_no_play() -> None:
    plain = records(NonlinearRig(LIGHT.system), 65, 4, LIGHT, -130.0)
    assert max(detections_of(record)["gear_backlash"].score for record in plain) < 3
    unlogged = [detections_of(without_command(record)).get("gear_backlash") for record in plain]
    assert all(detection is None or detection.score < 3 for detection in unlogged)


def without_command(record: WindowRecord) -> WindowRecord:
    return replace(record, command=np.full_like(record.command, np.nan))


def test_ends_of_a_window_that_do_not_meet_are_no_torque_that_changes_its_sign() -> None:
    record = records(NonlinearRig(RIG.system), 66)[0]
    slower = replace(record, speed=record.speed + np.linspace(0.5, -0.5, record.speed.size))
    for each in (record, slower):
        assert not GearSeen(Motion(ResidualRecord(each))).responses().any()


def test_teeth_part_for_as_long_as_the_motor_takes_to_cross_the_play() -> None:
    torque, inertia, play, step = 50.0, 400.0, 0.1, 1e-3
    reversed_at, samples = 500, 3000
    series = np.where(np.arange(samples) < reversed_at, torque, -torque)
    withheld = withheld_by_play(series, step, inertia, play / 2)
    apart = np.flatnonzero(withheld)
    assert apart[0] == reversed_at
    assert apart.size * step == pytest.approx(np.sqrt(2 * play * inertia / torque), abs=2 * step)
    assert withheld[apart[:-2]] == pytest.approx(torque)
    # when the teeth meet, the motor gives back what it gained
    assert withheld.sum() == pytest.approx(0.0, abs=1e-6 * torque / step)


def test_a_torque_that_keeps_its_sign_holds_the_teeth_together() -> None:
    assert not withheld_by_play(np.array([3.0, 1.0, 2.0]), 0.1, 100.0, 0.05).any()
    assert not withheld_by_play(np.array([-3.0, -1.0, -2.0]), 0.1, 100.0, 0.05).any()


def test_rate_limit_of_a_step() -> None:
    series = np.array([0.0, 1.0, 1.0, 1.0, 0.0])
    slow, fast = rate_limited(series, np.array([0.4, 2.0]))
    assert slow == pytest.approx([0.0, 0.4, 0.8, 1.0, 0.6])
    assert fast == pytest.approx(series)

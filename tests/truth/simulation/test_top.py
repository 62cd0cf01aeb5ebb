"""Top of the rig in the simulator: gear, limits, jitter, sensor, sampling, and rigs that change in time."""

from dataclasses import replace

import numpy as np
import pytest

from drillid.arrays import Floats
from drillid.errors import SettingsError
from drillid.excitation.torques import exponential_sweeps
from drillid.physics.equipment import Bit, Controller, DrillingSystem, TopDrive
from drillid.physics.nonlinear import DriveLimits, Gear, NonlinearRig, SpeedSensor, VaryingRig, WallContact
from drillid.physics.responses import command_mobility, laplace
from drillid.simulation.simulate import SAMPLE_INTERVAL, TIME_STEP, Simulation, simulate
from tests.truth.rigs import FREQUENCIES, PERIOD, SPEED, SYSTEM, TOP_DRIVE, closure, lines_of, multisine, steps_in

PHASES = ((10, 20), (30, 40), (50, 60))
FREE = replace(SYSTEM, top_drive=TopDrive(1100.0, 0.0413, Controller(0.0)))


def swept(
    rig: DrillingSystem | NonlinearRig | VaryingRig, amplitude: float = 600.0, bit_torque: float = 4e3
) -> Simulation:
    """A minute of sweeps, every step recorded."""
    time = TIME_STEP * np.arange(steps_in(60.0), dtype=float)
    return simulate(
        rig,
        exponential_sweeps(time, amplitude),
        np.full(time.size, SPEED),
        np.full(time.size, bit_torque),
        mean_bit_torque=bit_torque,
        sample_interval=TIME_STEP,
        energies=True,
    )


def test_the_motor_turns_through_the_play_and_no_further() -> None:
    """The string is held fast: a small torque to and fro takes the motor from flank to flank."""
    held = WallContact(np.array([0.0, 3000.0]), np.array([1e4]), np.array([1e4]))
    play = 0.05
    rig = NonlinearRig(FREE, contact=held, gear=Gear(play, 150.0))
    time = TIME_STEP * np.arange(steps_in(80.0), dtype=float)
    torque = 5.0 * np.sign(np.sin(2 * np.pi * time / 40))
    result = simulate(rig, torque, 0 * time, 0 * time, sample_interval=TIME_STEP)
    assert np.ptp(TIME_STEP * np.cumsum(result.speed)) == pytest.approx(play, rel=0.02)


def test_play_shows_only_where_the_torque_reverses() -> None:
    light = replace(SYSTEM, bit=Bit(40.0, 0.0))
    gear = Gear(0.05, 150.0)
    for bit_torque, visible in ((8e3, False), (0.0, True)):
        rigid, loose = (swept(NonlinearRig(light, gear=part), bit_torque=bit_torque) for part in (Gear(), gear))
        assert (rigid.string_torque.min() < 0) == visible
        difference = np.abs(loose.speed - rigid.speed).max() / rigid.speed.std()
        assert (difference > 0.1) == visible
        assert closure(loose) < 1e-3


def test_the_drive_gives_no_more_torque_than_its_limit() -> None:
    limit = 5200.0
    free = swept(SYSTEM)
    limited = swept(NonlinearRig(SYSTEM, limits=DriveLimits(torque=limit)))
    assert free.drive_torque.max() > 1.05 * limit
    assert limited.drive_torque.max() == limit
    assert np.mean(limited.drive_torque == limit) > 0.01


def test_the_integral_does_not_wind_up_at_the_limit() -> None:
    """After a minute in which the drive cannot hold the speed, it is back within seconds."""
    time = TIME_STEP * np.arange(steps_in(120.0), dtype=float)
    load = np.where((time > 10) & (time < 70), 8e3, 4e3)
    rig = NonlinearRig(SYSTEM, limits=DriveLimits(torque=7e3))
    result = simulate(rig, 0 * time, np.full(time.size, SPEED), load, mean_bit_torque=4e3)
    assert result.speed[result.time < 70].min() < 0.8 * SPEED
    assert result.speed.max() < 1.3 * SPEED
    assert result.speed[result.time > 110] == pytest.approx(SPEED, rel=0.05)


def test_the_drive_torque_changes_no_faster_than_its_limit() -> None:
    rate = 4000.0
    limited = swept(NonlinearRig(SYSTEM, limits=DriveLimits(rate=rate)))
    slopes = np.abs(np.diff(limited.drive_torque)) / TIME_STEP
    assert slopes.max() <= rate * (1 + 1e-9)
    assert np.mean(slopes > 0.999 * rate) > 0.05
    assert np.abs(np.diff(swept(SYSTEM).drive_torque)).max() / TIME_STEP > 1.5 * rate


def test_delay_jitter_has_the_size_and_interval_it_states() -> None:
    """On a torque ramp the drive's lateness is its torque's error over the slope."""
    slope, rms, hold = 50.0, 0.005, 0.02
    steady = replace(FREE, top_drive=replace(FREE.top_drive, delay=0.06))
    time = TIME_STEP * np.arange(steps_in(60.0), dtype=float)

    def lateness(seed: int, jitter: float) -> Floats:
        shaking = replace(steady, top_drive=replace(steady.top_drive, delay_jitter=jitter))
        rig = NonlinearRig(shaking, limits=DriveLimits(jitter_interval=hold))
        result = simulate(rig, slope * time, np.full(time.size, SPEED), 0 * time, sample_interval=TIME_STEP, seed=seed)
        commanded = result.drive_torque[0] + slope * (time + TIME_STEP / 2)
        return np.asarray((commanded - result.drive_torque)[100:] / slope, dtype=float)

    shaken = lateness(1, rms)
    assert shaken.mean() == pytest.approx(0.06, abs=5 * rms / np.sqrt(60 / hold))
    assert shaken.std() == pytest.approx(rms, rel=0.1)
    changes = np.flatnonzero(np.abs(np.diff(shaken)) > 1e-9) + 1
    assert set(np.diff(changes) % round(hold / TIME_STEP)) == {0}
    np.testing.assert_allclose(lateness(1, 0.0), 0.06, atol=1e-9)
    assert np.array_equal(shaken, lateness(1, rms))
    assert not np.array_equal(shaken, lateness(2, rms))


def test_a_coarse_sensor_reads_whole_steps() -> None:
    resolution = 0.05
    result = swept(NonlinearRig(SYSTEM, sensor=SpeedSensor(resolution=resolution)))
    steps = result.speed_reading / resolution
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-9)
    assert np.unique(np.rint(steps)).size > 3
    assert np.abs(result.speed_reading - result.speed).max() <= resolution / 2 * (1 + 1e-9)


def test_ripple_of_the_sensor_is_a_tone_once_per_revolution() -> None:
    """120 rpm is 2 Hz; the control responds to the tone, which thus enters the command."""
    speed, share = 4 * np.pi, 0.01
    time = TIME_STEP * np.arange(steps_in(60.0), dtype=float)
    rig = NonlinearRig(SYSTEM, sensor=SpeedSensor(ripple=share))
    result = simulate(rig, 0 * time, np.full(time.size, speed), np.full(time.size, 4e3), mean_bit_torque=4e3)
    late = result.time >= 20
    spectrum = np.abs(np.fft.rfft(result.speed_reading[late] - result.speed[late])) / (late.sum() / 2)
    frequencies = np.fft.rfftfreq(int(late.sum()), SAMPLE_INTERVAL)
    assert frequencies[spectrum[1:].argmax() + 1] == pytest.approx(120 / 60, abs=1 / 40)
    assert spectrum[1:].max() == pytest.approx(share * speed, rel=0.05)
    assert result.torque_command[late].std() == pytest.approx(1500 * share * speed / np.sqrt(2), rel=0.1)


def test_sampled_control_renews_its_command_at_its_interval() -> None:
    result = swept(NonlinearRig(SYSTEM, control_interval=0.04))
    held = result.torque_command.reshape(-1, round(0.04 / TIME_STEP))
    assert np.ptp(held, axis=1).max() == 0
    assert np.abs(np.diff(held[:, 0])).min() > 0


def test_parts_without_size_change_no_bit() -> None:
    plain = swept(SYSTEM)
    idle = swept(
        NonlinearRig(
            SYSTEM, gear=Gear(0.0, 150.0), limits=DriveLimits(), sensor=SpeedSensor(), control_interval=TIME_STEP
        )
    )
    for name in ("speed", "torque_command", "drive_torque", "bit_speed", "speed_reading", "string_torque"):
        assert getattr(plain, name).tobytes() == getattr(idle, name).tobytes(), name


def test_torque_into_the_string_is_what_the_top_drive_leaves() -> None:
    result = swept(SYSTEM)
    acceleration = np.diff(result.speed) / TIME_STEP
    inertia = TOP_DRIVE.inertia
    np.testing.assert_allclose(result.string_torque[:-1], result.drive_torque[:-1] - inertia * acceleration, rtol=1e-8)


def test_a_course_that_never_changes_is_the_rig() -> None:
    plain, coursed = swept(SYSTEM), swept(lambda time: NonlinearRig(SYSTEM))
    assert plain.speed.tobytes() == coursed.speed.tobytes()


def test_after_a_change_of_regime_the_rig_is_the_new_one() -> None:
    """String, bit, delay and controller change at 20 s; the last sweep period shows the new rig alone."""
    longer = replace(
        SYSTEM,
        top_drive=replace(TOP_DRIVE, delay=0.06, controller=Controller(2000.0, 700.0)),
        string=(replace(SYSTEM.string[0], length=2950.0), SYSTEM.string[1]),
        bit=Bit(60.0, 200.0),
    )
    sweep = multisine(steps_in(PERIOD))
    steady = np.ones(6 * sweep.size)
    result = simulate(
        lambda time: NonlinearRig(SYSTEM if time < 20 else longer),
        np.tile(sweep, 6),
        SPEED * steady,
        4e3 * steady,
        mean_bit_torque=4e3,
        energies=True,
    )
    samples = result.speed.size // 6
    measured = lines_of(result.speed, samples) / lines_of(sweep[:: round(SAMPLE_INTERVAL / TIME_STEP)], samples)
    expected = command_mobility(longer, laplace(FREQUENCIES))
    assert np.max(np.abs(measured - expected) / np.abs(expected)) < 3e-3
    assert closure(result) < 1e-9


def test_friction_that_comes_and_goes_takes_hold_of_a_turning_string() -> None:
    """The wall's torque adds to the string's from 20 s to 40 s; the drive has it again soon after."""
    total = 2.0 * 3000.0

    def course(time: float) -> NonlinearRig:
        grip = np.full(1, 2.0 if 20 <= time < 40 else 0.0)
        contact = WallContact(np.array([0.0, 3000.0]), grip, grip)
        shaking = replace(TOP_DRIVE, delay_jitter=1e-3 if time < 40 else 0.0)
        return NonlinearRig(replace(SYSTEM, top_drive=shaking), contact=contact)

    result = swept(course, amplitude=0.0)
    before, during, after = (result.string_torque[(result.time > a) & (result.time < b)] for a, b in PHASES)
    assert during.mean() - before.mean() == pytest.approx(total, rel=0.05)
    assert after.mean() == pytest.approx(before.mean(), rel=0.05)
    assert closure(result) < 1e-9


def test_a_growing_string_keeps_its_energy_account() -> None:
    def course(time: float) -> NonlinearRig:
        string = (replace(SYSTEM.string[0], length=2900.0 + 0.5 * time), SYSTEM.string[1])
        return NonlinearRig(replace(SYSTEM, string=string))

    result = swept(course)
    assert closure(result) < 1e-9
    assert result.energies is not None
    assert result.energies.parametric != 0


def test_parts_that_appear_in_time_are_refused() -> None:
    with pytest.raises(SettingsError, match="appear or vanish"):
        swept(lambda time: NonlinearRig(SYSTEM, gear=Gear(0.0 if time < 5 else 0.02, 150.0)))


def test_inputs_of_other_lengths_are_refused() -> None:
    with pytest.raises(SettingsError, match="one value for each step"):
        simulate(SYSTEM, np.zeros(10), np.ones(10), np.zeros(9))


def test_a_gear_heavier_than_the_top_drive_is_refused() -> None:
    with pytest.raises(SettingsError, match="no part of the top drive"):
        swept(NonlinearRig(SYSTEM, gear=Gear(0.02, 2000.0)))

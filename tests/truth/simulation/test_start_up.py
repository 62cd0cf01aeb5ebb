"""The field well's start of rotation: laws that hold for any friction."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.field.log import FieldLog, read_field_log
from benchmarks.field.well_b import EQUIPMENT, FRICTION, SURVEY
from drillid.errors import LogError, SettingsError
from drillid.physics.soft_string import Survey
from drillid.simulation.start_up import RATE, StartUp, WellFriction, rig_at, start_up
from drillid.simulation.start_up_files import ramped_speed, read_survey
from drillid.simulation.start_up_fit import misfit
from drillid.units import RPM, STANDARD_GRAVITY

SLIDING = WellFriction(0.1, kappa=3000.0, delta=1e9)


def ramp(seconds: float, speed: float, rise: float = 5.0) -> np.ndarray:
    """Top-drive speed (rad/s) at RATE that rises smoothly from rest."""
    time = np.arange(round(seconds * RATE)) / RATE
    share = np.clip((time - 1.0) / rise, 0.0, 1.0)
    return speed * share**2 * (3 - 2 * share)


def test_steady_rotation_takes_the_sliding_torque_and_the_drag_of_the_whole_string() -> None:
    rig = rig_at(1733.0, SURVEY, EQUIPMENT, SLIDING)
    result = start_up(rig, ramp(60.0, 10.0))
    assert rig.contact is not None
    sliding = float(np.sum(rig.contact.dynamic * np.diff(rig.contact.edges)))
    drag = sum(section.kappa * section.polar_moment * section.length for section in rig.system.string) * 10.0
    assert result.bit_speed[-500:].mean() == pytest.approx(10.0, rel=0.01)
    assert result.torque[-500:].mean() == pytest.approx(sliding + drag, rel=0.01)


def test_a_string_without_friction_takes_momentum_alone() -> None:
    rig = rig_at(1733.0, SURVEY, EQUIPMENT, WellFriction(0.0, delta=1e9))
    result = start_up(rig, ramp(30.0, 8.0))
    inertia = EQUIPMENT.top_drive.inertia + sum(section.inertia for section in rig.system.string)
    assert np.sum(result.torque) / RATE == pytest.approx(inertia * 8.0, rel=0.05)


def test_the_bit_stays_at_rest_until_the_static_torque_is_wound_up() -> None:
    friction = WellFriction(0.1, breakaway=2.0, threshold=0.5)
    rig = rig_at(1733.0, SURVEY, EQUIPMENT, friction)
    result = start_up(rig, ramp(20.0, 6.0))
    assert rig.contact is not None
    static = float(np.sum(rig.contact.static * np.diff(rig.contact.edges)))
    moving = np.flatnonzero(result.bit_speed > 0.05)
    assert moving.size
    # waves may break the bit loose a little before the wound-up torque alone would
    assert result.torque[: moving[0]].max() > 0.7 * static
    assert np.all(np.abs(result.bit_speed[: moving[0] - 5]) < 0.06)


def test_longer_strings_and_heavier_assemblies_take_more() -> None:
    def torque(depth: float, friction: WellFriction) -> float:
        contact = rig_at(depth, SURVEY, EQUIPMENT, friction).contact
        assert contact is not None
        return float(np.sum(contact.static * np.diff(contact.edges)))

    plain = WellFriction(0.2)
    assert torque(2500.0, plain) > torque(1733.0, plain)
    assert torque(1733.0, WellFriction(0.2, assembly_sliding=1.5)) > torque(1733.0, plain)
    assert torque(1733.0, WellFriction(0.2, breakaway=2.0)) == pytest.approx(2 * torque(1733.0, plain))
    inertias = [
        rig_at(1733.0, SURVEY, EQUIPMENT, WellFriction(0.2, assembly_inertia=size)).system.string for size in (1.0, 0.7)
    ]
    assert inertias[1][0].inertia == inertias[0][0].inertia
    assert inertias[1][1].inertia == pytest.approx(0.7 * inertias[0][1].inertia)


def steady_torque(survey: Survey, friction: WellFriction) -> float:
    return float(start_up(rig_at(1733.0, survey, EQUIPMENT, friction), ramp(60.0, 10.0)).torque[-500:].mean())


def test_another_hole_changes_the_torque_by_the_weight_that_it_carries() -> None:
    """In a straight hole at the inclination θ all sliding torque is μ sin θ Σ w r L, w the buoyed weight per length."""
    friction = WellFriction(0.2, kappa=3000.0, delta=1e9)
    torques = [steady_torque(Survey.from_degrees([0, 3000], [angle, angle]), friction) for angle in (0, 20, 50)]
    sections = ((1733.0 - EQUIPMENT.assembly_length, *EQUIPMENT.pipe), *EQUIPMENT.assembly)
    steel = (7850.0 - EQUIPMENT.mud_density) * STANDARD_GRAVITY * np.pi / 4
    carried = sum(steel * (outer**2 - inner**2) * outer / 2 * length for length, outer, inner in sections)
    for angle, torque in ((20, torques[1]), (50, torques[2])):
        assert torque - torques[0] == pytest.approx(0.2 * carried * np.sin(np.radians(angle)), rel=0.01)


def test_friction_of_rest_is_gone_after_long_rotation() -> None:
    plain = WellFriction(0.2, kappa=3000.0, delta=1e9)
    rested = replace(plain, rest=0.5, assembly_rest=0.3, rest_angle=5.0)
    assert steady_torque(SURVEY, rested) == pytest.approx(steady_torque(SURVEY, plain), rel=1e-3)
    kept = replace(plain, rest=0.5, assembly_rest=0.5, rest_angle=1e6)
    assert steady_torque(SURVEY, kept) == pytest.approx(steady_torque(SURVEY, replace(plain, sliding=0.3)), rel=1e-3)


def test_stick_slip_of_the_fitted_well_is_the_same_at_half_the_time_step() -> None:
    rig = rig_at(1733.0, SURVEY, EQUIPMENT, FRICTION)
    coarse, fine = (start_up(rig, ramped_speed(70.0, 15.0, 40.0), step) for step in (0.005, 0.0025))
    sticking = coarse.bit_speed[2500:] == 0
    assert 0.1 < sticking.mean() < 0.7
    size = min(coarse.time.size, fine.time.size)
    assert np.sqrt(np.mean((coarse.torque[:size] - fine.torque[:size]) ** 2)) < 250.0
    assert np.sqrt(np.mean((coarse.bit_speed[:size] - fine.bit_speed[:size]) ** 2)) < 2.0 * RPM


def test_a_record_has_the_middle_of_each_half_second_at_its_end() -> None:
    time = np.arange(400) / RATE
    result = StartUp(time, np.zeros(400), 3.0 * time)
    record = result.recorded_bit_speed()
    middle = np.array([(result.bit_speed[k - 50] + result.bit_speed[k]) / 2 for k in range(50, 400)])
    np.testing.assert_allclose(record[50:], middle, atol=1e-9)


def test_misfits_are_the_rms_deviations_over_measured_samples() -> None:
    flat = np.full(1000, 10 * RPM)
    gap = flat.copy()
    gap[:200] = np.nan
    log = FieldLog(flat, np.full(1000, 5e3), gap - 2 * RPM, gap + 4 * RPM, flat, flat)
    result = misfit(log, np.full(1000, 7e3), flat, 0.0, 9.0)
    assert result.torque_rms == pytest.approx(2.0)
    assert result.bit_rms == pytest.approx(1.0)
    assert result.extremes_rms == pytest.approx(np.sqrt((2**2 + 4**2) / 2))


def test_a_survey_is_read_from_its_sheet(tmp_path: Path) -> None:
    path = tmp_path / "survey.csv"
    path.write_text("depth_m,inclination_deg\n0,0\n1000,30\n")
    survey = read_survey(path)
    assert isinstance(survey, Survey)
    assert survey.inclination[-1] == pytest.approx(np.radians(30))
    path.write_text("depth,inclination_deg\n0,0\n1000,30\n")
    with pytest.raises(LogError, match="depth_m"):
        read_survey(path)


def test_what_makes_no_sense_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SettingsError):
        rig_at(200.0, SURVEY, EQUIPMENT, SLIDING)
    with pytest.raises(SettingsError):
        WellFriction(-0.1)
    with pytest.raises(SettingsError):
        WellFriction(0.1, breakaway=0.5)
    with pytest.raises(SettingsError, match="20 samples"):
        start_up(rig_at(1733.0, SURVEY, EQUIPMENT, SLIDING), np.zeros(20))
    path = tmp_path / "log.csv"
    path.write_text("t_s,td_rpm_measured\n0,0\n")
    with pytest.raises(LogError, match="torque_knm_measured"):
        read_field_log(path)

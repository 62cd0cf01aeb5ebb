"""Laws that hold for every cause of the catalogue."""

from dataclasses import replace

import numpy as np
import pytest

from drillid.arrays import Complex
from drillid.discrepancy.catalogue import CATALOGUE, Cause, OperatingPoint, WindowModel
from drillid.physics.dual_numbers import Dual
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, TopDrive, polar_moment
from drillid.physics.responses import laplace, string_admittance
from drillid.physics.sensor import Recording
from drillid.physics.top_drive import drive

FREQUENCY = np.geomspace(0.05, 5.0, 60)
S = laplace(FREQUENCY)
OPERATING_POINT = OperatingPoint(np.array([[10.0], [14.0]]), np.full((2, 1), 5e3), np.array([[2800.0], [2830.0]]))
LINEAR = [cause for cause in CATALOGUE.values() if (cause.is_linear or cause.time_varying) and not cause.size.fixed]
FEEDS_VIBRATION = {"coulomb_contact", "regenerative_cutting", "stribeck_cutting"}
"""Causes that bring energy into the string."""
ABOVE = {"drive", "control", "sensor"}
"""Families that leave the string as it is."""


def window_model() -> WindowModel:
    pipe = Section(OPERATING_POINT.length, polar_moment(0.1397, 0.1214), 200.0, 2.5e8)
    collars = Section(100.0, polar_moment(0.1651, 0.0714), 200.0, 2.5e8)
    system = DrillingSystem(TopDrive(1100.0, 0.04, Controller(1500.0, 800.0)), (pipe, collars), Bit(40.0, 400.0))
    return WindowModel(system, Recording())


def mobility(cause: Cause, size: object, shape: float) -> Complex:
    result = cause.extend(window_model(), size, shape, OPERATING_POINT).mobility(S)
    return np.asarray(result.value if isinstance(result, Dual) else result)


def shapes() -> list[tuple[Cause, float]]:
    return [(cause, shape) for cause in LINEAR for shape in cause.shapes]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", ["local_damping_zone", "tapered_string", "extra_section"])
def test_a_cause_beside_a_zone_at_the_top_is_finite(name: str) -> None:
    zone, further = CATALOGUE["local_damping_zone"], CATALOGUE[name]
    below = zone.extend(window_model(), 100.0, zone.shapes[0], OPERATING_POINT)
    assert np.all(below.system.string[0].length > 0)
    both = further.extend(below, further.size.typical, further.shapes[0], OPERATING_POINT)
    assert np.all(np.isfinite(both.mobility(S)))


@pytest.mark.parametrize(("cause", "shape"), shapes(), ids=lambda entry: getattr(entry, "name", str(entry)))
def test_size_zero_changes_nothing(cause: Cause, shape: float) -> None:
    base = window_model().mobility(S)
    np.testing.assert_allclose(mobility(cause, 0.0, shape), base, rtol=1e-6)


@pytest.mark.parametrize(("cause", "shape"), shapes(), ids=lambda entry: getattr(entry, "name", str(entry)))
def test_a_size_changes_the_responses(cause: Cause, shape: float) -> None:
    changed = cause.extend(window_model(), cause.size.typical, shape, OPERATING_POINT)
    base = window_model()
    far = (
        np.abs(changed.mobility(S) / base.mobility(S) - 1).max()
        + np.abs(changed.control(S) / base.control(S) - 1).max()
    )
    assert far > 1e-4


def test_what_moves_shows_its_mean_over_the_window() -> None:
    base, before, after = window_model(), 400.0, 1600.0
    ends = [replace(base, system=replace(base.system, bit=Bit(40.0, damping))) for damping in (before, after)]
    jumped = CATALOGUE["regime_change"].extend(base, after - before, 0.6, OPERATING_POINT)
    assert jumped.system.bit.damping == pytest.approx(0.6 * before + 0.4 * after)
    np.testing.assert_allclose(jumped.mobility(S), 0.6 * ends[0].mobility(S) + 0.4 * ends[1].mobility(S))
    drifted = CATALOGUE["parameter_drift"].extend(jumped, 100.0, 0.0, OPERATING_POINT)
    assert drifted.system.bit.damping == pytest.approx(jumped.system.bit.damping + 50.0)


@pytest.mark.parametrize(("cause", "shape"), shapes(), ids=lambda entry: getattr(entry, "name", str(entry)))
def test_derivatives_are_those_of_central_differences(cause: Cause, shape: float) -> None:
    size, step = 0.7 * cause.size.typical, 1e-4 * cause.size.typical
    dual = cause.extend(window_model(), Dual(np.full((1, 1), size), np.ones(1)), shape, OPERATING_POINT).mobility(S)
    difference = (mobility(cause, size + step, shape) - mobility(cause, size - step, shape)) / (2 * step)
    scale = np.abs(difference).max() + 1e-9 * np.abs(mobility(cause, size, shape)).max() / cause.size.typical
    np.testing.assert_allclose(dual.full_tangents()[0] / scale, difference / scale, atol=2e-6)


@pytest.mark.parametrize("coordinate", [-2.0, 0.0, 1.5])
@pytest.mark.parametrize("cause", [cause for cause in LINEAR if cause.shape_is_fitted], ids=lambda cause: cause.name)
def test_derivatives_to_what_is_fitted_of_a_shape(cause: Cause, coordinate: float) -> None:
    size, place, step = cause.size.typical, cause.shapes[len(cause.shapes) // 2], 1e-4
    dual = cause.shaped(Dual(np.full((1, 1), coordinate), np.ones(1)))
    slope = dual.extend(window_model(), size, place, OPERATING_POINT).mobility(S).full_tangents()[0]
    up, down = (mobility(cause.shaped(coordinate + side), size, place) for side in (step, -step))
    scale = np.abs(slope).max()
    np.testing.assert_allclose(slope / scale, (up - down) / (2 * step) / scale, atol=1e-5)


@pytest.mark.parametrize("cause", [cause for cause in LINEAR if cause.shape_is_fitted], ids=lambda cause: cause.name)
def test_the_usual_shape_is_in_the_middle_of_what_is_fitted(cause: Cause) -> None:
    of_cause, of_middle = (mobility(each, cause.size.typical, cause.shapes[0]) for each in (cause, cause.shaped(0.0)))
    np.testing.assert_array_equal(of_cause, of_middle)


@pytest.mark.parametrize("place", [0.02, 0.4, 0.98])
@pytest.mark.parametrize("coordinate", [-2.5, 0.0, 2.5])
def test_a_zone_of_any_width_is_a_part_of_the_pipe(place: float, coordinate: float) -> None:
    size, base = 100.0, window_model().system.string[0]
    changed = CATALOGUE["local_damping_zone"].shaped(coordinate).extend(window_model(), size, place, OPERATING_POINT)
    pieces = changed.system.string[:3]
    assert all(np.all(piece.length >= 0) for piece in pieces)
    np.testing.assert_allclose(sum(piece.length for piece in pieces), base.length)
    added = sum((piece.kappa - base.kappa) * piece.length * piece.polar_moment for piece in pieces)
    # a zone at the bit reaches below that of the shallower window
    assert added[1, 0] == pytest.approx(size)
    assert added[0, 0] == pytest.approx(size) if place < 0.5 else added[0, 0] <= size * (1 + 1e-9)


@pytest.mark.parametrize(("cause", "shape"), shapes(), ids=lambda entry: getattr(entry, "name", str(entry)))
def test_the_string_stays_passive_unless_the_cause_feeds_vibration(cause: Cause, shape: float) -> None:
    size = 0.9 * cause.size.typical
    system = cause.extend(window_model(), size, shape, OPERATING_POINT).system
    loss = string_admittance(system, S).real
    if cause.name in FEEDS_VIBRATION:
        assert loss.min() < string_admittance(window_model().system, S).real.min() + 1e-9
    else:
        assert loss.min() > 0


@pytest.mark.parametrize("cause", [one for one in LINEAR if one.family in ABOVE], ids=lambda cause: cause.name)
def test_causes_above_the_string_leave_it_alone(cause: Cause) -> None:
    changed = cause.extend(window_model(), cause.size.typical, cause.shapes[0], OPERATING_POINT)
    np.testing.assert_array_equal(string_admittance(changed.system, S), string_admittance(window_model().system, S))


@pytest.mark.parametrize("cause", CATALOGUE.values(), ids=lambda cause: cause.name)
def test_an_entry_says_what_it_is(cause: Cause) -> None:
    assert cause.family
    assert cause.port
    assert cause.meaning
    assert cause.separated_by
    assert cause.action.endswith(".")
    assert cause.size.low <= cause.size.high
    assert cause.size.typical > 0
    assert set(cause.looks_like) <= CATALOGUE.keys()


def test_the_catalogue_holds_the_vocabulary_of_verdicts() -> None:
    told = """
        drive_lag actuator_gain torque_limit torque_rate_limit delay_jitter controller_gain speed_filter torque_filter
        speed_scale clock_offset clock_drift quantisation aliased_tone once_per_revolution sign_or_unit recorder_filter
        sample_and_hold gear_backlash extra_section tapered_string local_damping_zone mud_drag hysteretic_damping
        coulomb_contact wave_speed distributed_bha motor_compliance regenerative_cutting stribeck_cutting
        stuck_slip_regimes length_growth parameter_drift regime_change
    """
    assert CATALOGUE.keys() == set(told.split())


@pytest.mark.parametrize(
    ("name", "shape", "size", "factor"),
    [
        ("clock_offset", 0.0, 0.05, np.exp(-0.05 * S)),
        ("speed_scale", 0.0, 0.05, 1.05),
        ("sign_or_unit", -1.0, 1.0, -1.0),
        ("sign_or_unit", 9.5493, 1.0, 9.5493),
        ("recorder_filter", 1.0, 0.03, 1 / (1 + 0.03 * S)),
        ("recorder_filter", 2.0, 0.03, 1 / (1 + np.sqrt(2) * 0.03 * S + (0.03 * S) ** 2)),
    ],
)
def test_faults_of_the_record_multiply_the_mobility(name: str, shape: float, size: float, factor: Complex) -> None:
    """A record that is late by τ shows exp(−sτ), one behind a Butterworth low pass 1/B(s)."""
    ratio = mobility(CATALOGUE[name], size, shape) / window_model().mobility(S)
    np.testing.assert_allclose(ratio, np.broadcast_to(factor, ratio.shape), rtol=1e-6)


@pytest.mark.parametrize("interval", [0.03, 0.3])
def test_a_held_record_is_late_by_a_uniformly_distributed_time(interval: float) -> None:
    ratio = mobility(CATALOGUE["sample_and_hold"], interval, 0.0) / window_model().mobility(S)
    held = (1 - np.exp(-S * interval)) / (S * interval)
    np.testing.assert_allclose(ratio, np.broadcast_to(held, ratio.shape), rtol=1e-6)


@pytest.mark.parametrize(
    ("name", "size", "factor"),
    [("drive_lag", 0.03, 1 / (1 + 0.03 * S)), ("actuator_gain", 0.1, 1.1), ("delay_jitter", 4e-4, np.exp(2e-4 * S**2))],
)
def test_faults_of_the_drive_multiply_its_torque(name: str, size: float, factor: Complex) -> None:
    changed = CATALOGUE[name].extend(window_model(), size, 0.0, OPERATING_POINT).system.top_drive
    ratio = drive(changed, S) / drive(window_model().system.top_drive, S)
    np.testing.assert_allclose(ratio, np.broadcast_to(factor, ratio.shape), rtol=1e-6)

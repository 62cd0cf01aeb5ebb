"""Margins, tuning and the stick-slip map against closed forms and the time-domain simulator."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from drillid.arrays import Complex
from drillid.control.margins import is_stable, margins
from drillid.control.stick_slip import (
    critical_slope,
    lowest_stable_speed,
    simulated_growth,
    simulated_lowest_speed,
    stick_slip_map,
)
from drillid.control.tuning import (
    Family,
    Goal,
    RequiredMargins,
    Tuning,
    bit_vibration,
    controlled_by,
    first_sample,
    in_units,
    sampled_systems,
    tune,
)
from drillid.discrepancy.catalogue import WindowModel
from drillid.errors import EstimationError, SettingsError
from drillid.excitation.torques import coloured_noise
from drillid.figures.control import draw_bit_mobility, draw_stick_slip_map
from drillid.physics.bottom_end import bit_load
from drillid.physics.eight_parameters import drilling_system
from drillid.physics.equipment import (
    Bit,
    Controller,
    DrillingSystem,
    ImpedanceMatching,
    Section,
    StribeckCutting,
    TopDrive,
)
from drillid.physics.modes import modes
from drillid.physics.nonlinear import Cutting, NonlinearRig, Weakening
from drillid.physics.responses import bit_mobility, command_mobility, laplace, torque_mobility
from drillid.physics.sensor import Recording
from drillid.physics.stability import growing_poles, loop_transfer, unstable_poles
from drillid.simulation.simulate import TIME_STEP, simulate
from tests.drawn import check_visible, line
from tests.simulated import DEEP

STIFF = Controller(20000.0, 20000.0)
SOFT = Controller(1500.0, 800.0)
MATCHED = Controller(
    4500.0, 4500.0, matching=ImpedanceMatching(1 / DEEP.pipe.characteristic_admittance, 1105.0, 0.01, 5.0)
)
CUTTING = Cutting(0.06, 0.03, Weakening(6.0))
SPREAD = np.array([0.3, 0.3, 0.01, 0.05, 0.05, 0.01, 0.3, 0.1])
SAMPLES = sampled_systems(DEEP.parameters, np.diag((SPREAD * DEEP.parameters) ** 2), DEEP.known, 8)


@pytest.mark.parametrize(("gain", "delay"), [(2.0, 0.1), (5.0, 0.03), (0.8, 1.2)])
def test_margins_of_an_integrator_with_delay(gain: float, delay: float) -> None:
    """L = K e^(−sT)/s: gain margin π/(2KT), phase margin π/2 − KT, delay margin π/(2K) − T."""
    result = margins(lambda s: gain * np.exp(-s * delay) / s)
    assert result.gain == pytest.approx(np.pi / (2 * gain * delay), rel=1e-3)
    assert result.phase == pytest.approx(np.pi / 2 - gain * delay, abs=1e-3)
    assert result.delay == pytest.approx(np.pi / (2 * gain) - delay, rel=2e-3)
    assert result.gain_reduction == 0.0

    def distance(speed: float) -> float:
        return float(np.abs(1 + gain * np.exp(-1j * speed * delay) / (1j * speed)))

    nearest = minimize_scalar(distance, bounds=(0.1 * gain, 3 / delay), method="bounded")
    assert result.modulus == pytest.approx(nearest.fun, rel=1e-3)
    assert result.sensitivity == pytest.approx(1 / nearest.fun, rel=1e-3)


def test_margins_of_a_first_order_plant_with_delay() -> None:
    """L = K e^(−sT)/(1 + sτ): phase margin π − ωT − atan ωτ at ω = √(K² − 1)/τ; gain margin where the lag is π."""
    gain, lag, delay = np.array([[4.0], [2.0]]), 1.5, 0.2
    result = margins(lambda s: gain * np.exp(-s * delay) / (1 + s * lag))
    crossover = np.sqrt(gain[:, 0] ** 2 - 1) / lag
    np.testing.assert_allclose(result.phase, np.pi - crossover * delay - np.arctan(crossover * lag), atol=2e-3)
    turned = brentq(lambda w: w * delay + np.arctan(w * lag) - np.pi, 0.1, np.pi / delay)
    np.testing.assert_allclose(result.gain, np.hypot(1, turned * lag) / gain[:, 0], rtol=1e-3)


def test_a_lead_at_a_crossover_is_lag_that_a_delay_has_to_use_up_first() -> None:
    """A resonance rises through |L| = 1 with a lead of more than 90° and falls through it with a lag."""

    def loop(s: Complex) -> Complex:
        return np.asarray(0.5 * s**2 / ((s**2 + 0.1 * s + 1) * (1 + s)), dtype=complex)

    found = margins(loop)
    crossovers = np.array([brentq(lambda w: abs(loop(1j * w)) - 1, *ends) for ends in ((0.3, 1.0), (1.0, 5.0))])
    lead, lag = np.angle(loop(1j * crossovers))
    assert lag < 0 < np.pi / 2 < lead
    assert found.phase == pytest.approx(np.pi - lead, rel=2e-3)
    assert found.delay == pytest.approx((np.pi + lag) / crossovers[1], rel=2e-3)
    assert found.delay > found.phase / crossovers[0]


def test_loop_of_a_top_drive_without_string_is_that_of_its_inertia() -> None:
    """With a negligible string L = (P + I/s) e^(−sT)/(J s); a gain margin is lost below as well as above."""
    string = (Section(100.0, 1e-12),)
    system = DrillingSystem(TopDrive(1000.0, 0.05, Controller(2000.0, 1000.0)), string, Bit(1e-6))
    s = laplace(np.geomspace(0.01, 5, 40))
    np.testing.assert_allclose(loop_transfer(system, s), (2000 + 1000 / s) * np.exp(-0.05 * s) / (1000 * s), rtol=1e-6)


@pytest.mark.parametrize("controller", [STIFF, SOFT, MATCHED, replace(MATCHED, speed_filter=0.03, torque_filter=0.02)])
def test_closing_the_loop_gives_the_command_mobility(controller: Controller) -> None:
    """M = D/(J s + Y_in)/(1 + L), impedance matching included, whose L is that at the drive's input."""
    system = controlled_by(DEEP.system, controller)
    s = laplace(np.geomspace(0.01, 8, 300))
    closed = torque_mobility(system, s) / (1 + loop_transfer(system, s))
    np.testing.assert_allclose(closed, command_mobility(system, s), rtol=1e-9)


def amplified(factor: float) -> DrillingSystem:
    controller = Controller(8000.0 * factor, 800.0 * factor)
    return controlled_by(DEEP.system, controller)


def test_nyquist_counts_the_growing_modes() -> None:
    limit = float(margins(lambda s: loop_transfer(amplified(1.0), s)).gain)
    counts = []
    for factor in (1.0, 0.97 * limit, 1.03 * limit):
        system = amplified(factor)
        growing = modes(system, 0.02, 15.0, fastest_growth=30.0).poles.real > 0
        count = int(unstable_poles(partial(loop_transfer, system), integrating=True))
        assert count == 2 * np.count_nonzero(growing)
        counts.append(count)
    assert counts == [0, 0, 2]


@pytest.mark.parametrize(
    "bit",
    [Bit(85.0, -60.0), Bit(85.0, -250.0), Bit(85.0, 0.0, (StribeckCutting(6e3, 3e3, 6.0, 8.0),))],
    ids=["weak", "strong", "Stribeck"],
)
@pytest.mark.parametrize("controller", [STIFF, SOFT])
def test_stability_is_that_of_the_modes_where_the_bit_feeds_vibration(bit: Bit, controller: Controller) -> None:
    """Its motion grows under a constant torque of the drive, in some modes and, as drag is too weak, as a whole."""
    system = replace(controlled_by(DEEP.system, controller), bit=bit)
    free = controlled_by(system, Controller(0.0))
    drag = float(bit_load(bit, laplace(np.full(1, 1e-9)))[0].real)
    drag += sum(section.kappa * section.polar_moment * section.length for section in system.string)

    def growing(which: DrillingSystem) -> int:
        return 2 * int(np.count_nonzero(modes(which, 1e-3, 15.0, fastest_growth=30.0).poles.real > 0))

    assert growing_poles(system) == growing(free) + (drag < 0)
    count = unstable_poles(partial(loop_transfer, system), integrating=True, open_loop=growing_poles(system))
    assert count == growing(system)
    assert is_stable(system) == (growing(system) == 0)


def test_tuned_control_is_stable_where_the_bit_feeds_vibration() -> None:
    system = replace(controlled_by(DEEP.system, SOFT), bit=Bit(85.0, -40.0))
    result = tune(system)
    assert np.all(modes(controlled_by(system, result.controller), 1e-3, 15.0).poles.real < 0)
    assert result.value < result.present


def test_gain_margin_is_where_the_simulated_rig_begins_to_vibrate() -> None:
    limit = float(margins(lambda s: loop_transfer(amplified(1.0), s)).gain)
    growth = [top_drive_growth(NonlinearRig(amplified(factor * limit))) for factor in (0.97, 1.03)]
    assert growth[0] < 0.8
    assert growth[1] > 1.25


def top_drive_growth(rig: NonlinearRig) -> float:
    """Acceleration of the simulated top drive in the last third of 30 s after a pulse, per that in the second."""
    steps = round(30 / TIME_STEP)
    sweep = np.zeros(steps)
    sweep[:200] = 100.0
    result = simulate(rig, sweep, np.full(steps, 10.5), np.zeros(steps))
    early, late = np.array_split(result.speed - 10.5, 3)[1:]
    return float(np.std(np.diff(late)) / np.std(np.diff(early)))


@pytest.mark.parametrize("interval", [0.02, 0.03, 0.05])
def test_a_held_control_has_the_gain_margin_of_its_continuous_system(interval: float) -> None:
    """Within 10 %: a simulated rig whose control holds begins to vibrate there."""
    system = amplified(1.0)
    late = replace(system.top_drive, delay=system.top_drive.delay + interval / 2)
    held = WindowModel(replace(system, top_drive=late), Recording(), control_interval=interval).held()
    limit = float(margins(partial(loop_transfer, held.continuous_system)).gain)
    assert is_stable(held.continuous_system)
    stable, unstable = (NonlinearRig(amplified(factor * limit), control_interval=interval) for factor in (0.9, 1.1))
    assert top_drive_growth(stable) < 0.8
    assert top_drive_growth(unstable) > 1.25


def test_a_loop_that_is_not_finite_is_no_stable_one() -> None:
    with pytest.raises(EstimationError, match="not finite"):
        unstable_poles(lambda s: np.where(s.imag > 100.0, np.nan, 1 / s), integrating=True)


TUNED: list[tuple[Family, Goal]] = [
    ("proportional integral", "peak"),
    ("proportional integral", "decay"),
    ("inertia compensation", "mean square"),
    ("impedance matching", "peak"),
]


@pytest.fixture(scope="module", params=TUNED, ids=[" for ".join(names) for names in TUNED])
def tuning(request: pytest.FixtureRequest) -> tuple[Tuning, Goal]:
    family, goal = request.param
    return tune(controlled_by(SAMPLES, STIFF), family, goal), goal


def test_tuned_control_keeps_its_margins_for_every_sample(tuning: tuple[Tuning, Goal]) -> None:
    result, limits = tuning[0], RequiredMargins()
    assert result.margins.gain.shape == (8,)
    assert np.all(result.margins.gain >= limits.gain)
    assert np.all(result.margins.gain_reduction <= 1 / limits.gain)
    assert np.all(result.margins.phase >= limits.phase)
    assert np.all(result.margins.sensitivity <= limits.sensitivity)
    assert is_stable(controlled_by(SAMPLES, result.controller))


def test_tuned_control_is_better_than_stiff_and_than_its_neighbours(tuning: tuple[Tuning, Goal]) -> None:
    result, goal = tuning
    assert result.value < 0.65 * result.present
    for factor in (0.9, 1.1):
        controller = replace(result.controller, proportional=factor * result.controller.proportional)
        if controller.matching is not None:
            matching = replace(controller.matching, impedance=factor * controller.matching.impedance)
            controller = replace(result.controller, matching=matching)
        candidate = controlled_by(SAMPLES, controller)
        kept = RequiredMargins().shortfall(margins(partial(loop_transfer, candidate))) == 0
        if kept:
            assert np.max(bit_vibration(candidate, goal, (0.05, 3.0))) > 0.999 * result.value


def test_tuned_control_calms_the_simulated_bit(tuning: tuple[Tuning, Goal]) -> None:
    steps = round(240 / TIME_STEP)
    torque = 4000.0 + coloured_noise(np.random.default_rng(5), steps, TIME_STEP, 500.0, 2.0)
    spread = {}
    for name, controller in (("stiff", STIFF), ("tuned", tuning[0].controller)):
        system = controlled_by(DEEP.system, controller)
        result = simulate(system, np.zeros(steps), np.full(steps, 10.5), torque, mean_bit_torque=4000.0)
        spread[name] = float(np.std(result.bit_speed[1000:]))
    assert spread["tuned"] < 0.8 * spread["stiff"]


@pytest.mark.parametrize("goal", ["peak", "mean square", "decay"])
def test_settings_do_not_depend_on_a_present_control_that_is_unstable(goal: Goal) -> None:
    pair = drilling_system(
        np.stack([DEEP.parameters, DEEP.parameters * np.where(SPREAD == 0.01, 0.99, 1.0)]), DEEP.known
    )
    unstable = controlled_by(pair, Controller(50000.0, 10000.0))
    assert not is_stable(unstable)
    found, expected = tune(unstable, goal=goal), tune(controlled_by(pair, SOFT), goal=goal)
    assert found.present == np.inf
    assert np.isfinite(expected.present)
    assert found.value == pytest.approx(expected.value, rel=1e-3)
    assert found.controller.proportional == pytest.approx(expected.controller.proportional, rel=0.02)
    assert found.controller.integral == pytest.approx(expected.controller.integral, rel=0.02)
    assert is_stable(controlled_by(pair, found.controller))


def test_goals_agree_with_their_definitions() -> None:
    system = drilling_system(DEEP.parameters, DEEP.known)
    size = np.abs(bit_mobility(system, laplace(np.linspace(0.05, 3.0, 30000))))
    assert bit_vibration(system, "peak", (0.05, 3.0))[()] == pytest.approx(size.max(), rel=0.01)
    assert bit_vibration(system, "mean square", (0.05, 3.0))[()] == pytest.approx(np.mean(size**2), rel=0.01)


def test_a_peak_between_the_lines_is_found() -> None:
    """Against a grid of 0.01 mHz, of which the narrowest peak spans some dozen lines."""
    length, delta = np.array([[1800.0], [3100.0], [6200.0]]), np.array([[2e8], [2e7], [1e6]])
    system = DrillingSystem(DEEP.top_drive, (Section(length, 1.6e-5, 2.0, delta),), Bit(300.0, 0.2))
    frequency = np.linspace(0.05, 3.0, 295_001)
    for controller in (STIFF, SOFT):
        stiff = controlled_by(system, controller)
        found = bit_vibration(stiff, "peak", (0.05, 3.0))
        sizes = np.abs(bit_mobility(stiff, laplace(frequency)))
        np.testing.assert_allclose(found, sizes.max(axis=-1), rtol=1e-3)
    result = tune(controlled_by(system, STIFF))
    calmed = np.abs(bit_mobility(controlled_by(system, result.controller), laplace(frequency)))
    assert result.value == pytest.approx(calmed.max(), rel=1e-3)


def test_margins_that_no_settings_keep_raise() -> None:
    with pytest.raises(EstimationError, match="no settings keep the margins"):
        tune(controlled_by(SAMPLES, STIFF), required=RequiredMargins(sensitivity=1.0001))


def test_settings_in_the_rigs_units() -> None:
    settings = in_units(MATCHED)
    assert {name: unit for name, (_, unit) in settings.items()} == {
        "proportional": "kN m/rpm",
        "integral": "kN m/rad",
        "impedance": "rpm/(kN m)",
        "low_pass": "s",
        "high_pass": "s",
    }
    assert settings["proportional"][0] == pytest.approx(4.5 * np.pi / 30)
    assert settings["integral"][0] == pytest.approx(4.5)
    assert settings["impedance"][0] == pytest.approx(30 / np.pi * 1000 / DEEP.pipe.characteristic_admittance)
    assert in_units(SOFT, {"proportional": "ft-lbf/rpm"})["proportional"][0] == pytest.approx(
        1500 / 1.3558179483314 * np.pi / 30
    )
    with pytest.raises(SettingsError, match="unit of proportional"):
        in_units(SOFT, {"proportional": "bar"})


def test_samples_stay_within_bounds_and_begin_at_the_fit() -> None:
    lengths = np.asarray(SAMPLES.string[0].length)
    assert lengths.shape == (8, 1)
    assert lengths[0, 0] == DEEP.parameters[2]
    plain = first_sample(SAMPLES)
    assert plain.string[0].length == DEEP.parameters[2]
    assert plain.bit.damping == DEEP.parameters[6]
    assert 0.003 < lengths.std() / lengths.mean() < 0.02
    with pytest.raises(EstimationError, match="outside"):
        sampled_systems(np.full(8, -1.0), np.eye(8) * 1e-6, DEEP.known)


def test_critical_slope_of_a_lossless_string_is_the_damping_of_its_bit() -> None:
    """At a resonance of a clamped lossless string only the bit's own damping dissipates energy."""
    system = DrillingSystem(DEEP.top_drive, (Section(2000.0, 1.6e-5), Section(150.0, 7e-5)), Bit(50.0, 33.0))
    slope, frequency = critical_slope(system, stiff=True)
    assert slope == pytest.approx(33.0, rel=1e-6)
    expected = modes(replace(system, bit=Bit(50.0)), highest=10.3, stiff=True).frequency
    assert np.min(np.abs(expected - frequency)) < 1e-3


def test_several_samples_have_no_single_critical_slope() -> None:
    with pytest.raises(SettingsError, match="first_sample"):
        critical_slope(SAMPLES)
    alone = drilling_system(DEEP.parameters[None], DEEP.known)
    assert critical_slope(alone) == pytest.approx(critical_slope(first_sample(SAMPLES)), rel=1e-12)


@pytest.mark.parametrize("controller", [STIFF, SOFT])
@pytest.mark.parametrize("damping", [-20.0, -60.0, -200.0])
def test_damping_of_the_bit_adds_to_the_critical_slope_even_below_zero(controller: Controller, damping: float) -> None:
    """Damping is a torque that rises with speed; where the sum is below zero, some mode already grows."""
    without, system = (
        replace(controlled_by(DEEP.system, controller), bit=Bit(85.0, value)) for value in (0.0, damping)
    )
    slope, frequency = critical_slope(system)
    assert slope == pytest.approx(critical_slope(without)[0] + damping, rel=1e-6)
    assert frequency == pytest.approx(critical_slope(without)[1])
    assert (slope > 0) == is_stable(system)


def test_a_control_that_makes_the_simulated_rig_vibrate_without_rock_has_no_stable_speed() -> None:
    """Its growing modes at the bit are no matter of the rock, nor is the next mode's limit the rig's."""
    unstable = Controller(50000.0, 10000.0)
    system = controlled_by(DEEP.system, unstable)
    assert top_drive_growth(NonlinearRig(system)) > 1.25
    with pytest.raises(EstimationError, match="unstable without the rock"):
        critical_slope(system)
    found = stick_slip_map(DEEP.system, CUTTING, np.array([5e4, 1e5]), {"unstable": unstable, "soft": SOFT})
    assert np.all(found.speed["unstable"] == np.inf)
    assert np.isnan(found.frequency["unstable"])
    assert np.all(np.isfinite(found.speed["soft"]))
    legend = draw_stick_slip_map(found).axes[0].get_legend_handles_labels()[1]
    assert legend == ["unstable: unstable", f"soft: vibrates at {found.frequency['soft']:.2f} Hz"]


@pytest.mark.parametrize("weight", [5e4, 1e5, 2e5])
def test_lowest_speed_of_an_exponential_law(weight: float) -> None:
    """−T' = W Δ/Ω_s e^(−Ω/Ω_s) = g, so Ω = Ω_s ln(W Δ/(Ω_s g)); without enough weight no speed is unstable."""
    slope = 60.0
    expected = 6.0 * np.log(weight * 0.03 / (6.0 * slope))
    assert lowest_stable_speed(CUTTING, weight, slope) == pytest.approx(expected, rel=1e-9)
    assert lowest_stable_speed(CUTTING, 1.1e4, slope) == 0.0


@pytest.mark.parametrize("controller", [STIFF, SOFT, MATCHED], ids=["stiff", "soft", "matched"])
def test_predicted_lowest_speed_is_the_simulated_one(controller: Controller) -> None:
    """Within 1 %: a small vibration grows 1 % below and decays 1 % above."""
    system, weight = controlled_by(DEEP.system, controller), 1e5
    slope, frequency = critical_slope(system)
    predicted = lowest_stable_speed(CUTTING, weight, slope)
    assert simulated_growth(system, CUTTING, weight, 0.99 * predicted, frequency) > 0
    assert simulated_growth(system, CUTTING, weight, 1.01 * predicted, frequency) < 0


def test_bit_sticks_below_the_lowest_speed_and_turns_steadily_above() -> None:
    """With a torque pulse of 2 % of the bit's own, the bit comes to a stop 10 % below and stays within 5 % above."""
    system, weight = controlled_by(DEEP.system, STIFF), 1e5
    predicted = lowest_stable_speed(CUTTING, weight, critical_slope(system)[0])
    steps = round(240 / TIME_STEP)
    pulse = np.zeros(steps)
    pulse[:200] = 0.02 * weight * CUTTING.static
    slowest = []
    for factor in (0.9, 1.1):
        speed = factor * predicted
        rig = NonlinearRig(system, cutting=CUTTING)
        result = simulate(rig, np.zeros(steps), np.full(steps, speed), pulse, weight_on_bit=weight)
        slowest.append(float(result.bit_speed[-3000:].min()) / speed)
    assert slowest[0] < 0.05
    assert slowest[1] > 0.95


def test_simulated_lowest_speed_is_found_between_two() -> None:
    system, weight = controlled_by(DEEP.system, STIFF), 1e5
    predicted = lowest_stable_speed(CUTTING, weight, critical_slope(system)[0])
    result = simulated_lowest_speed(system, CUTTING, weight, (0.95 * predicted, 1.05 * predicted))
    assert result == pytest.approx(predicted, rel=0.01)
    with pytest.raises(EstimationError, match="keeps its sign"):
        simulated_lowest_speed(system, CUTTING, weight, (1.05 * predicted, 1.1 * predicted))


def test_map_orders_the_controllers_and_is_drawn() -> None:
    controllers = {"stiff": STIFF, "soft": SOFT, "impedance matched": MATCHED}
    result = stick_slip_map(DEEP.system, CUTTING, np.linspace(2e4, 2e5, 10), controllers)
    stiff, soft, matched = (result.speed[name] for name in controllers)
    assert np.all(np.diff(stiff) > 0)
    assert np.all(soft < stiff)
    assert np.all(matched < soft)
    systems = {name: controlled_by(SAMPLES, controller) for name, controller in controllers.items()}
    figures = draw_stick_slip_map(result, {"stiff": (1e5, 12.0)}), draw_bit_mobility(systems, (0.1, 4.0))
    lowest, mobility = (figure.axes[0] for figure in figures)
    assert (lowest.get_xlabel(), lowest.get_ylabel()) == ("Weight on bit [kN]", "Lowest stable speed [rpm]")
    for name, speed in result.speed.items():
        weight, drawn = line(lowest, f"{name}: vibrates at {result.frequency[name]:.2f} Hz")
        np.testing.assert_allclose(weight, result.weight / 1e3)
        np.testing.assert_allclose(drawn, speed * 30 / np.pi)
    assert line(lowest, "_") == (pytest.approx([100.0]), pytest.approx([360 / np.pi]))
    assert mobility.get_ylabel() == "Bit speed per torque [rpm/(kN m)]"
    assert mobility.get_xlabel() == "Frequency [Hz]"
    assert mobility.get_xlim() == (0.1, 4.0)
    for name, system in systems.items():
        frequency, drawn = line(mobility, name)
        exact = np.abs(bit_mobility(first_sample(system), laplace(frequency))) * 30e3 / np.pi
        np.testing.assert_allclose(drawn, exact, rtol=1e-9)
    for figure in figures:
        check_visible(figure)


def test_complex_loops_keep_their_leading_axes() -> None:
    def loop(s: Complex) -> Complex:
        return np.asarray(np.array([[0.5], [40.0]]) * np.exp(-0.1 * s) / s, dtype=complex)

    np.testing.assert_array_equal(unstable_poles(loop, integrating=True), [0, 2])


def test_samples_with_and_without_integral_are_counted_alike() -> None:
    """As each alone, of which the last is unstable."""
    gains = ((1500.0, 0.0), (1500.0, 800.0), (60000.0, 0.0))
    proportional, integral = np.array(gains).T[..., None]
    together = controlled_by(DEEP.system, Controller(proportional, integral))
    alone = [is_stable(controlled_by(DEEP.system, Controller(*each))) for each in gains]
    assert alone == [True, True, False]
    stable = controlled_by(DEEP.system, Controller(proportional[:2], integral[:2]))
    assert is_stable(stable)
    counts = unstable_poles(partial(loop_transfer, together), integrating=integral[:, 0] != 0)
    assert (counts == 0).tolist() == alone

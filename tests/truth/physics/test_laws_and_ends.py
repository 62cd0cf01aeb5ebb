"""One suite over every damping law, end and part: the laws that any of them must obey."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from drillid.physics.bottom_end import chain_through_motor, cutting_admittance
from drillid.physics.damping import (
    ConstantLossFactor,
    DampingLaw,
    HystereticLoss,
    KelvinVoigt,
    RootDrag,
    StokesLayerDrag,
    ViscousWall,
)
from drillid.physics.dual_numbers import derivatives
from drillid.physics.equipment import (
    Bit,
    Controller,
    DrillingSystem,
    ImpedanceMatching,
    Motor,
    RegenerativeCutting,
    Section,
    StribeckCutting,
    TopDrive,
    polar_moment,
)
from drillid.physics.line import chain_matrix, input_admittance, input_impedance
from drillid.physics.lumped import ladder_string_admittance
from drillid.physics.responses import (
    bit_mobility,
    bit_reflection,
    bit_speed_ratio,
    command_mobility,
    laplace,
    string_admittance,
    string_torque,
    top_reflection,
    torque_mobility,
)
from drillid.physics.sensor import sensed
from drillid.physics.strings import tapered, with_zone

S = laplace(np.geomspace(0.05, 5.0, 61))
RIGHT = 0.3 + S
"""Right of the imaginary axis, where step responses are computed."""
PIPE = Section(2600.0, polar_moment(0.1397, 0.1214), kappa=50.0, delta=1e8)
COLLARS = Section(90.0, polar_moment(0.2032, 0.0714), kappa=20.0, delta=1e8)
DRIVE = TopDrive(1100.0, 0.04, Controller(1500.0, 800.0))
BIT = Bit(40.0, 30.0)
PLAIN = DrillingSystem(DRIVE, (PIPE, COLLARS), BIT)
MATCHED = 1 / 430.0


def with_law(law: DampingLaw) -> DrillingSystem:
    pipe = Section(PIPE.length, PIPE.polar_moment, PIPE.kappa, PIPE.delta, laws=(law,))
    return DrillingSystem(DRIVE, (pipe, COLLARS), BIT)


def with_top(lag: Any = 0.0, gain: Any = 1.0, delay: Any = 0.04, jitter: Any = 0.0, **control: Any) -> DrillingSystem:
    controller = Controller(**({"proportional": 1500.0, "integral": 800.0} | control))
    return DrillingSystem(TopDrive(1100.0, delay, controller, lag, gain, jitter), (PIPE, COLLARS), BIT)


def with_bottom(*cutting: RegenerativeCutting | StribeckCutting, motor: Motor | None = None) -> DrillingSystem:
    return DrillingSystem(DRIVE, (PIPE, COLLARS), Bit(40.0, 30.0, cutting), motor)


@dataclass(frozen=True)
class Case:
    """An effect as a function of its parameters, usual values, and values without effect."""

    build: Callable[..., DrillingSystem]
    usual: tuple[float, ...]
    nothing: tuple[float, ...]
    passive: bool = True
    """Whether string and bit only take power."""
    tolerance: float = 1e-12


CASES = {
    "viscous wall": Case(lambda kappa: with_law(ViscousWall(kappa)), (300.0,), (0.0,)),
    "Kelvin-Voigt": Case(lambda delta: with_law(KelvinVoigt(delta)), (3e8,), (0.0,)),
    "hysteretic": Case(lambda eta: with_law(HystereticLoss(eta)), (0.01,), (0.0,)),
    "constant loss factor": Case(lambda eta, f: with_law(ConstantLossFactor(eta, f)), (0.01, 0.5), (0.0, 0.5)),
    "root drag": Case(lambda b: with_law(RootDrag(b)), (200.0,), (0.0,)),
    "mud drag": Case(
        lambda density, viscosity, outer, inner: with_law(StokesLayerDrag(density, viscosity, outer, inner)),
        (1300.0, 0.03, 0.1397, 0.1214),
        (1e-9, 1e-9, 0.1397, 0.1214),
        tolerance=1e-8,
    ),
    "mud drag outside": Case(
        lambda mu: with_law(StokesLayerDrag(1300.0, mu, 0.1397)), (0.03,), (1e-14,), tolerance=1e-5
    ),
    "zone": Case(
        lambda top, length, factor: DrillingSystem(DRIVE, with_zone((PIPE, COLLARS), top, length, factor), BIT),
        (1400.0, 200.0, 20.0),
        (1400.0, 200.0, 1.0),
    ),
    "zone across a joint": Case(
        lambda top, length: DrillingSystem(DRIVE, with_zone((PIPE, COLLARS), top, length, 20.0), BIT),
        (2550.0, 100.0),
        (1400.0, 0.0),
    ),
    "steel": Case(
        lambda density, modulus: DrillingSystem(
            DRIVE, (Section(2600.0, PIPE.polar_moment, 50.0, 1e8, density, modulus), COLLARS), BIT
        ),
        (7700.0, 70e9),
        (7850.0, 79.3e9),
    ),
    "taper": Case(
        lambda below: DrillingSystem(DRIVE, (*tapered(PIPE, below, 6), COLLARS), BIT), (3e-5,), (PIPE.polar_moment,)
    ),
    "extra section": Case(
        lambda length: DrillingSystem(DRIVE, (PIPE, Section(length, 5e-5), COLLARS), BIT), (150.0,), (0.0,)
    ),
    "drive lag": Case(lambda lag: with_top(lag=lag), (0.03,), (0.0,)),
    "actuator gain": Case(lambda gain: with_top(gain=gain), (0.9,), (1.0,)),
    "delay": Case(lambda delay: with_top(delay=delay), (0.07,), (0.04,)),
    "delay jitter": Case(lambda jitter: with_top(jitter=jitter), (0.01,), (0.0,)),
    "scale of the control's sensor": Case(lambda scale: sensed(PLAIN, scale), (1.1,), (1.0,)),
    "controller": Case(lambda p, i: with_top(proportional=p, integral=i), (4e3, 1e3), (1500.0, 800.0)),
    "filters": Case(lambda h, e: with_top(speed_filter=h, torque_filter=e), (0.05, 0.02), (0.0, 0.0)),
    "inertia compensation": Case(
        lambda j, tau: with_top(compensated_inertia=j, compensation_filter=tau), (500.0, 0.1), (0.0, 0.1)
    ),
    "impedance matching": Case(
        lambda z, j, low, high: with_top(matching=ImpedanceMatching(z, j, low, high)),
        (MATCHED, 1100.0, 0.05, 5.0),
        (0.0, 1100.0, 0.05, 5.0),
    ),
    "motor": Case(lambda k, c, j: with_bottom(motor=Motor(k, c, j)), (5e4, 200.0, 30.0), (np.inf, 0.0, 0.0)),
    "regenerative": Case(
        lambda torque, speed, blades: with_bottom(RegenerativeCutting(torque, speed, blades)),
        (4e3, 12.0, 5.0),
        (0.0, 12.0, 5.0),
        passive=False,
    ),
    "Stribeck": Case(
        lambda static, dynamic, threshold, speed, n: with_bottom(StribeckCutting(static, dynamic, threshold, speed, n)),
        (6e3, 4e3, 5.0, 12.0, 1.2),
        (4e3, 4e3, 5.0, 12.0, 1.2),
        passive=False,
    ),
}
RESPONSES: dict[str, Callable[[DrillingSystem, Any], Any]] = {
    "command mobility": command_mobility,
    "torque mobility": torque_mobility,
    "string admittance": string_admittance,
    "string torque": string_torque,
    "bit mobility": bit_mobility,
    "stiff bit mobility": lambda system, s: bit_mobility(system, s, stiff=True),
    "bit speed ratio": bit_speed_ratio,
    "top reflection": top_reflection,
    "bit reflection": bit_reflection,
}
EFFECTS = pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())


@EFFECTS
def test_zero_size_changes_nothing(case: Case) -> None:
    for name, response in RESPONSES.items():
        changed, plain = response(case.build(*case.nothing), S), response(PLAIN, S)
        np.testing.assert_allclose(changed, plain, rtol=case.tolerance * 1e2, err_msg=name)


@EFFECTS
def test_usual_size_changes_something(case: Case) -> None:
    changed = [np.abs(response(case.build(*case.usual), S) / response(PLAIN, S) - 1) for response in RESPONSES.values()]
    assert np.max(changed) > 1e-3


@EFFECTS
def test_every_section_is_reciprocal(case: Case) -> None:
    for section in case.build(*case.usual).string:
        matrix = chain_matrix(section, S)
        np.testing.assert_allclose(np.linalg.det(matrix), 1.0, rtol=0, atol=1e-12 * np.abs(matrix).max() ** 2)


@EFFECTS
def test_passive_parts_never_feed_the_string(case: Case) -> None:
    """Power flows into string and bit at any frequency; only cutting laws feed them."""
    admittance = string_admittance(case.build(*case.usual), S)
    if case.passive:
        assert np.all(admittance.real > 0)
        assert np.all(string_admittance(case.build(*case.usual), RIGHT).real > 0)
    else:
        assert np.any(admittance.real < 0)


@EFFECTS
def test_conjugate_frequencies_give_conjugate_responses(case: Case) -> None:
    system = case.build(*case.usual)
    for name, response in RESPONSES.items():
        for s in (S, RIGHT):
            np.testing.assert_allclose(response(system, s.conj()), response(system, s).conj(), rtol=1e-11, err_msg=name)


@EFFECTS
def test_derivatives_are_exact(case: Case) -> None:
    """Against Cauchy's integral over a circle of complex parameters, exact to rounding inside the nearest pole."""
    usual, corners = np.array(case.usual), np.exp(2j * np.pi * np.arange(32) / 32)
    for name, response in RESPONSES.items():
        value, slopes = derivatives(lambda *values, response=response: response(case.build(*values), S), usual)
        np.testing.assert_allclose(value, response(case.build(*case.usual), S), rtol=1e-12, err_msg=name)
        for row, size in enumerate(usual):
            radius = 1e-3 * size
            circle = []
            for corner in corners:
                values = usual.astype(complex)
                values[row] += radius * corner
                circle.append(response(case.build(*values), S) / corner)
            exact = np.mean(circle, axis=0) / radius
            rounding = 1e-12 * np.abs(value) / radius
            assert np.all(np.abs(slopes[row] - exact) <= 1e-9 * np.abs(exact) + rounding), (name, row)


@EFFECTS
def test_windows_are_computed_at_once(case: Case) -> None:
    """Parameters of shape (windows, 1) give every window its response computed alone."""
    spread = np.array(case.usual)[:, None, None] * np.array([1.0, 1.002, 0.997])[:, None]
    together = command_mobility(case.build(*spread), S)
    for window in range(3):
        alone = command_mobility(case.build(*spread[:, window, 0]), S)
        np.testing.assert_allclose(together[window], alone, rtol=1e-11)


@EFFECTS
def test_the_ladder_converges_to_the_line_with_second_order(case: Case) -> None:
    system, slow = case.build(*case.usual), S[:40]
    exact = string_admittance(system, slow)
    errors = [np.max(np.abs(ladder_string_admittance(system, slow, n) / exact - 1)) for n in (150, 300)]
    assert errors[1] < 0.02
    assert 3.6 < errors[0] / errors[1] < 4.4


@EFFECTS
def test_bit_mobility_agrees_with_the_transfer_matrices(case: Case) -> None:
    """The string solved as one linear system: end conditions and product of the sections' matrices."""
    system = case.build(*case.usual)
    matrix = np.eye(2)
    for section in system.string:
        matrix = matrix @ chain_matrix(section, S)
    if system.motor is not None:
        entries = np.broadcast_arrays(*chain_through_motor(system.motor, S))
        matrix = matrix @ np.moveaxis(np.array(entries).reshape(2, 2, -1), -1, 0)
    load = 40.0 * S + 30.0 + sum(cutting_admittance(law, S) for law in system.bit.cutting)
    speed = matrix[:, 0, 0] + matrix[:, 0, 1] * load
    torque = matrix[:, 1, 0] + matrix[:, 1, 1] * load
    np.testing.assert_allclose(string_admittance(system, S), torque / speed, rtol=1e-9)
    np.testing.assert_allclose(bit_speed_ratio(system, S), 1 / speed, rtol=1e-9)
    # clamped at the top: 0 = m00 ω + m01 T with T = Y_L ω − 1
    np.testing.assert_allclose(bit_mobility(system, S, stiff=True), matrix[:, 0, 1] / speed, rtol=1e-9)


@pytest.mark.parametrize("law", [HystereticLoss(0.02), ConstantLossFactor(0.02, 1.0)], ids=["ideal", "causal"])
def test_structural_laws_lose_the_stated_share(law: DampingLaw) -> None:
    series = PIPE.shear_modulus * PIPE.polar_moment / S + law.series(PIPE, S)
    modulus = series * S / PIPE.polar_moment
    np.testing.assert_allclose(modulus.imag / modulus.real, 0.02, rtol=1e-12)
    at_reference = laplace(np.array([1.0]))
    modulus = (PIPE.shear_modulus * PIPE.polar_moment / at_reference + law.series(PIPE, at_reference)) * at_reference
    np.testing.assert_allclose(modulus / PIPE.polar_moment, PIPE.shear_modulus * (1 + 0.02j), rtol=1e-12)


def test_a_section_split_where_its_law_holds_is_the_same_section() -> None:
    law = StokesLayerDrag(1300.0, 0.03, 0.1397, 0.1214)
    whole, part = (Section(length, PIPE.polar_moment, laws=(law,)) for length in (1000.0, 500.0))
    load = 60 * S + 5
    twice = input_admittance(part, input_admittance(part, load, S), S)
    np.testing.assert_allclose(twice, input_admittance(whole, load, S), rtol=1e-10)
    np.testing.assert_allclose(input_impedance(whole, 1 / load, S), 1 / twice, rtol=1e-10)

"""Laws that any passive torsional line obeys, and closed forms at its limits."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drillid.physics.dual_numbers import Dual
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, TopDrive, polar_moment
from drillid.physics.line import (
    chain_matrix,
    input_admittance,
    input_impedance,
    profile_slopes,
    propagation,
    speed_ratio,
)
from drillid.physics.lumped import ladder_input_admittance
from drillid.physics.responses import bit_mobility, laplace, string_admittance
from drillid.physics.time_responses import bit_step_response

S = laplace(np.geomspace(0.05, 5.0, 61))
SECTIONS = st.builds(
    Section,
    length=st.floats(20, 6000),
    polar_moment=st.floats(2e-6, 2e-4),
    kappa=st.floats(0, 5e3),
    delta=st.floats(0, 1e10),
    density=st.floats(7000, 8500),
    shear_modulus=st.floats(55e9, 85e9),
)
LOADS = st.builds(lambda inertia, damping: inertia * S + damping, st.floats(0, 500), st.floats(0, 1e4))


@settings(max_examples=60, deadline=None)
@given(section=SECTIONS)
def test_reciprocity(section: Section) -> None:
    matrix = chain_matrix(section, S)
    rounding = 1e-12 * np.abs(matrix[..., 0, 0]) ** 2
    assert np.all(np.abs(np.linalg.det(matrix) - 1.0) <= 1e-12 + rounding)


@settings(max_examples=60, deadline=None)
@given(section=SECTIONS, load=LOADS)
def test_a_passive_load_stays_passive_through_a_section(section: Section, load: np.ndarray) -> None:
    admittance = input_admittance(section, load, S)
    assert np.all(admittance.real >= -1e-9 * np.abs(admittance))


@pytest.mark.parametrize("kappa", [-20.0, 20.0])
def test_the_speed_ratio_is_that_of_the_chain_matrix_on_lines_that_feed_too(kappa: float) -> None:
    section = Section(length=3000.0, polar_moment=2e-5, kappa=kappa, delta=0.0, density=7850, shear_modulus=79e9)
    matrix, load = chain_matrix(section, S), 200.0 * S + 300.0
    speed = 1 / (matrix[..., 1, 1] + load * matrix[..., 0, 1])
    np.testing.assert_allclose(speed_ratio(section, load, S), speed, rtol=1e-9)
    assert np.isfinite(speed_ratio(replace(section, kappa=1e5 * kappa), load, S)).all()


@settings(max_examples=60, deadline=None)
@given(section=SECTIONS, load=LOADS)
def test_input_admittance_is_the_chain_matrix_applied(section: Section, load: np.ndarray) -> None:
    top = chain_matrix(section, S) @ np.stack([np.ones_like(load), load], -1)[..., None]
    np.testing.assert_allclose(input_admittance(section, load, S), top[:, 1, 0] / top[:, 0, 0], rtol=1e-6)


@settings(max_examples=60, deadline=None)
@given(section=SECTIONS, load=LOADS, share=st.floats(0.05, 0.95))
def test_a_section_cut_in_two_is_the_same_section(section: Section, load: np.ndarray, share: float) -> None:
    upper = replace(section, length=section.length * share)
    lower = replace(section, length=section.length * (1 - share))
    whole = input_admittance(section, load, S)
    np.testing.assert_allclose(input_admittance(upper, input_admittance(lower, load, S), S), whole, rtol=1e-7)


@settings(max_examples=60, deadline=None)
@given(section=SECTIONS, load=LOADS)
def test_impedance_and_admittance_forms_agree(section: Section, load: np.ndarray) -> None:
    load = load + 1.0
    np.testing.assert_allclose(input_impedance(section, 1 / load, S) * input_admittance(section, load, S), 1, rtol=1e-8)


def test_bit_mobility_is_reciprocal_to_the_string_seen_from_the_other_end() -> None:
    """A string turned upside down: the impedance at the bit becomes that at the top."""
    sections = (Section(1000.0, 1.6e-5, 50.0, 1e8), Section(300.0, 6e-5, 10.0, 2e8))
    drive = TopDrive(1200.0, 0.0, Controller(0.0))
    down = DrillingSystem(drive, sections, Bit(80.0, 20.0))
    turned = DrillingSystem(TopDrive(80.0, 0.0, Controller(20.0)), sections[::-1], Bit(1200.0))
    at_bit = 1 / bit_mobility(down, S)
    np.testing.assert_allclose(at_bit, 80.0 * S + 20.0 + string_admittance(turned, S), rtol=1e-10)


def test_limits_of_a_section() -> None:
    load = 60.0 * S + 5.0
    short = Section(1e-6, 1.6e-5)
    np.testing.assert_allclose(input_admittance(short, load, S), load, rtol=1e-6)
    long_and_lossy = Section(3e5, 1.6e-5, kappa=5e3, delta=1e9)
    np.testing.assert_allclose(input_admittance(long_and_lossy, load, S), propagation(long_and_lossy, S)[1], rtol=1e-8)
    slow = laplace(np.array([1e-5]))
    pipe = Section(3000.0, 1.6e-5)
    np.testing.assert_allclose(input_admittance(pipe, 60.0 * slow, slow), (60.0 + pipe.inertia) * slow, rtol=1e-6)


def test_lossless_modes_of_a_free_string() -> None:
    pipe = Section(3000.0, 1.6e-5)
    wave_speed = np.sqrt(pipe.shear_modulus / pipe.density)
    modes = laplace(np.arange(1, 5) * wave_speed / (2 * pipe.length))
    np.testing.assert_allclose(np.abs(input_admittance(pipe, 0 * modes, modes)), 0, atol=1e-9)


def test_the_ladder_converges_to_the_line_with_second_order() -> None:
    pipe, load = Section(2000.0, 1.6e-5, 100.0, 3e8), 80.0 * S + 20.0
    exact = input_admittance(pipe, load, S)
    errors = [np.max(np.abs(ladder_input_admittance(pipe, load, S, n) / exact - 1)) for n in (400, 800, 1600)]
    assert errors[-1] < 2e-3
    np.testing.assert_allclose(np.log2([errors[0] / errors[1], errors[1] / errors[2]]), 2, atol=0.1)


def test_one_element_is_the_lumped_two_inertia_model() -> None:
    pipe, load = Section(1500.0, 1.6e-5), 80.0 * S + 20.0
    half, stiffness = pipe.inertia / 2, pipe.shear_modulus * pipe.polar_moment / pipe.length
    below = load + half * S
    np.testing.assert_allclose(
        ladder_input_admittance(pipe, load, S, 1),
        half * S + below * (stiffness / S) / (below + stiffness / S),
        rtol=1e-12,
    )


@pytest.mark.parametrize("stiff", [True, False])
def test_step_response_settles_at_the_static_bit_mobility(stiff: bool) -> None:
    """With P control alone a steady bit torque slows the bit by torque over all damping; a clamped string stops it."""
    pipe, bit = Section(800.0, polar_moment(0.127, 0.1086), kappa=4e3, delta=2e8), Bit(100.0, 200.0)
    system = DrillingSystem(TopDrive(1000.0, 0.03, Controller(1500.0)), (pipe,), bit)
    _, bit_speed = bit_step_response(system, duration=60.0, interval=0.1, stiff=stiff)
    assert bit_speed[0] == 0
    resistance = pipe.polar_moment * np.sqrt(pipe.density * pipe.shear_modulus) + 200.0
    assert bit_speed[1] == pytest.approx(-np.expm1(-resistance * 0.1 / 100.0) / resistance, rel=0.02)
    static = 0.0 if stiff else float(bit_mobility(system, laplace(np.array([1e-7])))[0].real)
    assert bit_speed[-1] == pytest.approx(static, abs=1e-3 * np.abs(bit_speed).max())


def test_reflection_returns_after_twice_the_travel_time() -> None:
    pipe, bit = Section(3000.0, 1.6e-5, 0.0, 1e8), Bit(5.0)
    clamped = DrillingSystem(TopDrive(1.0, 0.0, Controller(0.0)), (pipe,), bit)
    lags, bit_speed = bit_step_response(clamped, duration=4.0, interval=0.01, stiff=True)
    wave_speed = np.sqrt(pipe.shear_modulus / pipe.density)
    before, after = bit_speed[(lags > 0.2) & (lags < 1.75)], bit_speed[(lags > 2.1) & (lags < 3.5)]
    characteristic = pipe.polar_moment * np.sqrt(pipe.density * pipe.shear_modulus)
    np.testing.assert_allclose(before, 1 / characteristic, rtol=0.005)
    np.testing.assert_allclose(after, -1 / characteristic, rtol=0.02)
    crossing = lags[1:][np.diff(np.sign(bit_speed)) < 0][0]
    rise = 3 * bit.inertia / characteristic
    assert 0 <= crossing - 2 * pipe.length / wave_speed <= rise


def test_derivatives_of_the_input_admittance_are_those_of_its_chain_matrix() -> None:
    s, names = laplace(np.linspace(0.1, 5.0, 7)), ("length", "polar_moment", "kappa", "delta", "density")
    section = Section(1500.0, 1.5e-5, 120.0, 2e8, 7850.0)
    load = 60.0 + 40.0 * s

    def admittance(own: Section, end: np.ndarray) -> np.ndarray:
        gamma, characteristic = propagation(own, s)
        tangent = np.tanh(gamma * own.length)
        return characteristic * (end + characteristic * tangent) / (characteristic + end * tangent)

    dual = {name: Dual(getattr(section, name), np.eye(6)[place]) for place, name in enumerate(names)}
    end = Dual(load, np.eye(6)[5])
    described = replace(section, **dual)
    found, expected = input_admittance(described, end, s), admittance(described, end)
    assert np.array_equal(found.value, expected.value)
    slopes, stepwise = found.full_tangents(), expected.full_tangents()
    assert np.all(np.abs(slopes - stepwise).max(axis=1) < 1e-12 * np.abs(stepwise).max(axis=1))
    (alone,) = input_admittance(section, end, s).full_tangents()[5:]
    assert alone == pytest.approx(stepwise[5], rel=1e-12)


@pytest.mark.parametrize("periods", [1, 4])
@pytest.mark.parametrize("wave", [np.cos, np.sin])
@pytest.mark.parametrize("kappa", [-20.0, 100.0])
def test_slopes_to_the_profile_are_differences_of_a_cascade_of_thin_sections(
    periods: int, wave: np.ufunc, kappa: float
) -> None:
    count, step, most = 1000, 1e-4, 5
    pipe, load = Section(3000.0, 1.2e-5, kappa, 1e7), 50.0 + 300.0 * S
    shape = wave(2 * np.pi * periods * (np.arange(count) + 0.5) / count)

    def admittance(change: float) -> np.ndarray:
        below = load
        for share in shape[::-1]:
            below = input_admittance(Section(3.0, 1.2e-5 * (1 + change * share), kappa, 1e7), below, S)
        return below

    expected = (admittance(step) - admittance(-step)) / (2 * step)
    found = profile_slopes(pipe, load, S, most)[periods - 1 + most * (wave is np.sin)]
    assert np.max(np.abs(found - expected)) < 1e-4 * np.max(np.abs(expected))

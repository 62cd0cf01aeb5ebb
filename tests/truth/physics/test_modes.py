"""Modes against closed forms, a state-space ladder, a published well and the paper's Table 1."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from drillid.arrays import Floats
from drillid.errors import EstimationError, SettingsError
from drillid.physics.attachments import MountedInertia, with_law
from drillid.physics.damping import HystereticLoss, StokesLayerDrag
from drillid.physics.dual_numbers import primal
from drillid.physics.eight_parameters import KnownEquipment, drilling_system
from drillid.physics.equipment import (
    Bit,
    Controller,
    DrillingSystem,
    ImpedanceMatching,
    Motor,
    RegenerativeCutting,
    Section,
    Shaping,
    StribeckCutting,
    TopDrive,
    polar_moment,
)
from drillid.physics.modes import characteristic_function, modes, pole_derivatives
from drillid.physics.parameters import PARAMETERS
from drillid.physics.responses import command_mobility
from drillid.physics.time_responses import bit_impulse_response

REFERENCE = Path(__file__).parents[4] / "shared" / "reference"
FREE = TopDrive(0.0, 0.0, Controller(0.0))
DRIVE = TopDrive(1100.0, 0.04, Controller(1500.0, 800.0))
MATCHED = TopDrive(
    1100.0, 0.1, Controller(4800.0, 4800.0, matching=ImpedanceMatching(2.5e-4, 1100.0, low_pass=0.2, high_pass=5.0))
)
PIPE = Section(3000.0, 1.6e-5)
WAVE_SPEED = np.sqrt(PIPE.shear_modulus / PIPE.density)


def test_lossless_clamped_and_free_strings() -> None:
    clamped = modes(DrillingSystem(FREE, (PIPE,), Bit(0.0)), stiff=True)
    quarter = WAVE_SPEED / (4 * PIPE.length)
    np.testing.assert_allclose(clamped.frequency, quarter * np.arange(1, 5 / quarter, 2), rtol=1e-12)
    np.testing.assert_allclose(clamped.poles.real, 0, atol=1e-10)
    free = modes(DrillingSystem(FREE, (PIPE,), Bit(0.0)))
    np.testing.assert_allclose(free.frequency, 2 * quarter * np.arange(1, 2.5 / quarter), rtol=1e-12)
    np.testing.assert_allclose(free.damping_ratio, 0, atol=1e-10)


def test_damped_string_has_the_poles_of_its_quadratic() -> None:
    """ρs² + (κ + k²δ) s + k²G = 0 for each wave number k of a clamped–free string."""
    pipe = Section(3000.0, 1.6e-5, 2e3, 2e9)
    result = modes(DrillingSystem(FREE, (pipe,), Bit(0.0)), stiff=True)
    wave_number = np.pi / (2 * pipe.length) * np.arange(1, 2 * result.poles.size, 2)
    exact = [np.roots([pipe.density, pipe.kappa + k * k * pipe.delta, k * k * pipe.shear_modulus]) for k in wave_number]
    np.testing.assert_allclose(result.poles, [roots[roots.imag > 0][0] for roots in exact], rtol=1e-10)
    assert result.frequency[-1] > 4.5


def test_hysteretic_string_has_half_the_loss_factor_as_damping_ratio() -> None:
    pipe = Section(3000.0, 1.6e-5, laws=(HystereticLoss(0.02),))
    result = modes(DrillingSystem(FREE, (pipe,), Bit(0.0)), stiff=True)
    np.testing.assert_allclose(result.damping_ratio, np.sin(np.arctan(0.02) / 2), rtol=1e-9)


def test_lossless_modes_with_a_bit() -> None:
    """Roots of J ω = Y₀ cot(ωL/c), bracketed one by one."""
    from scipy.optimize import brentq

    bit = Bit(120.0)
    result = modes(DrillingSystem(FREE, (PIPE,), bit), stiff=True)
    travel, y0 = PIPE.length / WAVE_SPEED, PIPE.characteristic_admittance
    exact = [
        brentq(lambda w: bit.inertia * w * np.sin(w * travel) - y0 * np.cos(w * travel), a + 1e-9, a + np.pi / travel)
        for a in np.pi / travel * np.arange(result.poles.size)
    ]
    np.testing.assert_allclose(result.poles.imag, exact, rtol=1e-11)


def state_space(system: DrillingSystem, elements: int) -> Floats:
    """Matrix of the ladder: speeds and spring torques, twist of the controller's integral; no drive delay."""
    nodes = elements * len(system.string) + 1
    inertia, viscous, stiffness, coupling = (np.zeros(nodes) for _ in range(4))
    for index, section in enumerate(system.string):
        width = section.length / elements
        for node in range(index * elements, (index + 1) * elements):
            inertia[[node, node + 1]] += section.density * section.polar_moment * width / 2
            viscous[[node, node + 1]] += section.kappa * section.polar_moment * width / 2
            stiffness[node] = section.shear_modulus * section.polar_moment / width
            coupling[node] = section.delta * section.polar_moment / width
    control = system.top_drive.controller
    inertia[0] += system.top_drive.inertia
    viscous[0] += control.proportional
    inertia[-1] += system.bit.inertia
    viscous[-1] += system.bit.damping
    segment = np.eye(nodes)[:-1] - np.eye(nodes)[1:]
    damping = np.diag(viscous) + segment.T @ np.diag(coupling[:-1]) @ segment
    spring = segment.T @ np.diag(stiffness[:-1]) @ segment
    spring[0, 0] += control.integral
    return np.block(
        [
            [np.zeros((nodes, nodes)), np.eye(nodes)],
            [-spring / inertia[:, None], -damping / inertia[:, None]],
        ]
    )


def test_modes_are_the_eigenvalues_of_a_fine_ladder() -> None:
    sections = (Section(2400.0, 1.6e-5, 800.0, 6e8), Section(240.0, 1.2e-4, 300.0, 3e8))
    system = DrillingSystem(TopDrive(1100.0, 0.0, Controller(1500.0, 800.0)), sections, Bit(60.0, 30.0))
    result = modes(system, highest=1.9)
    values = [np.linalg.eigvals(state_space(system, n)) for n in (40, 80)]
    in_band = [v[(v.imag > 2 * np.pi * 0.02) & (v.imag < 3.8 * np.pi)] for v in values]
    coarse, fine = (v[np.argsort(v.imag)] for v in in_band)
    assert fine.size == result.poles.size
    # errors fall with the number of elements squared; taken out to the next order
    np.testing.assert_allclose(fine + (fine - coarse) / 3, result.poles, rtol=1e-4)


def test_modes_of_a_published_synthetic_well() -> None:
    """Aarsnes and Shor 2018, figure 8: clamped–free modes of pipe and collars."""
    pipe = Section(2500.0 - 230.0, polar_moment(0.146529, 0.123024), shear_modulus=61e9)
    collars = Section(230.0, 8.494e-5, shear_modulus=67e9)
    result = modes(DrillingSystem(FREE, (pipe, collars), Bit(0.0)), highest=2.0, stiff=True)
    np.testing.assert_allclose(result.frequency, [0.226, 0.730, 1.293, 1.879], atol=0.0006)


@pytest.mark.skipif(not REFERENCE.exists(), reason=f"the reference tables are not at {REFERENCE}")
def test_modes_of_table_1_row_a() -> None:
    """Dips of |M| are the clamped string's modes, peaks those of the controlled rig; damping shifts either a little."""
    row = pd.read_csv(REFERENCE / "table1.csv").set_index("measurement").loc["A"][list(PARAMETERS)]
    system = drilling_system(row.to_numpy(float), KnownEquipment(Controller(1500.0, 800.0)))
    dips = modes(system, highest=1.9, stiff=True).frequency
    np.testing.assert_allclose(dips, [0.155, 0.471, 0.796, 1.128, 1.466, 1.808], rtol=0.015)
    peaks = modes(system, highest=1.6).frequency
    np.testing.assert_allclose(peaks[-3:], [0.815, 1.156, 1.505], rtol=0.015)


RICH = DrillingSystem(
    DRIVE,
    (
        Section(2600.0, 1.6e-5, 100.0, 2e8, laws=(StokesLayerDrag(1200.0, 0.02, 0.1397),)),
        Section(100.0, 1.5e-4, 50.0, 2e8),
    ),
    Bit(40.0, 30.0),
    Motor(3e5, 50.0, 20.0),
)


@pytest.mark.parametrize("shaping", [None, Shaping(pole_1=0.04, pole_2=(2 * np.pi) ** -2)])
@pytest.mark.parametrize("top_drive", [DRIVE, MATCHED], ids=["plain", "matched"])
def test_every_mode_is_a_pole_and_none_is_missed(shaping: Shaping | None, top_drive: TopDrive) -> None:
    """Newton's method from a dense grid of starts finds no other pole in the rectangle."""
    system = replace(RICH, top_drive=replace(top_drive, shaping=shaping))
    result = modes(system)
    np.testing.assert_allclose(1 / np.abs(command_mobility(system, result.poles)), 0, atol=1e-6)
    start = (np.arange(-12.0, 0.0, 2.0)[:, None] + 2j * np.pi * np.arange(0.05, 5.0, 0.05)).ravel()
    step = 1e-7
    with np.errstate(all="ignore"):
        for _ in range(40):
            value, ahead = characteristic_function(system, start), characteristic_function(system, start + step)
            start = start - value * step / (ahead - value)
    inside = (start.real > -20) & (start.real < 5) & (start.imag > 0.13) & (start.imag < 31.4)
    assert inside.sum() > 50
    nearest = np.min(np.abs(start[inside][:, None] - result.poles), axis=1)
    converged = np.abs(characteristic_function(system, start[inside])) < 1e-6 * DRIVE.inertia
    np.testing.assert_allclose(nearest[converged], 0, atol=1e-5)


def test_modes_beside_a_mounted_inertia_are_refused_as_they_could_be_missed() -> None:
    string = with_law(RICH.string, 1000.0, MountedInertia(100.0, 1.0, 0.1))
    with pytest.raises(EstimationError, match="resonance of its own"):
        modes(replace(RICH, string=string))


def test_bands_join_without_loss() -> None:
    whole = modes(RICH).poles
    parts = [modes(RICH, *band).poles for band in ((0.02, 1.0), (1.0, 2.63), (2.63, 5.0))]
    np.testing.assert_allclose(np.concatenate(parts), whole, rtol=1e-12)


@pytest.mark.parametrize(
    "law", [StribeckCutting(8e3, 3e3, 8.0, 9.0), RegenerativeCutting(8e3, 9.0, 5)], ids=["Stribeck", "regenerative"]
)
def test_cutting_feeds_the_first_mode_of_a_stiff_rig(law: StribeckCutting | RegenerativeCutting) -> None:
    pipe = Section(2600.0, 1.6e-5, 50.0, 1e8)
    stiff = TopDrive(1100.0, 0.04, Controller(40e3, 20e3))
    assert modes(DrillingSystem(stiff, (pipe,), Bit(150.0, 20.0))).damping_ratio[0] > 0
    assert modes(DrillingSystem(stiff, (pipe,), Bit(150.0, 20.0, (law,)))).damping_ratio[0] < 0


def test_the_slowest_mode_is_what_an_impulse_leaves() -> None:
    pipe = Section(1500.0, 1.6e-5, 20.0, 1e9)
    system = DrillingSystem(DRIVE, (pipe,), Bit(150.0, 5.0))
    first = modes(system, stiff=True).poles[0]
    lags, speed = bit_impulse_response(system, 60.0, 0.01, stiff=True)
    late = (lags > 25) & (lags < 30)
    both = np.stack([np.exp(first * lags[late]).real, np.exp(first * lags[late]).imag], -1)
    residual = np.linalg.lstsq(both, speed[late])[1]
    assert residual[0] < 1e-6 * np.sum(speed[late] ** 2)


def build(length: Any, polar: Any, kappa: Any, inertia: Any, delay: Any, gain: Any) -> DrillingSystem:
    pipe = Section(length, polar, kappa, 3e8)
    return DrillingSystem(TopDrive(1100.0, delay, Controller(gain, 800.0)), (pipe,), Bit(inertia, 20.0))


@pytest.mark.parametrize("stiff", [True, False])
def test_derivatives_of_a_pole(stiff: bool) -> None:
    """Against modes solved anew beside the point, good to about 1e-7."""
    point = np.array([2600.0, 1.6e-5, 100.0, 150.0, 0.04, 1500.0])
    pole = modes(build(*point), highest=1.5, stiff=stiff).poles[2]
    slopes = pole_derivatives(build, point, pole, stiff=stiff)
    for row, size in enumerate(point):
        moved = []
        for sign in (1, -1):
            beside = point.copy()
            beside[row] += sign * 1e-4 * size
            moved.append(modes(build(*beside), highest=1.5, stiff=stiff).poles[2])
        difference = (moved[0] - moved[1]) / (2e-4 * size)
        assert abs(slopes[row] - difference) <= 1e-5 * abs(difference) + 1e-9 * abs(pole) / size
    assert primal(slopes[4]) == 0 or not stiff


def test_derivatives_of_the_poles_of_many_windows_are_those_of_each() -> None:
    points = np.array([[1800.0, 1.6e-5, 100.0, 150.0, 0.04, 1500.0], [3400.0, 1.9e-5, 300.0, 50.0, 0.03, 3500.0]])
    poles = modes(build(*points.T[..., None]), highest=2.9).poles
    slopes = pole_derivatives(build, points, poles)
    assert slopes.shape == (*poles.shape, 6)
    for row, point in enumerate(points):
        for column, pole in enumerate(poles[row]):
            if np.isnan(pole):
                assert np.all(np.isnan(slopes[row, column]))
            else:
                np.testing.assert_allclose(slopes[row, column], pole_derivatives(build, point, pole), rtol=1e-10)
    assert np.isnan(poles).any()


def test_a_mode_on_the_edge_of_the_band_is_refused() -> None:
    quarter = WAVE_SPEED / (4 * PIPE.length)
    with pytest.raises(EstimationError, match="boundary"):
        modes(DrillingSystem(FREE, (PIPE,), Bit(0.0)), lowest=quarter, stiff=True)


def test_modes_of_several_windows_are_those_of_each() -> None:
    """Windows with different numbers of modes, whose length and inertia vary along axes of their own."""
    lengths, inertias = np.array([1800.0, 3400.0]), np.array([20.0, 90.0, 300.0])
    law = StokesLayerDrag(1200.0, np.array([[0.02], [0.05]])[:, None], 0.1397)
    pipe = Section(lengths[:, None, None], 1.6e-5, 100.0, 2e8, laws=(law,))
    result = modes(DrillingSystem(DRIVE, (pipe,), Bit(inertias[:, None], 30.0)), highest=3.0)
    assert result.poles.shape[:2] == (2, 3)
    for row, length in enumerate(lengths):
        for column, inertia in enumerate(inertias):
            own_pipe = Section(length, 1.6e-5, 100.0, 2e8, laws=(StokesLayerDrag(1200.0, (0.02, 0.05)[row], 0.1397),))
            alone = modes(DrillingSystem(DRIVE, (own_pipe,), Bit(inertia, 30.0)), highest=3.0)
            count = alone.poles.size
            np.testing.assert_allclose(result.poles[row, column, :count], alone.poles, rtol=1e-12)
            assert np.all(np.isnan(result.frequency[row, column, count:]))
            assert np.all(np.isnan(result.damping_ratio[row, column, count:]))
    assert np.isnan(result.poles[0, 0, -1])
    assert not np.isnan(result.poles[1]).all(axis=0).any()


def test_quantities_that_vary_along_frequency_are_refused() -> None:
    several = Section(np.array([2000.0, 2500.0]), 1.6e-5)
    with pytest.raises(SettingsError, match="shape"):
        modes(DrillingSystem(DRIVE, (several,), Bit(60.0)))

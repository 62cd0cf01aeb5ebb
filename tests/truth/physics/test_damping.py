"""Stokes' mud drag against mpmath, its limits and the flow itself; the causal structural law in time."""

import mpmath
import numpy as np
import pytest

from drillid.arrays import Complex, Floats
from drillid.errors import SettingsError
from drillid.physics.damping import ConstantLossFactor, DampingLaw, HystereticLoss, RootDrag, StokesLayerDrag
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, TopDrive
from drillid.physics.responses import bit_speed_ratio, laplace
from drillid.physics.time_responses import bit_step_response, inverse_laplace

PIPE = Section(3000.0, 1.6e-5)
DENSITY, VISCOSITY, OUTER, INNER = 1300.0, 0.04, 0.1397, 0.1214
S = laplace(np.array([0.05, 0.4, 1.7, 5.0]))


@pytest.mark.parametrize("viscosity", [1e-3, 0.04, 5.0])
def test_mud_drag_agrees_with_forty_digit_bessel_functions(viscosity: float) -> None:
    drag = StokesLayerDrag(DENSITY, viscosity, OUTER, INNER).shunt(PIPE, S)
    with mpmath.workdps(40):
        for value, s in zip(drag, S, strict=True):
            layer = mpmath.sqrt(DENSITY * mpmath.mpmathify(complex(s)) / viscosity)
            a, c = mpmath.mpf(OUTER) / 2, mpmath.mpf(INNER) / 2
            outside = 2 + layer * a * mpmath.besselk(0, layer * a) / mpmath.besselk(1, layer * a)
            inside = layer * c * mpmath.besseli(0, layer * c) / mpmath.besseli(1, layer * c) - 2
            exact = complex(2 * mpmath.pi * viscosity * (a**2 * outside + c**2 * inside))
            assert abs(value / exact - 1) < 1e-11


def oscillating_flow(nodes: Floats, fixed: dict[int, float], s: complex) -> Complex:
    """Swirl u(r) of ρ s u = μ d/dr(1/r d(r u)/dr) by finite volumes, with u fixed at some nodes."""
    count = nodes.size
    matrix, right = np.zeros((count, count), dtype=complex), np.zeros(count, dtype=complex)
    middles, gaps = (nodes[1:] + nodes[:-1]) / 2, np.diff(nodes)
    for i in range(count):
        if i in fixed:
            matrix[i, i], right[i] = 1.0, fixed[i]
            continue
        # angular momentum between middles: r² times shear stress μ r d(u/r)/dr on both faces
        below, above = middles[i - 1] ** 3 / gaps[i - 1], middles[i] ** 3 / gaps[i]
        inertia = DENSITY * s * nodes[i] ** 2 * (middles[i] - middles[i - 1])
        matrix[i, i - 1] = VISCOSITY * below / nodes[i - 1]
        matrix[i, i + 1] = VISCOSITY * above / nodes[i + 1]
        matrix[i, i] = -VISCOSITY * (below + above) / nodes[i] - inertia
    return np.linalg.solve(matrix, right)


def test_mud_drag_is_the_torque_of_the_flow() -> None:
    """Navier–Stokes for swirl, solved on a grid: torque = stress on the wall times lever times circumference."""
    s = complex(S[1])
    depth, radius = np.sqrt(VISCOSITY / (DENSITY * abs(s))), OUTER / 2
    nodes = radius + 25 * depth * np.linspace(0, 1, 700) ** 1.5
    flow = oscillating_flow(nodes, {0: radius, 699: 0.0}, s)
    # one-sided second-order derivative of u/r at the wall
    turning, (h1, h2) = flow[:3] / nodes[:3], nodes[1:3] - nodes[0]
    slope = (-turning[0] * (h2**2 - h1**2) + turning[1] * h2**2 - turning[2] * h1**2) / (h1 * h2 * (h2 - h1))
    torque = -2 * np.pi * radius**3 * VISCOSITY * slope
    expected = StokesLayerDrag(DENSITY, VISCOSITY, OUTER).shunt(PIPE, np.array([s]))[0]
    assert abs(torque / expected - 1) < 2e-3


def test_limits_of_mud_drag() -> None:
    fast = 1e8 * S
    high = 2 * np.pi * ((OUTER / 2) ** 3 + (INNER / 2) ** 3) * np.sqrt(DENSITY * VISCOSITY * fast)
    np.testing.assert_allclose(StokesLayerDrag(DENSITY, VISCOSITY, OUTER, INNER).shunt(PIPE, fast), high, rtol=1e-4)
    root_law = RootDrag(2 * np.pi * (OUTER / 2) ** 3 * np.sqrt(DENSITY * VISCOSITY) / PIPE.polar_moment)
    np.testing.assert_allclose(
        StokesLayerDrag(DENSITY, VISCOSITY, OUTER).shunt(PIPE, fast), root_law.shunt(PIPE, fast), rtol=1e-4
    )
    honey = StokesLayerDrag(DENSITY, 1e7, OUTER).shunt(PIPE, S)
    np.testing.assert_allclose(honey, 4 * np.pi * 1e7 * (OUTER / 2) ** 2, rtol=1e-4)
    bore = StokesLayerDrag(DENSITY, 1e4, OUTER, INNER).shunt(PIPE, S) - StokesLayerDrag(DENSITY, 1e4, OUTER).shunt(
        PIPE, S
    )
    np.testing.assert_allclose(bore, DENSITY * np.pi / 2 * (INNER / 2) ** 4 * S, rtol=1e-3)


PASSIVE_STRING = TopDrive(1000.0, 0.0, Controller(0.0))


@pytest.mark.parametrize(
    "law", [None, ConstantLossFactor(0.05), StokesLayerDrag(DENSITY, VISCOSITY, OUTER), RootDrag(300.0)]
)
def test_laws_are_causal(law: DampingLaw | None) -> None:
    """The bit stands still until the wave of a speed step at the top, at 1 s, has come down."""
    pipe = Section(3000.0, 1.6e-5, kappa=50.0, laws=(law,) if law else ())
    system = DrillingSystem(PASSIVE_STRING, (pipe,), Bit(80.0))

    def transform(s: Complex) -> Complex:
        return bit_speed_ratio(system, s) / s * np.exp(-s) / (1 + 0.05 * s) ** 2

    lags, speed = inverse_laplace(transform, 8.0, 0.02)
    assert np.abs(speed[lags < 1.5]).max() < 1e-6 * np.abs(speed).max()
    assert np.abs(speed[lags > 2.2]).max() > 0.5


def test_the_ideal_structural_law_has_no_response_in_time() -> None:
    pipe = Section(3000.0, 1.6e-5, laws=(HystereticLoss(0.01),))
    with pytest.raises(SettingsError, match="ConstantLossFactor"):
        bit_step_response(DrillingSystem(PASSIVE_STRING, (pipe,), Bit(80.0)), 4.0, 0.01)

"""Cutting laws against cutting itself, the motor against its equations of motion."""

import mpmath
import numpy as np
import pytest
from scipy.optimize import brentq

from drillid.physics.bottom_end import above_motor, below_motor, bit_load, cutting_admittance
from drillid.physics.equipment import Bit, Motor, RegenerativeCutting, StribeckCutting
from drillid.physics.responses import laplace

S = laplace(np.geomspace(0.05, 5.0, 31))


@pytest.mark.parametrize("frequency", [0.1, 0.7, 2.3, 4.9])
def test_regenerative_bit_against_its_blades(frequency: float) -> None:
    """Each blade's depth of cut from the time at which the blade ahead was there, solved for a wobbling bit.

    torque = T₀ · delay/(mean delay), as depth of cut is rate of penetration times delay.
    """
    law = RegenerativeCutting(4e3, 11.0, 5)
    omega, amplitude = 2 * np.pi * frequency, 1e-5
    blade_angle, mean_delay = 2 * np.pi / law.blades, 2 * np.pi / (law.blades * law.speed)

    def angle(time: float) -> float:
        return law.speed * time + amplitude * np.sin(omega * time)

    times = np.arange(48) / 48 / frequency
    delays = np.array(
        [
            brentq(lambda d, t=t: angle(t) - angle(t - d) - blade_angle, mean_delay / 2, mean_delay * 2, xtol=1e-15)
            for t in times
        ]
    )
    torque = law.torque * delays / mean_delay
    turning = np.exp(-1j * omega * times)
    speed = amplitude * omega * np.cos(omega * times)
    measured = np.mean((torque - torque.mean()) * turning) / np.mean(speed * turning)
    expected = cutting_admittance(law, laplace(np.array([frequency])))[0]
    assert abs(measured / expected - 1) < 1e-3


def test_slow_change_of_speed_at_a_set_rate_of_penetration() -> None:
    """T = constant/Ω, so dT/dΩ = −T/Ω."""
    law = RegenerativeCutting(4e3, 11.0, 5)
    slope = cutting_admittance(law, laplace(np.array([1e-5])))[0]
    assert slope == pytest.approx(-4e3 / 11.0, rel=1e-4)


@pytest.mark.parametrize("exponent", [1.0, 2.5])
def test_stribeck_slope(exponent: float) -> None:
    law = StribeckCutting(6e3, 4e3, 5.0, 7.0, exponent)

    def torque(speed: mpmath.mpf) -> mpmath.mpf:
        return 4000 + 2000 * mpmath.exp(-((speed / 5) ** exponent))

    assert float(mpmath.diff(torque, 7)) == pytest.approx(float(cutting_admittance(law, S)), rel=1e-10)


def test_laws_of_cutting_add_up() -> None:
    laws = (RegenerativeCutting(3e3, 9.0, 6), StribeckCutting(2e3, 1e3, 4.0, 9.0))
    total = bit_load(Bit(50.0, 10.0, laws), S)
    parts = 50.0 * S + 10.0 + cutting_admittance(laws[0], S) + cutting_admittance(laws[1], S)
    np.testing.assert_allclose(total, parts, rtol=1e-14)


def test_motor_against_its_equations_of_motion() -> None:
    """Housing and bit as two bodies joined by spring and damper, seen from above and from below."""
    motor, load, above = Motor(5e4, 300.0, 40.0), 60.0 * S + 25.0, 300.0 + 500.0 * S
    spring = 5e4 / S + 300.0
    seen_from_above, seen_from_below = [], []
    for s, y, k, top in zip(S, load, spring, above, strict=True):
        bodies = np.array([[40.0 * s + k, -k], [-k, y + k]])
        seen_from_above.append(1 / np.linalg.solve(bodies, [1, 0])[0])
        bodies = np.array([[top + 40.0 * s + k, -k], [-k, k]])
        seen_from_below.append(np.linalg.solve(bodies, [0, 1])[1])
    np.testing.assert_allclose(above_motor(motor, load, S), seen_from_above, rtol=1e-11)
    np.testing.assert_allclose(below_motor(motor, 1 / above, S), seen_from_below, rtol=1e-11)

"""Exact derivatives of the model against 40-digit arithmetic on the paper's equations, written anew."""

import mpmath
import numpy as np
import pytest

from drillid.errors import SettingsError
from drillid.physics.eight_parameters import KnownEquipment, command_mobility_with_derivatives, drilling_system
from drillid.physics.equipment import STEEL_DENSITY, STEEL_SHEAR_MODULUS, Controller, ImpedanceMatching
from drillid.physics.parameters import PARAMETERS
from drillid.physics.responses import command_mobility, laplace

FREQUENCIES = np.array([0.05, 0.3, 1.1, 4.7])
POINTS = [
    np.array([100.0, 3e8, 2700.0, 1.6e-5, 0.04, 1100.0, 20.0, 180.0]),
    np.array([1.0, 2e9, 8000.0, 6e-6, 0.1, 300.0, 2000.0, 60.0]),
]
EQUIPMENT = {
    "uniform": KnownEquipment(Controller(1500.0, 800.0)),
    "filtered": KnownEquipment(Controller(1500.0, 800.0, speed_filter=0.05, torque_filter=0.02)),
    "collars with a lump": KnownEquipment(Controller(1500.0, 800.0), 40.0, 1.2e-4),
    "collars thinned out": KnownEquipment(Controller(1500.0, 800.0), 120.0, 3e-4),
}


def by_the_paper(parameters: list[mpmath.mpf], equipment: KnownEquipment, frequency: float) -> mpmath.mpc:
    kappa, delta, length, polar, delay, inertia_td, damping, inertia = parameters
    s = mpmath.mpc(0, 2 * mpmath.pi * mpmath.mpf(float(frequency)))
    alpha, beta = STEEL_DENSITY * s + kappa, STEEL_SHEAR_MODULUS / s + delta
    carried = min(inertia, mpmath.mpf(equipment.collar_inertia))
    sections = [(length, polar)]
    if equipment.collar_length:
        sections.append((mpmath.mpf(equipment.collar_length), carried / (STEEL_DENSITY * equipment.collar_length)))
    matrix = mpmath.eye(2)
    for section_length, section_polar in sections:
        angle = mpmath.sqrt(alpha / beta) * section_length
        y0 = section_polar * mpmath.sqrt(alpha * beta)
        matrix = matrix * mpmath.matrix(
            [[mpmath.cosh(angle), mpmath.sinh(angle) / y0], [y0 * mpmath.sinh(angle), mpmath.cosh(angle)]]
        )
    load = (inertia - (carried if equipment.collar_length else 0)) * s + damping
    speed, torque = matrix[0, 0] + matrix[0, 1] * load, matrix[1, 0] + matrix[1, 1] * load
    control = equipment.controller
    feedback = (control.proportional + control.integral / s) / (
        (1 + s * control.speed_filter) * (1 + s * control.torque_filter)
    )
    drive = mpmath.exp(-s * delay)
    return drive / (inertia_td * s + torque / speed + drive * feedback)


@pytest.mark.parametrize("equipment", EQUIPMENT.values(), ids=EQUIPMENT.keys())
@pytest.mark.parametrize("point", POINTS, ids=["usual", "long and damped"])
def test_mobility_and_derivatives(point: np.ndarray, equipment: KnownEquipment) -> None:
    mobility, derivatives = command_mobility_with_derivatives(point, equipment, laplace(FREQUENCIES))
    with mpmath.workdps(40):
        for column, frequency in enumerate(FREQUENCIES):
            exact = [mpmath.mpf(float(value)) for value in point]
            value = by_the_paper(exact, equipment, frequency)
            assert abs(complex(value) / mobility[column] - 1) < 1e-12
            for row, parameter in enumerate(exact):
                step = parameter * mpmath.mpf("1e-15")
                up, down = list(exact), list(exact)
                up[row], down[row] = parameter + step, parameter - step
                slope = (by_the_paper(up, equipment, frequency) - by_the_paper(down, equipment, frequency)) / (2 * step)
                rounding = 1e-14 * abs(mobility[column]) / point[row]
                error = abs(complex(slope) - derivatives[row, column])
                assert error <= 1e-9 * abs(complex(slope)) + rounding, list(PARAMETERS)[row]


def test_windows_are_computed_at_once() -> None:
    equipment = EQUIPMENT["collars with a lump"]
    together = command_mobility_with_derivatives(np.stack(POINTS), equipment, laplace(FREQUENCIES))
    for row, point in enumerate(POINTS):
        alone = command_mobility_with_derivatives(point, equipment, laplace(FREQUENCIES))
        np.testing.assert_allclose(together[0][row], alone[0], rtol=1e-13)
        np.testing.assert_allclose(together[1][row], alone[1], rtol=1e-13)
        composed = command_mobility(drilling_system(point, equipment), laplace(FREQUENCIES))
        np.testing.assert_allclose(alone[0], composed, rtol=1e-12)


def test_feedback_of_the_string_torque_is_refused() -> None:
    with pytest.raises(SettingsError, match="string's torque"):
        KnownEquipment(Controller(1500.0, 800.0, matching=ImpedanceMatching(2e-3, 1100.0)))

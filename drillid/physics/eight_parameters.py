"""The paper's model: eight parameters → drilling system, response and exact derivatives."""

from dataclasses import dataclass

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.errors import SettingsError
from drillid.physics.equipment import (
    STEEL_DENSITY,
    STEEL_SHEAR_MODULUS,
    Bit,
    Controller,
    DrillingSystem,
    Section,
    TopDrive,
)
from drillid.physics.kernel import TransmissionLine, line_of, mobilities
from drillid.physics.parameters import PARAMETERS
from drillid.physics.top_drive import control


@dataclass(frozen=True)
class KnownEquipment:
    """Equipment that the fit takes as known: the controller and, where the tally lists them, the collars.

    Collars are a section of their own between pipe and bit. They carry BHA inertia up to
    their own; an excess is lumped at the bit, a deficit reduces their polar moment, so that the
    model stays passive for every positive BHA inertia.
    """

    controller: Controller
    collar_length: float = 0.0
    """m; 0 without collars."""
    collar_polar_moment: float = 0.0
    """m⁴."""

    def __post_init__(self) -> None:
        if self.controller.matching is not None:
            raise SettingsError(
                "eight-parameter model",
                "it has no feedback of the string's torque",
                "Compose the model with drillid.physics.responses and drillid.physics.dual_numbers.derivatives",
            )

    @property
    def collar_inertia(self) -> float:
        """Inertia of the collars, kg m²."""
        return STEEL_DENSITY * self.collar_polar_moment * self.collar_length


def drilling_system(parameters: Floats, equipment: KnownEquipment) -> DrillingSystem:
    """The system of parameters of shape (..., 8); its quantities have shape (..., 1) for broadcasting."""
    kappa, delta, length, polar, delay, inertia_td, damping_bha, inertia_bha = np.moveaxis(
        np.asarray(parameters, dtype=float)[..., None], -2, 0
    )
    string = [Section(length, polar, kappa, delta)]
    collar_polar, lump = _split_inertia(inertia_bha, equipment)
    if equipment.collar_length > 0:
        string.append(Section(equipment.collar_length, collar_polar, kappa, delta))
    return DrillingSystem(TopDrive(inertia_td, delay, equipment.controller), tuple(string), Bit(lump, damping_bha))


def _split_inertia(inertia_bha: Floats, equipment: KnownEquipment) -> tuple[Floats, Floats]:
    carried = np.minimum(inertia_bha, equipment.collar_inertia)
    per_length = STEEL_DENSITY * equipment.collar_length
    return carried / per_length if per_length else np.zeros_like(carried), inertia_bha - carried


def compiled_line(equipment: KnownEquipment, s: Complex) -> TransmissionLine:
    """Inputs of the compiled model from the known equipment and s of shape (frequency,)."""
    collars = (equipment.collar_length, equipment.collar_polar_moment, equipment.collar_inertia)
    return line_of(s, control(equipment.controller, s), STEEL_DENSITY * s, STEEL_SHEAR_MODULUS / s, collars)


def command_mobility_with_derivatives(
    parameters: Floats, equipment: KnownEquipment, s: Complex
) -> tuple[Complex, Complex]:
    """Command mobility and its derivative to each of the eight parameters.

    Parameters
    ----------
    parameters : shape (..., 8), in the order of `drillid.physics.parameters.PARAMETERS`
    s : shape (frequency,), without negative real part

    Returns
    -------
    mobility : shape (..., frequency), rad/(N m s)
    derivatives : shape (..., 8, frequency)
    """
    values = np.asarray(parameters, dtype=float)
    points = np.ascontiguousarray(values.reshape(-1, len(PARAMETERS)))
    mobility = np.empty((len(points), s.size), dtype=complex)
    derivatives = np.empty((len(points), len(PARAMETERS), s.size), dtype=complex)
    mobilities(points, compiled_line(equipment, s), mobility, derivatives)
    shape = values.shape[:-1]
    return mobility.reshape(*shape, s.size), derivatives.reshape(*shape, len(PARAMETERS), s.size)

"""The paper's model: eight parameters → drilling system, response and exact derivatives."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
from drillid.physics.line import Complex
from drillid.physics.top_drive import control
from drillid.schema import PARAMETERS

Floats = NDArray[np.float64]
KAPPA, DELTA, LENGTH, POLAR_MOMENT, DELAY, INERTIA_TD, DAMPING_BHA, INERTIA_BHA = range(len(PARAMETERS))


@dataclass(frozen=True)
class KnownEquipment:
    """What the fit takes as given: the controller and, where the tally lists them, the collars.

    Collars are a section of their own between pipe and bit. They carry BHA inertia up to
    their own; what is over is lumped at the bit, what is missing thins them out, so that the
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
                "it knows no controller that feeds the string's torque back",
                "Compose the model with drillid.physics.responses and drillid.physics.dual.derivatives",
            )

    @property
    def collar_inertia(self) -> float:
        """Inertia of the collars, kg m²."""
        return STEEL_DENSITY * self.collar_polar_moment * self.collar_length


def drilling_system(parameters: Floats, known: KnownEquipment) -> DrillingSystem:
    """The system that parameters of shape (..., 8) describe; its figures have shape (..., 1) for broadcasting."""
    kappa, delta, length, polar, delay, inertia_td, damping_bha, inertia_bha = np.moveaxis(
        np.asarray(parameters, dtype=float)[..., None], -2, 0
    )
    string = [Section(length, polar, kappa, delta)]
    collar_polar, lump = _split_inertia(inertia_bha, known)
    if known.collar_length > 0:
        string.append(Section(known.collar_length, collar_polar, kappa, delta))
    return DrillingSystem(TopDrive(inertia_td, delay, known.controller), tuple(string), Bit(lump, damping_bha))


def _split_inertia(inertia_bha: Floats, known: KnownEquipment) -> tuple[Floats, Floats]:
    carried = np.minimum(inertia_bha, known.collar_inertia)
    per_length = STEEL_DENSITY * known.collar_length
    return carried / per_length if per_length else np.zeros_like(carried), inertia_bha - carried


def command_mobility_with_derivatives(parameters: Floats, known: KnownEquipment, s: Complex) -> tuple[Complex, Complex]:
    """Command mobility and its derivative to each of the eight parameters.

    Parameters
    ----------
    parameters : shape (..., 8), in the order of `drillid.schema.PARAMETERS`
    s : shape (frequency,)

    Returns
    -------
    mobility : shape (..., frequency), rad/(N m s)
    derivatives : shape (..., 8, frequency)
    """
    columns = np.moveaxis(np.asarray(parameters, dtype=float)[..., None], -2, 0)
    kappa, delta, length, polar, delay, inertia_td, damping_bha, inertia_bha = columns
    alpha, beta = STEEL_DENSITY * s + kappa, STEEL_SHEAR_MODULUS / s + delta
    gamma, specific = np.sqrt(alpha / beta), np.sqrt(alpha * beta)
    wave = _Wave(
        gamma, specific, 1 / (2 * gamma * beta), beta / (2 * specific), -gamma / (2 * beta), alpha / (2 * specific)
    )

    collar_polar, lump = _split_inertia(inertia_bha, known)
    load = _Admittance.of_bit(lump * s + damping_bha, s, inertia_bha >= known.collar_inertia)
    if known.collar_length > 0:
        thinned = inertia_bha < known.collar_inertia
        per_inertia = np.where(thinned, 1 / (STEEL_DENSITY * known.collar_length), 0.0)
        load = load.through(wave, known.collar_length, collar_polar, {INERTIA_BHA: per_inertia})
    load = load.through(wave, length, polar, {POLAR_MOMENT: np.ones_like(polar)}, free_length=True)

    delayed = np.exp(-s * delay)
    total = inertia_td * s + load.value + delayed * control(known.controller, s)
    mobility = delayed / total
    derivatives = np.zeros((*np.broadcast_shapes(mobility.shape), len(PARAMETERS)), dtype=complex)
    for index, derivative in load.derivatives.items():
        derivatives[..., index] = -mobility / total * derivative
    derivatives[..., INERTIA_TD] = -mobility / total * s
    derivatives[..., DELAY] = -s * mobility * (inertia_td * s + load.value) / total
    return mobility, np.moveaxis(derivatives, -1, -2)


@dataclass(frozen=True)
class _Wave:
    """γ and √(αβ) with their derivatives to κ and δ."""

    gamma: Complex
    specific: Complex
    gamma_kappa: Complex
    specific_kappa: Complex
    gamma_delta: Complex
    specific_delta: Complex


@dataclass(frozen=True)
class _Admittance:
    """An admittance with its derivatives, by parameter index."""

    value: Complex
    derivatives: dict[int, Complex]

    @staticmethod
    def of_bit(load: Complex, s: Complex, lumped: NDArray[np.bool_]) -> "_Admittance":
        return _Admittance(load, {DAMPING_BHA: np.ones_like(load), INERTIA_BHA: np.where(lumped, s, 0)})

    def through(
        self,
        wave: _Wave,
        length: Floats | float,
        polar: Floats,
        polar_derivatives: dict[int, Floats],
        *,
        free_length: bool = False,
    ) -> "_Admittance":
        """Input admittance of a section that carries this one as its load."""
        tangent = np.tanh(wave.gamma * length)
        own = polar * wave.specific
        numerator, denominator = self.value + own * tangent, own + self.value * tangent
        by_load = own**2 * (1 - tangent**2) / denominator**2
        by_own = (numerator * denominator + own * (tangent * denominator - numerator)) / denominator**2
        by_phase = own * (own * denominator - numerator * self.value) / denominator**2 * (1 - tangent**2)
        derivatives = {index: by_load * derivative for index, derivative in self.derivatives.items()}

        def add(index: int, derivative: Complex) -> None:
            derivatives[index] = derivatives.get(index, 0) + derivative

        add(KAPPA, by_own * polar * wave.specific_kappa + by_phase * length * wave.gamma_kappa)
        add(DELTA, by_own * polar * wave.specific_delta + by_phase * length * wave.gamma_delta)
        for index, derivative in polar_derivatives.items():
            add(index, by_own * wave.specific * derivative)
        if free_length:
            add(LENGTH, by_phase * wave.gamma)
        return _Admittance(own * numerator / denominator, derivatives)

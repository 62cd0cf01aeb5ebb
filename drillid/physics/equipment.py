"""Description of the equipment, from which both the linear model and the time-domain simulator are built.

Any quantity may be an array that broadcasts against the Laplace variable, so that one
description covers many windows, or a `drillid.physics.dual_numbers.Dual`, which carries exact
derivatives through every response; the simulator takes floats only.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, TypeVar

import numpy as np

from drillid.errors import SettingsError
from drillid.physics.damping import DampingLaw

Quantity = Any
"""A float, an array of floats that broadcasts against s, or a Dual."""

STEEL_DENSITY = 7850.0
"""ρ, kg/m³."""
STEEL_SHEAR_MODULUS = 79.3e9
"""G, Pa."""

Part = TypeVar("Part")


def polar_moment(outer_diameter: float, inner_diameter: float) -> float:
    """Polar moment of a pipe's cross section, IP = π/32 (OD⁴ − ID⁴), in m⁴ from diameters in m."""
    return float(np.pi / 32 * (outer_diameter**4 - inner_diameter**4))


@dataclass(frozen=True)
class Section:
    """A uniform length of the string.

    length m, polar_moment m⁴, kappa N s/m⁴ (viscous damping of mud and wall), delta N s/m²
    (internal damping), density kg/m³, shear_modulus Pa, further damping laws.
    """

    length: Quantity
    polar_moment: Quantity
    kappa: Quantity = 0.0
    delta: Quantity = 0.0
    density: Quantity = STEEL_DENSITY
    shear_modulus: Quantity = STEEL_SHEAR_MODULUS
    laws: tuple[DampingLaw, ...] = ()

    @property
    def inertia(self) -> Quantity:
        """Inertia of the whole section, kg m²."""
        return self.density * self.polar_moment * self.length

    @property
    def characteristic_admittance(self) -> Quantity:
        """IP √(ρG), Y₀ of the section without damping, N m s/rad."""
        return self.polar_moment * np.sqrt(self.density * self.shear_modulus)


@dataclass(frozen=True)
class ImpedanceMatching:
    """String torque lowers the set point by Z F(s) T_string, so that the top drive absorbs waves.

    T_string is estimated from the drive's torque as T_m − J s ω. Under a stiff controller and a fast
    drive the top then has the admittance 1/Z, whatever its inertia. F(s) is a low pass
    1/(1 + s τ_low) and, so that the mean torque does not lower the mean speed, a high pass
    s τ_high/(1 + s τ_high).
    """

    impedance: Quantity
    """Z, rad/(N m s): 1/Y₀ of the pipe to match it; 0 switches the matching off."""
    inertia: Quantity
    """J that the controller assumes, kg m²."""
    low_pass: Quantity = 0.0
    """τ_low, s."""
    high_pass: Quantity | None = None
    """τ_high, s; None passes the mean."""


@dataclass(frozen=True)
class Shaping:
    """A rational factor (1 + b₁ s + b₂ s²)/(1 + a₁ s + a₂ s²) of a transfer; stable where a₁ and a₂ are positive."""

    zero_1: Quantity = 0.0
    """b₁, s."""
    zero_2: Quantity = 0.0
    """b₂, s²."""
    pole_1: Quantity = 0.0
    """a₁, s."""
    pole_2: Quantity = 0.0
    """a₂, s²."""

    def factor(self, s: Any) -> Any:
        """The factor, dimensionless."""
        return (1 + s * (self.zero_1 + s * self.zero_2)) / self.denominator(s)

    def denominator(self, s: Any) -> Any:
        """1 + a₁ s + a₂ s²."""
        return 1 + s * (self.pole_1 + s * self.pole_2)


@dataclass(frozen=True)
class Controller:
    """Speed control A(s) = P + I/s − J_c s/(1 + s τ_c), behind the filters of speed, H, and of torque, E.

    H(s) = 1/(1 + s τ_H) and E(s) = 1/(1 + s τ_E).
    """

    proportional: Quantity
    """P, N m s/rad."""
    integral: Quantity = 0.0
    """I, N m/rad."""
    speed_filter: Quantity = 0.0
    """τ_H, s."""
    torque_filter: Quantity = 0.0
    """τ_E, s."""
    compensated_inertia: Quantity = 0.0
    """J_c, kg m²: part of the top drive's inertia that torque in phase with acceleration compensates."""
    compensation_filter: Quantity = 0.0
    """τ_c, s."""
    matching: ImpedanceMatching | None = None
    """Feedback of the string's torque."""
    shaping: Shaping | None = None
    """Further factor of A."""


@dataclass(frozen=True)
class TopDrive:
    """Inertia J_td (kg m²), driven with the delay T_d (s), a first-order lag (s) and an actuator gain."""

    inertia: Quantity
    delay: Quantity
    controller: Controller
    lag: Quantity = 0.0
    gain: Quantity = 1.0
    """Torque per commanded torque at low frequency."""
    delay_jitter: Quantity = 0.0
    """s, root mean square of a normal variation of the delay."""
    shaping: Shaping | None = None
    """Further factor of D."""
    hold_variance: Quantity = 0.0
    """s², addition to the variance of the delay by control that samples and holds, as in
    `drillid.physics.held_control`."""
    hold_skewness: Quantity = 0.0
    """s³, addition to its third cumulant."""
    hold_higher: tuple[Quantity, Quantity] = (0.0, 0.0)
    """s⁴ and s⁵, additions to its fourth and fifth."""


@dataclass(frozen=True)
class Motor:
    """A mud motor between string and bit: the inertia of its housing, and below it a spring with a damper."""

    stiffness: Quantity
    """N m/rad; infinite for a rigid joint."""
    damping: Quantity = 0.0
    """N m s/rad, in parallel with the spring."""
    inertia: Quantity = 0.0
    """kg m², of the housing, at the string's lower end."""


@dataclass(frozen=True)
class RegenerativeCutting:
    """A bit each of whose blades cuts the rock left by the blade ahead, linearised at a mean torque and speed."""

    torque: Quantity
    """Mean cutting torque T₀, N m."""
    speed: Quantity
    """Mean bit speed Ω, rad/s."""
    blades: Quantity
    """Number of blades n."""


@dataclass(frozen=True)
class StribeckCutting:
    """Torque that falls from static to dynamic with bit speed: T_d + (T_s − T_d) exp(−(Ω/Ω_s)^n)."""

    static: Quantity
    """T_s, N m."""
    dynamic: Quantity
    """T_d, N m."""
    threshold: Quantity
    """Ω_s, rad/s."""
    speed: Quantity
    """Mean bit speed Ω, rad/s."""
    exponent: Quantity = 1.0
    """n; a large exponent approaches a jump at the threshold."""


@dataclass(frozen=True)
class Bit:
    """The lower end: a lumped inertia (kg m²) with viscous damping (N m s/rad) and cutting laws."""

    inertia: Quantity
    damping: Quantity = 0.0
    cutting: tuple[RegenerativeCutting | StribeckCutting, ...] = ()


@dataclass(frozen=True)
class DrillingSystem:
    """Top drive, string from top to bottom, mud motor where there is one, bit."""

    top_drive: TopDrive
    string: tuple[Section, ...]
    bit: Bit
    motor: Motor | None = None


def window_shape(part: Any) -> tuple[int, ...]:
    """Shape of the windows that a part describes; () where all quantities are plain numbers.

    Raises
    ------
    SettingsError
        If the last axis of a quantity, that of frequency, is not of length 1.
    """
    shapes = [np.shape(quantity) for quantity in _quantities(part) if np.ndim(quantity) > 0]
    for shape in shapes:
        if shape[-1] != 1:
            raise SettingsError(
                "equipment", f"a quantity has the shape {shape}", "Give an array of windows the shape (..., 1)"
            )
    return np.broadcast_shapes(*(shape[:-1] for shape in shapes))


def of_window(part: Part, index: tuple[int, ...], shape: tuple[int, ...]) -> Part:
    """The part of one window in plain numbers.

    Parameters
    ----------
    part : any dataclass of quantities, laws and parts, or a tuple of them
    index, shape : the window's, of `window_shape`
    """

    def select(value: Any) -> Any:
        if is_dataclass(value) and not isinstance(value, type):
            instance: Any = value
            return replace(instance, **{field.name: select(getattr(value, field.name)) for field in fields(value)})
        if isinstance(value, tuple):
            return tuple(select(item) for item in value)
        return np.broadcast_to(value, (*shape, 1))[index].item() if np.ndim(value) > 0 else value

    selected: Part = select(part)
    return selected


def _quantities(part: Any) -> Iterator[Any]:
    if is_dataclass(part) and not isinstance(part, type):
        for field in fields(part):
            yield from _quantities(getattr(part, field.name))
    elif isinstance(part, tuple):
        for item in part:
            yield from _quantities(item)
    elif part is not None:
        yield part

"""The equipment, described once: the linear model and the time-domain simulator are both built from it.

Any figure may be an array that broadcasts against the Laplace variable, so that one
description stands for many windows; the simulator takes plain numbers only.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

Figure = Any
"""A float, or an array of floats that broadcasts against s."""

STEEL_DENSITY = 7850.0
"""ρ, kg/m³."""
STEEL_SHEAR_MODULUS = 79.3e9
"""G, Pa."""


def polar_moment(outer_diameter: float, inner_diameter: float) -> float:
    """Polar moment of a pipe's cross section, IP = π/32 (OD⁴ − ID⁴), in m⁴ from diameters in m."""
    return float(np.pi / 32 * (outer_diameter**4 - inner_diameter**4))


@dataclass(frozen=True)
class Section:
    """A uniform length of the string.

    length m, polar_moment m⁴, kappa N s/m⁴ (viscous damping of mud and wall), delta N s/m²
    (internal damping), density kg/m³, shear_modulus Pa.
    """

    length: Figure
    polar_moment: Figure
    kappa: Figure = 0.0
    delta: Figure = 0.0
    density: float = STEEL_DENSITY
    shear_modulus: float = STEEL_SHEAR_MODULUS

    @property
    def inertia(self) -> Figure:
        """Inertia of the whole section, kg m²."""
        return self.density * self.polar_moment * self.length


@dataclass(frozen=True)
class Controller:
    """Speed control A(s) = P + I/s with filters of speed, H(s) = 1/(1 + s τ_H), and torque, E(s) = 1/(1 + s τ_E)."""

    proportional: Figure
    """P, N m s/rad."""
    integral: Figure = 0.0
    """I, N m/rad."""
    speed_filter: float = 0.0
    """τ_H, s."""
    torque_filter: float = 0.0
    """τ_E, s."""


@dataclass(frozen=True)
class TopDrive:
    """Inertia J_td (kg m²), driven with the delay T_d (s) and a first-order lag (s)."""

    inertia: Figure
    delay: Figure
    controller: Controller
    lag: float = 0.0


@dataclass(frozen=True)
class Bit:
    """The lower end: a lumped inertia (kg m²) with viscous damping (N m s/rad)."""

    inertia: Figure
    damping: Figure = 0.0


@dataclass(frozen=True)
class DrillingSystem:
    """Top drive, string from top to bottom, bit."""

    top_drive: TopDrive
    string: tuple[Section, ...]
    bit: Bit

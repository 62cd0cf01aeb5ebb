"""A uniform length of pipe as a damped transmission line (paper, equations 1–5).

Speed plays voltage and torque, counted positive from the top towards the bit, plays current.
All functions broadcast: s has shape (..., frequency), figures of a section broadcast against it.
"""

import numpy as np
from numpy.typing import NDArray

from drillid.physics.equipment import Section

Complex = NDArray[np.complex128]


def propagation(section: Section, s: Complex) -> tuple[Complex, Complex]:
    """Propagation coefficient and characteristic admittance.

    Equations 1 and 2 with β = G/s + δ, as the units demand; the roots with positive real
    part belong to a passive line.

    Returns
    -------
    gamma : 1/m
    characteristic_admittance : Y₀, N m s/rad
    """
    alpha = section.density * s + section.kappa
    beta = section.shear_modulus / s + section.delta
    return np.sqrt(alpha / beta), section.polar_moment * np.sqrt(alpha * beta)


def input_admittance(section: Section, load: Complex, s: Complex) -> Complex:
    """Admittance (N m s/rad) at one end of a section whose other end carries `load`.

    Equation 5 with both sides divided by cosh γL, which overflows on long lossy lines.
    """
    gamma, characteristic = propagation(section, s)
    tangent = np.tanh(gamma * section.length)
    admittance: Complex = characteristic * (load + characteristic * tangent) / (characteristic + load * tangent)
    return admittance


def input_impedance(section: Section, load: Complex, s: Complex) -> Complex:
    """Impedance (rad/(N m s)) at one end of a section whose other end carries the impedance `load`; zero is a clamp."""
    gamma, characteristic = propagation(section, s)
    tangent = np.tanh(gamma * section.length)
    impedance: Complex = (load + tangent / characteristic) / (1 + load * characteristic * tangent)
    return impedance


def chain_matrix(section: Section, s: Complex) -> Complex:
    """Transfer matrix of equation 5, shape s.shape + (2, 2); overflows where Re γL exceeds 700."""
    gamma, characteristic = propagation(section, s)
    cosh, sinh = np.cosh(gamma * section.length), np.sinh(gamma * section.length)
    return np.stack([np.stack([cosh, sinh / characteristic], -1), np.stack([sinh * characteristic, cosh], -1)], -2)

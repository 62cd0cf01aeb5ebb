"""A uniform length of pipe as a damped transmission line (paper, equations 1–5).

Speed corresponds to voltage, and torque, positive from the top towards the bit, to current.
All functions broadcast: s has shape (..., frequency), the quantities of a section broadcast against it.
"""

from typing import Any

import numpy as np

from drillid.arrays import Complex
from drillid.physics.damping import KelvinVoigt, ViscousWall
from drillid.physics.dual_numbers import Dual, composed, primal
from drillid.physics.equipment import Section


def immittances(section: Section, s: Complex) -> tuple[Any, Any]:
    """Sums over inertia, stiffness and all damping laws of a section.

    Equations 1 to 4 with β = G/s + δ, as the units require.

    Returns
    -------
    shunt : Y' = α IP + …, admittance per length, N s/rad
    series : B' = β IP + …, admittance times length, N m² s/rad
    """
    laws = (ViscousWall(section.kappa), KelvinVoigt(section.delta), *section.laws)
    shunt = section.density * section.polar_moment * s
    series = section.shear_modulus * section.polar_moment / s
    for law in laws:
        shunt = shunt + law.shunt(section, s)
        series = series + law.series(section, s)
    return shunt, series


def propagation(section: Section, s: Complex) -> tuple[Complex, Complex]:
    """Propagation coefficient γ = √(Y'/B') and characteristic admittance Y₀ = √(Y'B').

    Both are formed from the same two roots. On any branch, also left of the imaginary axis,
    γ and Y₀ therefore change sign together, which leaves equation 5 unchanged; on the
    right a passive line attenuates: Re γ ≥ 0.

    Returns
    -------
    gamma : 1/m
    characteristic_admittance : Y₀, N m s/rad
    """
    shunt, series = immittances(section, s)
    root_shunt, root_series = np.sqrt(shunt), np.sqrt(series)
    return root_shunt / root_series, root_shunt * root_series


def input_admittance(section: Section, load: Complex, s: Complex) -> Complex:
    """Admittance (N m s/rad) at one end of a section whose other end carries `load`.

    Equation 5 with both sides divided by cosh γL, which overflows on long lossy lines.
    """
    shunt, series = immittances(section, s)
    own, end = [primal(each) for each in (shunt, series, section.length)], primal(load)
    root_shunt, root_series = np.sqrt(own[0]), np.sqrt(own[1])
    gamma, characteristic = root_shunt / root_series, root_shunt * root_series
    phase = gamma * own[2]
    tangent = np.tanh(phase)
    above, below = end + characteristic * tangent, characteristic + end * tangent
    admittance = np.asarray(characteristic * above / below)
    if not any(isinstance(each, Dual) for each in (shunt, series, section.length, load)):
        return admittance
    # derivatives by hand: few products of long arrays, where the chain rule through every step would need many
    per_square = characteristic / (below * below)
    falling = 1 - tangent * tangent
    by_phase = per_square * (characteristic - end) * (characteristic + end) * falling
    by_logarithm = 0.5 * (admittance + per_square * (tangent * below - above) * characteristic)
    parts = [
        ((by_logarithm + 0.5 * phase * by_phase) / own[0], shunt),
        ((by_logarithm - 0.5 * phase * by_phase) / own[1], series),
        (gamma * by_phase, section.length),
        (per_square * characteristic * falling, load),
    ]
    found: Complex = composed(admittance, parts)
    return found


def input_impedance(section: Section, load: Complex, s: Complex) -> Complex:
    """Impedance (rad/(N m s)) at one end of a section whose other end carries the impedance `load`; zero is a clamp."""
    gamma, characteristic = propagation(section, s)
    tangent = np.tanh(gamma * section.length)
    impedance: Complex = (load + tangent / characteristic) / (1 + load * characteristic * tangent)
    return impedance


def _attenuating(section: Section, s: Complex) -> tuple[Complex, Complex]:
    """γ and Y₀ on the branch on which waves decay along the line: both negated where it amplifies them (Re γ < 0)."""
    gamma, characteristic = propagation(section, s)
    branch = np.where(primal(gamma).real < 0, -1.0, 1.0)
    return branch * gamma, branch * characteristic


def speed_ratio(section: Section, load: Complex, s: Complex) -> Complex:
    """Speed at the end that carries `load` per speed at the other: 1/(cosh γL + Y_L/Y₀ sinh γL), without overflow.

    The ratio is even in (γ, Y₀): either branch gives it.
    """
    gamma, characteristic = _attenuating(section, s)
    decay, relative = np.exp(-gamma * section.length), load / characteristic
    ratio: Complex = 2 * decay / (1 + relative + (1 - relative) * np.square(decay))
    return ratio


def profile_slopes(section: Section, load: Complex, s: Complex, periods: int) -> Complex:
    """Derivatives of the input admittance to relative changes of the polar moment along a section, N m s/rad.

    Where speed is a e^(−γx) and its reflection b e^(−γ(2L − x)), a change by a share ε(x) adds
    ∫ ε 2γY₀ (a² e^(−2γx) + b² e^(−2γ(2L − x))) dx/(a + b e^(−2γL))² to the admittance: the reflections of all places,
    each by the two-way travel to it. Both terms are in closed form for e^(±ikx) with whole numbers of periods along L.

    Parameters
    ----------
    load : admittance at the other end, shape (..., F)
    periods : largest number of periods

    Returns
    -------
    slopes : (..., 2 periods, F) for cosines of 1, 2 … periods from the upper end, then for sines
    """
    gamma, characteristic = _attenuating(section, s)
    reflection, decay = (characteristic - load) / (characteristic + load), np.exp(-2 * gamma * section.length)
    echo = (reflection**2 * decay)[..., None, :]
    wave_number = 2j * np.pi * np.arange(1, periods + 1)[:, None] / np.asarray(section.length)[..., None]
    twice = 2 * gamma[..., None, :]
    forward, backward = 1 / (twice - wave_number), 1 / (twice + wave_number)
    rising, falling = forward + echo * backward, backward + echo * forward
    slopes = np.concatenate([(rising + falling) / 2, (rising - falling) / 2j], axis=-2)
    common = 2 * gamma * characteristic * (1 - decay) / (1 + reflection * decay) ** 2
    return np.asarray(common[..., None, :] * slopes, dtype=complex)


def chain_entries(section: Section, s: Complex) -> tuple[Any, Any, Any, Any]:
    """Entries of the transfer matrix of equation 5, (cosh γL, Z₀ sinh γL, Y₀ sinh γL, cosh γL)."""
    gamma, characteristic = propagation(section, s)
    cosh, sinh = np.cosh(gamma * section.length), np.sinh(gamma * section.length)
    return cosh, sinh / characteristic, sinh * characteristic, cosh


def chain_matrix(section: Section, s: Complex) -> Complex:
    """Transfer matrix of equation 5, shape s.shape + (2, 2); overflows where Re γL exceeds 700."""
    entries = np.broadcast_arrays(*chain_entries(section, s))
    return np.stack([np.stack(entries[:2], -1), np.stack(entries[2:], -1)], -2)

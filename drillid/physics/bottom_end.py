"""The lower end: bit, cutting laws linearised about a steady speed, mud motor."""

from typing import Any

import numpy as np

from drillid.arrays import Complex
from drillid.physics.equipment import Bit, Motor, RegenerativeCutting, StribeckCutting


def bit_load(bit: Bit, s: Complex) -> Complex:
    """Y_L = J_bha s + Y_bha + cutting laws, N m s/rad."""
    admittance: Complex = bit.inertia * s + bit.damping
    for law in bit.cutting:
        admittance = admittance + cutting_admittance(law, s)
    return admittance


def cutting_admittance(law: RegenerativeCutting | StribeckCutting, s: Complex) -> Any:
    """Cutting torque per bit speed, N m s/rad; a negative real part feeds vibration.

    Stribeck: the slope of the torque at the mean speed, −(T_s − T_d) (Ω/Ω_s)^n exp(−(Ω/Ω_s)^n) n/Ω.

    Regenerative: with the rate of penetration V imposed, the depth of cut of a blade is V t, t being the time since
    the blade ahead passed: φ(τ) − φ(τ − t) = 2π/n. To first order in the vibration,

        Y = −n T₀/(2π) (1 − e^(−s t₀))/s,   t₀ = 2π/(n Ω),

    which tends to the slope −T₀/Ω of T ∝ V/Ω at low frequency. Torsional part of Richard, Germay and Detournay 2007,
    Journal of Sound and Vibration 305, 432–456.
    """
    if isinstance(law, StribeckCutting):
        ratio = (law.speed / law.threshold) ** law.exponent
        return -(law.static - law.dynamic) * np.exp(-ratio) * ratio * law.exponent / law.speed
    blade_time = 2 * np.pi / (law.blades * law.speed)
    return law.blades * law.torque / (2 * np.pi) * np.expm1(-s * blade_time) / s


def motor_impedance(motor: Motor, s: Complex) -> Complex:
    """Speed across the motor per torque through it, s/(k + c s), rad/(N m s)."""
    impedance: Complex = s / (motor.stiffness + motor.damping * s)
    return impedance


def above_motor(motor: Motor | None, load: Complex, s: Complex) -> Complex:
    """Admittance (N m s/rad) that loads the string where the motor carries `load`."""
    if motor is None:
        return load
    admittance: Complex = motor.inertia * s + load / (1 + load * motor_impedance(motor, s))
    return admittance


def below_motor(motor: Motor | None, impedance: Complex, s: Complex) -> Complex:
    """Impedance (rad/(N m s)) above the bit, `impedance` being that of the string above the motor."""
    if motor is None:
        return impedance
    total: Complex = motor_impedance(motor, s) + impedance / (1 + motor.inertia * s * impedance)
    return total


def chain_through_motor(motor: Motor, s: Complex) -> tuple[Any, Any, Any, Any]:
    """Entries of the motor's transfer matrix, row by row: the housing's inertia above the spring."""
    spring, housing = motor_impedance(motor, s), motor.inertia * s
    return 1.0, spring, housing, 1 + housing * spring

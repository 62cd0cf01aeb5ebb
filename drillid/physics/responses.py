"""Frequency responses of the whole drilling system, and its responses in time to steps and impulses."""

from functools import reduce
from typing import Any

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.physics.bottom_end import above_motor, below_motor, bit_load, motor_impedance
from drillid.physics.equipment import DrillingSystem
from drillid.physics.line import input_admittance, input_impedance, propagation, speed_ratio
from drillid.physics.top_drive import drive, top_admittance, torque_transfers

_LEAST_INERTIA = 1e-6
"""kg m²; represents a bit without inertia, whose speed steps at once."""


def laplace(frequency: Floats) -> Complex:
    """Laplace variable s = 2πjf for frequencies in Hz."""
    return np.asarray(2j * np.pi * np.asarray(frequency), dtype=complex)


def string_admittance(system: DrillingSystem, s: Complex) -> Complex:
    """Y_in, torque into the string per speed at its upper end, N m s/rad; sections cascade from the bit up."""
    load = above_motor(system.motor, bit_load(system.bit, s), s)
    return reduce(lambda below, section: input_admittance(section, below, s), reversed(system.string), load)


def command_mobility(system: DrillingSystem, s: Complex) -> Complex:
    """M = W/(J_td s + V + Y_in), top-drive speed per sweep torque, rad/(N m s)."""
    command_transfer, feedback = torque_transfers(system.top_drive, s)
    mobility: Complex = command_transfer / (system.top_drive.inertia * s + feedback + string_admittance(system, s))
    return mobility


def torque_mobility(system: DrillingSystem, s: Complex) -> Complex:
    """D e^(−sT_d)/(J_td s + Y_in), top-drive speed per total command, independent of the controller, rad/(N m s)."""
    mobility: Complex = drive(system.top_drive, s) / (system.top_drive.inertia * s + string_admittance(system, s))
    return mobility


def string_torque(system: DrillingSystem, s: Complex) -> Complex:
    """Y_in M, torque into the string per sweep torque, dimensionless: as measured by an instrumented sub."""
    torque: Complex = string_admittance(system, s) * command_mobility(system, s)
    return torque


def bit_mobility(system: DrillingSystem, s: Complex, *, stiff: bool = False) -> Complex:
    """Bit speed per torque on the bit, rad/(N m s); `stiff` clamps the top drive."""
    if stiff:
        above = reduce(lambda load, section: input_impedance(section, load, s), system.string, 0 * s)
        return 1 / (bit_load(system.bit, s) + 1 / below_motor(system.motor, above, s))
    top = top_admittance(system.top_drive, s)
    admittance = reduce(lambda load, section: input_admittance(section, load, s), system.string, top)
    return 1 / (bit_load(system.bit, s) + 1 / below_motor(system.motor, 1 / admittance, s))


def bit_speed_ratio(system: DrillingSystem, s: Complex) -> Complex:
    """Bit speed per top-drive speed where the string is driven from the top, dimensionless."""
    load = bit_load(system.bit, s)
    ratio: Any = 1.0
    if system.motor is not None:
        ratio = ratio / (1 + load * motor_impedance(system.motor, s))
        load = above_motor(system.motor, load, s)
    for section in reversed(system.string):
        ratio, load = ratio * speed_ratio(section, load, s), input_admittance(section, load, s)
    speed: Complex = ratio
    return speed


def top_reflection(system: DrillingSystem, s: Complex) -> Complex:
    """Reflection coefficient of the top drive: speed of the downgoing wave per speed of the upgoing, dimensionless.

    (Y₀ − Y_top)/(Y₀ + Y_top): −1 for a clamped top, 1 for a free one, 0 where the control matches the pipe.
    """
    characteristic = propagation(system.string[0], s)[1]
    above = top_admittance(system.top_drive, s)
    return (characteristic - above) / (characteristic + above)


def bit_reflection(system: DrillingSystem, s: Complex) -> Complex:
    """Reflection coefficient of the bit at the end of the lowest section: upgoing wave per downgoing, dimensionless."""
    characteristic = propagation(system.string[-1], s)[1]
    load = above_motor(system.motor, bit_load(system.bit, s), s)
    return (characteristic - load) / (characteristic + load)


def _bit_alone(system: DrillingSystem) -> tuple[Any, Any]:
    """Inertia and resistance that a torque at the bit acts on before any reflection returns."""
    resistance = system.string[-1].characteristic_admittance + system.bit.damping
    return np.maximum(system.bit.inertia, _LEAST_INERTIA), resistance

"""Frequency responses of the whole drilling system, and its responses in time to steps and impulses."""

from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drillid.physics.bottom_end import above_motor, below_motor, bit_load, motor_impedance
from drillid.physics.equipment import DrillingSystem
from drillid.physics.inversion import Floats, inverse_laplace
from drillid.physics.line import Complex, input_admittance, input_impedance, propagation, speed_ratio
from drillid.physics.top_drive import drive, top_admittance, torque_transfers

Steps = tuple[Floats, Floats]

_LEAST_INERTIA = 1e-6
"""kg m²; stands for a bit without inertia, whose speed steps at once."""
_LEAST_LAG = 1e-9
"""s; stands for a drive without lag."""


def laplace(frequency: NDArray[np.float64]) -> Complex:
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
    """D e^(−sT_d)/(J_td s + Y_in), top-drive speed per whole torque command, free of the controller, rad/(N m s)."""
    mobility: Complex = drive(system.top_drive, s) / (system.top_drive.inertia * s + string_admittance(system, s))
    return mobility


def string_torque(system: DrillingSystem, s: Complex) -> Complex:
    """Y_in M, torque into the string per sweep torque, without unit: what an instrumented sub shows."""
    torque: Complex = string_admittance(system, s) * command_mobility(system, s)
    return torque


def bit_mobility(system: DrillingSystem, s: Complex, *, stiff: bool = False) -> Complex:
    """Bit speed per torque on the bit, rad/(N m s); `stiff` clamps the top drive."""
    if stiff:
        above = reduce(lambda seen, section: input_impedance(section, seen, s), system.string, 0 * s)
        return 1 / (bit_load(system.bit, s) + 1 / below_motor(system.motor, above, s))
    top = top_admittance(system.top_drive, s)
    admittance = reduce(lambda seen, section: input_admittance(section, seen, s), system.string, top)
    return 1 / (bit_load(system.bit, s) + 1 / below_motor(system.motor, 1 / admittance, s))


def bit_speed_ratio(system: DrillingSystem, s: Complex) -> Complex:
    """Bit speed per top-drive speed where the string is driven from the top, without unit."""
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
    """Speed of the wave that the top drive sends down per speed of the one that comes up the pipe, without unit.

    (Y₀ − Y_top)/(Y₀ + Y_top): −1 for a clamped top, 1 for a free one, 0 where the control matches the pipe.
    """
    characteristic = propagation(system.string[0], s)[1]
    above = top_admittance(system.top_drive, s)
    return (characteristic - above) / (characteristic + above)


def bit_reflection(system: DrillingSystem, s: Complex) -> Complex:
    """Speed of the wave sent up from the end of the lowest section per speed of the one that comes down."""
    characteristic = propagation(system.string[-1], s)[1]
    load = above_motor(system.motor, bit_load(system.bit, s), s)
    return (characteristic - load) / (characteristic + load)


def _bit_alone(system: DrillingSystem) -> tuple[Any, Any]:
    """Inertia and resistance that a torque meets at the bit before anything is reflected."""
    resistance = system.string[-1].characteristic_admittance + system.bit.damping
    return np.maximum(system.bit.inertia, _LEAST_INERTIA), resistance


def bit_step_response(system: DrillingSystem, duration: float, interval: float, *, stiff: bool = False) -> Steps:
    """Bit speed after a unit torque step at the bit.

    The step into bit and lowest section without reflections is known in closed form and taken
    out first, so that the remainder's spectrum falls fast. The error is below 1e-6 of the largest
    value (against 30-digit inversion, usual rigs). Unstable systems: see `inverse_laplace`.

    Parameters
    ----------
    duration, interval : length and spacing of the lags, s; lag 0 is the instant before the step

    Returns
    -------
    lags : shape (lag,), s
    bit_speed : shape (..., lag), rad/s per N m; a Dual where the equipment holds one
    """
    inertia, resistance = _bit_alone(system)

    def remainder(s: Complex) -> Any:
        return bit_mobility(system, s, stiff=stiff) / s - 1 / (s * (inertia * s + resistance))

    lags, reflections = inverse_laplace(remainder, duration, interval)
    bit_speed = (reflections - np.expm1(-resistance / inertia * lags) / resistance) * (lags > 0)
    return lags, bit_speed


def bit_impulse_response(system: DrillingSystem, duration: float, interval: float, *, stiff: bool = False) -> Steps:
    """Bit speed after a unit angular momentum given to the bit, whose inertia must be positive.

    As `bit_step_response`, with lag 0 the instant after the impulse. The error is below 1e-4 of the first
    value; there, where the motion is fastest, it may reach 1 %.

    Returns
    -------
    lags : shape (lag,), s
    bit_speed : shape (..., lag), rad/s per N m s; a Dual where the equipment holds one
    """
    inertia, resistance = _bit_alone(system)

    def remainder(s: Complex) -> Any:
        return bit_mobility(system, s, stiff=stiff) - 1 / (inertia * s + resistance)

    lags, reflections = inverse_laplace(remainder, duration, interval)
    return lags, reflections + np.exp(-resistance / inertia * lags) / inertia


def command_step_response(system: DrillingSystem, duration: float, interval: float) -> Steps:
    """Top-drive speed after a unit step of the sweep torque.

    Taken out first in closed form: the delayed and lagging torque on the top drive's inertia alone. The
    error is below 2e-6 of the largest value.

    Returns
    -------
    lags : shape (lag,), s
    speed : shape (..., lag), rad/s per N m; a Dual where the equipment holds one
    """
    top_drive = system.top_drive

    def remainder(s: Complex) -> Any:
        return command_mobility(system, s) / s - drive(top_drive, s) / (top_drive.inertia * s * s)

    lags, rest = inverse_laplace(remainder, duration, interval)
    since = np.maximum(lags - top_drive.delay, 0.0)
    lag = np.maximum(top_drive.lag, _LEAST_LAG)
    alone = top_drive.gain / top_drive.inertia * (since + lag * np.expm1(-since / lag))
    return lags, rest + alone

"""Sensor, speed control and drive of the time-domain simulator, compiled."""

import numpy as np

from drillid.arrays import Floats
from drillid.simulation.parts import (
    DEMAND,
    DRIVE_BEFORE,
    DRIVE_TORQUE,
    ERROR,
    ERROR_SLOPE,
    EXCESS,
    FILTERED,
    INTEGRAL,
    MEAN_STRING,
    MEASURED,
    SHAPED_CONTROL,
    SHAPED_DRIVE,
    SMOOTH_ERROR,
    SMOOTH_STRING,
    SPEED,
    SPEED_SLOPE,
    STRING_TORQUE,
    TOP_ANGLE,
    TORQUE,
    UNFILTERED,
    Control,
    Drive,
    compiled,
)
from drillid.simulation.tables import law_torque


@compiled
def low_pass(before: float, now: float, state: float, time_constant: float, step: float) -> float:
    """First-order low pass by the trapezoidal rule; a time constant of 0 passes the input."""
    if time_constant == 0.0:
        return now
    return ((2 * time_constant - step) * state + step * (before + now)) / (2 * time_constant + step)


@compiled
def shaped(coefficients: Floats, now: float, memory: Floats, first: int) -> float:
    """A rational factor of order two at an input, with its states from `first` on (transposed direct form II)."""
    b0, b1, b2, a1, a2 = coefficients
    result = b0 * now + memory[first]
    memory[first] = b1 * now - a1 * result + memory[first + 1]
    memory[first + 1] = b2 * now - a2 * result
    return float(result)


@compiled
def read_speed(control: Control, speed: float, memory: Floats) -> float:
    """Reading of the top drive's speed in rad/s."""
    reading = control.scale * speed
    if control.ripple != 0.0:
        reading *= 1 + control.ripple * np.sin(memory[TOP_ANGLE])
    if control.resolution > 0.0:
        reading = control.resolution * np.rint(reading / control.resolution)
    memory[MEASURED] = reading
    return reading


@compiled
def matching_reduction(control: Control, step: float, speed: float, memory: Floats) -> float:
    """Reduction of the set point (rad/s) by impedance matching.

    Drive torque and acceleration are known half a step ago and extrapolated linearly.
    """
    slope = (speed - memory[SPEED]) / step
    drive = 1.5 * memory[DRIVE_TORQUE] - 0.5 * memory[DRIVE_BEFORE]
    torque = drive - control.matching_inertia * (1.5 * slope - 0.5 * memory[SPEED_SLOPE])
    smooth = low_pass(memory[STRING_TORQUE], torque, memory[SMOOTH_STRING], control.matching_low_pass, step)
    mean = 0.0
    if control.matching_high_pass < np.inf:
        mean = low_pass(memory[SMOOTH_STRING], smooth, memory[MEAN_STRING], control.matching_high_pass, step)
    memory[SPEED_SLOPE], memory[STRING_TORQUE], memory[SMOOTH_STRING] = slope, torque, smooth
    memory[MEAN_STRING] = mean
    return float(control.matching * (smooth - mean))


@compiled
def error_slope(control: Control, step: float, error: float, memory: Floats) -> float:
    """Time derivative of the speed error in rad/s², filtered by the inertia compensation."""
    if control.compensation_filter > 0.0:
        smooth = low_pass(memory[ERROR], error, memory[SMOOTH_ERROR], control.compensation_filter, step)
        memory[SMOOTH_ERROR] = smooth
        return float((error - smooth) / control.compensation_filter)
    slope = (error - memory[ERROR]) / step
    extrapolated = 1.5 * slope - 0.5 * memory[ERROR_SLOPE]
    memory[ERROR_SLOPE] = slope
    return float(extrapolated)


@compiled
def control_torque(control: Control, step: float, speed_set: float, speed: float, memory: Floats) -> float:
    """Torque command of the speed control (N m) at a reading `step` seconds after its last one."""
    filtered = low_pass(memory[SPEED], speed, memory[FILTERED], control.speed_filter, step)
    error = speed_set - filtered
    if control.matching > 0.0:
        error -= matching_reduction(control, step, speed, memory)
    integral = memory[INTEGRAL]
    if memory[EXCESS] * error <= 0.0:
        integral += control.integral * step / 2 * (error + memory[ERROR])
    unfiltered = control.proportional * error + integral
    if control.law.present:
        unfiltered += law_torque(control.law, error)
    if control.compensated_inertia > 0.0:
        unfiltered -= control.compensated_inertia * error_slope(control, step, error, memory)
    unfiltered = shaped(control.shaping, unfiltered, memory, SHAPED_CONTROL)
    torque = low_pass(memory[UNFILTERED], unfiltered, memory[TORQUE], control.torque_filter, step)
    memory[SPEED], memory[FILTERED], memory[ERROR] = speed, filtered, error
    memory[INTEGRAL], memory[UNFILTERED], memory[TORQUE] = integral, unfiltered, torque
    return float(torque)


@compiled
def delayed_command(command: Floats, newest: int, age: float) -> float:
    """Command of `age` steps ago by cubic interpolation; below one step it is extrapolated."""
    whole = max(1, int(np.floor(age)))
    part = age - whole
    first = newest - whole + 1
    delayed = (
        -part * (part - 1) * (part - 2) / 6 * command[first]
        + (part + 1) * (part - 1) * (part - 2) / 2 * command[first - 1]
        - (part + 1) * part * (part - 2) / 2 * command[first - 2]
        + (part + 1) * part * (part - 1) / 6 * command[first - 3]
    )
    return float(delayed)


@compiled
def drive_torque(drive: Drive, step: float, command: Floats, newest: int, jitter: float, memory: Floats) -> float:
    """Torque in N m of the drive, half a step after the newest command."""
    # the torque acts half a step after the speeds that it changes
    age = max(drive.delay + jitter, 0.0) / step - 0.5
    demand = drive.gain * shaped(drive.shaping, delayed_command(command, newest, age), memory, SHAPED_DRIVE)
    limited = min(max(demand, -drive.limit), drive.limit)
    memory[EXCESS] = demand - limited
    change = drive.rate * step
    limited = min(max(limited, memory[DEMAND] - change), memory[DEMAND] + change)
    torque = low_pass(memory[DEMAND], limited, memory[DRIVE_TORQUE], drive.lag, step)
    memory[DEMAND], memory[DRIVE_TORQUE], memory[DRIVE_BEFORE] = limited, torque, memory[DRIVE_TORQUE]
    return float(torque)

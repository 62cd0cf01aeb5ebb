"""The second world's steps in time, compiled: control, drive, gear, modes of the string, friction and blades."""

from typing import NamedTuple

import numpy as np

from benchmarks.blind.other_world.friction import Contacts, compiled, friction_torque, time_behind
from drillid.arrays import Floats

TOP, BIT = 0, 1
"""Ports; the contacts follow."""
_DEEPEST = 5.0
"""Greatest depth of cut of a blade, per that at the mean speed."""


class Steps(NamedTuple):
    """A propagator in real numbers: real and imaginary parts of each factor."""

    advance: tuple[Floats, Floats]
    """(Q,)."""
    drive: tuple[Floats, Floats]
    """(ports, Q)."""
    observe: tuple[Floats, Floats]
    """(ports, Q)."""
    compliance: Floats
    """(ports, ports)."""


class Rates(NamedTuple):
    """Control and drive in numbers."""

    step: float
    """s."""
    every: int
    """Steps between readings."""
    proportional: float
    integral: float
    speed_filter: float
    torque_filter: float
    windup_gain: float
    notch: Floats
    """(5,) coefficients b0 b1 b2 a1 a2; a plain 1 without a notch."""
    ripple: float
    delay: float
    """Steps."""
    gain: float
    lag: float
    """Share of the way to its input that the torque goes in a step."""
    limit: float
    rate: float
    """N m a step."""
    resonance: Floats
    """(2,) rad/s and damping ratio."""
    half_play: float
    """rad; negative for a rigid gear."""
    motor_inertia: float
    """kg m², above the gear."""
    blades: int
    blade_torque: float
    blade_time: float
    """Steps between blades at the mean speed."""


class Inputs(NamedTuple):
    """Series at each step, (steps,), or at each reading, (readings,)."""

    sweep: Floats
    """At readings, N m."""
    speed_set: Floats
    """At readings, rad/s."""
    noise: Floats
    """At readings, rad/s."""
    jitter: Floats
    """At steps, steps of delay."""
    rock: Floats
    """At steps, N m."""
    bit_damping: Floats
    """At steps, N m s/rad, added."""


class State(NamedTuple):
    """State of the rig, updated in place."""

    real: Floats
    imaginary: Floats
    bristle: Floats
    memory: Floats
    """(MEMORY,), see below."""
    held: Floats
    """(past + steps,) commands."""
    angle: Floats
    """(steps + 1,) rad turned by the bit."""


FILTERED, INTEGRAL, SMOOTH, UNFILTERED = range(4)
"""Control: filtered speed; integral; torque behind and in front of its filter."""
NOTCH, DEMAND, TORQUE, SLOPE, WITHHELD = 4, 8, 9, 10, 11
"""Notch's last inputs and outputs, two each; drive: limited demand, torque and its slope, and what limits withhold."""
TURNED, TWIST, MOTOR, SPEED = 12, 13, 14, 15
"""Angle of the top; twist of the gear about the middle of its play; speed of the motor; last speed of the top."""
AHEAD, STARTED = 16, 17
"""Step at which the bit was where the blade ahead is; whether the rig has made a step."""
MEMORY = 18


@compiled
def observed(parts: tuple[Floats, Floats], state: State, port: int) -> float:
    """Speed of a port, rad/s."""
    real, imaginary = parts[0][port], parts[1][port]
    total = 0.0
    for k in range(state.real.size):
        total += real[k] * state.real[k] - imaginary[k] * state.imaginary[k]
    return total


@compiled
def _push(parts: tuple[Floats, Floats], state: State, port: int, torque: float) -> None:
    """Add the change by a torque during a step."""
    real, imaginary = parts[0][port], parts[1][port]
    for k in range(state.real.size):
        state.real[k] += real[k] * torque
        state.imaginary[k] += imaginary[k] * torque


@compiled
def _move(parts: tuple[Floats, Floats], state: State) -> None:
    """Advance the free string by a step."""
    real, imaginary = parts
    for k in range(state.real.size):
        before = state.real[k]
        state.real[k] = real[k] * before - imaginary[k] * state.imaginary[k]
        state.imaginary[k] = imaginary[k] * before + real[k] * state.imaginary[k]


@compiled
def _control(rates: Rates, inputs: Inputs, memory: Floats, reading: int, speed: float) -> float:
    """Command of a reading, N m, sweep included."""
    interval = rates.step * rates.every
    error = inputs.speed_set[reading] - speed
    memory[INTEGRAL] += rates.integral * interval * error
    if rates.windup_gain > 0.0:
        memory[INTEGRAL] -= rates.windup_gain * interval * memory[WITHHELD]
    elif memory[WITHHELD] * error > 0.0:
        memory[INTEGRAL] -= rates.integral * interval * error
    torque = rates.proportional * error + memory[INTEGRAL]
    b, m = rates.notch, memory[NOTCH : NOTCH + 4]
    passed = b[0] * torque + b[1] * m[0] + b[2] * m[1] - b[3] * m[2] - b[4] * m[3]
    m[1], m[0], m[3], m[2] = m[0], torque, m[2], passed
    smooth, tau = passed, 2 * rates.torque_filter
    if tau > 0.0:
        before = memory[UNFILTERED] + passed
        smooth = ((tau - interval) * memory[SMOOTH] + interval * before) / (tau + interval)
    memory[UNFILTERED], memory[SMOOTH] = passed, smooth
    return float(inputs.sweep[reading] + smooth)


@compiled
def _drive(rates: Rates, state: State, newest: int, jitter: float) -> float:
    """Mean torque of the drive during the step that begins with the newest command, N m."""
    memory = state.memory
    age = max(rates.delay + jitter, 0.0)
    whole = int(age)
    part = age - whole
    demand = rates.gain * ((1 - part) * state.held[newest - whole] + part * state.held[newest - whole - 1])
    limited = min(max(demand, -rates.limit), rates.limit)
    limited = min(max(limited, memory[DEMAND] - rates.rate), memory[DEMAND] + rates.rate)
    memory[WITHHELD], memory[DEMAND] = demand - limited, limited
    if rates.resonance[0] > 0.0:
        # leapfrog steps of a second-order lag
        centre, damping, parts = rates.resonance[0], rates.resonance[1], 8
        small, total = rates.step / parts, 0.0
        for _ in range(parts):
            middle = memory[TORQUE] + small / 2 * memory[SLOPE]
            pull = centre**2 * (limited - middle) - 2 * damping * centre * memory[SLOPE]
            memory[SLOPE] += small * pull
            memory[TORQUE] = middle + small / 2 * memory[SLOPE]
            total += middle
        return float(total / parts)
    before = memory[TORQUE]
    memory[TORQUE] += rates.lag * (limited - before)
    # mean of an exponential approach over the step
    return float(limited + (before - limited) * _mean_left(rates.lag))


@compiled
def _mean_left(lag: float) -> float:
    """Mean over a step of what a first-order lag has left to go, as a share of what it had at the begin."""
    return 0.0 if lag >= 1.0 else float(-lag / np.log(1.0 - lag))


@compiled
def _gear(rates: Rates, steps: Steps, state: State, drive: float, free: float) -> float:
    """Torque through a gear with play; in contact both sides turn alike, apart the motor turns alone.

    Parameters
    ----------
    drive : N m, on the motor
    free : rad/s, speed of the top at the step's end without the gear's torque
    """
    memory, half = state.memory, rates.half_play
    ease = rates.step / rates.motor_inertia
    compliance = steps.compliance[TOP, TOP]
    alone = memory[MOTOR] + ease * drive
    twist = memory[TWIST] + rates.step * (alone - free)
    torque = 0.0
    if twist >= half or twist <= -half:
        flank = half if twist >= half else -half
        torque = (alone - free + (memory[TWIST] - flank) / rates.step) / (compliance + ease)
    memory[MOTOR] = alone - ease * torque
    memory[TWIST] += rates.step * (memory[MOTOR] - free - compliance * torque)
    return float(torque)


@compiled
def _rub(steps: Steps, contacts: Contacts, state: State, before: Floats, step: float) -> None:
    """Friction of all contacts one after the other; the first is at the bit where it rubs."""
    first = 1 if contacts.law.size == steps.compliance.shape[0] - 1 else 2
    for k in range(contacts.law.size):
        port = first + k
        free = observed(steps.observe, state, port)
        torque = friction_torque(contacts, k, before[k], free, steps.compliance[port, port], step, state.bristle)
        _push(steps.drive, state, port, torque)
        before[k] = free + steps.compliance[port, port] * torque


@compiled
def march(
    rates: Rates,
    steps: Steps,
    contacts: Contacts,
    inputs: Inputs,
    state: State,
    before: Floats,
    span: tuple[int, int],
    outputs: Floats,
    readings: Floats,
) -> None:
    """March through the steps of a span.

    Parameters
    ----------
    before : (contacts,) speeds of the contacts, updated
    outputs : (2, steps) speed of top and bit at the begin of each step, written
    readings : (2, readings) speed as read and command, written
    """
    memory = state.memory
    past = state.held.size - inputs.rock.size
    for n in range(span[0], span[1]):
        speed, bit = observed(steps.observe, state, TOP), observed(steps.observe, state, BIT)
        outputs[0, n], outputs[1, n] = speed, bit
        if rates.speed_filter > 0.0 and memory[STARTED] > 0.0:
            tau = 2 * rates.speed_filter
            mean = rates.step * (memory[SPEED] + speed)
            memory[FILTERED] = ((tau - rates.step) * memory[FILTERED] + mean) / (tau + rates.step)
        elif rates.speed_filter == 0.0:
            memory[FILTERED] = speed
        memory[SPEED], memory[STARTED] = speed, 1.0
        if n % rates.every == 0:
            reading = n // rates.every
            seen = 1 + rates.ripple * np.sin(memory[TURNED])
            readings[0, reading] = speed * seen + inputs.noise[reading]
            filtered = memory[FILTERED] * seen + inputs.noise[reading]
            readings[1, reading] = _control(rates, inputs, memory, reading, filtered)
        state.held[past + n] = readings[1, n // rates.every]
        drive = _drive(rates, state, past + n, inputs.jitter[n])
        rock = inputs.rock[n] + inputs.bit_damping[n] * bit
        if rates.blades:
            # in the middle of the step
            target = state.angle[n] + rates.step / 2 * bit - 2 * np.pi / rates.blades
            depth = 1.0
            if target >= state.angle[0] and n > 0:
                behind, steps_ago = time_behind(state.angle, target, n, int(memory[AHEAD]))
                memory[AHEAD] = behind
                depth = min((steps_ago + 0.5) / rates.blade_time, _DEEPEST)
            rock += rates.blade_torque * depth
        _move(steps.advance, state)
        _push(steps.drive, state, BIT, -rock)
        if rates.half_play >= 0.0:
            drive = _gear(rates, steps, state, drive, observed(steps.observe, state, TOP))
        _push(steps.drive, state, TOP, drive)
        if contacts.law.size:
            _rub(steps, contacts, state, before, rates.step)
        memory[TURNED] += rates.step * speed
        if rates.blades:
            after = observed(steps.observe, state, BIT)
            state.angle[n + 1] = state.angle[n] + rates.step * (bit + after) / 2

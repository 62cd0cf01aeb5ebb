"""A window of the second world, simulated: samples of its control and a fine record of its speeds."""

from dataclasses import dataclass

import numpy as np

from benchmarks.blind.other_world.disturbances import rock_torque, set_speed
from benchmarks.blind.other_world.elements import ELEMENT, HIGHEST, Modes, Propagator, modes, propagator
from benchmarks.blind.other_world.friction import Contacts
from benchmarks.blind.other_world.march import (
    DEMAND,
    FILTERED,
    INTEGRAL,
    MEMORY,
    MOTOR,
    TORQUE,
    TWIST,
    Inputs,
    Rates,
    State,
    Steps,
    march,
)
from benchmarks.blind.other_world.rig import FALLS, LAWS, Friction, Piece, Window
from benchmarks.blind.other_world.theory import NOTCH_WIDTH, RESONANCE_DAMPING
from drillid.arrays import Floats
from drillid.excitation.torques import exponential_sweeps

TIME_STEP = 0.0025
"""s; intervals of control are multiples of it."""
_BLOCK = 30.0
"""s, for which the length of a growing string is constant."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """Channels of a window; `sweep`, `reading` and `command` at the control's readings, speeds at each step."""

    interval: float
    """s, between readings."""
    step: float
    """s."""
    sweep: Floats
    """N m."""
    reading: Floats
    """rad/s, speed as the control reads it, with its noise, before filters."""
    command: Floats
    """N m, sweep included."""
    speed: Floats
    """rad/s, of the top drive."""
    bit_speed: Floats
    """rad/s."""


@dataclass(frozen=True)
class Resolution:
    """Discretisation."""

    step: float = TIME_STEP
    """s."""
    element: float = ELEMENT
    """m."""
    highest: float = HIGHEST
    """Hz."""


def simulate(
    window: Window, lead_in: float, seconds: float, seed: list[int], resolution: Resolution = Resolution()
) -> Simulation:
    """Simulate a window from steady rotation.

    Parameters
    ----------
    lead_in, seconds : s, before the window and its length; the sweep's period begins at the first step
    seed : of rock, sensor noise, jitter and wandering set point
    """
    rock_draws, sensor, jitters, speeds = (np.random.default_rng([*seed, number]) for number in range(4))
    step, every = resolution.step, max(1, round(window.control.interval / resolution.step))
    count = round((lead_in + seconds) / step)
    readings = -(-count // every)
    interval = every * step
    rock = rock_torque(rock_draws, window.rock, count, step)
    jitter = np.repeat(window.drive.jitter / step * jitters.standard_normal(readings), every)[:count]
    inputs = Inputs(
        exponential_sweeps(np.arange(readings) * interval, window.sweep),
        set_speed(speeds, window.speed, window.speed_wander, readings, interval),
        window.recording.noise * sensor.standard_normal(readings),
        jitter,
        rock,
        _course(window, count, lead_in / (lead_in + seconds)),
    )
    outputs, seen = np.zeros((2, count)), np.zeros((2, readings))
    _run(window, inputs, (outputs, seen), (lead_in, seconds), resolution)
    return Simulation(interval, step, inputs.sweep, seen[0], seen[1], outputs[0], outputs[1])


def _course(window: Window, count: int, lead: float) -> Floats:
    """Damping added at the bit at each step; its first value holds during the lead-in."""
    return window.added_damping(np.clip((np.arange(count) / count - lead) / (1 - lead), 0.0, 1.0))


def _run(
    window: Window,
    inputs: Inputs,
    written: tuple[Floats, Floats],
    times: tuple[float, float],
    resolution: Resolution,
) -> None:
    """March block by block; the state of the nodes is handed on where the string's length changes."""
    count, step = inputs.rock.size, resolution.step
    block = round(_BLOCK / step) if window.growth else count
    drive = window.drive
    play = drive.play > 0
    inertia = drive.inertia * (drive.share_below_gear if play else 1.0)
    rates, contacts = _rates(window, step), _contacts(window)
    past = int(np.ceil((drive.delay + 6 * drive.jitter) / step)) + 2
    memory, held = np.zeros(MEMORY), np.zeros(past + count)
    state = before = old = None
    for first in range(0, count, block):
        share = np.clip(((first + block / 2) * step - times[0]) / times[1], 0.0, 1.0) if window.growth else 0.5
        string = window.grown(float(share))
        now = modes(string, inertia, resolution.element, resolution.highest)
        shares = [contact.share for contact in window.contacts]
        length = sum(piece.length for piece in string)
        advance = propagator(now, np.array([0.0, length, *(length * share for share in shares)]), step)
        if state is None:
            load = _steady(window, now, inputs, memory)
            held[:] = load
            modal = advance.from_modal @ now.steady(*_rotation(window, now, string, inputs, load))
            before = np.full(contacts.law.size, window.speed)
            angle = np.zeros(count + 1 if rates.blades else 1)
            bristle = np.zeros(contacts.law.size)
            state = State(modal.real.copy(), modal.imag.copy(), bristle, memory, held, angle)
        elif old is not None:
            modal = advance.from_modal @ _handed_on(old, state, now)
            state = state._replace(real=modal.real.copy(), imaginary=modal.imag.copy())
        old = (now, advance)
        march(rates, _steps(advance), contacts, inputs, state, before, (first, min(first + block, count)), *written)


def _steady(window: Window, now: Modes, inputs: Inputs, memory: Floats) -> float:
    """Torque of the drive in steady rotation, N m; writes the memory of control and drive."""
    rub = [contact.friction.level(window.speed) for contact in window.contacts]
    if window.bit_friction is not None:
        rub.append(window.bit_friction.level(window.speed))
    viscous = float(now.steady_drag.sum()) + float(inputs.bit_damping[0])
    cut = window.blades.torque if window.blades else 0.0
    load = window.rock.mean + sum(rub) + viscous * window.speed + cut
    memory[[INTEGRAL, DEMAND, TORQUE]] = load / window.drive.gain, load, load
    # a notch and a filter pass a steady torque
    memory[4:8], memory[2:4] = load / window.drive.gain, load / window.drive.gain
    memory[[FILTERED, MOTOR]] = window.speed
    memory[TWIST] = window.drive.play / 2
    return load / window.drive.gain


def _rotation(
    window: Window, now: Modes, string: tuple[Piece, ...], inputs: Inputs, load: float
) -> tuple[Floats, Floats]:
    """Speeds of the nodes in steady rotation, and the torques on them."""
    torque = -now.steady_drag * window.speed
    torque[0] += load * window.drive.gain
    torque[-1] -= window.rock.mean + float(inputs.bit_damping[0]) * window.speed
    torque[-1] -= window.blades.torque if window.blades else 0.0
    torque[-1] -= window.bit_friction.level(window.speed) if window.bit_friction else 0.0
    length = sum(piece.length for piece in string)
    for contact in window.contacts:
        node = int(np.argmin(np.abs(now.mesh.place - contact.share * length)))
        torque[node] -= contact.friction.level(window.speed)
    return np.full(now.mesh.place.size, window.speed), torque


def _handed_on(old: tuple[Modes, Propagator], state: State, now: Modes) -> Floats:
    """State of a string of another length from that of the last, by the speeds and torques of its nodes."""
    before, advance = old
    speeds, twists = before.fields((advance.to_modal @ (state.real + 1j * state.imaginary)).real)
    share, new = before.mesh.place / before.mesh.place[-1], now.mesh.place / now.mesh.place[-1]
    # the elastic torques are kept: the twist grows with the length
    grown = now.mesh.place[-1] / before.mesh.place[-1]
    return now.state(*(np.stack([np.interp(new, share, row) for row in rows]) for rows in (speeds, grown * twists)))


def _steps(advance: Propagator) -> Steps:
    def parts(values: np.ndarray) -> tuple[Floats, Floats]:
        return np.ascontiguousarray(values.real), np.ascontiguousarray(values.imag)

    return Steps(parts(advance.advance), parts(advance.drive.T), parts(advance.observe), advance.compliance)


def _contacts(window: Window) -> Contacts:
    """Friction at the bit first, where there is some, then along the string."""
    frictions: list[Friction] = [contact.friction for contact in window.contacts]
    if window.bit_friction is not None:
        frictions.insert(0, window.bit_friction)
    return Contacts(
        np.array([LAWS.index(friction.law) for friction in frictions], dtype=np.int64),
        np.array([FALLS.index(friction.fall) for friction in frictions], dtype=np.int64),
        *(np.array([getattr(each, name) for each in frictions], dtype=float) for name in ("coulomb", "rise")),
        np.array([friction.threshold for friction in frictions], dtype=float),
    )


def _rates(window: Window, step: float) -> Rates:
    control, drive, blades = window.control, window.drive, window.blades
    every = max(1, round(control.interval / step))
    return Rates(
        step=step,
        every=every,
        proportional=control.proportional,
        integral=control.integral,
        speed_filter=control.speed_filter,
        torque_filter=control.torque_filter,
        windup_gain=control.windup_gain,
        notch=_notch(control.notch, control.notch_depth, every * step),
        ripple=window.recording.ripple,
        delay=drive.delay / step,
        gain=drive.gain,
        lag=1.0 if drive.lag == 0 else 1 - float(np.exp(-step / drive.lag)),
        limit=drive.limit,
        rate=drive.rate * step,
        resonance=np.array([2 * np.pi * drive.resonance, RESONANCE_DAMPING]),
        half_play=drive.play / 2 if drive.play > 0 else -1.0,
        motor_inertia=max(drive.inertia * (1 - drive.share_below_gear), 1e-9),
        blades=blades.count if blades else 0,
        blade_torque=blades.torque if blades else 0.0,
        blade_time=2 * np.pi / window.speed / blades.count / step if blades else 1.0,
    )


def _notch(frequency: float, depth: float, interval: float) -> Floats:
    """Coefficients of a notch by the trapezoidal rule; those of a plain gain of one at 0 Hz."""
    if frequency == 0:
        return np.array([1.0, 0.0, 0.0, 0.0, 0.0])
    rate, centre = 2 / interval, 2 * np.pi * frequency
    spread = 2 * NOTCH_WIDTH * centre * rate
    left = (1 - depth) * spread
    above = np.array([rate**2 + left + centre**2, 2 * (centre**2 - rate**2), rate**2 - left + centre**2])
    below = np.array([rate**2 + spread + centre**2, 2 * (centre**2 - rate**2), rate**2 - spread + centre**2])
    return np.concatenate([above / below[0], below[1:] / below[0]])

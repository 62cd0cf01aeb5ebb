"""Time-domain simulation of a drilling rig: top drive under speed control, string, bit, and what is not linear.

The string is cut into springs and inertias such that a wave passes one spring a time step. At that
ratio the leap-frog scheme moves waves without dispersion, whatever the frequency; sections that are not
a whole number of steps long come close to it. What is left are errors of second order in the step,
about 0.03 % of the command mobility at 5 Hz for the default step. The simulator shares nothing with
the transmission-line formulas but the description of the equipment.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drillid.arrays import Floats
from drillid.errors import SettingsError
from drillid.physics.equipment import DrillingSystem
from drillid.physics.nonlinear import Course, NonlinearRig
from drillid.simulation.grid import build, element_counts, whole_steps
from drillid.simulation.initial_state import steady_state, take_grip
from drillid.simulation.kernel import OUTPUTS, flank_torque, march
from drillid.simulation.parts import TWIST, Inputs, Machine, State

TIME_STEP = 0.0025
"""s."""
SAMPLE_INTERVAL = 0.02
"""s; rig logs give torque and speed at 50 Hz."""
RENEWAL = 1.0
"""s, after which a rig that changes in time is described anew."""


@dataclass(frozen=True)
class Energies:
    """Energies of one simulation, J; supplied + brought = dissipated + stored."""

    supplied: float
    """Work of the drive less work taken by the given bit torque."""
    brought: float
    """Energy that came with new descriptions of a rig that changes in time."""
    dissipated: float
    """Lost in mud, steel, bottom-hole assembly, friction, cutting and gear."""
    stored: float
    """Gain of kinetic and elastic energy."""


@dataclass(frozen=True)
class Simulation:
    """Samples of one simulation, each (samples,); torques belong to half a time step after `time`."""

    time: Floats
    """s since the first step."""
    speed: Floats
    """rad/s, of the top drive."""
    speed_reading: Floats
    """rad/s, as the speed sensor gives it."""
    torque_command: Floats
    """N m, sweep included, before the drive's delay; at `time`. 0 where the top drive follows a given speed."""
    drive_torque: Floats
    """N m, of the drive on the top drive's inertia."""
    string_torque: Floats
    """N m, into the top of the string."""
    bit_speed: Floats
    """rad/s."""
    torque_on_bit: Floats
    """N m, of the rock and, where the string rubs at the bit, of the wall."""
    energies: Energies | None
    """Given where asked for."""


def simulate(
    rig: DrillingSystem | NonlinearRig | Course,
    sweep: Floats,
    speed_set: Floats,
    bit_torque: Floats,
    *,
    mean_bit_torque: float = 0.0,
    weight_on_bit: Floats | float = 0.0,
    top_speed: Floats | None = None,
    time_step: float = TIME_STEP,
    sample_interval: float = SAMPLE_INTERVAL,
    seed: int | Sequence[int] = 0,
    energies: bool = False,
) -> Simulation:
    """Simulate from steady rotation, or standstill, at the first set point.

    Parameters
    ----------
    rig : equipment in plain numbers; a function of time gives one that changes, read every RENEWAL seconds
    sweep : (steps,) N m, injected torque at each step
    speed_set : (steps,) rad/s, set point of the speed control
    bit_torque : (steps,) N m, all torque that the rock takes from the bit beside the rig's own cutting
    mean_bit_torque : N m, `bit_torque` before the first step
    weight_on_bit : N, (steps,) or the same at each step
    top_speed : (steps,) rad/s, speed that the top drive follows whatever it takes, without control and drive
    time_step : s
    sample_interval : s, a whole number of time steps
    seed : of the delay's jitter
    energies : also sum up the energies

    Raises
    ------
    SettingsError
        If an interval is no whole number of steps, a section is shorter than a wave's way in a step, an input
        has another length than the others, or a rig that changes in time changes its parts.
    """
    every = whole_steps("sample interval", sample_interval, time_step)
    rigs, block = _rigs(rig, sweep.size, time_step)
    # the fewest elements keep a string that grows or shrinks within the scheme's stability
    counts = tuple(map(min, zip(*(element_counts(one, time_step) for one in rigs), strict=True)))
    machines = [_build(one, counts, time_step, top_speed is not None) for one in rigs]
    _check_parts(machines)
    jitter = _jitter(rigs, block, sweep.size, time_step, seed)
    inputs = _inputs((sweep, speed_set, bit_torque), weight_on_bit, top_speed, jitter)
    state = steady_state(machines, inputs, mean_bit_torque, time_step)
    outputs = np.zeros((OUTPUTS, (sweep.size + every - 1) // every))
    account, brought = np.zeros(2), 0.0
    before = stored = _stored(machines[0], state, time_step)
    for number, machine in enumerate(machines):
        brought += _stored(machine, state, time_step) - stored
        take_grip(machine, state, top_speed is not None)
        span = (number * block, min((number + 1) * block, sweep.size))
        march(machine, inputs, state, span, time_step, every, outputs, account, energies)
        stored = _stored(machine, state, time_step)
    balance = Energies(float(account[0]), brought, float(account[1]), stored - before) if energies else None
    speed, reading, command, drive, string, bit_speed, on_bit = outputs
    time = sample_interval * np.arange(outputs.shape[1], dtype=float)
    return Simulation(time, speed, reading, command, drive, string, bit_speed, on_bit, balance)


def _rigs(rig: DrillingSystem | NonlinearRig | Course, steps: int, time_step: float) -> tuple[list[NonlinearRig], int]:
    """Descriptions for one block of steps after another, and the blocks' length in steps."""
    if isinstance(rig, DrillingSystem):
        return [NonlinearRig(rig)], steps
    if isinstance(rig, NonlinearRig):
        return [rig], steps
    block = max(1, round(RENEWAL / time_step))
    rigs = [rig(first * time_step) for first in range(0, steps, block)]
    if len({len(one.system.string) for one in rigs}) > 1:
        raise SettingsError("simulation", "sections of the string come or go in time", "Let them change size only")
    return rigs, block


def _check_parts(machines: Sequence[Machine]) -> None:
    """The state that is carried from block to block must keep its shape."""
    parts = {
        (one.grid.inertia.size, one.gear.present, one.rock.blades > 0, one.memory.shunt.shape, one.memory.series.shape)
        for one in machines
    }
    if len(parts) > 1:
        raise SettingsError(
            "simulation",
            "gear, motor, blades or damping laws with memory come or go in time",
            "Give them a size, however small, all the time",
        )


def _build(rig: NonlinearRig, counts: tuple[int, ...], time_step: float, imposed: bool) -> Machine:
    machine = build(rig, counts, time_step)
    friction = machine.friction
    if not imposed or friction.nodes.size == 0 or friction.nodes[0] != 0:
        return machine
    # a top drive that follows a speed is held already: the wall's grip on its node moves to the node below
    if friction.nodes.size > 1 and friction.nodes[1] == 1:
        friction.static[1] += friction.static[0]
        friction.dynamic[1] += friction.dynamic[0]
        friction = friction._replace(
            nodes=friction.nodes[1:],
            static=friction.static[1:].copy(),
            dynamic=friction.dynamic[1:].copy(),
            rest=friction.rest[1:].copy(),
        )
    else:
        friction.nodes[0] = 1
    return machine._replace(friction=friction)


def _inputs(
    series: tuple[Floats, Floats, Floats], weight: Floats | float, top_speed: Floats | None, jitter: Floats
) -> Inputs:
    steps = series[0].size
    weights = np.full(steps, float(weight)) if np.ndim(weight) == 0 else np.asarray(weight, dtype=float)
    given = [*series, weights] if top_speed is None else [*series, weights, np.asarray(top_speed, dtype=float)]
    if steps == 0 or any(one.shape != (steps,) for one in given):
        raise SettingsError(
            "simulation", f"inputs have the shapes {[one.shape for one in given]}", "Give one value for each step"
        )
    followed = np.empty(0) if top_speed is None else np.append(given[4], given[4][-1])
    sweep, speed_set, bit_torque, weights = (np.ascontiguousarray(one, dtype=float) for one in given[:4])
    return Inputs(sweep, speed_set, bit_torque, weights, jitter, followed)


def _jitter(
    rigs: Sequence[NonlinearRig], block: int, steps: int, time_step: float, seed: int | Sequence[int]
) -> Floats:
    sizes = np.array([float(rig.system.top_drive.delay_jitter) for rig in rigs])
    if not sizes.any():
        return np.zeros(1)
    intervals = {rig.limits.jitter_interval for rig in rigs}
    if len(intervals) > 1:
        raise SettingsError("simulation", "the jitter's interval changes in time", "Let its size change only")
    every = whole_steps("jitter interval", intervals.pop(), time_step)
    draws = np.random.default_rng(seed).standard_normal(-(-steps // every))
    return np.asarray(np.repeat(sizes, block)[:steps] * np.repeat(draws, every)[:steps], dtype=float)


def _stored(machine: Machine, state: State, time_step: float) -> float:
    """Kinetic and elastic energy, J; the product of the torques of both half steps is what leap-frog conserves."""
    grid, gear = machine.grid, machine.gear
    after = state.torque + time_step * grid.stiffness * (state.speed[:-1] - state.speed[1:])
    if gear.present:
        twist = state.memory[TWIST] + time_step * (state.speed[0] - state.speed[1])
        after[0] = flank_torque(twist, gear.half_play, grid.stiffness[0])
    return float(np.sum(grid.inertia * state.speed**2) / 2 + np.sum(state.torque * after / grid.stiffness) / 2)

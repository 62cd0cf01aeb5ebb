"""Time-domain simulation of a drilling rig: top drive under speed control, string, bit, and nonlinear parts.

The string is divided into springs and inertias such that a wave passes one spring per time step. At this
Courant number the leap-frog scheme has no dispersion at any frequency; sections that are not a whole number
of steps long come close to it. The remaining errors are of second order in the step, about 0.03 % of the
command mobility at 5 Hz for the default step. The simulator shares only the description of the equipment
with the transmission-line formulas.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drillid.arrays import Floats
from drillid.errors import SettingsError
from drillid.physics.equipment import DrillingSystem
from drillid.physics.nonlinear import NonlinearRig, VaryingRig
from drillid.simulation.grid import build, element_counts, whole_steps
from drillid.simulation.initial_state import steady_state, update_contacts
from drillid.simulation.kernel import OUTPUTS, flank_torque, march
from drillid.simulation.parts import TWIST, CouplingTable, Inputs, Machine, State

TIME_STEP = 0.0025
"""s."""
SAMPLE_INTERVAL = 0.02
"""s; rig logs give torque and speed at 50 Hz."""
UPDATE_INTERVAL = 1.0
"""s, between updates of the parameters of a time-varying rig."""
_ENERGY_POINTS = 2001


@dataclass(frozen=True)
class Energies:
    """Energies of one simulation, J; supplied + parametric = dissipated + stored."""

    supplied: float
    """Work of the drive less that of the given bit torque."""
    parametric: float
    """Change of stored energy by updates of a time-varying rig."""
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
    """rad/s, as read by the speed sensor."""
    torque_command: Floats
    """N m, sweep included, before the drive's delay; at `time`. 0 where the top-drive speed is prescribed."""
    drive_torque: Floats
    """N m, of the drive on the top drive's inertia."""
    string_torque: Floats
    """N m, into the top of the string."""
    bit_speed: Floats
    """rad/s."""
    torque_on_bit: Floats
    """N m, of the rock and, where the string touches the wall at the bit, of the wall."""
    energies: Energies | None
    """None unless requested."""


def simulate(
    rig: DrillingSystem | NonlinearRig | VaryingRig,
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
    rig : equipment in plain numbers; a function of time for a time-varying rig, called every UPDATE_INTERVAL seconds
    sweep : (steps,) N m, injected torque at each step
    speed_set : (steps,) rad/s, set point of the speed control
    bit_torque : (steps,) N m, torque of the rock on the bit in addition to the rig's own cutting
    mean_bit_torque : N m, `bit_torque` before the first step
    weight_on_bit : N, (steps,) or the same at each step
    top_speed : (steps,) rad/s, prescribed speed of the top drive; control and drive then have no effect
    time_step : s
    sample_interval : s, a whole number of time steps
    seed : of the delay's jitter
    energies : also compute the energies

    Raises
    ------
    SettingsError
        If an interval is not a whole number of steps, a section is shorter than a wave travels in a step, an input
        has another length than the others, or a time-varying rig changes its parts.
    """
    every = whole_steps("sample interval", sample_interval, time_step)
    rigs, block = _rigs(rig, sweep.size, time_step)
    # the fewest elements keep a string that grows or shrinks within the scheme's stability
    counts = tuple(map(min, zip(*(element_counts(described, time_step) for described in rigs), strict=True)))
    machines = [_build(described, counts, time_step, top_speed is not None) for described in rigs]
    _check_parts(machines)
    jitter = _jitter(rigs, block, sweep.size, time_step, seed)
    inputs = _inputs((sweep, speed_set, bit_torque), weight_on_bit, top_speed, jitter)
    state = steady_state(machines, inputs, mean_bit_torque, time_step)
    outputs = np.zeros((OUTPUTS, (sweep.size + every - 1) // every))
    account, parametric = np.zeros(2), 0.0
    before = stored = _stored(machines[0], state, time_step)
    for number, machine in enumerate(machines):
        parametric += _stored(machine, state, time_step) - stored
        update_contacts(machine, state, top_speed is not None)
        span = (number * block, min((number + 1) * block, sweep.size))
        march(machine, inputs, state, span, time_step, every, outputs, account, energies)
        stored = _stored(machine, state, time_step)
    balance = Energies(float(account[0]), parametric, float(account[1]), stored - before) if energies else None
    speed, reading, command, drive, string, bit_speed, on_bit = outputs
    time = sample_interval * np.arange(outputs.shape[1], dtype=float)
    return Simulation(time, speed, reading, command, drive, string, bit_speed, on_bit, balance)


def _rigs(
    rig: DrillingSystem | NonlinearRig | VaryingRig, steps: int, time_step: float
) -> tuple[list[NonlinearRig], int]:
    """Descriptions for one block of steps after another, and the blocks' length in steps."""
    if isinstance(rig, DrillingSystem):
        return [NonlinearRig(rig)], steps
    if isinstance(rig, NonlinearRig):
        return [rig], steps
    block = max(1, round(UPDATE_INTERVAL / time_step))
    rigs = [rig(first * time_step) for first in range(0, steps, block)]
    if len({len(described.system.string) for described in rigs}) > 1:
        raise SettingsError("simulation", "the number of sections changes in time", "Change their parameters only")
    return rigs, block


def _check_parts(machines: Sequence[Machine]) -> None:
    """Check that the state keeps its shape from block to block."""
    parts = {
        (
            machine.grid.inertia.size,
            machine.gear.present,
            machine.rock.blades > 0,
            machine.memory.shunt.shape,
            machine.memory.series.shape,
            machine.mounts.nodes.size,
        )
        for machine in machines
    }
    if len(parts) > 1:
        raise SettingsError(
            "simulation",
            "gear, motor, blades, mounted inertias or damping laws with memory appear or vanish in time",
            "Keep each of them at all times, with a small parameter where it should have no effect",
        )


def _build(rig: NonlinearRig, counts: tuple[int, ...], time_step: float, imposed: bool) -> Machine:
    machine = build(rig, counts, time_step)
    friction = machine.friction
    if not imposed or friction.nodes.size == 0 or friction.nodes[0] != 0:
        return machine
    # the speed of the top node is prescribed, so its wall friction is moved to the node below
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
    arrays = [*series, weights] if top_speed is None else [*series, weights, np.asarray(top_speed, dtype=float)]
    if steps == 0 or any(array.shape != (steps,) for array in arrays):
        raise SettingsError(
            "simulation", f"inputs have the shapes {[array.shape for array in arrays]}", "Give one value for each step"
        )
    prescribed = np.empty(0) if top_speed is None else np.append(arrays[4], arrays[4][-1])
    sweep, speed_set, bit_torque, weights = (np.ascontiguousarray(array, dtype=float) for array in arrays[:4])
    return Inputs(sweep, speed_set, bit_torque, weights, jitter, prescribed)


def _jitter(
    rigs: Sequence[NonlinearRig], block: int, steps: int, time_step: float, seed: int | Sequence[int]
) -> Floats:
    sizes = np.array([float(rig.system.top_drive.delay_jitter) for rig in rigs])
    if not sizes.any():
        return np.zeros(1)
    intervals = {rig.limits.jitter_interval for rig in rigs}
    if len(intervals) > 1:
        raise SettingsError("simulation", "the jitter's interval changes in time", "Change its size only")
    every = whole_steps("jitter interval", intervals.pop(), time_step)
    draws = np.random.default_rng(seed).standard_normal(-(-steps // every))
    return np.asarray(np.repeat(sizes, block)[:steps] * np.repeat(draws, every)[:steps], dtype=float)


def _stored(machine: Machine, state: State, time_step: float) -> float:
    """Kinetic and elastic energy, J; leap-frog conserves the product of the torques of both half steps."""
    grid, gear = machine.grid, machine.gear
    after = state.torque + time_step * grid.stiffness * (state.speed[:-1] - state.speed[1:])
    if gear.present:
        twist = state.memory[TWIST] + time_step * (state.speed[0] - state.speed[1])
        after[0] = flank_torque(twist, gear.half_play, grid.stiffness[0])
    energy = float(np.sum(grid.inertia * state.speed**2) / 2 + np.sum(state.torque * after / grid.stiffness) / 2)
    return energy + _coupling_energy(machine.coupling, state.torque)


def _coupling_energy(coupling: CouplingTable, torque: Floats) -> float:
    """Elastic energy of a coupling's own twist, ∫ T dφ, J."""
    if coupling.spring < 0:
        return 0.0
    rising = np.linspace(0.0, torque[coupling.spring], _ENERGY_POINTS)
    known = coupling.first + coupling.spacing * np.arange(coupling.compliance.size)
    return float(np.trapezoid(rising * np.interp(rising, known, coupling.compliance), rising))

"""The time-domain simulator's inner loop, compiled.

Speeds are defined at whole steps, the elastic torques between nodes at half steps. Elastic torques are
leap-frogged; damping and friction are implicit, with one symmetric tridiagonal solution per step.
"""

import numpy as np

from drillid.arrays import Floats
from drillid.simulation.drive import control_torque, drive_torque, read_speed
from drillid.simulation.friction import (
    acting_speed,
    chip_torque,
    factorise,
    reaction,
    set_levels,
    settle,
)
from drillid.simulation.parts import (
    FOLLOWING,
    MEASURED,
    TOP_ANGLE,
    TWIST,
    CouplingTable,
    Inputs,
    Machine,
    Memory,
    Mounts,
    Scratch,
    SpatialGrid,
    State,
    allocating,
    compiled,
)
from drillid.simulation.tables import coupling_compliance, law_torque

OUTPUTS = 7
"""Top-drive speed, its reading, command, drive torque, torque into the string, bit speed, torque on bit."""
SUPPLIED, DISSIPATED = 0, 1


@compiled
def flank_torque(twist: float, half_play: float, stiffness: float) -> float:
    """Elastic torque of the gear at a twist; zero within the play."""
    if twist > half_play:
        return stiffness * (twist - half_play)
    if twist < -half_play:
        return stiffness * (twist + half_play)
    return 0.0


@compiled
def _twist(machine: Machine, state: State, step: float) -> bool:
    """Advance the torques of all springs; returns whether the gear's teeth have come into contact or separated."""
    grid, gear, coupling = machine.grid, machine.gear, machine.coupling
    coupled = state.torque[coupling.spring]
    for i in range(state.torque.size):
        state.torque[i] += step * grid.stiffness[i] * (state.speed[i] - state.speed[i + 1])
    if coupling.spring >= 0:
        i = coupling.spring
        state.torque[i] = _gives_way(coupling, coupled, grid.stiffness[i], state.torque[i] - coupled)
    if not gear.present:
        return False
    state.memory[TWIST] += step * (state.speed[0] - state.speed[1])
    state.torque[0] = flank_torque(state.memory[TWIST], gear.half_play, grid.stiffness[0])
    damping = gear.damping if state.torque[0] != 0.0 else 0.0
    changed = bool(damping != grid.coupling[0])
    grid.coupling[0] = damping
    return changed


@compiled
def _gives_way(coupling: CouplingTable, before: float, stiffness: float, added: float) -> float:
    """Torque of the coupling's spring after a step that would add `added` if it were as stiff as the string alone."""
    # the compliance is taken halfway between both torques, for second-order accuracy
    after = before + added / (1 + stiffness * coupling_compliance(coupling, before))
    return float(before + added / (1 + stiffness * coupling_compliance(coupling, (before + after) / 2)))


@compiled
def _push(grid: SpatialGrid, state: State, drive: float, rock: float, half_step: float, push: Floats) -> None:
    """Momentum plus impulse over half a step of all torques but damping and friction, (n + 1,) into `push`."""
    count = state.torque.size
    push[0] = grid.inertia[0] * state.speed[0] + half_step * (drive - state.torque[0])
    for i in range(1, count):
        push[i] = grid.inertia[i] * state.speed[i] + half_step * (state.torque[i - 1] - state.torque[i])
    push[count] = grid.inertia[count] * state.speed[count] + half_step * (state.torque[count - 1] - rock)


@compiled
def _add_relaxations(memory: Memory, state: State, half_step: float, past: tuple[Floats, Floats], push: Floats) -> None:
    """Torques of the relaxations' states on nodes and in springs, into `past`, and their impulse added to `push`."""
    on_nodes, in_springs = past
    on_nodes[:] = 0.0
    in_springs[:] = 0.0
    for k in range(memory.shunt_decay.size):
        for i in range(on_nodes.size):
            on_nodes[i] += memory.shunt[k, i] * state.relaxed_speed[k, i]
    for k in range(memory.series_decay.size):
        for i in range(in_springs.size):
            in_springs[i] += memory.series[k, i] * state.unrelaxed_twist[k, i]
    for i in range(on_nodes.size):
        push[i] += half_step * on_nodes[i]
    for i in range(in_springs.size):
        push[i] -= half_step * in_springs[i]
        push[i + 1] += half_step * in_springs[i]


@compiled
def _relax(memory: Memory, state: State, mean: Floats, half_step: float) -> None:
    """Advance the relaxations by one step, trapezoidal rule."""
    for k in range(memory.shunt_decay.size):
        a = memory.shunt_decay[k]
        kept, gained = (1 - a) / (1 + a), 2 * a / (1 + a)
        for i in range(mean.size):
            state.relaxed_speed[k, i] = kept * state.relaxed_speed[k, i] + gained * mean[i]
    for k in range(memory.series_decay.size):
        a = memory.series_decay[k]
        kept, gained = (1 - a) / (1 + a), 2 * half_step / (1 + a)
        for i in range(mean.size - 1):
            state.unrelaxed_twist[k, i] = kept * state.unrelaxed_twist[k, i] + gained * (mean[i] - mean[i + 1])


@compiled
def _add_mounts(mounts: Mounts, state: State, half_step: float, past: Floats, push: Floats) -> None:
    """Torques of the mounted inertias' states on nodes, (M,) into `past`, and their impulse added to `push`."""
    for k in range(mounts.nodes.size):
        spring = mounts.stiffness[k] * state.mounted_twist[k]
        coasting = mounts.inertia[k] * state.mounted_speed[k] + half_step * spring
        past[k] = mounts.damping[k] * coasting / (mounts.inertia[k] + half_step * mounts.damping[k]) - spring
        push[mounts.nodes[k]] += half_step * past[k]


@compiled
def _swing(mounts: Mounts, state: State, mean: Floats, half_step: float) -> None:
    """Advance the mounted inertias by one step, trapezoidal rule."""
    for k in range(mounts.nodes.size):
        node = mean[mounts.nodes[k]]
        impulse = half_step * (mounts.stiffness[k] * state.mounted_twist[k] + mounts.damping[k] * node)
        own = (mounts.inertia[k] * state.mounted_speed[k] + impulse) / (
            mounts.inertia[k] + half_step * mounts.damping[k]
        )
        state.mounted_twist[k] += 2 * half_step * (node - own)
        state.mounted_speed[k] = 2 * own - state.mounted_speed[k]


@compiled
def _losses(machine: Machine, push: Floats, mean: Floats, half_step: float, past: tuple[Floats, Floats]) -> float:
    """Power dissipated in dampers and friction, W; energy stored in relaxations counts as lost until returned."""
    grid = machine.grid
    lost = 0.0
    for i in range(mean.size):
        lost += (grid.viscous[i] * mean[i] - past[0][i]) * mean[i]
    for i in range(mean.size - 1):
        twisting = mean[i] - mean[i + 1]
        lost += (grid.coupling[i] * twisting + past[1][i]) * twisting
    for node in machine.friction.nodes:
        lost += reaction(grid, push, mean, half_step, node) * mean[node]
    return lost


@compiled
def _into_string(machine: Machine, state: State, mean: Floats, drive: float, step: float) -> float:
    """Torque into the string, N m: that of drive or gear less the top drive's own inertia."""
    torque = drive - machine.top_inertia * 2 * (mean[0] - state.speed[0]) / step
    if machine.gear.present:
        flanks = state.torque[0] + machine.grid.coupling[0] * (mean[0] - mean[1])
        torque = flanks - machine.top_inertia * 2 * (mean[1] - state.speed[1]) / step
    return float(torque)


@compiled
def _command(machine: Machine, inputs: Inputs, state: State, step: float, n: int, newest: int) -> None:
    """Write the command of step n, held between readings of the speed."""
    control = machine.control
    if n % control.every:
        state.command[newest] = state.command[newest - 1]
        return
    reading = read_speed(control, state.speed[0], state.memory)
    interval = control.every * step
    state.command[newest] = inputs.sweep[n] + control_torque(
        control, interval, inputs.speed_set[n], reading, state.memory
    )


@compiled
def _advance(machine: Machine, state: State, mean: Floats, step: float, n: int) -> None:
    """Advance speeds, angles, relaxations, mounted inertias and friction after rest by one step."""
    if machine.memory.present:
        _relax(machine.memory, state, mean, step / 2)
    _swing(machine.mounts, state, mean, step / 2)
    state.memory[TOP_ANGLE] += step * mean[0]
    state.memory[FOLLOWING] += machine.law.followed * (mean[-1] - state.memory[FOLLOWING])
    if machine.rock.blades:
        state.angle[n + 1] = state.angle[n] + step * mean[-1]
    for k in range(machine.friction.nodes.size):
        if machine.friction.rest[k] > 0.0:
            i = machine.friction.nodes[k]
            state.rested[i] *= np.exp(-step * abs(mean[i]) / machine.friction.rest_angle)
    for i in range(mean.size):
        state.before[i] = state.speed[i]
        state.speed[i] = 2 * mean[i] - state.speed[i]


@allocating
def march(
    machine: Machine,
    inputs: Inputs,
    state: State,
    steps: tuple[int, int],
    step: float,
    every: int,
    outputs: Floats,
    energy: Floats,
    account: bool,
) -> None:
    """March the rig through a block of time steps.

    Parameters
    ----------
    machine, inputs : the rig, and torques and set points at each step
    state : at the first step of the block on entry, at its end on return
    steps : first step of the block, first step after it
    step : s
    every : steps between samples of the output
    outputs : (OUTPUTS, samples), written
    energy : (2,) J, supplied and dissipated, accumulated
    account : accumulate the energies, at some cost
    """
    count, contacts = state.torque.size, machine.friction.nodes.size
    scratch = Scratch(
        np.empty(count + 1),
        np.empty(count + 1),
        (np.empty(count), np.empty(count + 1)),
        (np.zeros(contacts), np.zeros(contacts)),
        (np.zeros(contacts, dtype=np.bool_), np.zeros(contacts, dtype=np.bool_)),
        (np.zeros(count + 1), np.zeros(count)),
        np.zeros(machine.mounts.nodes.size),
    )
    _march(machine, inputs, state, scratch, steps, step, every, outputs, energy, account)


@compiled
def _march(
    machine: Machine,
    inputs: Inputs,
    state: State,
    scratch: Scratch,
    steps: tuple[int, int],
    step: float,
    every: int,
    outputs: Floats,
    energy: Floats,
    account: bool,
) -> None:
    grid, rock, nodes = machine.grid, machine.rock, machine.friction.nodes
    mean, push, swinging = scratch.mean, scratch.push, scratch.swinging
    half_step, imposed = step / 2, inputs.top_speed.size > 0
    past = state.command.size - inputs.sweep.size
    bit_friction = nodes.size > 0 and nodes[-1] == state.torque.size
    factorise(grid, state.held, half_step, scratch.factors)
    for n in range(steps[0], steps[1]):
        drive, top_mean, chips = 0.0, 0.0, 0.0
        if imposed:
            top_mean = (state.speed[0] + inputs.top_speed[n + 1]) / 2
            state.command[past + n] = 0.0
            read_speed(machine.control, state.speed[0], state.memory)
        else:
            _command(machine, inputs, state, step, n, past + n)
            jitter = inputs.jitter[n % inputs.jitter.size]
            drive = drive_torque(machine.drive, step, state.command, past + n, jitter, state.memory)
        if _twist(machine, state, step):
            factorise(grid, state.held, half_step, scratch.factors)
        set_levels(machine.friction, rock, inputs.weight[n], state, scratch.levels)
        if rock.blades:
            chips = chip_torque(rock, inputs.weight[n], state, n, step)
        rock_torque = inputs.bit_torque[n]
        if machine.law.present:
            rock_torque += law_torque(machine.law, acting_speed(machine.law, state))
        _push(grid, state, drive, rock_torque, half_step, push)
        if machine.memory.present:
            _add_relaxations(machine.memory, state, half_step, scratch.relaxing, push)
        _add_mounts(machine.mounts, state, half_step, swinging, push)
        settle(grid, nodes, scratch, chips, state, half_step, top_mean)
        if imposed:
            drive = -reaction(grid, push, mean, half_step, 0)
        if n % every == 0:
            output = outputs[:, n // every]
            output[0], output[1], output[2] = state.speed[0], state.memory[MEASURED], state.command[past + n]
            output[3], output[4], output[5] = drive, _into_string(machine, state, mean, drive, step), state.speed[-1]
            output[6] = rock_torque
            if bit_friction:
                output[6] += reaction(grid, push, mean, half_step, state.torque.size)
        if account:
            energy[SUPPLIED] += step * (drive * mean[0] - inputs.bit_torque[n] * mean[-1])
            energy[DISSIPATED] += step * _losses(machine, push, mean, half_step, scratch.relaxing)
            energy[DISSIPATED] += step * (rock_torque - inputs.bit_torque[n]) * mean[-1]
            for k in range(swinging.size):
                energy[DISSIPATED] -= step * swinging[k] * mean[machine.mounts.nodes[k]]
        _advance(machine, state, mean, step, n)

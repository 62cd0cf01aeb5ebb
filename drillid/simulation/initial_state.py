"""Initial state of the simulated rig, and changes of contact while it runs."""

from collections.abc import Sequence

import numpy as np

from drillid.arrays import Floats
from drillid.errors import SettingsError
from drillid.simulation.parts import (
    DEMAND,
    DRIVE_BEFORE,
    DRIVE_TORQUE,
    EARLIER_CUT,
    ERROR,
    FILTERED,
    FOLLOWING,
    INTEGRAL,
    MEAN_STRING,
    MEASURED,
    MEMORY_SIZE,
    SHAPED_CONTROL,
    SHAPED_DRIVE,
    SMOOTH_ERROR,
    SMOOTH_STRING,
    SPEED,
    STRING_TORQUE,
    TORQUE,
    TWIST,
    UNFILTERED,
    Inputs,
    Machine,
    NodeFriction,
    Rock,
    State,
)
from drillid.simulation.tables import law_torque


def steady_state(machines: Sequence[Machine], inputs: Inputs, mean_bit_torque: float, time_step: float) -> State:
    """State of steady rotation, or of a string at rest loaded only by the given torque at its lower end."""
    machine, steps = machines[0], inputs.sweep.size
    grid, friction, rock, gear = machine.grid, machine.friction, machine.rock, machine.gear
    scale = machine.control.scale
    first = float(inputs.speed_set[0] / scale if inputs.top_speed.size == 0 else inputs.top_speed[0])
    if first < 0 or (first == 0 and rock.blades and mean_bit_torque):
        raise SettingsError("simulation", "it cannot start from this rotation", "Start at rest or turning forward")
    # relaxations and mounted inertias take no torque at a constant speed
    viscous = grid.viscous - machine.memory.shunt.sum(axis=0)
    np.subtract.at(viscous, machine.mounts.nodes, machine.mounts.load)
    resistance = viscous * first
    resistance[-1] += mean_bit_torque
    if machine.law.present:
        resistance[-1] += law_torque(machine.law, first)
    earlier = 0.0
    if first > 0:
        resistance[friction.nodes] += _weakened(friction.static, friction.dynamic, first, friction)
        weight = max(float(inputs.weight[0]), 0.0)
        resistance[-1] += weight * float(_weakened(rock.static, rock.dynamic, first, rock)) if rock.cuts else 0.0
        earlier = min(rock.rate / first, rock.depth_per_weight * weight / (2 * np.pi))
        resistance[-1] += rock.torque_per_depth * earlier * 2 * np.pi
    torque = np.cumsum(resistance[::-1])[::-1][1:].copy()
    load = float(resistance.sum()) / machine.drive.gain
    error = inputs.speed_set[0] - scale * first
    memory = np.zeros(MEMORY_SIZE)
    memory[[SPEED, FILTERED, MEASURED]] = scale * first
    memory[EARLIER_CUT], memory[FOLLOWING] = earlier, first
    memory[[UNFILTERED, TORQUE]] = load
    for place, shaping in ((SHAPED_CONTROL, machine.control.shaping), (SHAPED_DRIVE, machine.drive.shaping)):
        _, b1, b2, a1, a2 = shaping
        memory[[place, place + 1]] = load * (b1 - a1 + b2 - a2), load * (b2 - a2)
    memory[[DEMAND, DRIVE_TORQUE, DRIVE_BEFORE, STRING_TORQUE, SMOOTH_STRING]] = machine.drive.gain * load
    if machine.control.matching_high_pass < np.inf:
        memory[MEAN_STRING] = memory[SMOOTH_STRING]
    else:
        error -= machine.control.matching * memory[SMOOTH_STRING]
    proportional = machine.control.proportional * error
    if machine.control.law.present:
        proportional += law_torque(machine.control.law, error)
    memory[[ERROR, SMOOTH_ERROR]], memory[INTEGRAL] = error, load - proportional
    if gear.present:
        memory[TWIST] = torque[0] / grid.stiffness[0] + np.sign(torque[0]) * gear.half_play
        grid.coupling[0] = gear.damping if torque[0] != 0.0 else 0.0
    speed = np.full(grid.inertia.size, first)
    slip, held = np.zeros(speed.size, dtype=np.int8), np.zeros(speed.size, dtype=np.bool_)
    longest = max(machine.drive.delay for machine in machines) + float(inputs.jitter.max())
    past = max(1, int(np.floor(longest / time_step))) + 3
    command = np.full(past + steps, load)
    angle = np.zeros(steps + 1 if rock.blades else 1)
    relaxed = np.full(machine.memory.shunt.shape, first)
    twists = np.zeros(machine.memory.series.shape)
    rested = np.full(speed.size, float(first == 0))
    mounted = np.full(machine.mounts.nodes.size, first), np.zeros(machine.mounts.nodes.size)
    return State(
        speed, speed.copy(), torque, slip, held, rested, memory, relaxed, twists, *mounted, command, angle, angle.copy()
    )


def _weakened(static: Floats | float, dynamic: Floats | float, speed: float, law: NodeFriction | Rock) -> Floats:
    share = np.exp(-((speed / law.threshold) ** law.exponent))
    return np.asarray(dynamic + (np.asarray(static) - dynamic) * share, dtype=float)


def update_contacts(machine: Machine, state: State, imposed: bool) -> None:
    """Let nodes with new contact slip in their direction of rotation, or stick, and release nodes without contact."""
    touches = np.zeros(state.slip.size, dtype=np.bool_)
    touches[machine.friction.nodes] = True
    new = touches & (state.slip == 0) & ~state.held
    state.slip[new] = np.sign(state.speed[new])
    state.slip[~touches] = 0
    state.held[:] = touches & (state.slip == 0)
    state.held[0] |= imposed

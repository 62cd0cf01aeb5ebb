"""What the simulated rig is doing before the first step, and where friction takes hold later on."""

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
    INTEGRAL,
    MEAN_STRING,
    MEASURED,
    MEMORY_SIZE,
    SMOOTH_ERROR,
    SMOOTH_STRING,
    SPEED,
    STRING_TORQUE,
    TORQUE,
    TWIST,
    WANTED,
    Friction,
    Inputs,
    Machine,
    Rock,
    State,
)


def steady_state(machines: Sequence[Machine], inputs: Inputs, mean_bit_torque: float, time_step: float) -> State:
    """State of steady rotation, or of a string at rest with nothing but the given torque at its lower end."""
    machine, steps = machines[0], inputs.sweep.size
    grid, friction, rock, gear = machine.grid, machine.friction, machine.rock, machine.gear
    scale = machine.control.scale
    first = float(inputs.speed_set[0] / scale if inputs.top_speed.size == 0 else inputs.top_speed[0])
    if first < 0 or (first == 0 and rock.blades and mean_bit_torque):
        raise SettingsError("simulation", "it cannot start from this rotation", "Start at rest or turning forward")
    # laws with memory take nothing from a speed that has lasted
    taken = (grid.viscous - machine.memory.shunt.sum(axis=0)) * first
    taken[-1] += mean_bit_torque
    earlier = 0.0
    if first > 0:
        taken[friction.nodes] += _weakened(friction.static, friction.dynamic, first, friction)
        weight = max(float(inputs.weight[0]), 0.0)
        taken[-1] += weight * float(_weakened(rock.static, rock.dynamic, first, rock)) if rock.cuts else 0.0
        earlier = min(rock.rate / first, rock.depth_per_weight * weight / (2 * np.pi))
        taken[-1] += rock.torque_per_depth * earlier * 2 * np.pi
    torque = np.cumsum(taken[::-1])[::-1][1:].copy()
    load = float(taken.sum()) / machine.drive.gain
    error = inputs.speed_set[0] - scale * first
    memory = np.zeros(MEMORY_SIZE)
    memory[[SPEED, FILTERED, MEASURED]] = scale * first
    memory[EARLIER_CUT] = earlier
    memory[[WANTED, TORQUE]] = load
    memory[[DEMAND, DRIVE_TORQUE, DRIVE_BEFORE, STRING_TORQUE, SMOOTH_STRING]] = machine.drive.gain * load
    if machine.control.matching_high_pass < np.inf:
        memory[MEAN_STRING] = memory[SMOOTH_STRING]
    else:
        error -= machine.control.matching * memory[SMOOTH_STRING]
    memory[[ERROR, SMOOTH_ERROR]], memory[INTEGRAL] = error, load - machine.control.proportional * error
    if gear.present:
        memory[TWIST] = torque[0] / grid.stiffness[0] + np.sign(torque[0]) * gear.half_play
        grid.coupling[0] = gear.damping if torque[0] != 0.0 else 0.0
    speed = np.full(grid.inertia.size, first)
    slip, held = np.zeros(speed.size, dtype=np.int8), np.zeros(speed.size, dtype=np.bool_)
    longest = max(one.drive.delay for one in machines) + float(inputs.jitter.max())
    past = max(1, int(np.floor(longest / time_step))) + 3
    command = np.full(past + steps, load)
    angle = np.zeros(steps + 1 if rock.blades else 1)
    relaxed = np.full(machine.memory.shunt.shape, first)
    twists = np.zeros(machine.memory.series.shape)
    rested = np.full(speed.size, float(first == 0))
    return State(speed, speed.copy(), torque, slip, held, rested, memory, relaxed, twists, command, angle, angle.copy())


def _weakened(static: Floats | float, dynamic: Floats | float, speed: float, law: Friction | Rock) -> Floats:
    fallen = np.exp(-((speed / law.threshold) ** law.exponent))
    return np.asarray(dynamic + (np.asarray(static) - dynamic) * fallen, dtype=float)


def take_grip(machine: Machine, state: State, imposed: bool) -> None:
    """Nodes that begin to rub slip as they turn, or stick; those that no longer rub are let go."""
    rubs = np.zeros(state.slip.size, dtype=np.bool_)
    rubs[machine.friction.nodes] = True
    new = rubs & (state.slip == 0) & ~state.held
    state.slip[new] = np.sign(state.speed[new])
    state.slip[~rubs] = 0
    state.held[:] = rubs & (state.slip == 0)
    state.held[0] |= imposed

"""The time-domain simulator's inner loop, compiled.

Speeds live at whole steps, twists between nodes and the drive's torque at half steps. Elastic
forces are leap-frogged, damping is centred implicitly: one symmetric tridiagonal solution a step.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Vector = NDArray[np.float64]


class Grid(NamedTuple):
    """The string as nodes 0 … n (top drive … bit) and the n springs between them."""

    inertia: Vector
    """(n + 1,) kg m², top drive and bit included."""
    viscous: Vector
    """(n + 1,) N m s/rad, damping of each node against the ground."""
    stiffness: Vector
    """(n,) N m/rad."""
    coupling: Vector
    """(n,) N m s/rad, damping in parallel with each spring."""


class Loop(NamedTuple):
    """Speed control and drive in discrete time."""

    proportional: float
    """N m s/rad."""
    integral: float
    """N m/rad."""
    speed_filter: float
    """s."""
    torque_filter: float
    """s."""
    lag: float
    """s."""
    delay_steps: int
    """Age, in steps, of the newest command but one that enters the delayed command."""
    delay_weights: Vector
    """(4,) weights of the commands of ages delay_steps − 1 … delay_steps + 2."""


class Inputs(NamedTuple):
    """What acts on the rig at each step."""

    sweep: Vector
    """(steps,) N m, injected torque."""
    speed_set: Vector
    """(steps,) rad/s."""
    bit_torque: Vector
    """(steps,) N m, torque that the rock takes from the bit, half a step after the step's speeds."""


@njit(cache=True)
def _factors(grid: Grid, half_step: float) -> tuple[Vector, Vector]:
    """LDLᵀ factors of inertia + half_step · damping: off-diagonal multipliers (n,), inverse pivots (n + 1,)."""
    count = grid.coupling.size
    multiplier = np.empty(count)
    inverse = np.empty(count + 1)
    diagonal = grid.inertia + half_step * grid.viscous
    diagonal[:count] += half_step * grid.coupling
    diagonal[1:] += half_step * grid.coupling
    for i in range(count):
        inverse[i] = 1.0 / diagonal[i]
        multiplier[i] = half_step * grid.coupling[i] * inverse[i]
        diagonal[i + 1] -= multiplier[i] * half_step * grid.coupling[i]
    inverse[count] = 1.0 / diagonal[count]
    return multiplier, inverse


@njit(cache=True)
def _low_pass(before: float, now: float, state: float, time_constant: float, step: float) -> float:
    """First-order low pass by the trapezoidal rule; a time constant of 0 passes the input."""
    if time_constant == 0.0:
        return now
    return ((2 * time_constant - step) * state + step * (before + now)) / (2 * time_constant + step)


@njit(cache=True, fastmath={"contract"})
def _mean_speeds(
    speed: Vector,
    torque: Vector,
    grid: Grid,
    multiplier: Vector,
    inverse: Vector,
    ends: tuple[float, float],
    half_step: float,
    mean: Vector,
) -> None:
    """Mean of old and new speeds, (n + 1,) rad/s into `mean`, from the balance of momentum at each node."""
    count = torque.size
    mean[0] = grid.inertia[0] * speed[0] + half_step * (ends[0] - torque[0])
    for i in range(1, count):
        mean[i] = grid.inertia[i] * speed[i] + half_step * (torque[i - 1] - torque[i])
    mean[count] = grid.inertia[count] * speed[count] + half_step * (torque[count - 1] - ends[1])
    for i in range(count):
        mean[i + 1] += multiplier[i] * mean[i]
    for i in range(count + 1):
        mean[i] *= inverse[i]
    for i in range(count - 1, -1, -1):
        mean[i] += multiplier[i] * mean[i + 1]


@njit(cache=True)
def _losses(mean: Vector, grid: Grid) -> float:
    """Power lost in all dampers, W."""
    twisting = mean[:-1] - mean[1:]
    return float(np.sum(grid.viscous * mean * mean) + np.sum(grid.coupling * twisting * twisting))


@njit(cache=True)
def _control(loop: Loop, step: float, speed_set: float, speed: float, memory: Vector) -> float:
    """Torque in N m; `memory` is (speed, filtered speed, error, integral's torque, wanted torque, torque)."""
    filtered = _low_pass(memory[0], speed, memory[1], loop.speed_filter, step)
    error = speed_set - filtered
    held = memory[3] + loop.integral * step / 2 * (error + memory[2])
    wanted = loop.proportional * error + held
    torque = _low_pass(memory[4], wanted, memory[5], loop.torque_filter, step)
    memory[:] = speed, filtered, error, held, wanted, torque
    return torque


@njit(cache=True, fastmath={"contract"})
def march(
    grid: Grid, loop: Loop, inputs: Inputs, step: float, every: int, speed: Vector, torque: Vector, account: bool
) -> tuple[NDArray[np.float64], Vector]:
    """March the rig from a steady state through all steps.

    Parameters
    ----------
    grid, loop, inputs : the rig and what acts on it
    step : s
    every : steps between samples of the output
    speed : (n + 1,) rad/s at step 0; holds the last speeds afterwards
    torque : (n,) N m, elastic torque half a step before step 0; holds the last ones afterwards
    account : sum up the energies, at some cost

    Returns
    -------
    outputs : (4, samples), top-drive speed, torque command, drive torque, bit speed
    energy : (2,) J, supplied and dissipated
    """
    steps, count = inputs.sweep.size, torque.size
    outputs = np.empty((4, (steps + every - 1) // every))
    energy = np.zeros(2)
    mean = np.empty_like(speed)
    multiplier, inverse = _factors(grid, step / 2)
    load = torque[0] + grid.viscous[0] * speed[0]
    error = inputs.speed_set[0] - speed[0]
    memory = np.array([speed[0], speed[0], error, load - loop.proportional * error, load, load])
    past = loop.delay_steps + 2
    command = np.full(steps + past, load)
    delayed_before = drive = load
    for n in range(steps):
        newest = past + n
        command[newest] = inputs.sweep[n] + _control(loop, step, inputs.speed_set[n], speed[0], memory)
        delayed = 0.0
        for k in range(4):
            delayed += loop.delay_weights[k] * command[newest - loop.delay_steps + 1 - k]
        drive = _low_pass(delayed_before, delayed, drive, loop.lag, step)
        delayed_before = delayed
        for i in range(count):
            torque[i] += step * grid.stiffness[i] * (speed[i] - speed[i + 1])
        ends = (drive, inputs.bit_torque[n])
        _mean_speeds(speed, torque, grid, multiplier, inverse, ends, step / 2, mean)
        if n % every == 0:
            outputs[:, n // every] = speed[0], command[newest], drive, speed[count]
        if account:
            energy += step * np.array([drive * mean[0] - inputs.bit_torque[n] * mean[count], _losses(mean, grid)])
        speed[:] = 2 * mean - speed
    return outputs, energy

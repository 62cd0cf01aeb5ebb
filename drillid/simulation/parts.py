"""Plain numbers and arrays that the time-domain simulator's compiled loops work on."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drillid.arrays import Booleans, Floats, Integers
from drillid.compiled import compiler

compiled = compiler("simulation", fastmath={"contract"})
"""Compile a function of the simulator, with products and sums contracted where the processor can."""


class Grid(NamedTuple):
    """The rig as nodes 0 … n (top drive … bit) and the n springs between them."""

    inertia: Floats
    """(n + 1,) kg m², top drive and bit included."""
    viscous: Floats
    """(n + 1,) N m s/rad, damping of each node against the ground."""
    stiffness: Floats
    """(n,) N m/rad."""
    coupling: Floats
    """(n,) N m s/rad, damping in parallel with each spring; the first is 0 while the gear's teeth are apart."""


class Gear(NamedTuple):
    """Play of the first spring; `present` is False where the top drive is rigid."""

    present: bool
    half_play: float
    """rad."""
    damping: float
    """N m s/rad, while teeth touch."""


class Friction(NamedTuple):
    """Dry friction of the nodes that rub; the bit is the last of them wherever it cuts."""

    nodes: Integers
    """(contacts,) numbers of the nodes."""
    static: Floats
    """(contacts,) N m, of the wall."""
    dynamic: Floats
    """(contacts,) N m, of the wall."""
    threshold: float
    """rad/s."""
    exponent: float
    rest: Floats
    """(contacts,) share by which the wall holds more after a long rest."""
    rest_angle: float
    """rad."""


class Rock(NamedTuple):
    """What the bit does to the rock."""

    cuts: bool
    static: float
    """m, torque per weight on bit."""
    dynamic: float
    """m."""
    threshold: float
    """rad/s."""
    exponent: float
    blades: int
    """0 for a bit without memory."""
    torque_per_depth: float
    """N."""
    rate: float
    """m/s."""
    depth_per_weight: float
    """m/N."""


class Memory(NamedTuple):
    """Relaxations of the damping laws, K of the nodes and L of the springs; `present` is False without any."""

    present: bool
    shunt_decay: Floats
    """(K,) rate times half a step."""
    shunt: Floats
    """(K, n + 1) N m s/rad, what the step's mean speed finds less what is owed to the relaxed speed."""
    series_decay: Floats
    """(L,) rate times half a step."""
    series: Floats
    """(L, n) N m/rad, owed to each spring's twist as far as it has not relaxed."""


class Control(NamedTuple):
    """Speed control in discrete time."""

    proportional: float
    """N m s/rad."""
    integral: float
    """N m/rad."""
    speed_filter: float
    """s."""
    torque_filter: float
    """s."""
    every: int
    """Steps between readings of the speed; the command is held between them."""
    scale: float
    """Reading per true speed."""
    resolution: float
    """rad/s, step of the reading."""
    ripple: float
    """Share of the speed."""
    compensated_inertia: float
    """kg m²."""
    compensation_filter: float
    """s."""
    matching: float
    """rad/(N m s), set-point speed given up per string torque."""
    matching_inertia: float
    """kg m²."""
    matching_low_pass: float
    """s."""
    matching_high_pass: float
    """s; infinite passes the mean."""


class Drive(NamedTuple):
    """Drive in discrete time."""

    delay: float
    """s."""
    lag: float
    """s."""
    gain: float
    limit: float
    """N m."""
    rate: float
    """N m/s."""


class Machine(NamedTuple):
    """Everything that may change from one block of steps to the next."""

    grid: Grid
    gear: Gear
    friction: Friction
    memory: Memory
    rock: Rock
    control: Control
    drive: Drive
    top_inertia: float
    """kg m², of the top drive, or of what turns below its gear; not part of the string."""


class Inputs(NamedTuple):
    """What acts on the rig at each step."""

    sweep: Floats
    """(steps,) N m, injected torque."""
    speed_set: Floats
    """(steps,) rad/s."""
    bit_torque: Floats
    """(steps,) N m, torque that the rock takes beside cutting, half a step after the step's speeds."""
    weight: Floats
    """(steps,) N, weight on bit, half a step after the step's speeds."""
    jitter: Floats
    """(steps,) s, variation of the drive's delay, or (1,) for all steps."""
    top_speed: Floats
    """(steps + 1,) rad/s that the top drive is made to follow, or (0,)."""


class State(NamedTuple):
    """What the rig is doing; changed in place by each step."""

    speed: Floats
    """(n + 1,) rad/s."""
    before: Floats
    """(n + 1,) rad/s, one step ago."""
    torque: Floats
    """(n,) N m, elastic torque half a step ago."""
    slip: NDArray[np.int8]
    """(n + 1,) direction in which a node slips; 0 while it sticks."""
    held: Booleans
    """(n + 1,) nodes whose next speed is known beforehand."""
    rested: Floats
    """(n + 1,) what slip has left of the friction of rest: 1 after a long rest, 0 after long rotation."""
    memory: Floats
    """(MEMORY_SIZE,) figures of control, drive, gear and bit, by the numbers below."""
    relaxed_speed: Floats
    """(K, n + 1) rad/s."""
    unrelaxed_twist: Floats
    """(L, n) rad."""
    command: Floats
    """(past + steps,) N m."""
    angle: Floats
    """(steps + 1,) rad turned by a bit with blades, else (1,)."""
    depth: Floats
    """(steps + 1,) m penetrated by a bit with blades, else (1,)."""


SPEED, FILTERED, ERROR, INTEGRAL, WANTED, TORQUE, MEASURED = range(7)
"""Speed control at its last reading."""
SMOOTH_ERROR, ERROR_SLOPE, SPEED_SLOPE, STRING_TORQUE, SMOOTH_STRING, MEAN_STRING = range(7, 13)
"""Inertia compensation and impedance matching at the last reading."""
DEMAND, DRIVE_TORQUE, DRIVE_BEFORE, EXCESS = range(13, 17)
"""Drive: limited delayed command; its torque now and a step ago; what the limit cut off."""
TOP_ANGLE, TWIST = range(17, 19)
"""Angle of the top drive; twist of the gear."""
BLADE, FURTHEST, EARLIER_CUT = range(19, 22)
"""Step in whose course the bit was one blade behind; furthest angle it has reached; depth per angle before step 0."""
MEMORY_SIZE = 22

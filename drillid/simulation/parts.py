"""Numbers and arrays of the time-domain simulator's compiled loops."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drillid.arrays import Booleans, Floats, Integers
from drillid.compiled import compiler

compiled = compiler("simulation", fastmath={"contract"}, _nrt=False)
"""Compile a function of the simulator, with fused multiply-add where the processor has it.

It allocates no arrays, so no references are counted, which would take several times as long as the sums of a step.
"""
allocating = compiler("simulation", fastmath={"contract"})
"""The same for a function that allocates arrays."""


class SpatialGrid(NamedTuple):
    """The rig as nodes 0 … n (top drive … bit) and the n springs between them."""

    inertia: Floats
    """(n + 1,) kg m², top drive and bit included."""
    viscous: Floats
    """(n + 1,) N m s/rad, damping of each node to ground."""
    stiffness: Floats
    """(n,) N m/rad."""
    coupling: Floats
    """(n,) N m s/rad, damping in parallel with each spring; the first is 0 while the gear's teeth are separated."""


class GearPlay(NamedTuple):
    """Play of the first spring; `present` is False where the top drive is rigid."""

    present: bool
    half_play: float
    """rad."""
    damping: float
    """N m s/rad, with teeth in contact."""


class NodeFriction(NamedTuple):
    """Dry friction of the nodes in contact; the bit is the last of them where it cuts."""

    nodes: Integers
    """(contacts,) indices of the nodes."""
    static: Floats
    """(contacts,) N m, of the wall."""
    dynamic: Floats
    """(contacts,) N m, of the wall."""
    threshold: float
    """rad/s."""
    exponent: float
    rest: Floats
    """(contacts,) relative increase of wall friction after a long rest."""
    rest_angle: float
    """rad."""


class Rock(NamedTuple):
    """Cutting at the bit."""

    cuts: bool
    static: float
    """m, torque per weight on bit."""
    dynamic: float
    """m."""
    threshold: float
    """rad/s."""
    exponent: float
    blades: int
    """0 for a bit without regenerative cutting."""
    torque_per_depth: float
    """N."""
    rate: float
    """m/s."""
    depth_per_weight: float
    """m/N."""


class LawTable(NamedTuple):
    """Torque of the bit against its speed, or of the control against its error; `present` is False without any."""

    present: bool
    first: float
    """rad/s, speed of the first point."""
    spacing: float
    """rad/s between points."""
    torque: Floats
    """(points,) N m."""
    followed: float
    """Fraction of its lag behind the bit's speed that a law with memory makes up in a step; 1 without memory."""
    followed_half: float
    """The same in half a step."""


class CouplingTable(NamedTuple):
    """Compliance of one spring against its torque, in addition to its own; `spring` is negative without any."""

    spring: int
    first: float
    """N m, torque of the first point."""
    spacing: float
    """N m between points."""
    compliance: Floats
    """(points,) rad/(N m)."""


class Memory(NamedTuple):
    """Relaxations of the damping laws, K of the nodes and L of the springs; `present` is False without any."""

    present: bool
    shunt_decay: Floats
    """(K,) rate times half a step."""
    shunt: Floats
    """(K, n + 1) N m s/rad, torque per difference of the step's mean speed from the relaxed speed."""
    series_decay: Floats
    """(L,) rate times half a step."""
    series: Floats
    """(L, n) N m/rad, torque per unrelaxed twist of each spring."""


class Mounts(NamedTuple):
    """M inertias mounted on nodes by a spring and a damper."""

    nodes: Integers
    """(M,) indices of the nodes."""
    inertia: Floats
    """(M,) kg m²."""
    stiffness: Floats
    """(M,) N m/rad."""
    damping: Floats
    """(M,) N m s/rad, of the damper and, as its torque is implicit, half a step of the spring."""
    load: Floats
    """(M,) N m s/rad, part of a node's viscous damping that stands for the inertia."""


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
    """rad/s, quantisation step of the reading."""
    ripple: float
    """Relative amplitude."""
    compensated_inertia: float
    """kg m²."""
    compensation_filter: float
    """s."""
    matching: float
    """rad/(N m s), reduction of the set-point speed per string torque."""
    matching_inertia: float
    """kg m²."""
    matching_low_pass: float
    """s."""
    matching_high_pass: float
    """s; infinite passes the mean."""
    shaping: Floats
    """(5,) coefficients b₀, b₁, b₂, a₁, a₂ of its rational factor in discrete time."""
    law: LawTable
    """Torque against the speed error, in addition to those of both gains."""


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
    shaping: Floats
    """(5,) as for the control; acts on the delayed command."""


class Machine(NamedTuple):
    """The discrete rig, which may change from one block of steps to the next."""

    grid: SpatialGrid
    gear: GearPlay
    friction: NodeFriction
    memory: Memory
    mounts: Mounts
    rock: Rock
    law: LawTable
    coupling: CouplingTable
    control: Control
    drive: Drive
    top_inertia: float
    """kg m², of the top drive, or of its part below the gear; not of the string."""


class Inputs(NamedTuple):
    """Torques, set points and other inputs at each step."""

    sweep: Floats
    """(steps,) N m, injected torque."""
    speed_set: Floats
    """(steps,) rad/s."""
    bit_torque: Floats
    """(steps,) N m, torque on bit in addition to cutting, half a step after the step's speeds."""
    weight: Floats
    """(steps,) N, weight on bit, half a step after the step's speeds."""
    jitter: Floats
    """(steps,) s, variation of the drive's delay, or (1,) for all steps."""
    top_speed: Floats
    """(steps + 1,) rad/s, prescribed speed of the top drive, or (0,)."""


class Scratch(NamedTuple):
    """Intermediate results of one step, overwritten by the next."""

    mean: Floats
    """(n + 1,) rad/s, of old and new speeds."""
    push: Floats
    """(n + 1,) N m s, momentum plus impulse of all torques but damping and friction."""
    factors: tuple[Floats, Floats]
    """(n,), (n + 1,) multipliers and inverse pivots of the system of equations."""
    levels: tuple[Floats, Floats]
    """(contacts,) N m, static and sliding."""
    turned: tuple[Booleans, Booleans]
    """(contacts,) which of them have come to rest, and which have broken away, in this step."""
    relaxing: tuple[Floats, Floats]
    """(n + 1,), (n,) N m, of the relaxations on nodes and in springs."""
    swinging: Floats
    """(M,) N m, of the mounted inertias on their nodes."""


class State(NamedTuple):
    """State of the rig, updated in place by each step."""

    speed: Floats
    """(n + 1,) rad/s."""
    before: Floats
    """(n + 1,) rad/s, one step ago."""
    torque: Floats
    """(n,) N m, elastic torque half a step ago."""
    slip: NDArray[np.int8]
    """(n + 1,) slip direction of a node; 0 while it sticks."""
    held: Booleans
    """(n + 1,) nodes whose next speed is prescribed: sticking ones, and a driven top."""
    rested: Floats
    """(n + 1,) remaining share of the increase of friction by rest: 1 after a long rest, 0 after long rotation."""
    memory: Floats
    """(MEMORY_SIZE,) state of control, drive, gear and bit, indexed by the constants below."""
    relaxed_speed: Floats
    """(K, n + 1) rad/s."""
    unrelaxed_twist: Floats
    """(L, n) rad."""
    mounted_speed: Floats
    """(M,) rad/s, of the inertias that hang on nodes."""
    mounted_twist: Floats
    """(M,) rad, of their springs."""
    command: Floats
    """(past + steps,) N m."""
    angle: Floats
    """(steps + 1,) rad turned by a bit with blades, else (1,)."""
    depth: Floats
    """(steps + 1,) m penetrated by a bit with blades, else (1,)."""


SPEED, FILTERED, ERROR, INTEGRAL, UNFILTERED, TORQUE, MEASURED = range(7)
"""Speed control at its last reading."""
SMOOTH_ERROR, ERROR_SLOPE, SPEED_SLOPE, STRING_TORQUE, SMOOTH_STRING, MEAN_STRING = range(7, 13)
"""Inertia compensation and impedance matching at the last reading."""
DEMAND, DRIVE_TORQUE, DRIVE_BEFORE, EXCESS = range(13, 17)
"""Drive: limited delayed command; its torque now and a step ago; excess of the demand over the limit."""
TOP_ANGLE, TWIST = range(17, 19)
"""Angle of the top drive; twist of the gear."""
BLADE, FURTHEST, EARLIER_CUT = range(19, 22)
"""Step during which the bit was one blade behind; largest angle it has reached; depth per angle before step 0."""
SHAPED_CONTROL, SHAPED_DRIVE = 22, 24
"""First of two states each of the rational factors of control and drive."""
FOLLOWING = 26
"""Speed that a law with memory acts on."""
MEMORY_SIZE = 27

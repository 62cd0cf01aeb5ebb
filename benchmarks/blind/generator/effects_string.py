"""Causes along the string, as the simulator knows them."""

import numpy as np

from benchmarks.blind.generator.effect import Context, Effect
from benchmarks.blind.generator.world import World
from benchmarks.blind.hidden import Hidden, altered
from drillid.physics.damping import ConstantLossFactor, DampingLaw, RootDrag
from drillid.physics.nonlinear import WallContact, Weakening

ZONE_SHARE = 0.05
"""Length of a zone of local damping, as a share of the first window's pipe."""
_HEAVIER = (1.6, 2.5, 5.0)
"""Polar moments of an extra section per pipe's."""
LEAST_SECTION = 20.0
"""m; a wave travels 16 m of steel in a time step of 5 ms."""
_DRY_SHARE = 0.2
"""Wall friction far above the threshold speed, as a share of the rock's torque."""


def heavier(shape: float) -> float:
    """Polar moment of an extra section per pipe's."""
    return _HEAVIER[min(int(shape * len(_HEAVIER)), len(_HEAVIER) - 1)]


def _extra_section(world: World, size: float, context: Context) -> World:
    pipe, *below = world.rig.system.string
    extra = altered(pipe, length=size, polar_moment=pipe.polar_moment * heavier(context.shape))
    return world.with_system(string=(altered(pipe, length=pipe.length - size), extra, *below))


def upper_share(shape: float) -> float:
    """Share of the first window's pipe that the upper size takes."""
    return 0.2 + 0.6 * shape


def same_string(hidden: Hidden, pipe_length: float) -> tuple[Hidden, ...]:
    """The extra section that is nearest to a string of two sizes, and the string that is an extra section; none for
    other causes.

    Parameters
    ----------
    pipe_length : m, in the first window
    """
    if hidden.name == "tapered_string":
        nearest = int(np.argmin(np.abs(np.log(_HEAVIER) - np.log(1 + hidden.size))))
        return (
            Hidden("extra_section", (1 - upper_share(hidden.shape)) * pipe_length, (nearest + 0.5) / len(_HEAVIER)),
        )
    if hidden.name == "extra_section":
        shape = np.interp(hidden.size / pipe_length, (1 - upper_share(1.0), 1 - upper_share(0.0)), (1.0, 0.0))
        return (Hidden("tapered_string", heavier(hidden.shape) - 1, float(shape)),)
    return ()


def _tapered_string(world: World, size: float, context: Context) -> World:
    """The lower pipe goes down with the bit: what is added while drilling is upper pipe."""
    pipe, *below = world.rig.system.string
    length = context.first.pipe_length * (1 - upper_share(context.shape))
    lower = altered(pipe, length=length, polar_moment=pipe.polar_moment * (1 + size))
    return world.with_system(string=(altered(pipe, length=pipe.length - length), lower, *below))


def zone_middle(context: Context) -> float:
    """Depth of the middle of a zone of local damping, m; it stays in the hole while the string moves on."""
    return (0.06 + 0.86 * context.shape) * context.first.pipe_length


def _local_damping_zone(world: World, size: float, context: Context) -> World:
    pipe, *below = world.rig.system.string
    width = ZONE_SHARE * context.first.pipe_length
    above = zone_middle(context) - width / 2
    kappa = pipe.kappa + size / (width * pipe.polar_moment)
    rest = pipe.length - above - width
    parts = (altered(pipe, length=above), altered(pipe, length=width, kappa=kappa), altered(pipe, length=rest))
    return world.with_system(string=(*parts, *below))


def _with_law(world: World, law: DampingLaw) -> World:
    return world.with_system(string=tuple(altered(part, laws=(*part.laws, law)) for part in world.rig.system.string))


def _mud_drag(world: World, size: float, context: Context) -> World:
    return _with_law(world, RootDrag(size))


def _hysteretic_damping(world: World, size: float, context: Context) -> World:
    return _with_law(world, ConstantLossFactor(size))


def _coulomb_contact(world: World, size: float, context: Context) -> World:
    """Dry friction whose slope takes `size` (10 rad/s/Ω)² from κ, along the whole string.

    The friction weakens over half the mean speed, where its slope falls as 1/Ω².
    """
    string = world.rig.system.string
    length = float(sum(section.length for section in string))
    moment = float(string[0].polar_moment)
    threshold = world.speed / 2
    slope = size * (10.0 / world.speed) ** 2 * moment
    dynamic = _DRY_SHARE * world.bit_torque / length
    static = dynamic + slope * threshold * np.exp(world.speed / threshold)
    contact = WallContact(np.array([0.0, length]), np.array([static]), np.array([dynamic]), Weakening(threshold))
    rock = world.bit_torque * (1 - _DRY_SHARE)
    return altered(world, rig=altered(world.rig, contact=contact), bit_torque=rock)


def _kappa_range(world: World, context: Context) -> tuple[float, float]:
    scaled = float(world.pipe.kappa) * (world.speed / 10.0) ** 2
    return 0.02 * scaled, 0.9 * scaled


def _wave_speed(world: World, size: float, context: Context) -> World:
    """Slower waves in the pipe with the same characteristic admittance."""
    pipe, *below = world.rig.system.string
    slow = 1 + size
    other = altered(pipe, density=pipe.density * slow, shear_modulus=pipe.shear_modulus / slow)
    return world.with_system(string=(other, *below))


EFFECTS = (
    Effect("extra_section", _extra_section, (LEAST_SECTION, 600.0)),
    Effect("tapered_string", _tapered_string, (0.03, 1.5)),
    Effect("local_damping_zone", _local_damping_zone, (5.0, 1500.0)),
    Effect("mud_drag", _mud_drag, (10.0, 1500.0)),
    Effect("hysteretic_damping", _hysteretic_damping, (1e-3, 0.1)),
    Effect("coulomb_contact", _coulomb_contact, _kappa_range),
    Effect("wave_speed", _wave_speed, (0.01, 0.25), signed=True),
)

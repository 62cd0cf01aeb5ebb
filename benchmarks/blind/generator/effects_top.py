"""Causes above the string, as the simulator knows them."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.generator.effect import Context, Effect
from benchmarks.blind.generator.world import World

_GEAR_RESONANCE = 2 * np.pi * 40.0
"""rad/s, of the top drive's two inertias against each other: far above the sweep, so that only the play shows."""
_GEAR_DAMPING = 0.1
"""Damping ratio of that resonance."""
_LARGEST_JITTER = 0.4
"""Largest standard deviation of a delay with jitter, as a share of the delay."""
_BELOW_GEAR = 0.3
"""Share of the top drive's inertia that turns below its gear."""


def _drive_lag(world: World, size: float, context: Context) -> World:
    return world.with_top_drive(lag=size)


def _actuator_gain(world: World, size: float, context: Context) -> World:
    return world.with_top_drive(gain=1 + size)


def _delay_jitter(world: World, size: float, context: Context) -> World:
    return world.with_top_drive(delay_jitter=float(np.sqrt(size)))


def _jitter_range(world: World, context: Context) -> tuple[float, float]:
    """Variances of delays of which hardly any would be negative, at which they are clipped."""
    return 1e-5, (_LARGEST_JITTER * float(world.rig.system.top_drive.delay)) ** 2


def _mean_load(world: World) -> float:
    """Torque of steady drilling at the top, N m."""
    wall = sum(section.kappa * section.polar_moment * section.length for section in world.rig.system.string)
    return float(world.bit_torque + (wall + world.rig.system.bit.damping) * world.speed)


def _torque_limit(world: World, size: float, context: Context) -> World:
    return replace(world, rig=replace(world.rig, limits=replace(world.rig.limits, torque=size)))


def _limit_range(world: World, context: Context) -> tuple[float, float]:
    load, sweep = _mean_load(world), context.equipment.sweep_amplitude
    return load + 0.7 * sweep, load + 4.0 * sweep


def _torque_rate_limit(world: World, size: float, context: Context) -> World:
    return replace(world, rig=replace(world.rig, limits=replace(world.rig.limits, rate=size)))


def _rate_range(world: World, context: Context) -> tuple[float, float]:
    sweep = context.equipment.sweep_amplitude
    return 5.0 * sweep, 60.0 * sweep


def _controller_gain(world: World, size: float, context: Context) -> World:
    controller = world.rig.system.top_drive.controller
    return world.with_controller(
        proportional=controller.proportional * (1 + size), integral=controller.integral * (1 + size)
    )


def _speed_filter(world: World, size: float, context: Context) -> World:
    return world.with_controller(speed_filter=size)


def _torque_filter(world: World, size: float, context: Context) -> World:
    return world.with_controller(torque_filter=size)


def _gear_backlash(world: World, size: float, context: Context) -> World:
    """Play that opens, as the mean torque is low."""
    inertia = float(world.rig.system.top_drive.inertia)
    against = _BELOW_GEAR * (1 - _BELOW_GEAR) * inertia
    gear = replace(
        world.rig.gear,
        play=size,
        output_inertia=_BELOW_GEAR * inertia,
        stiffness=against * _GEAR_RESONANCE**2,
        damping=2 * _GEAR_DAMPING * against * _GEAR_RESONANCE,
    )
    light = 0.1 * context.equipment.sweep_amplitude
    return replace(world, rig=replace(world.rig, gear=gear), bit_torque=light)


EFFECTS = (
    Effect("drive_lag", _drive_lag, (1e-3, 0.15)),
    Effect("actuator_gain", _actuator_gain, (0.01, 0.5), signed=True),
    Effect("delay_jitter", _delay_jitter, _jitter_range),
    Effect("torque_limit", _torque_limit, _limit_range, linear=False),
    Effect("torque_rate_limit", _torque_rate_limit, _rate_range, linear=False),
    Effect("controller_gain", _controller_gain, (0.02, 0.5), signed=True),
    Effect("speed_filter", _speed_filter, (3e-5, 0.15)),
    Effect("torque_filter", _torque_filter, (3e-5, 0.15)),
    Effect("gear_backlash", _gear_backlash, (0.01, 0.5), linear=False),
)

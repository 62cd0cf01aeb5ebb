"""Causes at the lower end and in time, as the simulator knows them."""

import numpy as np

from benchmarks.blind.generator.effect import Context, Effect
from benchmarks.blind.generator.world import World
from benchmarks.blind.hidden import altered
from drillid.physics.equipment import Motor
from drillid.physics.nonlinear import Cutting, NonlinearRig, RegenerativeBit, Weakening

_BLADES = (4, 6, 8)
_MOTOR_LOSS = 0.02
"""Damping of a motor, as a share of √(stiffness × inertia of the bit)."""
_SWING_SPEED = 6.5
"""rad/s, mean speed of strings that stick and slip."""
_SWING_THRESHOLD = 3.0
"""rad/s, over which their rock's torque falls."""


def _distributed_bha(world: World, size: float, context: Context) -> World:
    pipe, *middle, collars = world.rig.system.string
    longer = altered(collars, length=collars.length + size)
    return world.with_system(string=(altered(pipe, length=pipe.length - size), *middle, longer))


def _motor_compliance(world: World, size: float, context: Context) -> World:
    bit = world.rig.system.bit
    stiffness, half = 1 / size, float(bit.inertia) / 2
    motor = Motor(stiffness, _MOTOR_LOSS * float(np.sqrt(stiffness * half)), half)
    return world.with_system(bit=altered(bit, inertia=half), motor=motor)


def blades(shape: float) -> int:
    """Blades of the bit."""
    return _BLADES[min(int(shape * len(_BLADES)), len(_BLADES) - 1)]


def _regenerative_cutting(world: World, size: float, context: Context) -> World:
    """Cutting of `size` mean torque; the bit is never short of weight."""
    rate = 0.005
    depth = rate * 2 * np.pi / world.speed
    cutting = RegenerativeBit(blades(context.shape), size / depth, rate, 4 * depth / world.weight_on_bit)
    return altered(world, rig=altered(world.rig, regenerative=cutting), bit_torque=max(world.bit_torque - size, 0.0))


def _regenerative_range(world: World, context: Context) -> tuple[float, float]:
    bearable = float(world.rig.system.bit.damping + 0.3 * world.pipe.characteristic_admittance) * world.speed
    return 0.02 * bearable, 0.8 * bearable


def _stribeck_cutting(world: World, size: float, context: Context) -> World:
    """Rock whose torque falls by `size` (10 rad/s/Ω)² per speed; it weakens over half the mean speed."""
    threshold = world.speed / 2
    fall = size * (10.0 / world.speed) ** 2 * threshold * np.exp(world.speed / threshold)
    weight = world.weight_on_bit
    dynamic = 0.3 * world.bit_torque / weight
    cutting = Cutting(dynamic + fall / weight, dynamic, Weakening(threshold))
    taken = cutting.torque(weight, world.speed)
    return altered(world, rig=altered(world.rig, cutting=cutting), bit_torque=max(world.bit_torque - taken, 0.0))


def _stribeck_range(world: World, context: Context) -> tuple[float, float]:
    bearable = float(world.rig.system.bit.damping + 0.2 * world.pipe.characteristic_admittance)
    scaled = bearable * (world.speed / 10.0) ** 2
    return 0.02 * scaled, 0.7 * scaled


def _stuck_slip_regimes(world: World, size: float, context: Context) -> World:
    """Slow rotation on a rock whose torque falls by `size` times the pipe's characteristic admittance per speed."""
    speed = min(world.speed, _SWING_SPEED)
    steepness = size * float(world.pipe.characteristic_admittance)
    fall = steepness * _SWING_THRESHOLD * np.exp(speed / _SWING_THRESHOLD)
    weight = world.weight_on_bit
    dynamic = 0.5 * world.bit_torque / weight
    cutting = Cutting(dynamic + fall / weight, dynamic, Weakening(_SWING_THRESHOLD))
    return altered(world, rig=altered(world.rig, cutting=cutting), bit_torque=0.0, speed=speed)


def _length_growth(world: World, size: float, context: Context) -> World:
    def grown(rig: NonlinearRig, share: float) -> NonlinearRig:
        pipe, *below = rig.system.string
        longer = altered(pipe, length=pipe.length + size * (share - 0.5))
        return altered(rig, system=altered(rig.system, string=(longer, *below)))

    return altered(world, change=grown)


def _with_damping(rig: NonlinearRig, added: float) -> NonlinearRig:
    bit = altered(rig.system.bit, damping=rig.system.bit.damping + added)
    return altered(rig, system=altered(rig.system, bit=bit))


def _parameter_drift(world: World, size: float, context: Context) -> World:
    return altered(world, change=lambda rig, share: _with_damping(rig, size * share))


def _regime_change(world: World, size: float, context: Context) -> World:
    begin = 0.3 + 0.4 * context.shape
    return altered(world, change=lambda rig, share: _with_damping(rig, size * (share >= begin)))


EFFECTS = (
    Effect("distributed_bha", _distributed_bha, (5.0, 200.0)),
    Effect("motor_compliance", _motor_compliance, (3e-6, 2.5e-4)),
    Effect("regenerative_cutting", _regenerative_cutting, _regenerative_range),
    Effect("stribeck_cutting", _stribeck_cutting, _stribeck_range),
    Effect("stuck_slip_regimes", _stuck_slip_regimes, (0.3, 1.5), linear=False),
    Effect("length_growth", _length_growth, (2.0, 150.0)),
    Effect("parameter_drift", _parameter_drift, (10.0, 1500.0)),
    Effect("regime_change", _regime_change, (10.0, 1500.0)),
)

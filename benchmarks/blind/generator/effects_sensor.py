"""Causes in sensors, filters, clocks and recorder, as the simulator and the recorder know them."""

from dataclasses import replace

import numpy as np

from benchmarks.blind.generator.effect import Context, Effect
from benchmarks.blind.generator.world import World
from benchmarks.blind.vocabulary import tone_frequency, wrong_factor
from drillid.simulation.recorder import Tone


def _speed_scale(world: World, size: float, context: Context) -> World:
    return world.with_recorder(scale=1 + size)


def _sign_or_unit(world: World, size: float, context: Context) -> World:
    return world.with_recorder(scale=1 + size * (wrong_factor(context.shape) - 1))


def _clock_offset(world: World, size: float, context: Context) -> World:
    return world.with_recorder(clock_offset=world.recorder.clock_offset + size)


def _clock_drift(world: World, size: float, context: Context) -> World:
    return world.with_recorder(clock_drift=size)


def filter_order(shape: float) -> int:
    """First or second order."""
    return 1 + int(shape > 0.5)


def _recorder_filter(world: World, size: float, context: Context) -> World:
    return world.with_recorder(filter_frequency=1 / (2 * np.pi * size), filter_order=filter_order(context.shape))


def _sample_and_hold(world: World, size: float, context: Context) -> World:
    return world.with_recorder(held=size)


def _quantisation(world: World, size: float, context: Context) -> World:
    return world.with_recorder(resolution=size)


def _aliased_tone(world: World, size: float, context: Context) -> World:
    return world.with_recorder(tones=(Tone(tone_frequency(context.shape), size),))


def _once_per_revolution(world: World, size: float, context: Context) -> World:
    return replace(world, rig=replace(world.rig, sensor=replace(world.rig.sensor, ripple=size)))


EFFECTS = (
    Effect("speed_scale", _speed_scale, (0.005, 0.3), signed=True),
    Effect("sign_or_unit", _sign_or_unit, (1.0, 1.0)),
    Effect("clock_offset", _clock_offset, (3e-5, 0.3), signed=True),
    Effect("clock_drift", _clock_drift, (1e-7, 2e-3), signed=True),
    Effect("recorder_filter", _recorder_filter, (0.0045, 0.15)),
    Effect("sample_and_hold", _sample_and_hold, (0.01, 0.3)),
    Effect("quantisation", _quantisation, (0.01, 1.0), linear=False),
    Effect("aliased_tone", _aliased_tone, (3e-5, 0.1), linear=False),
    Effect("once_per_revolution", _once_per_revolution, (1e-5, 0.05), linear=False),
)

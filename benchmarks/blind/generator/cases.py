"""Sealed cases: hidden causes are drawn from a seed, and the data come from the time-domain simulator alone."""

import inspect
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.blind.generator import effects_bit, effects_sensor, effects_string, effects_top
from benchmarks.blind.generator.effect import Context, Effect
from benchmarks.blind.generator.rigs import (
    TIME_STEP,
    DrillingSegment,
    Equipment,
    draw_data_sheet,
    draw_equipment,
    draw_segments,
)
from benchmarks.blind.generator.world import World, base_world
from benchmarks.blind.hidden import Hidden, Sealed, kept_records
from drillid.arrays import Floats
from drillid.excitation.torques import SWEEP_PERIOD, coloured_noise, exponential_sweeps
from drillid.fits.datasheet import DataSheet
from drillid.fleet.provenance import digest, source_hash
from drillid.physics.nonlinear import NonlinearRig, VaryingRig
from drillid.simulation.simulate import SAMPLE_INTERVAL, simulate

EFFECTS: dict[str, Effect] = {
    effect.name: effect
    for module in (effects_top, effects_sensor, effects_string, effects_bit)
    for effect in module.EFFECTS
}
"""All causes that can be hidden."""
FOLDER = Path("results/blind/cases")
_FINE = 0.01
"""s, sample interval of the recorder's input."""
WINDOW_S = 600.0
LEAD_IN_S = SWEEP_PERIOD
RATE = 1 / SAMPLE_INTERVAL
_LEVEL_MEMORY = 100.0
"""s, correlation time of the level of the bit's noise."""
_STANDING = 0.05
"""Share of its mean speed below which the bit stands."""
_SEAL = 20260
"""First element of the seeds of all cases."""


@dataclass(frozen=True)
class Case(Sealed):
    """One sealed case."""

    seed: int
    equipment: Equipment
    segments: tuple[DrillingSegment, ...]
    data_sheet: DataSheet
    hidden: tuple[Hidden, ...]
    removed: bool
    """Whether the hidden cause is removed from the engine's catalogue."""
    command_logged: bool

    def context(self, hidden: Hidden) -> Context:
        """Context for the effect of a hidden cause."""
        return Context(self.equipment, self.segments[0], hidden.shape)

    def world(self, window: int, nuisances: Floats | None = None, hidden: tuple[Hidden, ...] | None = None) -> World:
        """One window with the hidden causes, or with other ones."""
        world = base_world(self.equipment, self.segments[window], nuisances)
        for cause in self.hidden if hidden is None else hidden:
            world = EFFECTS[cause.name].apply(world, cause.size, self.context(cause))
        return world

    @property
    def path(self) -> Path:
        """Cache file of its records, named after a hash of the simulator's code and input."""
        code = source_hash("drillid.simulation.simulate", "drillid.excitation.torques", "drillid.simulation.recorder")
        own = [inspect.getsource(function) for function in (simulated, _course, bit_noise)]
        worlds = [_content(self.world(number)) for number in range(len(self.segments))]
        excitation = [self.equipment.sweep_amplitude, self.equipment.noise_bandwidth, self.equipment.noise_swing]
        levels = [segment.bit_noise for segment in self.segments]
        return FOLDER / f"{digest([code, own, worlds, excitation, levels, self.seed])}.npz"


def _content(world: World) -> list[object]:
    """Everything that the simulation of a window depends on, for a hash."""
    rigs = [world.rig if world.change is None else world.change(world.rig, share) for share in np.linspace(0, 1, 11)]
    plain = [str(rig) for rig in rigs]
    return [plain, str(world.recorder), world.bit_torque, world.weight_on_bit, world.speed]


@dataclass(frozen=True, eq=False)
class Records:
    """Logged channels, each (W, samples) in SI units at RATE."""

    sweep: Floats
    speed: Floats
    command: Floats
    """NaN where it is not logged."""
    standing: Floats
    """(W,) share of the time in which the bit stands; not logged."""


def plain_case(seed: int, windows: int | None = None) -> tuple[Case, np.random.Generator]:
    """A case without hidden causes, and the random generator for further draws."""
    generator = np.random.default_rng([_SEAL, seed])
    equipment = draw_equipment(generator)
    segments = draw_segments(generator, equipment, windows)
    data_sheet = draw_data_sheet(generator, equipment)
    return Case(seed, equipment, segments, data_sheet, (), False, bool(generator.random() < 0.7)), generator


def simulate_case(case: Case) -> Records:
    """Records of a case, cached in a file."""
    series = kept_records(case.path, len(case.segments), partial(simulated, case))
    if not case.command_logged:
        series["command"] = np.full_like(series["speed"], np.nan)
    return Records(**series)


def simulated(case: Case, window: int, nuisances: Floats | None = None) -> dict[str, Floats]:
    """Channels of one window, each (samples,); of a rig with other nuisances, offsets from the truth (12,)."""
    world, equipment = case.world(window, nuisances), case.equipment
    generator = np.random.default_rng([_SEAL, case.seed, window, 1])
    steps = round((LEAD_IN_S + WINDOW_S) / TIME_STEP)
    time = np.arange(steps) * TIME_STEP
    noise = bit_noise(generator, steps, equipment, case.segments[window].bit_noise)
    result = simulate(
        world.rig if world.change is None else _course(world),
        exponential_sweeps(time, equipment.sweep_amplitude),
        np.full(steps, world.speed),
        world.bit_torque + noise,
        mean_bit_torque=world.bit_torque,
        weight_on_bit=world.weight_on_bit,
        time_step=TIME_STEP,
        sample_interval=_FINE,
        seed=[_SEAL, case.seed, window, 2],
    )
    drift = world.recorder.clock_drift
    # the clocks agree in the middle of the window, so that drift adds no mean offset
    recorder = replace(world.recorder, clock_offset=world.recorder.clock_offset - drift * (LEAD_IN_S + WINDOW_S / 2))
    first, every = round(LEAD_IN_S * RATE), round(SAMPLE_INTERVAL / _FINE)
    speed = recorder.record(result.speed_reading, _FINE, generator)[first:]
    command = result.torque_command[::every][first:]
    sweep = exponential_sweeps(np.arange(speed.size) / RATE, equipment.sweep_amplitude)
    bit = np.abs(result.bit_speed[first:])
    standing = np.mean(bit < _STANDING * bit.mean())
    return {"sweep": sweep, "speed": speed, "command": command, "standing": np.array(standing)}


def _course(world: World) -> VaryingRig:
    change = world.change
    assert change is not None

    def at(time: float) -> NonlinearRig:
        return change(world.rig, min(max((time - LEAD_IN_S) / WINDOW_S, 0.0), 1.0))

    return at


def bit_noise(generator: np.random.Generator, steps: int, equipment: Equipment, level: float) -> Floats:
    """Coloured torque noise at the bit of slowly varying level, (steps,) N m, with a mean rms of `level`."""
    noise = coloured_noise(generator, steps, TIME_STEP, level, equipment.noise_bandwidth)
    if equipment.noise_swing == 0:
        return noise
    wander = coloured_noise(generator, steps, TIME_STEP, equipment.noise_swing, 1 / (2 * np.pi * _LEVEL_MEMORY))
    return np.asarray(noise * np.exp(wander - equipment.noise_swing**2), dtype=float)

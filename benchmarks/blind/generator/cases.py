"""Sealed cases: what is hidden is drawn from a seed, and data come from the time-domain simulator alone."""

import inspect
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.blind.generator import effects_bit, effects_sensor, effects_string, effects_top
from benchmarks.blind.generator.effect import Context, Effect
from benchmarks.blind.generator.rigs import (
    TIME_STEP,
    Equipment,
    Segment,
    draw_data_sheet,
    draw_equipment,
    draw_stretches,
)
from benchmarks.blind.generator.world import World, base_world
from drillid.arrays import Floats
from drillid.config.settings import Settings
from drillid.discrepancy.evidence import Evidence, OperatingPoints
from drillid.discrepancy.gather import Series, gather
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
"""All causes that are hidden."""
FOLDER = Path("results/blind/cases")
_FINE = 0.01
"""s, interval at which the recorder sees the speed."""
WINDOW_S = 600.0
LEAD_IN_S = SWEEP_PERIOD
RATE = 1 / SAMPLE_INTERVAL
SETTINGS = Settings()
_LEVEL_MEMORY = 100.0
"""s, over which the level of the bit's noise changes."""
_STANDING = 0.05
"""Share of its mean speed below which the bit stands."""
_STANDS = 0.01
"""Share of the time from which a bit that stands counts."""
_SEAL = 20260
"""Begins the seeds of all cases."""


@dataclass(frozen=True)
class Hidden:
    """A cause that the engine is not told."""

    name: str
    size: float
    """In the catalogue's unit."""
    shape: float
    """0 to 1, which of the cause's shapes."""


@dataclass(frozen=True)
class Case:
    """One sealed case."""

    seed: int
    equipment: Equipment
    stretches: tuple[Segment, ...]
    data_sheet: DataSheet
    hidden: tuple[Hidden, ...]
    removed: bool
    """Whether the hidden cause is taken out of the engine's catalogue."""
    command_logged: bool

    @property
    def answer(self) -> frozenset[str]:
        """Names of all that is hidden."""
        return frozenset(one.name for one in self.hidden)

    def context(self, hidden: Hidden) -> Context:
        """What the effect of a hidden cause may know."""
        return Context(self.equipment, self.stretches[0], hidden.shape)

    def world(self, window: int, figures: Floats | None = None, hidden: tuple[Hidden, ...] | None = None) -> World:
        """One window with what is hidden in it, or with something else."""
        world = base_world(self.equipment, self.stretches[window], figures)
        for one in self.hidden if hidden is None else hidden:
            world = EFFECTS[one.name].apply(world, one.size, self.context(one))
        return world

    @property
    def path(self) -> Path:
        """File that keeps its records, named after the simulator's code and all that it is given."""
        code = source_hash("drillid.simulation.simulate", "drillid.excitation.torques", "drillid.simulation.recorder")
        own = [inspect.getsource(function) for function in (_simulated, _course, bit_noise)]
        worlds = [_content(self.world(number)) for number in range(len(self.stretches))]
        excitation = [self.equipment.sweep_amplitude, self.equipment.noise_bandwidth, self.equipment.noise_swing]
        levels = [stretch.bit_noise for stretch in self.stretches]
        return FOLDER / f"{digest([code, own, worlds, excitation, levels, self.seed])}.npz"


def _content(world: World) -> list[object]:
    """All that a window's simulation depends on, for a hash."""
    rigs = [world.rig if world.change is None else world.change(world.rig, share) for share in np.linspace(0, 1, 11)]
    plain = [str(rig) for rig in rigs]
    return [plain, str(world.recorder), world.bit_torque, world.weight_on_bit, world.speed]


@dataclass(frozen=True, eq=False)
class Records:
    """What was logged, each (W, samples) in SI units at RATE."""

    sweep: Floats
    speed: Floats
    command: Floats
    """NaN where it is not logged."""
    standing: Floats
    """Share of the time in which the bit stands, (W,); it is not logged."""


def plain_case(seed: int, windows: int | None = None) -> tuple[Case, np.random.Generator]:
    """A case without anything hidden, and the generator for what is to be drawn further."""
    generator = np.random.default_rng([_SEAL, seed])
    equipment = draw_equipment(generator)
    stretches = draw_stretches(generator, equipment, windows)
    data_sheet = draw_data_sheet(generator, equipment)
    return Case(seed, equipment, stretches, data_sheet, (), False, bool(generator.random() < 0.7)), generator


def simulate_case(case: Case) -> Records:
    """Its records, kept in a file between runs."""
    if case.path.is_file():
        with np.load(case.path) as stored:
            series = {name: stored[name].astype(float) for name in ("sweep", "speed", "command", "standing")}
    else:
        windows = [_simulated(case, number) for number in range(len(case.stretches))]
        series = {name: np.stack([one[name] for one in windows]) for name in windows[0]}
        case.path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = case.path.with_suffix(".part.npz")
        np.savez_compressed(unfinished, **{name: values.astype(np.float32) for name, values in series.items()})
        unfinished.replace(case.path)
    if not case.command_logged:
        series["command"] = np.full_like(series["speed"], np.nan)
    return Records(**series)


def bit_stands(case: Case) -> bool:
    """Whether the bit of a simulated case stands for some of the time in any of its windows."""
    with np.load(case.path) as stored:
        return bool(stored["standing"].max() > _STANDS)


def _simulated(case: Case, window: int) -> dict[str, Floats]:
    """Channels of one window, each (samples,)."""
    world, equipment = case.world(window), case.equipment
    generator = np.random.default_rng([_SEAL, case.seed, window, 1])
    steps = round((LEAD_IN_S + WINDOW_S) / TIME_STEP)
    time = np.arange(steps) * TIME_STEP
    noise = bit_noise(generator, steps, equipment, case.stretches[window].bit_noise)
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
    # the clocks agree in the middle of the window, so that drift is no offset
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
    """Coloured torque noise at the bit whose level wanders, (steps,) N m; its rms is `level` in the mean."""
    noise = coloured_noise(generator, steps, TIME_STEP, level, equipment.noise_bandwidth)
    if equipment.noise_swing == 0:
        return noise
    wander = coloured_noise(generator, steps, TIME_STEP, equipment.noise_swing, 1 / (2 * np.pi * _LEVEL_MEMORY))
    return np.asarray(noise * np.exp(wander - equipment.noise_swing**2), dtype=float)


def evidence_of(case: Case) -> Evidence:
    """What the engine is shown of a case: logs, how it was drilled by the logs, and the data sheets."""
    records = simulate_case(case)
    windows = [Series(*channels) for channels in zip(records.sweep, records.speed, records.command, strict=True)]
    stretches = case.stretches
    operating_points = OperatingPoints(
        hole_depth=np.array([one.hole_depth for one in stretches]),
        bit_depth=np.array([one.pipe_length for one in stretches]) + float(case.equipment.collars.length),
        speed=records.speed.mean(axis=1),
        torque=records.command.mean(axis=1),
        weight_on_bit=np.full(len(stretches), case.equipment.weight_on_bit),
    )
    return gather(windows, RATE, operating_points, case.data_sheet, SETTINGS)

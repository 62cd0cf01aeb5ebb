"""The embedded demo fleet: true parameters of three small wells, and the raw logs that their rigs write.

Only the rule that writes the logs may read this truth; tests compare results with it.
"""

import dataclasses
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drillid.arrays import Floats
from drillid.config.settings import SimulateSettings
from drillid.demo.logs import Faults, LogColumn, LogWriter
from drillid.errors import SettingsError
from drillid.excitation.torques import coloured_noise, exponential_sweeps
from drillid.physics.equipment import (
    STEEL_DENSITY,
    Bit,
    Controller,
    DrillingSystem,
    Section,
    TopDrive,
    polar_moment,
)
from drillid.simulation.simulate import SAMPLE_INTERVAL, simulate
from drillid.units import RPM, STANDARD_GRAVITY

STAND_LENGTH = 30.0
"""m drilled with each stand."""
_LEAD_IN_S = 30.0
"""Time simulated before each log starts, so that transients have decayed."""
_LIFT_OFF_S, _SLOW_DOWN_S, _STANDSTILL_S = 5.0, 20.0, 30.0
"""Times after drilling, s, when the bit is off bottom, the set point reaches zero, and the string is at rest."""
_BLOCK_WEIGHT = 25e3 * STANDARD_GRAVITY
_BUOYANCY = 0.85


@dataclass(frozen=True)
class PipeSize:
    """Size of pipe or collars: outer and inner diameter, m."""

    outer_diameter: float
    inner_diameter: float

    def section(self, length: float) -> Section:
        """A section of this pipe in mud."""
        moment = polar_moment(self.outer_diameter, self.inner_diameter)
        return Section(length, moment, kappa=200.0, delta=2.5e8)

    def weight(self, length: float) -> float:
        """Buoyed weight, N."""
        area = np.pi / 4 * (self.outer_diameter**2 - self.inner_diameter**2)
        return float(_BUOYANCY * STEEL_DENSITY * STANDARD_GRAVITY * area * length)


@dataclass(frozen=True)
class WashOut:
    """An interval of enlarged hole, in which the whirling assembly has additional damping and moves more mud."""

    from_depth: float
    to_depth: float
    extra: Bit


@dataclass(frozen=True)
class DemoWell:
    """The truth about one well; SI units."""

    first_depth: float
    """m, hole depth at which the first stand starts."""
    top_drive: TopDrive
    pipe: PipeSize
    collars: PipeSize
    collars_length: float
    bit: Bit
    speed: float
    """rad/s, set point."""
    bit_torque: float
    """N m, mean torque at the lower end of the string, of rock and bottom-hole assembly together."""
    bit_noise: float
    """N m, root mean square of the bit torque's noise."""
    bit_noise_bandwidth: float
    """Hz."""
    sweep_amplitude: float
    """N m, of each of the three sweeps."""
    weight_on_bit: float
    flow: float
    standpipe_pressure: float
    log_writer: LogWriter
    wash_out: WashOut | None = None
    stand_length: float = STAND_LENGTH
    """m drilled with each stand."""

    def system(self, stand: int) -> DrillingSystem:
        """The equipment while a stand (counted from 0) is drilled.

        The top drive follows the pipe down, so that the string keeps its length within a stand; it is set to
        the hole's mean depth in the stand.
        """
        depth = self.first_depth + self.stand_length * (stand + 0.5)
        bit = self.bit
        if self.wash_out is not None and self.wash_out.from_depth <= depth < self.wash_out.to_depth:
            extra = self.wash_out.extra
            bit = Bit(bit.inertia + extra.inertia, bit.damping + extra.damping)
        string = (self.pipe.section(depth - self.collars_length), self.collars.section(self.collars_length))
        return DrillingSystem(self.top_drive, string, bit)

    def hanging_weight(self, stand: int) -> float:
        """Weight of the string off bottom, top drive and block included, N."""
        pipe, collars = self.system(stand).string
        return self.pipe.weight(pipe.length) + self.collars.weight(collars.length) + _BLOCK_WEIGHT


_FIVE_AND_A_HALF = PipeSize(0.1397, 0.1214)
_FIVE = PipeSize(0.1270, 0.1086)
_COLLARS = PipeSize(0.1651, 0.0714)

_METRIC = (
    LogColumn("TQ_CMD", "torque_command", "kN m", 3),
    LogColumn("TQ_SWEEP", "torque_sweep", "kN m", 3),
    LogColumn("RPM", "speed", "rpm", 3),
    LogColumn("RPM_SET", "speed_set", "rpm", 1),
    LogColumn("HOLE_DEPTH", "hole_depth", "m", 2),
    LogColumn("BIT_DEPTH", "bit_depth", "m", 2),
    LogColumn("WOB", "weight_on_bit", "t", 2),
    LogColumn("FLOW_IN", "flow", "L/min", 0),
    LogColumn("SPP", "standpipe_pressure", "bar", 1),
    LogColumn("HOOKLOAD", "hook_load", "t", 1),
)
_NEWTONS = tuple(
    dataclasses.replace(column, header=column.channel, unit=unit, decimals=decimals)
    for column, (unit, decimals) in zip(
        _METRIC,
        (
            *(("N m", 0), ("N m", 1), ("rpm", 3), ("rpm", 1), ("m", 2), ("m", 2)),
            *(("kN", 1), ("L/min", 0), ("kPa", 0), ("kN", 0)),
        ),
        strict=True,
    )
)
_US = (
    LogColumn("Torque Command (ft-lbf)", "torque_command", "ft-lbf", 0),
    LogColumn("Torque Sweep (ft-lbf)", "torque_sweep", "ft-lbf", 1),
    LogColumn("Rotary Speed (rpm)", "speed", "rpm", 2),
    LogColumn("Rotary Set (rpm)", "speed_set", "rpm", 0),
    LogColumn("Hole Depth (ft)", "hole_depth", "ft", 1),
    LogColumn("Bit Depth (ft)", "bit_depth", "ft", 1),
    LogColumn("WOB (klbf)", "weight_on_bit", "klbf", 1),
    LogColumn("Flow In (gpm)", "flow", "gal/min", 0),
    LogColumn("SPP (psi)", "standpipe_pressure", "psi", 0),
    LogColumn("Hook Load (klbf)", "hook_load", "klbf", 1),
)

WELLS = {
    "D01": DemoWell(
        first_depth=2900.0,
        top_drive=TopDrive(1085.0, 0.0392, Controller(1500.0, 800.0)),
        pipe=_FIVE_AND_A_HALF,
        collars=_COLLARS,
        collars_length=100.0,
        bit=Bit(40.0, 40.0),
        speed=120 * RPM,
        bit_torque=5200.0,
        bit_noise=350.0,
        bit_noise_bandwidth=2.0,
        sweep_amplitude=560.0,
        weight_on_bit=9.1e3 * STANDARD_GRAVITY,
        flow=2700 / 6e4,
        standpipe_pressure=210e5,
        log_writer=LogWriter("TIME", _METRIC),
        wash_out=WashOut(2990.0, 3050.0, Bit(35.0, 300.0)),
    ),
    "D02": DemoWell(
        first_depth=2160.0,
        top_drive=TopDrive(1015.0, 0.0360, Controller(1600.0, 900.0, speed_filter=0.02)),
        pipe=_FIVE_AND_A_HALF,
        collars=_COLLARS,
        collars_length=80.0,
        bit=Bit(40.0, 25.0),
        speed=130 * RPM,
        bit_torque=4300.0,
        bit_noise=400.0,
        bit_noise_bandwidth=3.0,
        sweep_amplitude=520.0,
        weight_on_bit=8.0e3 * STANDARD_GRAVITY,
        flow=2400 / 6e4,
        standpipe_pressure=185e5,
        log_writer=LogWriter(
            "time",
            _NEWTONS,
            zone="Asia/Muscat",
            faults=Faults(jitter=0.002, dropped_share=0.001, speed_spikes=4, gap=5.0),
        ),
    ),
    "D03": DemoWell(
        first_depth=1620.0,
        top_drive=TopDrive(1390.0, 0.0315, Controller(1200.0, 650.0)),
        pipe=_FIVE,
        collars=_COLLARS,
        collars_length=60.0,
        bit=Bit(40.0, 30.0),
        speed=100 * RPM,
        bit_torque=3600.0,
        bit_noise=300.0,
        bit_noise_bandwidth=2.0,
        sweep_amplitude=420.0,
        weight_on_bit=7.2e3 * STANDARD_GRAVITY,
        flow=2100 / 6e4,
        standpipe_pressure=160e5,
        log_writer=LogWriter("Time", _US, faults=Faults(dropped_share=0.0005)),
    ),
}
"""The demo fleet."""


def write_demo_logs(well: str, paths: Sequence[Path], settings: SimulateSettings) -> None:
    """Simulate a well of the demo stand by stand and write one raw log for each.

    Parameters
    ----------
    well : name of one of WELLS
    paths : one log per stand, in order; the names end in the logs' start times, the suffix sets the format

    Raises
    ------
    SettingsError
        If the demo has no such well.
    """
    for stand, path in enumerate(paths):
        write_demo_log(well, stand, path, settings)


def write_demo_log(well: str, stand: int, path: Path, settings: SimulateSettings) -> None:
    """Simulate one stand of a well of the demo and write its raw log.

    Parameters
    ----------
    well : name of one of WELLS
    stand : number of the stand, from 0
    path : the log; its name ends in the log's start time, the suffix sets the format

    Raises
    ------
    SettingsError
        If the demo has no such well.
    """
    if well not in WELLS:
        raise SettingsError(f"well {well}", "the demo has no such well", f"Use one of {', '.join(WELLS)}")
    generator = np.random.default_rng([settings.seed, zlib.crc32(well.encode()), stand])
    write_stand(WELLS[well], stand, path, settings, generator)


def write_stand(
    truth: DemoWell, stand: int, path: Path, settings: SimulateSettings, generator: np.random.Generator
) -> None:
    """Simulate one stand of any well and write its raw log; see `write_demo_log`."""
    time, channels = _stand(truth, stand, settings, generator)
    truth.log_writer.write(Path(path), time, channels, settings.drilling_s, generator)


def _stand(
    truth: DemoWell, stand: int, settings: SimulateSettings, generator: np.random.Generator
) -> tuple[Floats, dict[str, Floats]]:
    """Time (s, 0 where the log starts) and all channels (SI) of one stand, each (rows,)."""
    rows = round((settings.drilling_s + settings.connection_s) / SAMPLE_INTERVAL)
    time = SAMPLE_INTERVAL * np.arange(rows, dtype=float)
    channels = _slow_channels(truth, stand, settings, time, generator)
    turning = min(_STANDSTILL_S, settings.connection_s)
    steps = round((_LEAD_IN_S + settings.drilling_s + turning) / settings.time_step_s)
    step_time = settings.time_step_s * np.arange(steps, dtype=float) - _LEAD_IN_S
    after = step_time - settings.drilling_s
    noise = coloured_noise(generator, steps, settings.time_step_s, truth.bit_noise, truth.bit_noise_bandwidth)
    system = truth.system(stand)
    rock_torque = truth.bit_torque - system.bit.damping * truth.speed
    result = simulate(
        system,
        np.where(after < 0, exponential_sweeps(step_time, truth.sweep_amplitude), 0.0),
        _speed_set(truth, after),
        np.clip(1 - after / _LIFT_OFF_S, 0, 1) * (rock_torque + noise),
        mean_bit_torque=rock_torque,
        time_step=settings.time_step_s,
    )
    logged = slice(round(_LEAD_IN_S / SAMPLE_INTERVAL), None)
    for name, series in (("speed", result.speed), ("torque_command", result.torque_command)):
        channels[name] = np.zeros(rows)
        channels[name][: series[logged].size] = series[logged][:rows]
    return time, channels


def _speed_set(truth: DemoWell, after: Floats) -> Floats:
    """Set point (rad/s) at times after drilling (s): full speed until the bit is off bottom, then down to zero."""
    return truth.speed * np.clip((_SLOW_DOWN_S - after) / (_SLOW_DOWN_S - _LIFT_OFF_S), 0, 1)


def _slow_channels(
    truth: DemoWell, stand: int, settings: SimulateSettings, time: Floats, generator: np.random.Generator
) -> dict[str, Floats]:
    """All channels but speed and torque command: the string hangs while lifted, then rests in the slips."""
    after = time - settings.drilling_s
    on_bottom = np.clip(1 - after / _LIFT_OFF_S, 0, 1)
    pumping = np.clip(1 - (after - _SLOW_DOWN_S) / 5, 0, 1)
    top = truth.first_depth + truth.stand_length * stand
    hole_depth = top + truth.stand_length * np.clip(time / settings.drilling_s, 0, 1)
    weight_noise = coloured_noise(generator, time.size, SAMPLE_INTERVAL, 0.02 * truth.weight_on_bit, 0.05)
    weight = on_bottom * (truth.weight_on_bit + weight_noise)
    in_slips = after > 60
    return {
        "torque_sweep": np.where(after < 0, exponential_sweeps(time, truth.sweep_amplitude), 0.0),
        "speed_set": _speed_set(truth, after),
        "hole_depth": hole_depth,
        "bit_depth": hole_depth - np.clip(0.3 * after, 0, 12),
        "weight_on_bit": weight,
        "flow": truth.flow * pumping,
        "standpipe_pressure": truth.standpipe_pressure * pumping**2,
        "hook_load": np.where(in_slips, _BLOCK_WEIGHT, truth.hanging_weight(stand) - weight),
    }

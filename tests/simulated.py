"""Small wells from the time-domain simulator, which shares no formula with what is fitted to them."""

import importlib
import shutil
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from drillid.arrays import Floats
from drillid.config.listing import Well
from drillid.config.rig import CHANNEL_UNITS, Rig
from drillid.config.settings import Settings
from drillid.datasets.codes import RigState
from drillid.datasets.store import Problem, WellFolders
from drillid.discrepancy.sets import read_verdicts
from drillid.excitation.torques import coloured_noise, exponential_sweeps
from drillid.physics.eight_parameters import KnownEquipment
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, TopDrive, polar_moment
from drillid.simulation.simulate import SAMPLE_INTERVAL, TIME_STEP, simulate

RATE = 1 / SAMPLE_INTERVAL
WINDOW_S = 600.0
LEAD_IN_S = 120.0
"""Simulated before each stand, so that what is recorded has settled."""
SPEED = 10.5
"""rad/s."""
_START = pd.Timestamp("2025-03-03T06:00:00")


@dataclass(frozen=True)
class Truth:
    """A rig, string and bit with the torques that excite them."""

    pipe: Section
    collars: Section
    top_drive: TopDrive
    bit: Bit
    sweep_amplitude: float
    """N m, of each of three sweeps."""
    bit_noise: float
    """N m rms."""
    bit_torque: float
    """N m, mean."""

    @property
    def system(self) -> DrillingSystem:
        """All of the equipment."""
        return DrillingSystem(self.top_drive, (self.pipe, self.collars), self.bit)

    @property
    def known(self) -> KnownEquipment:
        """What a fit is told."""
        return KnownEquipment(self.top_drive.controller, self.collars.length, self.collars.polar_moment)

    @property
    def bit_depth(self) -> float:
        """Length of the whole string, m."""
        return float(self.pipe.length + self.collars.length)

    @property
    def parameters(self) -> Floats:
        """The eight parameters, in the order of the schema."""
        pipe, top_drive, bit = self.pipe, self.top_drive, self.bit
        inertia_bha = bit.inertia + self.collars.inertia
        figures = [pipe.kappa, pipe.delta, pipe.length, pipe.polar_moment]
        return np.array([*figures, top_drive.delay, top_drive.inertia, bit.damping, inertia_bha], dtype=float)


DEEP = Truth(
    pipe=Section(3100.0, polar_moment(0.1397, 0.1214), kappa=200.0, delta=2.5e8),
    collars=Section(100.0, polar_moment(0.1651, 0.0714), kappa=200.0, delta=2.5e8),
    top_drive=TopDrive(1105.0, 0.04, Controller(1500.0, 800.0)),
    bit=Bit(40.0, 40.0),
    sweep_amplitude=530.0,
    bit_noise=500.0,
    bit_torque=4000.0,
)
SHALLOW = Truth(
    pipe=Section(900.0, polar_moment(0.0889, 0.0702), kappa=150.0, delta=3e8),
    collars=Section(60.0, polar_moment(0.1206, 0.0572), kappa=150.0, delta=3e8),
    top_drive=TopDrive(450.0, 0.028, Controller(350.0, 180.0)),
    bit=Bit(10.0, 15.0),
    sweep_amplitude=150.0,
    bit_noise=50.0,
    bit_torque=1500.0,
)

RIG = Rig.checked(
    {
        "name": "small rig",
        "channels": {
            name: {"column": name, "unit": unit} for name, unit in CHANNEL_UNITS.items() if name != "hook_load"
        },
        "controller": {"proportional": "350 N m s/rad", "integral": "180 N m/rad"},
        "collars": [{"outer_diameter": "120.6 mm", "inner_diameter": "57.2 mm", "length": "60 m"}],
    },
    "small rig",
)
"""The data sheets of the shallow truth: controller and collars."""


def drilled(truth: Truth, seconds: float, seed: int, sweep_period: float = 120.0) -> dict[str, Floats]:
    """Sweep, speed and torque command of steady drilling, each (samples,)."""
    steps = round((LEAD_IN_S + seconds) / TIME_STEP)
    time = np.arange(steps) * TIME_STEP
    noise = coloured_noise(np.random.default_rng(seed), steps, TIME_STEP, truth.bit_noise, 2.0)
    result = simulate(
        truth.system,
        exponential_sweeps(time, truth.sweep_amplitude, period=sweep_period),
        np.full(steps, SPEED),
        truth.bit_torque + noise,
        mean_bit_torque=truth.bit_torque,
    )
    first = round(LEAD_IN_S * RATE)
    channels = {
        "torque_sweep": exponential_sweeps(result.time, truth.sweep_amplitude, period=sweep_period),
        "speed": result.speed,
        "torque_command": result.torque_command,
    }
    return {name: values[first:] for name, values in channels.items()}


def write_records(folders: WellFolders, stands: Sequence[dict[str, Floats]], bit_depth: float) -> None:
    """Records of successive stands, and windows that fill them, as the stages before spectra leave them."""
    joined = {name: np.concatenate([stand[name] for stand in stands]) for name in stands[0]}
    samples = joined["speed"].size
    time = (_START + pd.to_timedelta(np.arange(samples) / RATE, unit="s")).to_numpy().astype("datetime64[ns]")
    slow = {name: np.full(samples, np.nan) for name in CHANNEL_UNITS if name not in joined}
    slow |= {name: bit_depth + 0.01 * np.arange(samples) / RATE for name in ("hole_depth", "bit_depth")}
    variables = {name: ("time", values) for name, values in {**joined, **slow}.items()}
    marks = {name: ("time", np.zeros(samples)) for name in ("flags", "log")}
    folders.write("records", "records", xr.Dataset(variables | marks, {"time": time}))

    length = round(WINDOW_S * RATE)
    first = np.arange(samples // length) * length
    middle = slow["hole_depth"][first + length // 2]
    figures = {
        "start": time[first],
        "end": time[first] + np.timedelta64(round(WINDOW_S), "s"),
        "hole_depth": middle,
        "depth_from": slow["hole_depth"][first],
        "depth_to": slow["hole_depth"][first + length - 1],
        "bit_depth": np.full(first.size, bit_depth),
        "speed": np.full(first.size, SPEED),
        "torque": np.full(first.size, joined["torque_command"].mean()),
        "weight_on_bit": np.full(first.size, np.nan),
        "flow": np.full(first.size, np.nan),
        "standpipe_pressure": np.full(first.size, np.nan),
        "sweep_amplitude": np.full(first.size, joined["torque_sweep"].std()),
        "flagged_share": np.zeros(first.size),
        "first_sample": first,
        "samples": np.full(first.size, length),
        "key": [f"window {row}" for row in range(first.size)],
    }
    windows = xr.Dataset({name: ("window", values) for name, values in figures.items()})
    folders.write("windows", "windows", windows.assign_coords(window=np.arange(first.size)))
    drilling = xr.Dataset({"rig_state": ("time", np.full(samples, RigState.DRILLING))}, {"time": time})
    folders.write("windows", "states", drilling)


@dataclass(frozen=True)
class Processed:
    """A well of the shallow truth with what the stages from spectra to depth made of it."""

    well: Well
    folders: WellFolders
    settings: Settings
    problems: dict[str, list[Problem]]

    def dataset(self, stage: str, name: str) -> xr.Dataset:
        """One of its datasets, in memory."""
        return self.folders.read(stage, name).load()

    def verdicts(self) -> list[dict[Hashable, Any]]:
        """Rows of verdicts.csv."""
        return read_verdicts(self.folders).to_dict("records")

    def run(self, stage: str, rig: Rig | None = None, settings: Settings | None = None) -> list[Problem]:
        """Do one stage again, with another rig or other settings where given."""
        module = importlib.import_module(f"drillid.{stage}.stage")
        well = replace(self.well, rig=rig or self.well.rig)
        problems: list[Problem] = module.process(well, self.folders, settings or self.settings)
        return problems

    def copied(self, results: Path) -> "Processed":
        """The same in a folder of its own, to be changed at will."""
        shutil.copytree(self.folders.results, results)
        return replace(self, folders=WellFolders(results, self.well.name))


def processed(results: Path, name: str, stands: Sequence[dict[str, Floats]]) -> Processed:
    """A well of the shallow truth through the stages from spectra to depth."""
    folders = WellFolders(results, name)
    write_records(folders, stands, SHALLOW.bit_depth)
    well = Processed(Well(name, RIG, ()), folders, Settings(), {})
    for stage in ("spectra", "mobility", "fits", "discrepancy", "depth"):
        well.problems[stage] = well.run(stage)
    return well

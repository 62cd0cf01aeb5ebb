"""A small well made by the linear model plus noise: datasets from windows to depth, without any time series."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from drillid import discrepancy
from drillid.config.listing import Well
from drillid.config.rig import CHANNEL_UNITS, Rig
from drillid.config.settings import Settings
from drillid.datasets.codes import RigState
from drillid.datasets.store import WellFolders
from drillid.depth import stage as depth
from drillid.fits import stage as fits
from drillid.fits.datasheet import data_sheet
from drillid.mobility import stage as mobility
from drillid.physics.eight_parameters import drilling_system
from drillid.physics.equipment import Controller, polar_moment
from drillid.physics.responses import command_mobility, laplace
from drillid.windows.segments import SEGMENT_COLUMNS

RIG: dict[str, Any] = {
    "name": "Rig <of the test>",
    "channels": {
        "torque_sweep": {"column": "SWEEP", "unit": "kN m"},
        "speed": {"column": "RPM", "unit": "rpm"},
        "hole_depth": {"column": "DMEA", "unit": "m"},
    },
    "controller": {"proportional": "1500 N m s/rad", "integral": "800 N m/rad"},
    "drive_delay": {"value": "40 ms", "tolerance": "5 ms"},
    "top_drive_inertia": {"value": "1100 kg m^2", "relative": "5 %"},
    "pipe": {"outer_diameter": "139.7 mm", "inner_diameter": "121.4 mm"},
    "collars": [{"length": "60 m", "outer_diameter": "165.1 mm", "inner_diameter": "71.4 mm"}],
    "hole_sections": [{"diameter": '12¼"'}, {"diameter": '8⅜"', "from_depth": "1018 m"}],
}
SETTINGS = Settings()
FIRST_DEPTH, WINDOW_HEIGHT, WINDOW_S = 1000.0, 3.0, 600
FREQUENCY = np.linspace(0.05, 4.0, 160)
SWEEP_POWER, AVERAGES = 1e4, 5.0
NOISE_DEVIATION = 4e-6
"""Standard deviation of the complex command mobility, rad/(N m s)."""
DISTORTION = ("response", "noise", "even", "odd")
FLAGGED = (5, 6)
"""Windows with more damping and inertia at the bit, in a well of more than these."""


def truth(bit_depth: float, *, restless: bool) -> np.ndarray[Any, np.dtype[np.float64]]:
    """The eight parameters at a bit depth (m)."""
    damping, inertia = (400.0, 120.0) if restless else (20.0, 60.0)
    return np.array([150.0, 2.5e8, bit_depth - 60.0, polar_moment(0.1397, 0.1214), 0.0405, 1105.0, damping, inertia])


def windows_of(count: int, gap: float = 0.0) -> xr.Dataset:
    """Windows on end, with a gap (m) behind the third."""
    begin = FIRST_DEPTH + WINDOW_HEIGHT * np.arange(count) + gap * (np.arange(count) > 2)
    start = np.datetime64("2025-05-01T06:00:00", "ns") + np.arange(count) * np.timedelta64(WINDOW_S, "s")
    middle, one = begin + WINDOW_HEIGHT / 2, np.ones(count)
    columns = {"hole_depth": middle, "depth_from": begin, "depth_to": begin + WINDOW_HEIGHT, "bit_depth": middle}
    columns |= {"speed": 12 * one, "torque": 1e4 * one, "weight_on_bit": 1e5 * one, "flow": 0.04 * one}
    columns |= {"standpipe_pressure": 2e7 * one}
    columns |= {"sweep_amplitude": 500 * one, "flagged_share": 0 * one}
    columns |= {"start": start, "end": start + np.timedelta64(WINDOW_S, "s")}
    columns |= {"first_sample": 30000 * np.arange(count), "samples": 30000 * one}
    columns |= {"key": [f"window {row}" for row in range(count)]}
    return xr.Dataset({name: ("window", values) for name, values in columns.items()}, {"window": np.arange(count)})


def spectra_of(windows: xr.Dataset, rig: Rig, rng: np.random.Generator) -> xr.Dataset:
    """Spectra that the true systems and Gaussian noise would give, without a logged torque command."""
    count, controller = windows.sizes["window"], Controller(1500.0, 800.0)
    shape = (count, FREQUENCY.size)
    true = [
        command_mobility(
            drilling_system(truth(bit, restless=row in FLAGGED), data_sheet(rig, controller, bit).equipment),
            laplace(FREQUENCY),
        )
        for row, bit in enumerate(windows["bit_depth"].values.tolist())
    ]
    noise = rng.normal(0, NOISE_DEVIATION / np.sqrt(2), (2, *shape))
    cross = SWEEP_POWER * (np.array(true).reshape(shape) + noise[0] + 1j * noise[1])
    speed_noise = np.full(shape, NOISE_DEVIATION**2 * AVERAGES * SWEEP_POWER)
    one, lines = np.ones(shape), ("window", "frequency")
    images = ("window", "spectrogram_frequency", "spectrogram_time")
    power = rng.chisquare(2, (count, 50, 20))
    levels = {f"{name}_level": (("window", "band"), np.zeros((count, 2))) for name in DISTORTION}
    detected = {f"{name}_detected": (("window", "band"), np.zeros((count, 2), dtype=bool)) for name in DISTORTION[2:]}
    return xr.Dataset(
        {
            "sweep_power": (lines, SWEEP_POWER * one),
            "speed_power": (lines, np.abs(cross) ** 2 / SWEEP_POWER + speed_noise * (AVERAGES - 1) / AVERAGES),
            "speed_noise": (lines, speed_noise),
            "command_noise": (lines, np.nan * one),
            "cross_noise": (lines, np.nan * one),
            "cross_speed": (lines, cross),
            "cross_command": (lines, np.nan * one),
            "averages": (lines, AVERAGES * one),
            "degrees_of_freedom": (lines, 40 * one),
            "sweep_rounding": (lines, 0 * one),
            "sweep_period": ("window", np.full(count, 120.0)),
            "key": ("window", [f"spectra {row}" for row in range(count)]),
            "torque_spectrogram": (images, power),
            "speed_spectrogram": (images, 1e-6 * power),
        }
        | levels
        | detected,
        {
            "band": FREQUENCY[[0, 80]],
            "band_end": ("band", FREQUENCY[[80, -1]]),
            "frequency": FREQUENCY,
            "spectrogram_frequency": 0.1 * np.arange(50),
            "spectrogram_time": 30.0 * (1 + np.arange(20)),
            **{name: windows[name] for name in ("window", "hole_depth", "start", "end")},
        },
    )


def records_of(time: np.ndarray[Any, np.dtype[np.datetime64]]) -> xr.Dataset:
    """Records that hold nothing, so that no sign can be read in them."""
    empty = {name: ("time", np.full(time.size, np.nan)) for name in CHANNEL_UNITS}
    marks = {name: ("time", np.zeros(time.size)) for name in ("flags", "log")}
    return xr.Dataset(empty | marks, {"time": time})


def make_well(results: Path, name: str, count: int, *, gap: float = 0.0, settings: Settings = SETTINGS) -> Well:
    """Write all datasets of a well with so many windows; of one without windows only the windows."""
    well, folders = Well(name, Rig.checked(RIG, "rig"), ()), WellFolders(results, name)
    windows = windows_of(count, gap)
    folders.write("windows", "windows", windows)
    end = int((windows["first_sample"] + windows["samples"]).max()) if count else 2
    time = np.datetime64("2025-05-01", "ns") + np.arange(end) * np.timedelta64(1, "s")
    drilling = xr.Dataset({"rig_state": ("time", np.full(end, RigState.DRILLING))}, {"time": time})
    folders.write("windows", "states", drilling)
    folders.write("records", "records", records_of(time))
    state = RigState.DRILLING.name.lower()
    rows = [
        (name, state, begin, end, top, bottom, WINDOW_S, 1, "")
        for begin, end, top, bottom in zip(
            *(windows[each].values for each in ("start", "end", "depth_from", "depth_to")), strict=True
        )
    ]
    reason = "too short: 300.0 s of the 360.0 s needed"
    rows += [(name, state, "2025-05-01T09:00:00", "2025-05-01T09:05:00", 1090, 1091, 300, 0, reason)]
    rows += [(name, "connection", "2025-05-01T09:05:00", "2025-05-01T09:08:00", 1091, 1091, 180, 0, "connection")]
    pd.DataFrame(rows, columns=list(SEGMENT_COLUMNS)).to_csv(folders.stage("windows") / "segments.csv", index=False)
    if count:
        folders.write("spectra", "spectra", spectra_of(windows, well.rig, np.random.default_rng(20250501)))
        for stage in (mobility, fits, discrepancy, depth):
            stage.process(well, folders, settings)
    return well

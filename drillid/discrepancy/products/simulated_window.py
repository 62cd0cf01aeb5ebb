"""A drilled window simulated in time by the rig that was identified in it, with what was named or learnt."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from drillid.arrays import Floats
from drillid.config.folders import folder_of
from drillid.datasets.store import WellFolders
from drillid.discrepancy.products.extended_model import simulated_rigs
from drillid.errors import LogError, SettingsError, writing
from drillid.physics.nonlinear import NonlinearRig
from drillid.simulation.simulate import SAMPLE_INTERVAL, TIME_STEP, simulate
from drillid.units import RPM
from drillid.windows.channels import sample_rate, window_channels

_ANY_WEIGHT = 1e5
"""N, weight on bit where none is logged: the cutting laws have their torques at whatever weight is given."""

COLUMNS = ("t_s", "torque_sweep_knm", "td_rpm_measured", "td_rpm", "torque_command_knm", "bit_rpm")
"""Columns of the file that is written: time since the window's start first; the last three are simulated."""


@dataclass(frozen=True, eq=False)
class SimulatedWindow:
    """Series at SAMPLE_INTERVAL, each (samples,), SI units."""

    time: Floats
    sweep: Floats
    measured: Floats
    """rad/s, recorded speed of the top drive."""
    speed: Floats
    command: Floats
    bit_speed: Floats

    def write(self, path: Path) -> None:
        """Write COLUMNS to a CSV file."""
        import pandas as pd

        series = (self.time, self.sweep / 1e3, self.measured / RPM, self.speed / RPM, self.command / 1e3)
        columns = dict(zip(COLUMNS, (*series, self.bit_speed / RPM), strict=True))
        with writing(path, "--output", LogError):
            pd.DataFrame(columns).to_csv(path, index=False, float_format="%.4f")

    @property
    def summary(self) -> str:
        """Text: how far speeds swing, and how alike simulated and recorded speed are."""
        alike = float(np.corrcoef(self.measured, self.speed)[0, 1])
        swings = [float(np.std(series)) / RPM for series in (self.measured, self.speed, self.bit_speed)]
        return (
            f"top drive {swings[0]:.2f} rpm rms about its mean as recorded, {swings[1]:.2f} simulated (correlation "
            f"{alike:.2f}); bit {swings[2]:.2f} rpm rms\nwhat rock and noise do to the recorded speed is not simulated"
        )


def simulated_window(results: Path, well: str, window: int) -> SimulatedWindow:
    """Simulate a window under its recorded sweep and set point, at a bit torque that gives its mean torque.

    Parameters
    ----------
    results : folder of a run
    window : number of the window, as in the datasets

    Raises
    ------
    SettingsError
        If the well or the window was not examined, or what was found has no simulation in time.
    """
    folders = WellFolders(results, well)
    if not folders.has("discrepancy", "examination"):
        folders = WellFolders(results, folder_of(well), name=well)
    if not folders.has("discrepancy", "examination"):
        raise SettingsError(
            f"{results}, well {well}",
            "there is no examination of it",
            "Give the results of a run, and one of its wells",
        )
    examination, windows = (
        folders.read(*each).load() for each in (("discrepancy", "examination"), ("windows", "windows"))
    )
    rows = np.flatnonzero(windows["window"].values == window)
    rigs = simulated_rigs(examination)
    if rows.size == 0 or int(rows[0]) not in rigs:
        known = ", ".join(str(windows["window"].values[row]) for row in sorted(rigs)) or "none"
        raise SettingsError(f"well {well}, window {window}", "it was not examined", f"Examined are: {known}")
    row, records = int(rows[0]), folders.read("records", "records")
    sweep, measured = window_channels(records, windows, row, ("torque_sweep", "speed"))
    set_speed, torque = (float(windows[name].values[row]) for name in ("speed", "torque"))
    weight = float(windows["weight_on_bit"].values[row])
    weight = weight if weight > 0 else _ANY_WEIGHT
    rig = _with_cutting(rigs[row], weight)
    rock = float(np.nan_to_num(torque)) - _steady_torque(rig, set_speed, weight)
    recorded = np.arange(sweep.size) / sample_rate(records)
    steps = np.arange(0.0, recorded[-1], TIME_STEP)
    still = np.zeros(steps.size)
    result = simulate(
        rig,
        np.interp(steps, recorded, np.nan_to_num(sweep)),
        still + set_speed,
        still + rock,
        mean_bit_torque=rock,
        weight_on_bit=weight,
        sample_interval=SAMPLE_INTERVAL,
    )
    own = [np.interp(result.time, recorded, np.nan_to_num(series)) for series in (sweep, measured)]
    return SimulatedWindow(result.time, own[0], own[1], result.speed, result.torque_command, result.bit_speed)


def _steady_torque(rig: NonlinearRig, speed: float, weight: float) -> float:
    """What the rig's own dampings and cutting laws take at a steady speed, N m."""
    drag = sum(float(section.kappa * section.polar_moment * section.length) for section in rig.system.string)
    torque = (drag + float(rig.system.bit.damping)) * speed
    torque += rig.regenerative.torque(speed, weight) if rig.regenerative else 0.0
    return torque + (rig.cutting.torque(weight, speed) if rig.cutting else 0.0)


def _with_cutting(rig: NonlinearRig, weight: float) -> NonlinearRig:
    """The rig with the bit's named cutting laws as the simulator has them."""
    if not rig.system.bit.cutting:
        return rig
    cut = NonlinearRig.from_linear(rig.system, weight)
    return replace(rig, system=cut.system, cutting=cut.cutting, regenerative=cut.regenerative)

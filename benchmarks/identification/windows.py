"""Windows of steady drilling from the time-domain simulator, kept under results/bench between runs.

A run of the simulator gives several windows, one after the other. Runs are spread over two processes, and each is
kept in a file named after the simulator's code and all of its inputs.
"""

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from rich.progress import track

from drillid.arrays import Floats
from drillid.config.settings import Settings
from drillid.excitation.torques import SWEEP_PERIOD
from drillid.fits.window_fit import Measured, measured_rows
from drillid.fleet.provenance import digest, source_hash
from drillid.mobility.gate import gated_mobility
from drillid.spectra.cross_spectra import Spectra, stacked
from drillid.spectra.periodic import line_spectra
from drillid.spectra.stage import frequency_grid
from tests.simulated import DEEP, RATE, WINDOW_S, Truth, drilled

FOLDER = Path("results/bench")
PROCESSES = 2
BIT_NOISE = (100.0, 225.0, 350.0, 475.0, 600.0)
"""N m rms, in the order of runs."""
SWEEP = 500.0
"""N m, of each of the three sweeps."""
SETTINGS = Settings.checked({"fits": {"use_data_sheets": False}}, "benchmark")
"""Default settings, but without the rig's data sheets."""

_WINDOWS_PER_RUN = 5
_SAMPLES = round(WINDOW_S * RATE)


@dataclass(frozen=True, eq=False)
class SimulatedWindow:
    """One window of a known rig; channels of shape (samples,) at RATE, in SI units."""

    truth: Truth
    sweep: Floats
    speed: Floats
    command: Floats


@dataclass(frozen=True)
class Run:
    """What one run of the simulator is made from."""

    truth: Truth
    windows: int
    seed: int

    @property
    def path(self) -> Path:
        """File that holds its channels."""
        code = source_hash("drillid.simulation.simulate", "drillid.excitation.torques")
        return FOLDER / "windows" / f"{digest([code, asdict(self.truth), self.windows, self.seed, RATE])}.npz"

    def make(self) -> None:
        """Simulate, unless that is done already."""
        if self.path.is_file():
            return
        channels = drilled(self.truth, self.windows * WINDOW_S, self.seed)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = self.path.with_suffix(f".{os.getpid()}.npz")
        single: dict[str, Any] = {name: values.astype(np.float32) for name, values in channels.items()}
        np.savez(unfinished, **single)
        unfinished.replace(self.path)

    def read(self) -> Iterator[SimulatedWindow]:
        """Its windows in order."""
        with np.load(self.path) as channels:
            sweep, speed, command = (
                channels[name].astype(float) for name in ("torque_sweep", "speed", "torque_command")
            )
        for first in range(0, self.windows * _SAMPLES, _SAMPLES):
            part = slice(first, first + _SAMPLES)
            yield SimulatedWindow(self.truth, sweep[part], speed[part], command[part])


def windows_of(runs: Sequence[Run], progress: str = "Simulating windows") -> list[SimulatedWindow]:
    """Windows of all runs in order; what is not there yet is simulated with two processes."""
    missing = [run for run in runs if not run.path.is_file()]
    if missing:
        with ProcessPoolExecutor(PROCESSES) as pool:
            for _ in track(pool.map(Run.make, missing), progress, total=len(missing), disable=len(missing) == 1):
                pass
    return [window for run in runs for window in run.read()]


def simulated_windows(
    count: int = 200,
    bit_noise: Sequence[float] = BIT_NOISE,
    sweep: float = SWEEP,
    seed: int = 1,
    truth: Truth = DEEP,
) -> list[SimulatedWindow]:
    """Ten-minute windows of one rig, as many at each level of bit noise.

    Parameters
    ----------
    count : windows in all, a multiple of five times the levels where all levels are to have as many
    bit_noise : N m rms
    sweep : N m, amplitude of each of the three simultaneous sweeps
    """
    runs = [
        Run(
            replace(truth, bit_noise=bit_noise[number % len(bit_noise)], sweep_amplitude=sweep),
            _WINDOWS_PER_RUN,
            1000 * seed + number,
        )
        for number in range(-(-count // _WINDOWS_PER_RUN))
    ]
    return windows_of(runs)[:count]


def quiet_window(truth: Truth) -> SimulatedWindow:
    """Any window of the same rig without bit noise: what the sweep alone does, as these rigs are linear."""
    return windows_of([Run(replace(truth, bit_noise=0.0), 1, 0)])[0]


def at_level(windows: Sequence[SimulatedWindow], bit_noise: float) -> list[SimulatedWindow]:
    """The same windows with their noise made larger or smaller, as the simulator would with such a bit.

    The rigs are linear, so that speed and command are what the sweep alone does plus what the bit does.
    """
    quiet = quiet_window(windows[0].truth)
    changed = []
    for window in windows:
        factor = bit_noise / window.truth.bit_noise
        speed, command = (
            own + factor * (whole - own)
            for own, whole in ((quiet.speed, window.speed), (quiet.command, window.command))
        )
        changed.append(SimulatedWindow(replace(window.truth, bit_noise=bit_noise), window.sweep, speed, command))
    return changed


def grid() -> Floats:
    """Frequencies of the sweep's harmonics, Hz."""
    return frequency_grid(SWEEP_PERIOD, SETTINGS.spectra, RATE)


def spectra_of(window: SimulatedWindow) -> Spectra:
    """Spectra of a window whose sweep repeats every SWEEP_PERIOD."""
    channels = (window.sweep, window.speed, window.command)
    return line_spectra(*channels, RATE, SWEEP_PERIOD, grid(), SETTINGS.spectra.noise_lines)


def mobilities(windows: Sequence[SimulatedWindow]) -> xr.Dataset:
    """Gated mobilities (window, frequency), as the stages make them."""
    return gated_mobility(stacked([spectra_of(window) for window in windows], grid()), SETTINGS.mobility)


def measured_windows(windows: Sequence[SimulatedWindow]) -> list[Measured]:
    """What a fit is given of each window: the frequencies that passed the gate."""
    return measured_rows(mobilities(windows))

"""Compiled kernels, made once before the first run, on two cores.

One process runs the simulator and compiles what the verdicts need, the other what the fits need, both from a computed
mobility. Then the simulated log goes through all stages, so that nothing is left to compile.

`make setup` runs it when the kernels' sources have changed. Of two at once, one waits for the other and finds all done.
"""

import multiprocessing
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import typer

import drillid
from drillid.config.rig import Rig
from drillid.config.settings import FitsSettings, SimulateSettings
from drillid.demo.wells import WELLS, write_demo_log
from drillid.discrepancy.evidence import Evidence, OperatingPoints
from drillid.discrepancy.inference.set_model import SetModel
from drillid.fits.datasheet import DataSheet, data_sheet
from drillid.fits.joint.fit import joint_fit
from drillid.fits.window_fit import Measured, fit
from drillid.fleet.lock import held
from drillid.physics.held_control import read_and_kept
from drillid.physics.limits import rate_limited, withheld_by_play
from drillid.physics.parameters import USUAL
from drillid.physics.responses import command_mobility, laplace

ROOT = Path(__file__).resolve().parents[1]
WELL, RIG = "D03", ROOT / "config/demo/rigs/charlie.yaml"
"""Well and rig of the demo; the well's windows are accepted, so they are examined as a set."""
DEPTH = 1600.0


def main() -> None:
    """Compile all kernels that are not compiled yet."""
    cache = Path(os.environ.get("NUMBA_CACHE_DIR", ROOT / ".venv/numba"))
    with held(cache / ".lock"), tempfile.TemporaryDirectory() as folder:
        log = Path(folder, f"{WELL}_20250601T0600.csv")
        print("compiled kernels: two processes, less than a minute …", flush=True)
        # forked, so that it too holds the lock
        other = multiprocessing.get_context("fork").Process(target=timed, args=("fits", fit_mobility))
        other.start()
        timed("simulator", lambda: simulate(log))
        timed("verdicts", examine_mobility)
        other.join()
        timed("all stages", lambda: drillid.identify(log, RIG).results)


def timed(kernels: str, work: Callable[[], object]) -> None:
    """Do the work, then print which kernels it compiled and how long it took."""
    began = time.monotonic()
    work()
    print(f"compiled kernels: {kernels}, {time.monotonic() - began:.0f} s", flush=True)


def simulate(log: Path) -> None:
    """Simulate a stand of two windows."""
    write_demo_log(WELL, 0, log, SimulateSettings(connection_s=20.0))


def fit_mobility() -> None:
    """Make one fit with intervals, and one of two windows together."""
    (sheet, measured), settings = computed(), FitsSettings()
    prior = sheet.prior(DEPTH)
    alone = fit(measured, sheet.equipment, prior, settings)
    depth, starts = DEPTH + np.arange(2.0), np.stack([alone.value, alone.value])
    joint_fit([measured] * 2, [sheet.equipment] * 2, depth, prior, starts, settings)


def examine_mobility() -> None:
    """Run the model of a set of one window, summed over its rows and row by row, a held control, and what limits."""
    sheet, measured = computed()
    rows = (row[None] for row in (measured.mobility, measured.variance, measured.degrees_of_freedom))
    used, points = np.ones((1, measured.frequency.size), dtype=bool), OperatingPoints(*np.full((5, 1), DEPTH))
    model = SetModel(Evidence(measured.frequency, *rows, used, points, sheet, USUAL.mean(axis=0, keepdims=True)))
    model.products(model.start(), ())
    model.linearised(model.start())
    read_and_kept(0.02, 0.05, 0.0)
    rate_limited(np.zeros(2), np.ones(1))
    withheld_by_play(np.zeros(2), 0.02, 1.0, 0.01)


def computed() -> tuple[DataSheet, Measured]:
    """The rig's data sheet and the well's mobility, computed without a simulation."""
    system, frequency = WELLS[WELL].system(0), np.linspace(0.05, 3.0, 100)
    mobility, same = command_mobility(system, laplace(frequency)), np.ones(frequency.size)
    sheet = data_sheet(Rig.from_yaml(RIG), system.top_drive.controller, DEPTH)
    return sheet, Measured(frequency, mobility, 1e-4 * np.abs(mobility) ** 2, 100.0 * same, same)


if __name__ == "__main__":
    typer.run(main)

"""Compiled kernels, made once before the first run: a short simulated log goes through the stages that use them.

`make setup` runs it when their sources have changed. Of two at once, one waits for the other and finds all there.
"""

import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import typer

import drillid
from drillid.config.settings import SimulateSettings
from drillid.demo.wells import write_demo_log
from drillid.fleet.lock import held

Result = TypeVar("Result")

ROOT = Path(__file__).resolve().parents[1]
WELL, RIG = "D03", ROOT / "config/demo/rigs/charlie.yaml"
"""Of the demo; a well whose windows are accepted, so that they are examined as a set."""


def main() -> None:
    """Compile what is not compiled yet."""
    cache = Path(os.environ.get("NUMBA_CACHE_DIR", ROOT / ".venv/numba"))
    with held(cache / ".lock"), tempfile.TemporaryDirectory() as folder:
        log = Path(folder, f"{WELL}_20250601T0600.csv")
        timed("simulator", lambda: simulate(log))
        found = timed("spectra, mobility and fits", lambda: identify(log))
        timed("verdicts and depth", lambda: found.results)


def timed(kernels: str, work: Callable[[], Result]) -> Result:
    """What `work` gives, with a line that tells what it is for and how long it took."""
    print(f"compiled kernels: {kernels} …", end="", flush=True)
    began = time.monotonic()
    result = work()
    print(f" {time.monotonic() - began:.0f} s", flush=True)
    return result


def simulate(log: Path) -> None:
    """A stand of two windows."""
    write_demo_log(WELL, 0, log, SimulateSettings(connection_s=20.0))


def identify(log: Path) -> drillid.Identification:
    """Both windows' fits, and the joint one."""
    return drillid.identify(log, RIG)


if __name__ == "__main__":
    typer.run(main)

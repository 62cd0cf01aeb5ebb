"""From a regular record to fitted parameters: how many times real time on one core, and growth with the log's length.

Wells of one and of ten lengths are written as the records stage leaves them. A process of its own takes each from its
records to fits with intervals, a block of windows after the other, and reports its processor time and largest memory.
A small well goes first, so that neither holds what is done once a process. The workflow's stages, which write
spectrograms, stacks and joint fits as well, are timed apart.
"""

import importlib
import json
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import typer
import xarray as xr

from benchmarks.identification.windows import FOLDER, SETTINGS, SWEEP, SimulatedWindow
from drillid.config.listing import Well
from drillid.config.rig import CHANNEL_UNITS, Rig
from drillid.config.settings import Settings
from drillid.datasets.store import WellFolders
from drillid.fits.window_fit import Prior, fit, measured_rows
from drillid.fleet.provenance import digest, source_hash
from drillid.mobility.gate import gated_mobility
from drillid.spectra.cross_spectra import stacked
from drillid.spectra.period import sweep_period
from drillid.spectra.periodic import line_spectra
from drillid.spectra.stage import frequency_grid
from drillid.windows.channels import sample_rate
from tests.simulated import DEEP, WINDOW_S, write_records

Size = Literal["warm", "short", "long"]
Way = Literal["stream", "stages"]
SIZES: dict[Size, int] = {"warm": 2, "short": 24, "long": 240}
"""Windows of ten minutes in each well."""
STAGES = ("spectra", "mobility", "fits")
_BLOCK = 12
"""Windows held at a time."""

_RESULTS = FOLDER / "throughput"
_DEEP_RIG = {
    "name": "benchmark rig",
    "channels": {name: {"column": name, "unit": unit} for name, unit in CHANNEL_UNITS.items() if name != "hook_load"},
    "controller": {"proportional": "1500 N m s/rad", "integral": "800 N m/rad"},
    "collars": [{"outer_diameter": "165.1 mm", "inner_diameter": "71.4 mm", "length": "100 m"}],
}


@dataclass(frozen=True)
class Passage:
    """One well's passage from records to fits.

    seconds : processor time
    megabytes : largest resident memory of the process
    """

    windows: int
    seconds: float
    megabytes: float

    @property
    def real_time_factor(self) -> float:
        """Seconds of record per second."""
        return self.windows * WINDOW_S / self.seconds


def passages(windows: Sequence[SimulatedWindow], size: Size, repeats: int = 3, way: Way = "stream") -> list[Passage]:
    """The well of one size, each time in a new process."""
    _write(windows, "warm")
    _write(windows, size)
    command = [sys.executable, "-m", "benchmarks.identification.throughput", size, way]
    found = []
    for _ in range(repeats):
        finished = subprocess.run(command, check=True, capture_output=True, text=True)
        found.append(Passage(**json.loads(finished.stdout.splitlines()[-1])))
    return found


def growth(short: Sequence[Passage], long: Sequence[Passage], quantity: str) -> float:
    """Median of a passage's `seconds` or `megabytes` for the long well over that for the short one."""
    late, early = (np.median([getattr(one, quantity) for one in found]) for found in (long, short))
    return float(late / early)


def _folders(name: Size) -> WellFolders:
    return WellFolders(_RESULTS, name)


def _write(windows: Sequence[SimulatedWindow], name: Size) -> None:
    """Records of a well, unless they are there: the windows again and again until there are enough."""
    folders, mark = _folders(name), _RESULTS / f"{name}.key"
    key = digest([source_hash("drillid.records.stage", "drillid.windows.stage"), SIZES[name], SWEEP, len(windows)])
    if mark.is_file() and mark.read_text() == key:
        return
    stands = [
        {"torque_sweep": window.sweep, "speed": window.speed, "torque_command": window.command}
        for window in (windows[number % len(windows)] for number in range(SIZES[name]))
    ]
    write_records(folders, stands, DEEP.bit_depth)
    mark.write_text(key)


def stream(name: Size) -> None:
    """Fits of all windows of a well, a block of windows at a time."""
    folders = _folders(name)
    records, windows = folders.read("records", "records"), folders.read("windows", "windows").load()
    rate = sample_rate(records)
    rows = list(zip(windows["first_sample"].values.tolist(), windows["samples"].values.tolist(), strict=True))
    for first in range(0, len(rows), _BLOCK):
        spectra = _spectra(records, rows[first : first + _BLOCK], rate)
        for measured in measured_rows(gated_mobility(spectra, SETTINGS.mobility)):
            fit(measured, DEEP.known, Prior.silent(), SETTINGS.fits)


def _spectra(records: xr.Dataset, rows: list[tuple[int, int]], rate: float) -> xr.Dataset:
    """Cross spectra of some windows, the sweep's period found anew in each."""
    settings, found, begin = SETTINGS.spectra, [], rows[0][0]
    names, whole = ("torque_sweep", "speed", "torque_command"), slice(begin, sum(rows[-1]))
    channels = np.stack([np.asarray(records[name][whole].values, dtype=float) for name in names])
    for first, samples in rows:
        sweep, speed, command = channels[:, first - begin : first - begin + samples]
        period = sweep_period(sweep, rate, settings.frequency_minimum_hz)
        frequency = frequency_grid(period, settings, rate)
        found.append(line_spectra(sweep, speed, command, rate, period, frequency, settings.noise_lines))
    return stacked(found, frequency)


def stages(name: Size) -> None:
    """The workflow's stages from spectra to fits."""
    well = Well(name, Rig.checked(_DEEP_RIG, "benchmark rig"), ())
    for stage in STAGES:
        importlib.import_module(f"drillid.{stage}.stage").process(well, _folders(name), Settings())


WAYS: dict[Way, Callable[[Size], None]] = {"stream": stream, "stages": stages}


def main(
    size: Annotated[Size, typer.Argument(help="Which of the wells that `passages` has written.")],
    way: Annotated[Way, typer.Argument(help="Fits alone, block by block, or the workflow's stages.")],
) -> None:
    """Take one well from its records to fits; print processor time and memory as JSON."""
    WAYS[way]("warm")
    begin = time.process_time()
    WAYS[way](size)
    seconds = time.process_time() - begin
    print(json.dumps({"windows": SIZES[size], "seconds": seconds, "megabytes": _largest_megabytes()}))


def _largest_megabytes() -> float:
    """Largest resident memory; resource.getrusage would count that of the process which started this one too."""
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    return float(status["VmHWM"].split()[0]) / 1024


if __name__ == "__main__":
    typer.run(main)

"""The same wells by one worker and by two: time of the clock, whole workflow, on a machine with nothing else to do.

Where other programs take part of the cores, the ratio is smaller than the workflow's; the best of some repeats counts.
"""

import hashlib
import os
from pathlib import Path

from rich.console import Console

from benchmarks.fleet.measurement import FOLDER
from benchmarks.fleet.sheets import Run, workflow
from benchmarks.fleet.wells import write_wells
from benchmarks.parts import Measurement
from benchmarks.result import Result

WELLS, REPEATS = 40, 2


def measure(console: Console) -> Measurement:
    """Run with one and with two workers in turn, and compare the bits as well."""
    clocks: dict[int, list[float]] = {1: [], 2: []}
    bits = set[str]()
    for _ in range(REPEATS):
        for workers, spent in clocks.items():
            spent.append(spread_run(workers).clock)
            bits.add(content(FOLDER / "speedup/results"))
    ratio = min(clocks[1]) / min(clocks[2])
    console.print(
        f"{WELLS} wells: {min(clocks[1]):.0f} s by one worker, {min(clocks[2]):.0f} s by two; load of the machine "
        f"{os.getloadavg()[0]:.1f}; results {'identical' if len(bits) == 1 else 'DIFFERENT'} in all {2 * REPEATS} runs"
    )
    return Measurement(
        [Result("speedup_2_workers", "speed-up on two workers", ratio, least=1.8)],
        {"identical_on_2_workers": len(bits) == 1},
    )


def spread_run(workers: int) -> Run:
    """All wells anew in one batch for each worker."""
    folder = FOLDER / "speedup"
    write_wells(folder, WELLS)
    return workflow(folder, "--cores", str(workers), "--config", f"fleet={{batch_size: {WELLS // 2}}}")


def content(results: Path) -> str:
    """Hash of all numbers and figures: every dataset's chunks, and PNG files."""
    digest = hashlib.sha256()
    for path in sorted(results.rglob("*")):
        if path.is_file() and ("/c/" in path.as_posix() or path.suffix == ".png"):
            digest.update(path.relative_to(results).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()

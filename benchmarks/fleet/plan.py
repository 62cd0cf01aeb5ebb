"""Dry run of 1000 wells with ten logs each: time of one core and memory.

Once with one well a job, of which the figures are, and once with 25, as the profiles of clusters set it.
"""

import re
import shutil
from pathlib import Path

from rich.console import Console

from benchmarks.fleet.measurement import FOLDER
from benchmarks.fleet.sheets import ROOT, Run, workflow, write_fleet
from benchmarks.parts import Measurement
from benchmarks.result import Result

WELLS, LOGS = 1000, 10
BATCHES = (1, 25)


def measure(console: Console) -> Measurement:
    """Lay the sheets out and plan."""
    folder = FOLDER / "plan"
    lay_out(folder, WELLS, LOGS)
    found = {size: dry_run(folder, size) for size in BATCHES}
    shutil.rmtree(folder)
    for size, run in found.items():
        console.print(
            f"{WELLS} wells, {size} a job: {planned_jobs(run):,} jobs planned in {run.seconds:.1f} s, "
            f"{run.clock:.1f} s of the clock, {run.mebibytes:.0f} MiB"
        )
    singly, batched = (found[size] for size in BATCHES)
    return Measurement(
        [
            Result("plan_s_1000", "dry run of 1000 wells, s", singly.seconds, most=60.0),
            Result("plan_mib_1000", "memory of the dry run of 1000 wells, MiB", singly.mebibytes, most=1024.0),
        ],
        {"plan_s_of_a_well": batched.seconds / WELLS},
    )


def lay_out(folder: Path, wells: int, logs: int) -> None:
    """Sheets of wells with so many logs each; a dry run does not read them."""
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "raw").mkdir(parents=True)
    sheet = {f"W{well:05d}": [f"raw/W{well:05d}_{log}.csv" for log in range(logs)] for well in range(wells)}
    for path in (path for paths in sheet.values() for path in paths):
        (folder / path).write_text("no samples\n")
    rigs = sorted((ROOT / "config/demo/rigs").glob("*.yaml"))
    write_fleet(folder, sheet, {well: rigs[number % len(rigs)] for number, well in enumerate(sheet)})


def dry_run(folder: Path, batch_size: int) -> Run:
    """A dry run with so many wells a job."""
    return workflow(folder, "--dry-run", "--quiet", "rules", "--config", f"fleet={{batch_size: {batch_size}}}")


def planned_jobs(run: Run) -> int:
    """Number of jobs that the dry run lists."""
    (jobs,) = set(re.findall(r"^total +(\d+)$", run.output, re.MULTILINE))
    return int(jobs)

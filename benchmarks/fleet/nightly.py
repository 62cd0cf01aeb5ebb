"""One more day for every well of a fleet over the full run: time of one core, by stage.

A day is a log of an hour of drilling, twelve windows of five minutes. A well of thirty days is run, and a day is added,
beside a well of a single day, another one in each run, which goes first in every job and so bears what a job loads.
What the long well takes counts once for each well of the fleet, everything else once for each job's worth of wells.
"""

import datetime
import os
import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.fleet.measurement import FOLDER
from benchmarks.fleet.sheets import ROOT, workflow, write_fleet
from benchmarks.parts import Measurement
from benchmarks.result import Result
from drillid.config.settings import SimulateSettings
from drillid.demo.wells import WELLS, write_stand
from drillid.fleet.provenance import digest, source_hash
from drillid.fleet.stages import STAGES

SHORT, LONG, DAYS = "A", "B", 30
"""The wells, and the days of the long one."""
FLEET, BATCH = 50, 25
"""Wells that the share is stated for, and wells of a job."""
TRUTH = replace(WELLS["D03"], stand_length=10.0)
"""Nothing is wrong with it; an hour drills one joint of pipe."""
SIMULATED = SimulateSettings(drilling_s=3615.0, connection_s=45.0)
SETTINGS: dict[str, Any] = {"results": "results", "windows": {"length_s": 300.0}, "fleet": {"batch_size": 2}}
FIRST_DAY = datetime.datetime(2025, 6, 1, 6)


@dataclass(frozen=True)
class Cost:
    """Seconds of one core: of a whole run, and of each stage's work on the long well, with its page of the report."""

    total: float
    stages: Mapping[str, float]

    @property
    def well(self) -> float:
        """Of the long well."""
        return sum(self.stages.values())

    @property
    def rest(self) -> float:
        """Start-up and loading of all jobs, planning, tables, the fleet's page, and the short well."""
        return self.total - self.well


def measure(console: Console) -> Measurement:
    """Run in full, add a day and run again."""
    folder, logs = FOLDER / "nightly", daily_logs(DAYS + 1)
    shutil.rmtree(folder, ignore_errors=True)
    full, night = (run(folder, {SHORT: logs[days - 1 : days], LONG: logs[:days]}) for days in (DAYS, DAYS + 1))
    console.print(_table(full, night))
    share = share_of_fleet(full, night)
    console.print(
        f"These two wells as measured: {night.total / full.total:.3f} of the full run; the long well alone "
        f"{night.well / full.well:.3f}; {FLEET} such wells, {BATCH} a job, from these: {share:.3f}"
    )
    meaning = f"one more day for {FLEET} wells of {DAYS} days, over the full run"
    costs = {name: {**cost.stages, "rest": cost.rest} for name, cost in (("full", full), ("one more day", night))}
    return Measurement([Result("nightly_share", meaning, share, most=0.05)], {"nightly_s": costs})


def share_of_fleet(full: Cost, night: Cost) -> float:
    """Cost of one more day for a fleet over that of its full run."""
    costs = [FLEET * cost.well + FLEET / BATCH * cost.rest for cost in (night, full)]
    return costs[0] / costs[1]


def daily_logs(days: int) -> Sequence[Path]:
    """Logs of a well, one a day, simulated anew where the simulator has changed."""
    folder = FOLDER / "days" / digest([source_hash("drillid.demo.wells"), repr(TRUTH), SIMULATED.model_dump()])[:12]
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"W_{FIRST_DAY + datetime.timedelta(days=day):%Y%m%dT%H%M}.parquet" for day in range(days)]
    for day, path in enumerate(paths):
        if not path.is_file():
            unfinished = path.with_name(f"part_{path.name.removeprefix('W_')}")
            write_stand(TRUTH, day, unfinished, SIMULATED, np.random.default_rng([2025, day]))
            unfinished.replace(path)
    return paths


def run(folder: Path, logs: Mapping[str, Sequence[Path]]) -> Cost:
    """Run the workflow on one core with these logs of each well, which are added where they are not there yet."""
    sheet = {well: [f"raw/{well}/{log.name}" for log in own] for well, own in logs.items()}
    for well, own in logs.items():
        for log, name in zip(own, sheet[well], strict=True):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            if not (folder / name).exists():
                os.link(log, folder / name)
    write_fleet(folder, sheet, dict.fromkeys(sheet, ROOT / "config/demo/rigs/charlie.yaml"), **SETTINGS)
    total, told = workflow(folder, "--cores", "1").seconds, folder / "results/logs"
    stages = {stage: worked_seconds(told / stage, f"{LONG}: ") for stage in STAGES}
    return Cost(total, stages | {"page of the report": worked_seconds(told, f"{LONG}: ")})


def worked_seconds(folder: Path, line: str) -> float:
    """Seconds of one core that the logs in a folder tell, in lines that begin so behind their time."""
    text = "\n".join(path.read_text() for path in folder.glob("*.log"))
    return sum(map(float, re.findall(rf"^\S+ \S+ {re.escape(line)}.*?([\d.]+) s of one core", text, re.MULTILINE)))


def _table(full: Cost, night: Cost) -> Table:
    table = Table(title=f"A well of {DAYS} days, time of one core, s")
    for heading in ("", "full run", "one more day", "share"):
        table.add_column(heading, justify="right" if heading else "left")
    rows = {stage: (full.stages[stage], night.stages[stage]) for stage in full.stages}
    rows |= {"the well": (full.well, night.well), "rest of the run, with a well of a day": (full.rest, night.rest)}
    for name, (before, after) in rows.items():
        table.add_row(name, f"{before:.2f}", f"{after:.2f}", f"{after / before:.3f}" if before else "")
    return table

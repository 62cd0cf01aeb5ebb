"""One more day for every well of a fleet, over the full run: time of one core, by stage.

A day is one log of an hour of drilling, twelve windows of five minutes. Two wells of thirty days are run, one more day
is added to both, then another to one of them alone, so that what a run costs for itself and what it costs for each well
are told apart. The share of 50 wells follows from these two.
"""

import datetime
import os
import re
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.fleet.measurement import FOLDER, Measurement
from benchmarks.fleet.sheets import ROOT, workflow, write_fleet
from benchmarks.result import Result
from drillid.config.settings import SimulateSettings
from drillid.demo.wells import WELLS as DEMO
from drillid.demo.wells import write_stand
from drillid.fleet.provenance import digest, source_hash
from drillid.fleet.stages import STAGES

WELLS, DAYS = ("A", "B"), 30
FLEET, BATCH = 50, 25
"""Wells that the share is stated for, and wells of a job."""
SIMULATED = SimulateSettings(drilling_s=3615.0, connection_s=45.0)
SETTINGS: dict[str, Any] = {"results": "results", "windows": {"length_s": 300.0}, "fleet": {"batch_size": len(WELLS)}}
FIRST_DAY = datetime.datetime(2025, 6, 1, 6)


@dataclass(frozen=True)
class Cost:
    """Seconds of one core: of a whole run, and of each stage's work on the wells."""

    total: float
    stages: dict[str, float]

    @property
    def rest(self) -> float:
        """Planning, start-up, tables and report."""
        return self.total - sum(self.stages.values())


def measure(console: Console) -> Measurement:
    """Run in full, with one more day for all wells, and with one more for a single one."""
    folder, logs = FOLDER / "nightly", daily_logs(DAYS + 2)
    shutil.rmtree(folder, ignore_errors=True)
    full, night, single = (
        run(folder, {well: logs[:count] for well, count in zip(WELLS, counts, strict=True)})
        for counts in ((DAYS, DAYS), (DAYS + 1, DAYS + 1), (DAYS + 2, DAYS + 1))
    )
    costs = {"full run": full, "one more day": night, "one more for one well": single}
    console.print(_table(costs))
    of_well = night.total - single.total
    of_run = single.total - of_well
    jobs = FLEET / BATCH
    share = (jobs * of_run + FLEET * of_well) / (jobs * of_run + FLEET * (full.total - of_run) / len(WELLS))
    console.print(
        f"One more day: {of_run:.1f} s of one core for a job's run and {of_well:.1f} s for each well; "
        f"{len(WELLS)} wells as measured: {night.total / full.total:.3f} of the full run; "
        f"{FLEET} wells, {BATCH} a job, from these: {share:.3f}"
    )
    meaning = f"one more day for {FLEET} wells of {DAYS} days, over the full run"
    return Measurement(
        [Result("nightly_share", meaning, share, most=0.05)],
        {"nightly_s": {name: {"total": cost.total, **cost.stages} for name, cost in costs.items()}},
    )


def daily_logs(days: int) -> Sequence[Path]:
    """Logs of a well, one a day, simulated anew where the simulator has changed."""
    folder = FOLDER / "days" / digest([source_hash("drillid.demo.wells"), SIMULATED.model_dump()])[:12]
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"W_{FIRST_DAY + datetime.timedelta(days=day):%Y%m%dT%H%M}.parquet" for day in range(days)]
    for day, path in enumerate(paths):
        if not path.is_file():
            unfinished = path.with_name(f"part_{path.name.removeprefix('W_')}")
            write_stand(DEMO["D03"], day, unfinished, SIMULATED, np.random.default_rng([2025, day]))
            unfinished.replace(path)
    return paths


def run(folder: Path, logs: dict[str, Sequence[Path]]) -> Cost:
    """Run the workflow on one core with these logs of each well, which are added where they are not there yet."""
    sheet = {well: [f"raw/{well}/{log.name}" for log in own] for well, own in logs.items()}
    for well, own in logs.items():
        for log, name in zip(own, sheet[well], strict=True):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            if not (folder / name).exists():
                os.link(log, folder / name)
    write_fleet(folder, sheet, dict.fromkeys(sheet, ROOT / "config/demo/rigs/charlie.yaml"), **SETTINGS)
    total = workflow(folder, "--cores", "1").seconds
    return Cost(total, {stage: worked_seconds(folder / "results/logs" / stage) for stage in STAGES})


def worked_seconds(folder: Path) -> float:
    """Seconds of one core that the jobs' logs of a stage tell of all wells."""
    text = "\n".join(path.read_text() for path in folder.glob("*.log"))
    return sum(float(found) for found in re.findall(r"([\d.]+) s of one core", text))


def _table(costs: dict[str, Cost]) -> Table:
    table = Table(title=f"{len(WELLS)} wells of {DAYS} days, time of one core, s")
    for heading in ("", *costs):
        table.add_column(heading, justify="right" if heading else "left")
    for stage in STAGES:
        table.add_row(stage, *(f"{cost.stages[stage]:.2f}" for cost in costs.values()))
    table.add_row("planning, start-up, tables, report", *(f"{cost.rest:.2f}" for cost in costs.values()))
    table.add_row("all", *(f"{cost.total:.2f}" for cost in costs.values()))
    return table

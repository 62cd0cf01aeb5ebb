"""What a well costs from raw logs to the report: time of one core per stage and window, and of batches as they run.

Wells of 6, 24 and 200 windows of ten minutes in which nothing is wrong, and one of 24 windows whose drive lags. Each
stage works twice on a well in one process: the first time it loads what it needs, the second time it does not.
"""

import datetime
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.fleet.measurement import FOLDER
from benchmarks.fleet.sheets import ROOT, workflow, write_fleet
from benchmarks.parts import Measurement
from benchmarks.result import Result
from drillid.config.settings import SimulateSettings
from drillid.demo.wells import WELLS, DemoWell, write_stand
from drillid.figures.captions import FIGURES

RIG = ROOT / "config/demo/rigs/charlie.yaml"
SOUND = WELLS["D03"]
LAGGING = replace(SOUND, top_drive=replace(SOUND.top_drive, lag=0.03))
"""Its drive lags, which its data sheet does not state."""
WINDOWS_PER_STAND = 2
SIZES = (6, 24, 200)
BATCH = 4
"""Wells of a batch."""
FIRST_START = datetime.datetime(2025, 6, 1, 6)


@dataclass(frozen=True)
class StageCost:
    """Seconds of one core that a stage takes.

    loading : to load what the stage needs
    work : on one well, once it is loaded
    """

    loading: float
    work: float


def measure(console: Console) -> Measurement:
    """Simulate, run and print."""
    stages: dict[str, dict[str, StageCost]] = {}
    for size in SIZES:
        stages[f"{size} windows"] = stage_costs(f"sound-{size}", SOUND, size)
    stages["24 windows, a cause"] = stage_costs("lagging-24", LAGGING, 24)
    console.print(_table(stages))
    sound, lagging = (_batch(name, truth) for name, truth in (("sound", SOUND), ("lagging", LAGGING)))
    worked = sum(stage.work for stage in stages["24 windows"].values())
    figure = stages["24 windows"]["figures"].work / len(FIGURES)
    results = [
        Result("well_s_24_nothing_wrong", f"a well of 24 windows in a batch of {BATCH}, s", sound, most=25.0),
        Result("well_s_24_cause", "the same where its drive lags, s", lagging, most=60.0),
        Result("well_start_up_share", "share of imports and start-up", 1 - worked / sound, most=0.15),
        Result("figure_s", "one figure of it, s", figure, most=0.3),
    ]
    table = {name: {stage: vars(cost) for stage, cost in costs.items()} for name, costs in stages.items()}
    return Measurement(results, {"well_stages": table})


def stage_costs(name: str, truth: DemoWell, windows: int) -> dict[str, StageCost]:
    """Costs of all stages of a well, which is processed twice under two names."""
    folder = (FOLDER / "cost" / name).absolute()
    _lay_out(folder, truth, windows, 2)
    words = [sys.executable, "-m", "benchmarks.fleet.stages", str(folder / "fleet.yaml")]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=True)
    costs = {stage: StageCost(**cost) for stage, cost in json.loads(done.stdout.splitlines()[-1]).items()}
    shutil.rmtree(folder / "results")
    return costs


def _batch(name: str, truth: DemoWell) -> float:
    """Seconds of one core per well of 24 windows that the whole workflow takes for a batch."""
    folder = (FOLDER / "cost" / f"{name}-batch").absolute()
    _lay_out(folder, truth, 24, BATCH)
    seconds = workflow(folder).seconds
    shutil.rmtree(folder / "results")
    return seconds / BATCH


def _lay_out(folder: Path, truth: DemoWell, windows: int, wells: int) -> None:
    """A fleet of so many wells with the same logs."""
    logs = simulated(truth, windows // WINDOWS_PER_STAND)
    shutil.rmtree(folder, ignore_errors=True)
    sheet = {f"W{well}": [f"raw/W{well}/{log.name}" for log in logs] for well in range(wells)}
    for paths in sheet.values():
        (folder / paths[0]).parent.mkdir(parents=True)
        for path, log in zip(paths, logs, strict=True):
            os.link(log, folder / path)
    write_fleet(folder, sheet, dict.fromkeys(sheet, RIG), results="results", fleet={"batch_size": wells})


def simulated(truth: DemoWell, stands: int) -> Sequence[Path]:
    """Logs of a well, one a stand, which are simulated once."""
    folder = (FOLDER / "cost" / ("raw-sound" if truth is SOUND else "raw-lagging")).absolute()
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for stand in range(stands):
        start = FIRST_START + datetime.timedelta(minutes=30 * stand)
        path = folder / f"W_{start:%Y%m%dT%H%M}.parquet"
        if not path.is_file():
            unfinished = folder / f"part_{start:%Y%m%dT%H%M}.parquet"
            write_stand(truth, stand, unfinished, SimulateSettings(), np.random.default_rng([2025, stand]))
            unfinished.replace(path)
        paths.append(path)
    return paths


def _table(stages: dict[str, dict[str, StageCost]]) -> Table:
    """Seconds of one core per stage, in all and per window, and of loading."""
    table = Table(title="Time of one core, s: a well's, in brackets a window's")
    for heading in ("stage", *stages, "loading"):
        table.add_column(heading, justify="right" if heading != "stage" else "left")
    rows = {stage: [costs[stage] for costs in stages.values()] for stage in next(iter(stages.values()))}
    loading = dict.fromkeys(rows, 0.0)
    for stage, costs in rows.items():
        loading[stage] = min(cost.loading for cost in costs)
    totals = [sum(cost.work for cost in costs.values()) for costs in stages.values()]
    windows = [int(name.split()[0]) for name in stages]
    for stage, costs in rows.items():
        cells = [f"{cost.work:.2f} ({cost.work / count:.3f})" for cost, count in zip(costs, windows, strict=True)]
        table.add_row(stage, *cells, f"{loading[stage]:.2f}")
    cells = [f"{total:.2f} ({total / count:.3f})" for total, count in zip(totals, windows, strict=True)]
    table.add_row("all", *cells, f"{sum(loading.values()):.2f}")
    return table

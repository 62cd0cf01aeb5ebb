"""Small real wells: one simulated log of ten minutes each, two windows of five, taken through all stages as they are.

Nine different logs of the three demo rigs are simulated once; the wells of a fleet hold them in turn.
"""

import os
import shutil
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.fleet.measurement import FOLDER
from benchmarks.fleet.sheets import ROOT, write_fleet
from drillid.config.settings import Settings, SimulateSettings
from drillid.config.sheets import read_sheets
from drillid.demo.wells import write_demo_log
from drillid.fleet.provenance import digest, source_hash
from drillid.fleet.run import process_well, tasks_of
from drillid.fleet.stages import STAGES

RIGS = {"D01": "alfa", "D02": "bravo", "D03": "charlie"}
SUFFIXES = {"D01": ".parquet", "D02": ".csv", "D03": ".csv.gz"}
STANDS = 3
SIMULATED = SimulateSettings(drilling_s=620.0, connection_s=60.0)
SHORT_ROWS = 3000
"""Of a log of one minute."""
SETTINGS: dict[str, Any] = {"results": "results", "windows": {"length_s": 300.0}}


def raw_logs() -> list[tuple[str, Path]]:
    """Rig and log of each simulated stand, simulated anew where the simulator has changed."""
    folder = FOLDER / "logs" / digest([source_hash("drillid.demo.wells"), SIMULATED.model_dump()])[:12]
    logs = []
    for stand in range(STANDS):
        for well, rig in RIGS.items():
            path = folder / f"{well}_20250601T0{6 + stand}00{SUFFIXES[well]}"
            if not path.exists():
                partial = folder / "partial" / path.name
                write_demo_log(well, stand, partial, SIMULATED)
                os.replace(partial, path)
            logs.append((rig, path))
    return logs


def write_wells(folder: Path, number: int, drilling: int = 1) -> None:
    """A fleet of so many wells in a folder, each with a log of its own.

    Parameters
    ----------
    drilling : number of wells of which one drills; the others have a log that is too short for a window
    """
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "raw").mkdir(parents=True)
    sources, logs, rigs = raw_logs(), dict[str, list[str]](), dict[str, Path]()
    for well in range(number):
        rig, source = sources[well // drilling % len(sources)] if well % drilling == 0 else _short(*sources[0])
        name, log = f"W{well:05d}", f"raw/W{well:05d}_{source.name}"
        os.link(source, folder / log)
        logs[name], rigs[name] = [log], ROOT / f"config/demo/rigs/{rig}.yaml"
    write_fleet(folder, logs, rigs, **SETTINGS)


def _short(rig: str, source: Path) -> tuple[str, Path]:
    """Rig and log of the first rows of a log."""
    path = source.parent / "short" / source.name
    if not path.exists():
        path.parent.mkdir(exist_ok=True)
        pd.read_parquet(source).head(SHORT_ROWS).to_parquet(path)
    return rig, path


def computing_seconds(folder: Path, number: int) -> float:
    """Mean time of one core for all stages of a well without any workflow, in one process that has imported all, s.

    Parameters
    ----------
    folder : a folder for a fleet of its own
    number : wells to take it from; one more goes first
    """
    write_wells(folder, number + 1)
    with ProcessPoolExecutor(1, get_context("spawn")) as process:
        spent = process.submit(_computing_seconds, folder).result()
    shutil.rmtree(folder)
    return sum(spent[1:]) / number


def _computing_seconds(folder: Path) -> Sequence[float]:
    os.chdir(folder)
    settings = Settings(**SETTINGS)
    spent = []
    for well in read_sheets(settings):
        begin = time.process_time()
        for stage in STAGES:
            process_well(*tasks_of(stage, [well], settings))
        spent.append(time.process_time() - begin)
    return spent

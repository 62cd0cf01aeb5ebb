"""Time of one core of every stage on two wells, each stage in a process of its own; prints one line of JSON.

Run by `benchmarks.fleet.cost` in the folder of a fleet: `python -m benchmarks.fleet.stages fleet.yaml`.
"""

import json
import multiprocessing
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import yaml


def costs(configuration: Path) -> dict[str, dict[str, float]]:
    """Loading and work of every stage, and of the report over both wells as work per well."""
    from drillid.fleet.stages import STAGES

    found = {}
    for stage in STAGES:
        # a fresh interpreter, which has loaded nothing
        with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
            found[stage] = pool.submit(_cost, stage, configuration).result()
    return found


def _cost(stage: str, configuration: Path) -> dict[str, float]:
    """Process time until the first well is done, less that of the second, which needs nothing loaded."""
    from drillid.config.settings import Settings
    from drillid.config.sheets import read_sheets
    from drillid.fleet.provenance import package_hash
    from drillid.fleet.run import Task, process_well

    settings = Settings.checked(_merged(configuration), "configuration")
    results = Path(settings.results).absolute()
    ends = []
    for listing in read_sheets(settings).values():
        outcome = process_well(Task(stage, listing.absolute(), settings, results, package_hash()))
        if outcome.status != "done":
            raise RuntimeError(f"{stage}: {outcome}")
        ends.append(time.process_time())
    work = ends[1] - ends[0]
    return {"loading": ends[0] - work, "work": work}


def _merged(configuration: Path) -> dict[str, Any]:
    """Defaults with the sections and keys of a configuration."""
    defaults = yaml.safe_load((configuration.parent / "config/config.yaml").read_text())
    for name, value in yaml.safe_load(configuration.read_text()).items():
        defaults[name] = {**defaults[name], **value} if isinstance(value, dict) and name in defaults else value
    return dict(defaults)


if __name__ == "__main__":
    print(json.dumps(costs(Path(sys.argv[1]).absolute())))

"""Time of one core of every stage on two wells, each stage in a process of its own; prints one line of JSON.

Run by `benchmarks.fleet.cost` in the folder of a fleet: `python -m benchmarks.fleet.stages fleet.yaml`.
"""

import json
import multiprocessing
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Annotated

import typer


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

    settings = Settings.from_yaml(configuration)
    results = Path(settings.results).absolute()
    ends = []
    for listing in read_sheets(settings).values():
        outcome = process_well(Task(stage, listing.absolute(), settings, results, package_hash()))
        if outcome.status != "done":
            raise RuntimeError(f"{stage}: {outcome}")
        ends.append(time.process_time())
    work = ends[1] - ends[0]
    return {"loading": ends[0] - work, "work": work}


def main(configuration: Annotated[Path, typer.Argument(help="Configuration of a fleet of two wells.")]) -> None:
    """Print the costs of all stages as one line of JSON."""
    print(json.dumps(costs(configuration.absolute())))


if __name__ == "__main__":
    typer.run(main)

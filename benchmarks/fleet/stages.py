"""Time of one core of every stage on two wells and of their pages, each in a process of its own; prints a line of JSON.

Run by `benchmarks.fleet.cost` in the folder of a fleet: `python -m benchmarks.fleet.stages fleet.yaml`.
"""

import functools
import json
import multiprocessing
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Annotated

import typer


def costs(configuration: Path) -> dict[str, dict[str, float]]:
    """Loading and work of every stage, and of a well's page in the report."""
    from drillid.fleet.stages import STAGES

    steps = {stage: functools.partial(_cost, stage) for stage in STAGES} | {"page of the report": _page_cost}
    found = {}
    for name, step in steps.items():
        # a fresh interpreter, which has loaded nothing
        with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
            found[name] = pool.submit(step, configuration).result()
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


def _page_cost(configuration: Path) -> dict[str, float]:
    """Time of the first well's page less that of the second, which needs nothing loaded; tables are not counted."""
    from drillid.common_causes.stage import write_common_causes
    from drillid.config.settings import Settings
    from drillid.config.sheets import read_sheets
    from drillid.report.page import write_report
    from scripts.fleet import write

    settings = Settings.from_yaml(configuration)
    results, wells = Path(settings.results).absolute(), list(read_sheets(settings))
    config = settings.model_dump(mode="json", exclude_unset=True)
    write(config, wells, [], str(results / "problems.csv"), str(results / "logs/fleet.log"))
    write_common_causes(results, {well: {} for well in wells}, settings.common_causes)
    first, second = write_report(settings, results, wells).values()
    return {"loading": first - second, "work": second}


def main(configuration: Annotated[Path, typer.Argument(help="Configuration of a fleet of two wells.")]) -> None:
    """Print the costs of all stages as one line of JSON."""
    print(json.dumps(costs(configuration.absolute())))


if __name__ == "__main__":
    typer.run(main)

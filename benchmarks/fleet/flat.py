"""Cost of a well in fleets of 10 and of 1000 wells on one core.

The 1000 wells are the 200 of the part `overhead`, which are kept, and 800 more, whose cost is counted.
"""

import re
from pathlib import Path

from rich.console import Console

from benchmarks.fleet.measurement import FOLDER
from benchmarks.fleet.overhead import FLEET, WELLS, serial_run
from benchmarks.fleet.sheets import workflow
from benchmarks.fleet.wells import write_wells
from benchmarks.parts import Measurement
from benchmarks.result import Result

SMALL, LARGE = 10, 1000
TABLES = ("fleet", "report")


def measure(console: Console) -> Measurement:
    """Run the small fleet anew and let the other one grow."""
    folder = FOLDER / "ten"
    write_wells(folder, SMALL)
    small = workflow(folder, "--cores", "1", "--config", f"fleet={{batch_size: {SMALL}}}").seconds / SMALL
    write_wells(FLEET, WELLS, anew=False)
    serial_run()
    write_wells(FLEET, LARGE, anew=False)
    large = serial_run().seconds / (LARGE - WELLS)
    tables = sum(_seconds(FLEET / f"results/logs/{name}.log") for name in TABLES)
    console.print(
        f"A well costs {small:.2f} s in a fleet of {SMALL} and {large:.2f} s in one of {LARGE}; "
        f"tables and report of {LARGE} wells take {tables:.0f} s"
    )
    ratio = Result("cost_1000_over_10", "cost of a well in 1000 over that in 10", large / small, most=1.1)
    return Measurement([ratio], {"tables_s_of_a_well": tables / LARGE})


def _seconds(log: Path) -> float:
    """Time of one core that a job took, as its log tells."""
    found = re.search(r" job: ([\d.]+) s of one core", log.read_text())
    if found is None:
        raise RuntimeError(f"{log} does not tell what its job took")
    return float(found[1])

"""Cost of a well in fleets of 10, 100 and 1000 wells on one core.

Of ten wells, nine have a log of one minute, too short for a window: the less a well's own computing takes, the more
would show if the workflow's share of it grew with the fleet. Starts of jobs weigh more on ten wells, which fill no
batch; a hundred fill one, and a thousand ten.
"""

import re
from pathlib import Path

from rich.console import Console

from benchmarks.fleet.measurement import FOLDER
from benchmarks.fleet.sheets import workflow
from benchmarks.fleet.wells import write_wells
from benchmarks.parts import Measurement
from benchmarks.result import Result

SMALL, BATCH, LARGE = 10, 100, 1000
"""Numbers of wells, of which the second is that of a batch."""
DRILLING = 10
"""Wells among which one drills."""
TABLES = ("fleet", "report")


def measure(console: Console) -> Measurement:
    """Run the smaller fleets before and after the large one, as a machine's speed changes."""
    before = [_seconds_of_a_well(wells) for wells in (SMALL, BATCH)]
    large = _seconds_of_a_well(LARGE)
    tables = sum(_seconds(_folder(LARGE) / f"results/logs/{name}.log") for name in TABLES)
    after = [_seconds_of_a_well(wells) for wells in (SMALL, BATCH)]
    small, batch = ((one + other) / 2 for one, other in zip(before, after, strict=True))
    console.print(
        f"A well costs {small:.2f} s in a fleet of {SMALL}, {batch:.2f} s in one of {BATCH} and {large:.2f} s in one "
        f"of {LARGE} (before and after: {before[0]:.2f} and {after[0]:.2f} s, {before[1]:.2f} and {after[1]:.2f} s); "
        f"tables and report of {LARGE} wells take {tables:.0f} s"
    )
    results = [
        Result("cost_1000_over_10", "cost of a well in 1000 over that in 10", large / small, most=1.1),
        Result("cost_1000_over_100", "the same over that in 100, which fill a batch", large / batch, most=1.1),
    ]
    return Measurement(results, {"tables_s_of_a_well": tables / LARGE})


def _seconds_of_a_well(wells: int) -> float:
    """Seconds of one core that a well takes in a fleet that is run anew."""
    folder = _folder(wells)
    write_wells(folder, wells, drilling=DRILLING)
    return workflow(folder, "--cores", "1", "--config", f"fleet={{batch_size: {BATCH}}}").seconds / wells


def _folder(wells: int) -> Path:
    return FOLDER / f"flat-{wells}"


def _seconds(log: Path) -> float:
    """Time of one core that a job took, as its log tells."""
    found = re.search(r" job: ([\d.]+) s of one core", log.read_text())
    if found is None:
        raise RuntimeError(f"{log} does not tell what its job took")
    return float(found[1])

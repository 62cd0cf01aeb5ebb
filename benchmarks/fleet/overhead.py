"""200 wells through the whole workflow on one core, over the computing itself.

The computing itself is the mean well in one warm process without any workflow, times the wells: start-up, imports,
planning, keys, manifests, tables of the fleet and the report all count as overhead.
"""

from rich.console import Console

from benchmarks.fleet.measurement import FOLDER
from benchmarks.fleet.sheets import workflow
from benchmarks.fleet.wells import computing_seconds, write_wells
from benchmarks.parts import Measurement
from benchmarks.result import Result

WELLS, SAMPLE, BATCH = 200, 9, 100
FLEET = FOLDER / "fleet"


def measure(console: Console) -> Measurement:
    """Time a few wells alone before and after the run, as a machine's speed changes, and all of them in it."""
    before = computing_seconds(FOLDER / "alone", SAMPLE)
    write_wells(FLEET, WELLS)
    run = workflow(FLEET, "--cores", "1", "--config", f"fleet={{batch_size: {BATCH}}}")
    after = computing_seconds(FOLDER / "alone", SAMPLE)
    alone = (before + after) / 2
    overhead = run.seconds / (WELLS * alone) - 1
    console.print(
        f"{WELLS} wells, {BATCH} a job: {run.seconds:,.0f} s of one core, {run.clock:,.0f} s of the clock; "
        f"a well alone {alone:.2f} s ({before:.2f} s before, {after:.2f} s after); overhead {100 * overhead:.1f} %, "
        f"{run.seconds - WELLS * alone:,.0f} s"
    )
    return Measurement(
        [Result("workflow_overhead_200", "overhead of the workflow at 200 wells, share", overhead, most=0.15)],
        {"computing_s_of_a_well": alone, "overhead_s_200": run.seconds - WELLS * alone},
    )

"""10,000 wells on paper: what the measured constants say of one machine and of a cluster of 100 nodes.

Work of a well, start of a job, planning, tables and report are taken as proportional to wells or jobs, as `flat` and
`plan` show; the well is that of `overhead`, of two windows. Left out are queueing and a file system that the nodes
saturate.
"""

import json
import math
from dataclasses import dataclass

from rich.console import Console
from rich.table import Table

from benchmarks.fleet import overhead
from benchmarks.fleet.measurement import FILE
from benchmarks.parts import Measurement
from drillid.errors import SettingsError
from drillid.fleet.stages import STAGES

WELLS, NODES, CORES, BATCH = 10_000, 100, 16, 25
_MEASURED = ("computing_s_of_a_well", "overhead_s_200", "plan_s_of_a_well", "tables_s_of_a_well")


@dataclass(frozen=True)
class Constants:
    """Measured times of one core, s.

    well : all stages of a well
    job : start of a job, its imports included
    plan, tables : planning, and tables with report, of one well of a fleet
    """

    well: float
    job: float
    plan: float
    tables: float

    @classmethod
    def measured(cls) -> "Constants":
        """From the parts that have been run.

        Raises
        ------
        SettingsError
            If one of plan, overhead and flat has not been run.
        """
        found = json.loads(FILE.read_text()) if FILE.is_file() else {}
        missing = sorted(set(_MEASURED) - found.keys())
        if missing:
            parts = "Run the parts plan, overhead and flat first"
            raise SettingsError(str(FILE), f"lacks {', '.join(missing)}", parts)
        well, overhead_s, plan, tables = (float(found[name]) for name in _MEASURED)
        jobs = len(STAGES) * math.ceil(overhead.WELLS / overhead.BATCH)
        job = (overhead_s - overhead.WELLS * (plan + tables)) / jobs
        return cls(well, max(job, 0.0), plan, tables)


@dataclass(frozen=True)
class Forecast:
    """Hours of the clock for a fleet, of which a part cannot be spread; share of the cores' time that is used."""

    hours: float
    serial_hours: float
    efficiency: float


def forecast(constants: Constants, wells: int, nodes: int, cores: int, batch: int) -> Forecast:
    """A fleet on nodes that each take one job at a time and spread its wells over their cores.

    Parameters
    ----------
    wells, nodes, cores : numbers of wells, of nodes, of cores in each
    batch : wells a job
    """
    rounds = math.ceil(math.ceil(wells / batch) / nodes)
    passage = len(STAGES) * constants.job + math.ceil(batch / cores) * constants.well
    serial = wells * (constants.plan + constants.tables)
    seconds = serial + rounds * passage
    return Forecast(seconds / 3600, serial / 3600, wells * constants.well / (seconds * nodes * cores))


def measure(console: Console) -> Measurement:
    """Print the table for one node and for all."""
    constants = Constants.measured()
    console.print(
        f"Of one core: a well {constants.well:.2f} s, start of a job {constants.job:.1f} s, planning a well "
        f"{1000 * constants.plan:.0f} ms, its part of tables and report {1000 * constants.tables:.0f} ms"
    )
    table = Table(title=f"{WELLS:,} wells, {BATCH} a job, {CORES} cores a node")
    for heading in ("nodes", "hours", "of which one core is at work", "use of the cores"):
        table.add_column(heading, justify="right")
    found = {}
    for nodes in (1, NODES):
        one = forecast(constants, WELLS, nodes, CORES, BATCH)
        table.add_row(f"{nodes}", f"{one.hours:.2f}", f"{one.serial_hours:.2f}", f"{100 * one.efficiency:.0f} %")
        found[str(nodes)] = {"hours": one.hours, "serial_hours": one.serial_hours, "efficiency": one.efficiency}
    console.print(table)
    return Measurement(tables={"forecast_10000_wells_by_nodes": found})

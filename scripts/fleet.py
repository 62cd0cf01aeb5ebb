"""The fleet's dataset, and the tables of everything that was rejected and of what is new since the last report."""

from pathlib import Path

from drillid.config.settings import Settings
from drillid.datasets.tables import write_table
from drillid.depth.changes import write_changes
from drillid.depth.fleet import write_fleet
from drillid.discrepancy.learning.fleet import write_learnt
from drillid.fleet.outcome import failed_wells
from drillid.fleet.run import collect_problems, drop_damaged, logged

if __name__ == "__main__":
    results = Path(Settings.checked(dict(snakemake.config), "configuration").results)
    wells = list(snakemake.params.wells)
    with logged(snakemake.log[0]) as log:
        drop_damaged(results, wells)
        write_fleet(results, wells)
        write_learnt(results, wells)
        problems = collect_problems(results, wells, snakemake.params.start_ups)
        write_table(problems, snakemake.output.problems)
        write_changes(results, wells, problems, failed_wells(results, wells))
        log.info("%d well(s), %d problem(s)", len(wells), len(problems))

"""The fleet's dataset, and the tables of everything that was rejected and of what is new since the last report."""

from pathlib import Path
from typing import Any

from drillid.fleet.job import run_job


def write(
    config: dict[str, Any], wells: list[str], start_ups: list[str], made_from: str, problems: str, log: str
) -> None:
    """Write the dataset and all tables."""
    from drillid.config.settings import Settings
    from drillid.datasets.tables import write_table
    from drillid.depth.changes import write_changes
    from drillid.depth.fleet import write_fleet
    from drillid.discrepancy.learning.fleet import write_learnt
    from drillid.fleet.manifest import note_made_from
    from drillid.fleet.outcome import failed_wells
    from drillid.fleet.run import collect_problems, drop_damaged, logged

    results = Path(Settings.checked(config, "configuration").results)
    with logged(log) as logger:
        drop_damaged(results, wells)
        write_fleet(results, wells)
        write_learnt(results, wells)
        rows = collect_problems(results, wells, start_ups)
        write_table(rows, problems)
        write_changes(results, wells, rows, failed_wells(results, wells))
        note_made_from(results, "fleet", made_from)
        logger.info("%d well(s), %d problem(s)", len(wells), len(rows))


if __name__ == "__main__":
    run_job(
        "scripts.fleet:write",
        config=dict(snakemake.config),
        wells=list(snakemake.params.wells),
        start_ups=list(snakemake.params.start_ups),
        made_from=snakemake.params.made_from,
        problems=snakemake.output.problems,
        log=snakemake.log[0],
    )

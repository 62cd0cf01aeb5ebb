"""The fleet's report, its page and one for each well, and the run's provenance."""

from pathlib import Path
from typing import Any

from drillid.fleet.job import run_job


def write(config: dict[str, Any], wells: list[str], snakefile: str, log: str) -> None:
    """Write all pages."""
    from drillid.config.settings import Settings
    from drillid.depth.changes import mark_reported
    from drillid.fleet.crate import write_crate
    from drillid.fleet.run import logged
    from drillid.report.page import write_report

    settings = Settings.checked(config, "configuration")
    with logged(log) as logger:
        for well, spent in write_report(settings, Path(settings.results), wells).items():
            logger.info("%s: page, %.2f s of one core", well, spent)
        mark_reported(Path(settings.results))
        write_crate(settings, Path(settings.results), wells, Path(snakefile))
        logger.info("report over %d well(s)", len(wells))


if __name__ == "__main__":
    run_job(
        "scripts.report:write",
        config=dict(snakemake.config),
        wells=list(snakemake.params.wells),
        snakefile=str(Path(snakemake.scriptdir).parent / "Snakefile"),
        log=snakemake.log[0],
    )

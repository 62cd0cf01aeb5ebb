"""The fleet's report, its page and one for each well, and the run's provenance."""

from pathlib import Path

from drillid.config.settings import Settings
from drillid.depth.changes import mark_reported
from drillid.fleet.crate import write_crate
from drillid.fleet.run import logged
from drillid.report.page import write_report

if __name__ == "__main__":
    settings = Settings.checked(dict(snakemake.config), "configuration")
    wells = list(snakemake.params.wells)
    with logged(snakemake.log[0]) as log:
        for well, spent in write_report(settings, Path(settings.results), wells).items():
            log.info("%s: page, %.2f s of one core", well, spent)
        mark_reported(Path(settings.results))
        write_crate(settings, Path(settings.results), wells, Path(snakemake.scriptdir).parent / "Snakefile")
        log.info("report over %d well(s)", len(wells))

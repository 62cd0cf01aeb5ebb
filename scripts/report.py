"""The fleet's report: its page and one for each well."""

import time
from pathlib import Path

from drillid.config.settings import Settings
from drillid.depth.changes import mark_reported
from drillid.fleet.run import logged
from drillid.report.page import write_report

if __name__ == "__main__":
    settings = Settings.checked(dict(snakemake.config), "configuration")
    wells = list(snakemake.params.wells)
    with logged(snakemake.log[0]) as log:
        began = time.process_time()
        write_report(settings, Path(settings.results), wells)
        spent = time.process_time() - began
        mark_reported(Path(settings.results))
        log.info("report over %d well(s), %.2f s of one core", len(wells), spent)

"""Causes that wells of a rig, a hole section or a tool have in common."""

from pathlib import Path

from drillid.common_causes.stage import write_common_causes
from drillid.config.settings import Settings
from drillid.fleet.run import logged

if __name__ == "__main__":
    settings = Settings.checked(dict(snakemake.config), "configuration")
    wells = dict(snakemake.params.wells)
    with logged(snakemake.log[0]) as log:
        named = write_common_causes(Path(settings.results), wells, settings.common_causes)
        log.info("%d well(s), %d common cause(s)", len(wells), named)

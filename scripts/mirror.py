"""The copy of the results, brought up to date."""

from pathlib import Path

from drillid.config.settings import Settings
from drillid.fleet.mirror import update_mirror
from drillid.fleet.run import logged

if __name__ == "__main__":
    settings = Settings.checked(dict(snakemake.config), "configuration")
    with logged(snakemake.log[0]) as log:
        changes = update_mirror(Path(settings.results), snakemake.params.mirror, Path(snakemake.output.listing))
        log.info("%d file(s) written to %s, %d deleted", changes.written, snakemake.params.mirror, changes.deleted)

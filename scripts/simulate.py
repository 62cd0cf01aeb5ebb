"""Raw log of one stand of a well of the embedded demo fleet."""

from pathlib import Path

from drillid.config.settings import Settings
from drillid.demo.wells import write_demo_log
from drillid.fleet.run import logged

if __name__ == "__main__":
    settings = Settings.checked(dict(snakemake.config), "configuration")
    well, stand, raw = snakemake.params.well, snakemake.params.stand, Path(snakemake.output.raw)
    with logged(snakemake.log[0]) as log:
        write_demo_log(well, stand, raw, settings.simulate)
        log.info("%s: log of stand %d written", well, stand)

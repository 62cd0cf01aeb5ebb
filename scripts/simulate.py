"""Raw logs of one well of the embedded demo fleet."""

from pathlib import Path

from drillid.config.settings import Settings
from drillid.demo.wells import write_demo_logs
from drillid.fleet.run import logged

if __name__ == "__main__":
    settings = Settings.checked(dict(snakemake.config), "configuration")
    with logged(snakemake.log[0]) as log:
        write_demo_logs(snakemake.params.well, [Path(path) for path in snakemake.output], settings.simulate)
        log.info("%s: %d log(s) written", snakemake.params.well, len(snakemake.output))

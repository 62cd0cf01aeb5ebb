"""Raw logs to regular SI time series with quality flags."""

from drillid.config.settings import Settings
from drillid.fleet.manifest import write_manifest
from drillid.fleet.run import run_stage

if __name__ == "__main__":
    settings = Settings.checked(dict(snakemake.config), "configuration")
    run_stage("records", snakemake.params.wells, settings, snakemake.log[0])
    write_manifest(snakemake.output.manifest, snakemake.params.wells)

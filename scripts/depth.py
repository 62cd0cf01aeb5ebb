"""The depth-indexed dataset of a well and its parameter table."""

from drillid.config.settings import Settings
from drillid.fleet.run import run_stage

if __name__ == "__main__":
    settings = Settings.checked(dict(snakemake.config), "configuration")
    run_stage("depth", snakemake.params.wells, settings, snakemake.log[0], snakemake.output.manifest)

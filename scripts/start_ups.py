"""A described well fitted to the first part of a measured start of rotation, and judged on the rest of it."""

from drillid.config.settings import Settings
from drillid.fleet.run import run_stage

if __name__ == "__main__":
    settings = Settings.checked(dict(snakemake.config), "configuration")
    run_stage("start_ups", snakemake.params.wells, settings, snakemake.log[0], snakemake.output.manifest)

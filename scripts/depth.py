"""The depth-indexed dataset of a well and its parameter table."""

from drillid.config.settings import Settings
from drillid.fleet.run import run_stage

if __name__ == "__main__":
    run_stage(
        "depth", snakemake.params.wells, Settings.checked(dict(snakemake.config), "configuration"), snakemake.log[0]
    )

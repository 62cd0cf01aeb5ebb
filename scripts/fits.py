"""The transmission line's eight parameters for every window and stack."""

from drillid.config.settings import Settings
from drillid.fleet.run import run_stage

if __name__ == "__main__":
    run_stage(
        "fits", snakemake.params.wells, Settings.checked(dict(snakemake.config), "configuration"), snakemake.log[0]
    )

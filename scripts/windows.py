"""Rig states, and windows of steady drilling with the sweep on."""

from drillid.config.settings import Settings
from drillid.fleet.run import run_stage

if __name__ == "__main__":
    run_stage(
        "windows", snakemake.params.wells, Settings.checked(dict(snakemake.config), "configuration"), snakemake.log[0]
    )

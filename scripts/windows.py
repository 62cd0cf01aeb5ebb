"""Rig states, and windows of steady drilling with the sweep on."""

from drillid.config.settings import Settings
from drillid.fleet.run import run_stage

if __name__ == "__main__":
    settings = Settings.checked(dict(snakemake.config), "configuration")
    run_stage("windows", snakemake.params.wells, settings, snakemake.log[0], snakemake.output.manifest)

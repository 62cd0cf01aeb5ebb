"""The paper's figures for a well."""

from drillid.config import Settings
from drillid.fleet import run_stage

if __name__ == "__main__":
    run_stage(
        "figures", snakemake.params.wells, Settings.checked(dict(snakemake.config), "configuration"), snakemake.log[0]
    )

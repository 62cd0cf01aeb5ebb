"""Raw logs to regular SI time series with quality flags."""

from drillid.config.settings import Settings
from drillid.fleet.run import run_stage

if __name__ == "__main__":
    run_stage(
        "records", snakemake.params.wells, Settings.checked(dict(snakemake.config), "configuration"), snakemake.log[0]
    )

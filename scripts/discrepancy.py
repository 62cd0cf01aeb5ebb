"""What the fitted models leave unexplained, and verdicts on its cause."""

from drillid.config.settings import Settings
from drillid.fleet.run import run_stage

if __name__ == "__main__":
    run_stage(
        "discrepancy",
        snakemake.params.wells,
        Settings.checked(dict(snakemake.config), "configuration"),
        snakemake.log[0],
    )

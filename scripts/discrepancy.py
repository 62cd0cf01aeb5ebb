"""What the fitted models leave unexplained, and verdicts on its cause."""

from drillid.fleet.job import run_stage_job

if __name__ == "__main__":
    run_stage_job("discrepancy", snakemake)

"""Raw logs to regular SI time series with quality flags."""

from drillid.fleet.job import run_stage_job

if __name__ == "__main__":
    run_stage_job("records", snakemake)

"""The depth-indexed dataset of a well and its parameter table."""

from drillid.fleet.job import run_stage_job

if __name__ == "__main__":
    run_stage_job("depth", snakemake)

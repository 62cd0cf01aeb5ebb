"""The transmission line's eight parameters for every window and stack."""

from drillid.fleet.job import run_stage_job

if __name__ == "__main__":
    run_stage_job("fits", snakemake)

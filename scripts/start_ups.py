"""A described well fitted to the first part of a measured start of rotation, and judged on the rest of it."""

from drillid.fleet.job import run_stage_job

if __name__ == "__main__":
    run_stage_job("start_ups", snakemake)

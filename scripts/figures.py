"""The paper's figures for a well."""

from drillid.fleet.job import run_stage_job

if __name__ == "__main__":
    run_stage_job("figures", snakemake)

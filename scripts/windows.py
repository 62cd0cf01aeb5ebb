"""Rig states, and windows of steady drilling with the sweep on."""

from drillid.fleet.job import run_stage_job

if __name__ == "__main__":
    run_stage_job("windows", snakemake)

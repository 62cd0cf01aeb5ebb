"""Command mobility with its coherence gate, and stacks of windows."""

from drillid.fleet.job import run_stage_job

if __name__ == "__main__":
    run_stage_job("mobility", snakemake)

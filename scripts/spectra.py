"""Cross spectra and spectrograms of every window."""

from drillid.fleet.job import run_stage_job

if __name__ == "__main__":
    run_stage_job("spectra", snakemake)

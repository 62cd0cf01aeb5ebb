"""Identification while drilling: raw rig logs in, depth datasets and a report out."""

from snakemake.utils import min_version

min_version("9.20")


configfile: "config/config.yaml"


include: "workflow/rules/common.smk"
include: "workflow/rules/simulate.smk"
include: "workflow/rules/records.smk"
include: "workflow/rules/windows.smk"
include: "workflow/rules/spectra.smk"
include: "workflow/rules/mobility.smk"
include: "workflow/rules/fits.smk"
include: "workflow/rules/discrepancy.smk"
include: "workflow/rules/depth.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/fleet.smk"
include: "workflow/rules/report.smk"


rule all:
    default_target: True
    input:
        everything(),

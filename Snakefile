"""Identification while drilling: raw rig logs in, depth datasets and a report out."""

from snakemake.utils import min_version

min_version("9.20")


configfile: "config/config.yaml"


include: "workflow/rules/common.smk"


pathvars:
    results=PLAN.settings.results,
    logs=f"{PLAN.settings.results}/logs",


report: "workflow/report/workflow.rst"


wildcard_constraints:
    stage=one_of(stage for stage in STAGES if stage != "figures"),
    batch=one_of(BATCHES),
    well=one_of(PLAN.wells),
    log=one_of(SIMULATED),
    start_up=one_of(PLAN.start_ups),


onstart:
    begin()
    forget_forced()


onsuccess:
    end()


onerror:
    end()


include: "workflow/rules/simulate.smk"
include: "workflow/rules/records.smk"
include: "workflow/rules/windows.smk"
include: "workflow/rules/spectra.smk"
include: "workflow/rules/mobility.smk"
include: "workflow/rules/fits.smk"
include: "workflow/rules/discrepancy.smk"
include: "workflow/rules/common_causes.smk"
include: "workflow/rules/start_ups.smk"
include: "workflow/rules/depth.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/well.smk"
include: "workflow/rules/fleet.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/mirror.smk"


rule all:
    default_target: True
    input:
        everything(),
        mirrored(),

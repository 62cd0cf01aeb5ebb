"""Command mobility with its coherence gate, and stacks of windows."""

for batch, wells in PLAN.batches.items():

    rule:
        name:
            f"mobility_{batch}"
        input:
            spectra=folders("spectra", wells),
        output:
            kept_folders("mobility", wells),
        log:
            f"{RESULTS}/logs/mobility/{batch}.log",
        benchmark:
            f"{RESULTS}/benchmarks/mobility/{batch}.tsv"
        conda:
            "../../envs/drillid.yaml"
        threads: PLAN.threads(wells)
        resources:
            mem_mb=1000 * PLAN.threads(wells),
            runtime=10 + 5 * len(wells),
        params:
            **PLAN.dependencies("mobility", wells),
        script:
            "../../scripts/mobility.py"

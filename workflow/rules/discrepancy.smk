"""What the fitted models leave unexplained, and verdicts on its cause."""

for batch, wells in PLAN.batches.items():

    rule:
        name:
            f"discrepancy_{batch}"
        input:
            records=folders("records", wells),
            windows=folders("windows", wells),
            spectra=folders("spectra", wells),
            mobility=folders("mobility", wells),
            fits=folders("fits", wells),
        output:
            kept_folders("discrepancy", wells),
        log:
            f"{RESULTS}/logs/discrepancy/{batch}.log",
        benchmark:
            f"{RESULTS}/benchmarks/discrepancy/{batch}.tsv"
        conda:
            "../../envs/drillid.yaml"
        threads: PLAN.threads(wells)
        resources:
            mem_mb=2000 * PLAN.threads(wells),
            runtime=10 + 5 * len(wells),
        params:
            **PLAN.dependencies("discrepancy", wells),
        script:
            "../../scripts/discrepancy.py"

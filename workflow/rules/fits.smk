"""The transmission line's eight parameters for every window and stack."""

for batch, wells in PLAN.batches.items():

    rule:
        name:
            f"fits_{batch}"
        input:
            windows=folders("windows", wells),
            spectra=folders("spectra", wells),
            mobility=folders("mobility", wells),
        output:
            kept_folders("fits", wells),
        log:
            f"{RESULTS}/logs/fits/{batch}.log",
        benchmark:
            f"{RESULTS}/benchmarks/fits/{batch}.tsv"
        conda:
            "../../envs/drillid.yaml"
        threads: PLAN.threads(wells)
        resources:
            mem_mb=1500 * PLAN.threads(wells),
            runtime=10 + 5 * len(wells),
        params:
            **PLAN.dependencies("fits", wells),
        script:
            "../../scripts/fits.py"

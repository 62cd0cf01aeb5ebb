"""The depth-indexed dataset of a well and its parameter table."""

for batch, wells in PLAN.batches.items():

    rule:
        name:
            f"depth_{batch}"
        input:
            records=folders("records", wells),
            windows=folders("windows", wells),
            spectra=folders("spectra", wells),
            mobility=folders("mobility", wells),
            fits=folders("fits", wells),
            discrepancy=folders("discrepancy", wells),
        output:
            kept_folders("depth", wells),
        log:
            f"{RESULTS}/logs/depth/{batch}.log",
        benchmark:
            f"{RESULTS}/benchmarks/depth/{batch}.tsv"
        conda:
            "../../envs/drillid.yaml"
        threads: PLAN.threads(wells)
        resources:
            mem_mb=1500 * PLAN.threads(wells),
            runtime=10 + 5 * len(wells),
        params:
            **PLAN.dependencies("depth", wells),
        script:
            "../../scripts/depth.py"

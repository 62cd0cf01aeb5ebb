"""Raw logs to regular SI time series with quality flags."""

for batch, wells in PLAN.batches.items():

    rule:
        name:
            f"records_{batch}"
        input:
            logs=PLAN.logs(wells),
        output:
            kept_folders("records", wells),
        log:
            f"{RESULTS}/logs/records/{batch}.log",
        benchmark:
            f"{RESULTS}/benchmarks/records/{batch}.tsv"
        conda:
            "../../envs/drillid.yaml"
        threads: PLAN.threads(wells)
        resources:
            mem_mb=PLAN.memory_mb(wells),
            runtime=10 + 5 * len(wells),
        params:
            **PLAN.dependencies("records", wells),
        script:
            "../../scripts/records.py"

"""Rig states, and windows of steady drilling with the sweep on."""

for batch, wells in PLAN.batches.items():

    rule:
        name:
            f"windows_{batch}"
        input:
            records=folders("records", wells),
        output:
            kept_folders("windows", wells),
        log:
            f"{RESULTS}/logs/windows/{batch}.log",
        benchmark:
            f"{RESULTS}/benchmarks/windows/{batch}.tsv"
        conda:
            "../../envs/drillid.yaml"
        threads: PLAN.threads(wells)
        resources:
            mem_mb=PLAN.memory_mb(wells),
            runtime=10 + 5 * len(wells),
        params:
            **PLAN.dependencies("windows", wells),
        script:
            "../../scripts/windows.py"

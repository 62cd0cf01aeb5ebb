"""Cross spectra and spectrograms of every window."""

for batch, wells in PLAN.batches.items():

    rule:
        name:
            f"spectra_{batch}"
        input:
            records=folders("records", wells),
            windows=folders("windows", wells),
        output:
            kept_folders("spectra", wells),
        log:
            f"{RESULTS}/logs/spectra/{batch}.log",
        benchmark:
            f"{RESULTS}/benchmarks/spectra/{batch}.tsv"
        conda:
            "../../envs/drillid.yaml"
        threads: PLAN.threads(wells)
        resources:
            mem_mb=1500 * PLAN.threads(wells),
            runtime=10 + 5 * len(wells),
        params:
            **PLAN.dependencies("spectra", wells),
        script:
            "../../scripts/spectra.py"

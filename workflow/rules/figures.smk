"""The paper's figures for a well."""


def kept_figures(wells):
    return [update(figures_of(well)) for well in wells]


def figures_of(well):
    return report(
        directory(f"{RESULTS}/figures/{well}"),
        patterns=["{figure}.png"],
        caption="../report/figures.rst",
        category="Figures",
        subcategory=well,
        labels={"figure": "{figure}"},
    )


for batch, wells in PLAN.batches.items():

    rule:
        name:
            f"figures_{batch}"
        input:
            records=folders("records", wells),
            windows=folders("windows", wells),
            spectra=folders("spectra", wells),
            mobility=folders("mobility", wells),
            fits=folders("fits", wells),
            discrepancy=folders("discrepancy", wells),
            depth=folders("depth", wells),
        output:
            kept_figures(wells),
        log:
            f"{RESULTS}/logs/figures/{batch}.log",
        benchmark:
            f"{RESULTS}/benchmarks/figures/{batch}.tsv"
        conda:
            "../../envs/drillid.yaml"
        threads: PLAN.threads(wells)
        resources:
            mem_mb=1500 * PLAN.threads(wells),
            runtime=10 + 5 * len(wells),
        params:
            **PLAN.dependencies("figures", wells),
        script:
            "../../scripts/figures.py"

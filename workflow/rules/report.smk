"""The fleet's report, one self-contained HTML file."""


rule report:
    input:
        fleet=rules.fleet.output.fleet,
        problems=rules.fleet.output.problems,
        windows=folders("windows", PLAN.wells),
        fits=folders("fits", PLAN.wells),
        discrepancy=folders("discrepancy", PLAN.wells),
        depth=folders("depth", PLAN.wells),
        figures=folders("figures", PLAN.wells),
    output:
        html=report(f"{RESULTS}/report.html", caption="../report/report.rst", category="Report"),
    log:
        f"{RESULTS}/logs/report.log",
    benchmark:
        f"{RESULTS}/benchmarks/report.tsv"
    conda:
        "../../envs/drillid.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        **PLAN.report_dependencies(),
    script:
        "../../scripts/report.py"

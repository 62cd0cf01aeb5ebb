"""The fleet's report; the wells' pages in the folder beside it are no outputs, so that those that hold are kept."""


rule report:
    input:
        fleet=rules.fleet.output.fleet,
        problems=rules.fleet.output.problems,
        changes=rules.fleet.output.changes,
        common_causes=rules.common_causes.output,
        windows=manifests("windows"),
        fits=manifests("fits"),
        discrepancy=manifests("discrepancy"),
        depth=manifests("depth"),
        figures=manifests("figures"),
        start_ups=start_up_manifests(),
        again=again(REPORT),
    output:
        html=report(
            "<results>/report.html",
            caption="../report/report.rst",
            category="Report",
            labels={"report": "fleet"},
        ),
        crate="<results>/ro-crate-metadata.json",
    log:
        "<logs>/report.log",
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

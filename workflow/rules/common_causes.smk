"""Causes that wells of a rig, a hole section or a tool have in common; reads what the wells' verdicts come from."""


rule common_causes:
    input:
        manifests("discrepancy"),
        again=again("common_causes.csv"),
    output:
        causes=report(
            "<results>/common_causes.csv",
            caption="../report/common_causes.rst",
            category="Tables",
            labels={"table": "common causes"},
        ),
        standings="<results>/well_standings.csv",
    log:
        "<logs>/common_causes.log",
    conda:
        "../../envs/drillid.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        **PLAN.common_causes_dependencies(),
    script:
        "../../scripts/common_causes.py"

"""All wells together: the fleet's dataset, its verdicts, everything that was rejected, and what is new."""


rule fleet:
    input:
        [manifests(stage) for stage in STAGES],
        start_up_manifests(),
        again=again("problems.csv"),
    output:
        fleet=directory("<results>/fleet.zarr"),
        problems=report(
            "<results>/problems.csv",
            caption="../report/problems.rst",
            category="Tables",
            labels={"table": "problems"},
        ),
        verdicts=report(
            "<results>/verdicts.csv",
            caption="../report/verdicts.rst",
            category="Tables",
            labels={"table": "verdicts"},
        ),
        changes=report(
            "<results>/changes.csv",
            caption="../report/changes.rst",
            category="Tables",
            labels={"table": "changes"},
        ),
        learnt=report(
            "<results>/learnt.csv",
            caption="../report/learnt.rst",
            category="Tables",
            labels={"table": "learnt"},
        ),
    log:
        "<logs>/fleet.log",
    conda:
        "../../envs/drillid.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        **PLAN.fleet_dependencies(),
    script:
        "../../scripts/fleet.py"

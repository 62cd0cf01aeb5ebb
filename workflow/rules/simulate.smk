"""Raw logs of the embedded demo fleet, one stand each; without the section `simulate` there is no such rule.

The logs sheet places them in <results>/raw.
"""

if SIMULATED:

    rule simulate:
        output:
            raw="<results>/raw/{log}",
        log:
            "<logs>/simulate/{log}.log",
        conda:
            "../../envs/drillid.yaml"
        threads: 1
        resources:
            mem_mb=1000,
            runtime=10,
        params:
            **PLAN.simulation_dependencies(),
            well=lambda wildcards: SIMULATED[wildcards.log][0],
            stand=lambda wildcards: SIMULATED[wildcards.log][1],
        script:
            "../../scripts/simulate.py"

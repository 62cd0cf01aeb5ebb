"""A copy of the results on a store or share; without the setting `mirror` there is no such rule."""

if PLAN.settings.mirror:

    rule mirror:
        input:
            everything(),
        output:
            listing="<results>/mirror.json",
        log:
            "<logs>/mirror.log",
        conda:
            "../../envs/drillid.yaml"
        threads: 1
        resources:
            mem_mb=1000,
            runtime=60,
        params:
            mirror=PLAN.settings.mirror,
        script:
            "../../scripts/mirror.py"

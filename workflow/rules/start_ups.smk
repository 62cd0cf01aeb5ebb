"""A described well fitted to the first part of a measured start of rotation, and judged on the rest of it."""


rule start_ups:
    input:
        files=lambda wildcards: PLAN.start_up_files(wildcards.start_up),
        again=again("start_ups/{start_up}.json"),
    output:
        manifest="<results>/start_ups/{start_up}.json",
    log:
        "<logs>/start_ups/{start_up}.log",
    conda:
        "../../envs/drillid.yaml"
    threads: 1
    resources:
        mem_mb=1500,
        runtime=60,
    params:
        **dependencies("start_ups", start_up),
    script:
        "../../scripts/start_ups.py"

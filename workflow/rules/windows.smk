"""Rig states, and windows of steady drilling with the sweep on."""


rule windows:
    input:
        records="<results>/records/{batch}.json",
        again=again("windows/{batch}.json"),
    output:
        manifest="<results>/windows/{batch}.json",
    log:
        "<logs>/windows/{batch}.log",
    conda:
        "../../envs/drillid.yaml"
    threads: processes
    resources:
        mem_mb=memory,
        runtime=runtime,
    params:
        **dependencies("windows"),
    script:
        "../../scripts/windows.py"

"""Command mobility with its coherence gate, and stacks of windows."""


rule mobility:
    input:
        spectra="<results>/spectra/{batch}.json",
        again=again("mobility/{batch}.json"),
    output:
        manifest="<results>/mobility/{batch}.json",
    log:
        "<logs>/mobility/{batch}.log",
    conda:
        "../../envs/drillid.yaml"
    threads: processes
    resources:
        mem_mb=lambda wildcards, threads: 1000 * threads,
        runtime=runtime,
    params:
        **dependencies("mobility"),
    script:
        "../../scripts/mobility.py"

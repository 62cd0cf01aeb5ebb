"""The depth-indexed dataset of a well and its parameter table."""


rule depth:
    input:
        records="<results>/records/{batch}.json",
        windows="<results>/windows/{batch}.json",
        spectra="<results>/spectra/{batch}.json",
        mobility="<results>/mobility/{batch}.json",
        fits="<results>/fits/{batch}.json",
        discrepancy="<results>/discrepancy/{batch}.json",
        again=again("depth/{batch}.json"),
    output:
        manifest="<results>/depth/{batch}.json",
    log:
        "<logs>/depth/{batch}.log",
    conda:
        "../../envs/drillid.yaml"
    threads: processes
    resources:
        mem_mb=lambda wildcards, threads: 1500 * threads,
        runtime=runtime,
    params:
        **dependencies("depth"),
    script:
        "../../scripts/depth.py"

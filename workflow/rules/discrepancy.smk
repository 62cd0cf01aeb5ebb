"""What the fitted models leave unexplained, and verdicts on its cause."""


rule discrepancy:
    input:
        records="<results>/records/{batch}.json",
        windows="<results>/windows/{batch}.json",
        spectra="<results>/spectra/{batch}.json",
        mobility="<results>/mobility/{batch}.json",
        fits="<results>/fits/{batch}.json",
        again=again("discrepancy/{batch}.json"),
    output:
        manifest="<results>/discrepancy/{batch}.json",
    log:
        "<logs>/discrepancy/{batch}.log",
    conda:
        "../../envs/drillid.yaml"
    threads: processes
    resources:
        mem_mb=lambda wildcards, threads: 2000 * threads,
        runtime=runtime,
    params:
        **dependencies("discrepancy"),
    script:
        "../../scripts/discrepancy.py"

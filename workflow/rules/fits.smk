"""The transmission line's eight parameters for every window and stack."""


rule fits:
    input:
        windows="<results>/windows/{batch}.json",
        spectra="<results>/spectra/{batch}.json",
        mobility="<results>/mobility/{batch}.json",
        again=again("fits/{batch}.json"),
    output:
        manifest="<results>/fits/{batch}.json",
    log:
        "<logs>/fits/{batch}.log",
    conda:
        "../../envs/drillid.yaml"
    threads: processes
    resources:
        mem_mb=lambda wildcards, threads: 1500 * threads,
        runtime=runtime,
    params:
        **dependencies("fits"),
    script:
        "../../scripts/fits.py"

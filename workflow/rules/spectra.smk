"""Cross spectra and spectrograms of every window."""


rule spectra:
    input:
        records="<results>/records/{batch}.json",
        windows="<results>/windows/{batch}.json",
        again=again("spectra/{batch}.json"),
    output:
        manifest="<results>/spectra/{batch}.json",
    log:
        "<logs>/spectra/{batch}.log",
    conda:
        "../../envs/drillid.yaml"
    threads: processes
    resources:
        mem_mb=lambda wildcards, threads: 1500 * threads,
        runtime=runtime,
    params:
        **dependencies("spectra"),
    script:
        "../../scripts/spectra.py"

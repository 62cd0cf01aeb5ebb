"""The paper's figures for a well."""


rule figures:
    input:
        records="<results>/records/{batch}.json",
        windows="<results>/windows/{batch}.json",
        spectra="<results>/spectra/{batch}.json",
        mobility="<results>/mobility/{batch}.json",
        fits="<results>/fits/{batch}.json",
        discrepancy="<results>/discrepancy/{batch}.json",
        depth="<results>/depth/{batch}.json",
        again=again("figures/{batch}.json"),
    output:
        manifest="<results>/figures/{batch}.json",
    log:
        "<logs>/figures/{batch}.log",
    conda:
        "../../envs/drillid.yaml"
    threads: processes
    resources:
        mem_mb=lambda wildcards, threads: 1500 * threads,
        runtime=runtime,
    params:
        **dependencies("figures"),
    script:
        "../../scripts/figures.py"


rule figures_of_well:
    input:
        manifest_of_well("figures"),
    output:
        report(
            directory("<results>/figures/{well}"),
            patterns=["{figure}.png"],
            caption="../report/figures.rst",
            category="Figures",
            subcategory="{well}",
            labels={"figure": "{figure}"},
        ),

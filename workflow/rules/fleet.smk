"""All wells together: the fleet's dataset, its verdicts and the table of everything that was rejected."""


rule fleet:
    input:
        stages=[folder for stage in STAGES for folder in folders(stage, PLAN.wells)],
    output:
        fleet=directory(f"{RESULTS}/fleet.zarr"),
        problems=f"{RESULTS}/problems.csv",
        verdicts=f"{RESULTS}/verdicts.csv",
    log:
        f"{RESULTS}/logs/fleet.log",
    benchmark:
        f"{RESULTS}/benchmarks/fleet.tsv"
    conda:
        "../../envs/drillid.yaml"
    threads: 1
    resources:
        mem_mb=2000,
        runtime=10,
    params:
        **PLAN.fleet_dependencies(),
    script:
        "../../scripts/fleet.py"

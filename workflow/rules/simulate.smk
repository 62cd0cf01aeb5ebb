"""Raw logs of the embedded demo fleet; without the section `simulate` there are no such rules."""

if PLAN.settings.simulate is not None:
    for well, listing in PLAN.wells.items():

        rule:
            name:
                f"simulate_{well}"
            output:
                [str(log) for log in listing.logs],
            log:
                f"{RESULTS}/logs/simulate/{well}.log",
            benchmark:
                f"{RESULTS}/benchmarks/simulate/{well}.tsv"
            conda:
                "../../envs/drillid.yaml"
            threads: 1
            resources:
                mem_mb=1000,
                runtime=10,
            params:
                **PLAN.simulation_dependencies(well),
            script:
                "../../scripts/simulate.py"

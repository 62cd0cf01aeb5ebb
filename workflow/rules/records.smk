"""Raw logs to regular SI time series with quality flags."""


rule records:
    input:
        logs=raw_logs,
        again=again("records/{batch}.json"),
    output:
        manifest="<results>/records/{batch}.json",
    log:
        "<logs>/records/{batch}.log",
    conda:
        "../../envs/drillid.yaml"
    threads: processes
    resources:
        mem_mb=memory,
        runtime=runtime,
    params:
        **dependencies("records"),
    script:
        "../../scripts/records.py"

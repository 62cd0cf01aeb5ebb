"""Raw log of one stand of a well of the embedded demo fleet."""

from pathlib import Path
from typing import Any

from drillid.fleet.job import run_job


def write(config: dict[str, Any], well: str, stand: int, raw: str, log: str) -> None:
    """Write the log."""
    from drillid.config.settings import Settings
    from drillid.demo.wells import write_demo_log
    from drillid.fleet.run import logged

    settings = Settings.checked(config, "configuration")
    with logged(log) as logger:
        write_demo_log(well, stand, Path(raw), settings.simulate)
        logger.info("%s: log of stand %d written", well, stand)


if __name__ == "__main__":
    run_job(
        "scripts.simulate:write",
        config=dict(snakemake.config),
        well=snakemake.params.well,
        stand=snakemake.params.stand,
        raw=snakemake.output.raw,
        log=snakemake.log[0],
    )

"""Causes that wells of a rig, a hole section or a tool have in common."""

from pathlib import Path
from typing import Any

from drillid.fleet.job import run_job


def write(config: dict[str, Any], wells: dict[str, dict[str, str]], made_from: str, log: str) -> None:
    """Write both tables."""
    from drillid.common_causes.stage import write_common_causes
    from drillid.config.settings import Settings
    from drillid.fleet.manifest import note_made_from
    from drillid.fleet.run import logged

    settings = Settings.checked(config, "configuration")
    with logged(log) as logger:
        named = write_common_causes(Path(settings.results), wells, settings.common_causes)
        note_made_from(Path(settings.results), "common_causes", made_from)
        logger.info("%d well(s), %d common cause(s)", len(wells), named)


if __name__ == "__main__":
    run_job(
        "scripts.common_causes:write",
        config=dict(snakemake.config),
        wells=dict(snakemake.params.wells),
        made_from=snakemake.params.made_from,
        log=snakemake.log[0],
    )

"""The copy of the results, brought up to date."""

from pathlib import Path
from typing import Any

from drillid.fleet.job import run_job


def update(config: dict[str, Any], mirror: str, listing: str, log: str) -> None:
    """Copy what is new, and delete what is gone."""
    from drillid.config.settings import Settings
    from drillid.fleet.mirror import update_mirror
    from drillid.fleet.run import logged

    settings = Settings.checked(config, "configuration")
    with logged(log) as logger:
        changes = update_mirror(Path(settings.results), mirror, Path(listing))
        logger.info("%d file(s) written to %s, %d deleted", changes.written, mirror, changes.deleted)


if __name__ == "__main__":
    run_job(
        "scripts.mirror:update",
        config=dict(snakemake.config),
        mirror=snakemake.params.mirror,
        listing=snakemake.output.listing,
        log=snakemake.log[0],
    )

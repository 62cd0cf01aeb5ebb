"""A well to which logs are added night by night, as the workflow takes it through its stages."""

from collections.abc import Sequence
from pathlib import Path

import yaml

from drillid.config.listing import Listing
from drillid.config.settings import Settings
from drillid.fleet.provenance import package_hash
from drillid.fleet.run import Task, process_well
from tests.raw_logs import RIG


def rig_file(folder: Path) -> Path:
    """The rig description of the made-up logs."""
    path = folder / "rig.yaml"
    path.write_text(yaml.safe_dump(RIG.model_dump(mode="json", exclude_unset=True)))
    return path


def night(results: Path, rig: Path, logs: Sequence[Path], stages: Sequence[str], settings: Settings) -> list[str]:
    """Take the well through stages after whatever was there before; how it ended in each."""
    listing = Listing("W1", rig, tuple(logs))
    tasks = [Task(stage, listing, settings, results, package_hash()) for stage in stages]
    return [process_well(task).status for task in tasks]


def files(results: Path, stages: Sequence[str]) -> dict[str, bytes]:
    """All that the stages wrote, but for how it came to be."""
    folders = [results / stage / "W1" for stage in stages]
    return {
        str(path.relative_to(results)): path.read_bytes()
        for folder in folders
        for path in folder.rglob("*")
        if path.is_file() and path.name not in ("key.json", ".inputs.json")
    }

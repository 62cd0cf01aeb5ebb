"""What a job leaves for the workflow to see: a manifest of its batch, `<results>/<stage>/<batch>.json`.

It lists the batch's wells with the keys in their folders, which lie beside it. Snakemake knows only the manifest;
whether a well's folder is kept or redone depends on its key.
"""

import json
import os
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

KEY = "key.json"
"""File in a well's folder that says what its datasets were made from; without it they count as never made."""

PROBLEMS = "problems.csv"
"""File in a well's folder with whatever the stage rejected."""

MADE_FROM = "made_from"
"""Folder of the results with a hash for each rule over all wells of what it was planned with."""

AGAIN = "again"
"""Mark in a key of results that are to be done again, as something could not be read for a fault of the machine."""


def stored(folder: Path) -> dict[str, Any]:
    """What one stage of one well was made from; empty if it was never finished, or a file is damaged or missing."""
    try:
        content = json.loads((folder / KEY).read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    if not isinstance(content, dict) or not isinstance(content.get("key"), str):
        return {}
    return content if all((folder / name).exists() for name in _names(content)) else {}


def stored_key(folder: Path) -> str:
    """The key of one stage of one well; empty if it was never finished."""
    return str(stored(folder).get("key", ""))


def write_manifest(path: str | Path, wells: Iterable[str], made_from: str = "") -> None:
    """Write the wells' keys once all of them have been through the stage.

    Parameters
    ----------
    path : the manifest, beside the folders of the wells
    wells : wells of the batch
    made_from : hash of code, settings and rigs that the batch was planned with
    """
    path = Path(path)
    keys = {well: stored_key(path.parent / well) for well in wells}
    write_whole(path, json.dumps({"made_from": made_from, "wells": keys}, indent=1) + "\n")


def note_made_from(results: Path, rule: str, made_from: str) -> None:
    """Leave in the results what a rule over all wells was planned with: a hash of code, settings and wells."""
    path = results / MADE_FROM / f"{rule}.txt"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, f"{made_from}\n")


def is_made_from(results: Path, rule: str, made_from: str) -> bool:
    """Whether the outputs of a rule over all wells were made from the same code, settings and wells."""
    try:
        return (results / MADE_FROM / f"{rule}.txt").read_text().strip() == made_from
    except (OSError, ValueError):
        return False


def out_of_date(path: Path, wells: Collection[str], failed_on: Callable[[str], str], made_from: str = "") -> str:
    """Why a manifest no longer holds, in a few words; empty if it does.

    It holds while the batch, code, settings and rigs are the same, folders are complete with the keys that it lists,
    nothing has changed that may have made a well fail, and nothing is to be tried again.

    Parameters
    ----------
    path : the manifest
    wells : of the batch
    failed_on : hash of everything that may make a well fail, as it is now, by the well's name
    made_from : hash of code, settings and rigs as they are now
    """
    found = _read(path)
    keys = _keys(found)
    if keys.keys() != set(wells):
        return "other wells"
    if found.get("made_from") != made_from:
        return "other code, settings or rig descriptions"
    return next(filter(None, (_unfinished(path.parent, well, key, failed_on) for well, key in keys.items())), "")


def marks(out_of_date: Mapping[Path, str], folder: Path) -> dict[str, str]:
    """New files whose names say what is out of date and why; as an input, one has Snakemake make the output again.

    Parameters
    ----------
    out_of_date : reasons by the paths of outputs
    folder : for the new files
    """
    found = {}
    for path, reason in out_of_date.items():
        mark = folder / f"{path.parent.name if path.suffix == '.json' else path.stem}: {reason}"
        mark.touch()
        found[str(path)] = str(mark)
    return found


def failed_in(path: Path) -> int:
    """How many of the manifest's wells failed; 0 without a manifest."""
    return sum(stored(path.parent / str(well)).get("status", "failed") == "failed" for well in _keys(_read(path)))


def _read(path: Path) -> dict[str, Any]:
    """Content of a manifest; empty if it is missing or damaged."""
    try:
        content = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def _keys(manifest: dict[str, Any]) -> dict[str, str]:
    keys = manifest.get("wells")
    return keys if isinstance(keys, dict) else {}


def _unfinished(stage: Path, well: str, key: str, failed_on: Callable[[str], str]) -> str:
    """Why a well is to be done again; empty if it is not."""
    content = stored(stage / well)
    if not key or content.get("key") != key:
        return f"{well} not finished"
    if AGAIN in content:
        return f"{well} lacks what could not be read"
    if "failed_on" in content and content["failed_on"] != failed_on(well):
        return f"{well} failed, and its inputs have changed"
    return ""


def _names(content: dict[str, Any]) -> list[str]:
    """Files and stores that a key lists."""
    names = content.get("files", [])
    return [name for name in names if isinstance(name, str)] if isinstance(names, list) else []


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file under another name first, so that a partial file is never seen."""
    temporary = path.with_suffix(".part")
    if isinstance(content, str):
        temporary.write_text(content)
    else:
        temporary.write_bytes(content)
    os.replace(temporary, path)

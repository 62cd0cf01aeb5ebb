"""What a job leaves for the workflow to see: a manifest of its batch, `<results>/<stage>/<batch>.json`.

It names the batch's wells with the keys in their folders, which lie beside it. Snakemake knows the manifest only; the
folders are kept or done again well by well, by their keys.
"""

import json
import os
from collections.abc import Iterable
from pathlib import Path

KEY = "key.json"
"""File of a well's folder that says what its datasets were made from; without it they count as never made."""


def stored_key(folder: Path) -> str:
    """The key of one stage of one well; empty where it was never finished."""
    try:
        return str(json.loads((folder / KEY).read_text())["key"])
    except FileNotFoundError:
        return ""


def write_manifest(path: str | Path, wells: Iterable[str]) -> None:
    """Write the wells' keys once all of them went through the stage.

    Parameters
    ----------
    path : the manifest, beside the folders of the wells
    wells : wells of the batch
    """
    path = Path(path)
    write_whole(path, json.dumps({well: stored_key(path.parent / well) for well in wells}, indent=1) + "\n")


def holds(path: Path) -> bool:
    """Whether every folder is there with the key that the manifest names."""
    try:
        keys = json.loads(path.read_text())
    except ValueError:
        return False
    folders = {path.parent / well: key for well, key in keys.items()}
    return all(folder.is_dir() and stored_key(folder) == key for folder, key in folders.items())


def write_whole(path: Path, text: str) -> None:
    """Write a file under another name first, so that it is never there in part."""
    temporary = path.with_suffix(".part")
    temporary.write_text(text)
    os.replace(temporary, path)

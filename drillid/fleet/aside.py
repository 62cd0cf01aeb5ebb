"""Earlier results of a stage for a well, set aside while the stage is redone, so that unchanged rows are kept.

A folder is moved as a whole, with its key: a folder set aside that has a key is complete, even after a killed run.
"""

import os
import shutil

from drillid.datasets.store import WellFolders
from drillid.fleet.manifest import KEY, stored

_KEPT_FILES = {".snakemake_timestamp"}


def set_aside(folders: WellFolders, stage: str) -> None:
    """Empty the well's folder of the stage; finished results are set aside until `forget_aside`.

    They are of use only if made on the same basis as the work to come: on another, every row is made anew.
    """
    folder, aside = folders.stage(stage), folders.aside(stage)
    finished = stored(folder).get("status") == "done" and stored(folder).get("basis") == folders.basis
    if finished or stored(aside).get("basis") != folders.basis:
        forget_aside(folders, stage)
    if finished:
        aside.parent.mkdir(parents=True, exist_ok=True)
        os.replace(folder, aside)
        folder.mkdir()
        for name in _KEPT_FILES:
            if (aside / name).exists():
                os.replace(aside / name, folder / name)
    clear(folders, stage)


def clear(folders: WellFolders, stage: str) -> None:
    """Empty the folder, its key first, so that a half-deleted folder never looks complete."""
    folder = folders.stage(stage)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / KEY).unlink(missing_ok=True)
    for path in folder.iterdir():
        if path.is_dir():
            shutil.rmtree(path)
        elif path.name not in _KEPT_FILES:
            path.unlink()


def forget_aside(folders: WellFolders, stage: str) -> None:
    """Delete what was set aside, its key first."""
    aside = folders.aside(stage)
    (aside / KEY).unlink(missing_ok=True)
    if aside.exists():
        shutil.rmtree(aside)

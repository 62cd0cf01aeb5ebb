"""Where the workflow's files are: in the current folder, or else with the library, in its checkout or package."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path

from drillid.errors import SettingsError

SNAKEFILE = "Snakefile"
PROFILE = Path("workflow/profiles/default")
_PLUGINS = Path("workflow/plugins")
_LIBRARY = Path(__file__).resolve().parents[1]
_PLACES = (Path(), _LIBRARY / "checkout", _LIBRARY.parent)
_DEMO = Path("config/demo")
_TO_FILL_IN = ("config/config.yaml", "config/wells.tsv", "config/logs.tsv", "config/README.md")


def workflow_folder() -> Path:
    """Folder with the Snakefile: the current one if it has a Snakefile, else that of the library.

    Raises
    ------
    SettingsError
        If neither has a workflow.
    """
    return _first_with_workflow(_PLACES)


def workflow_of_library() -> Path:
    """Folder with the Snakefile and scripts that belong to the library, whatever the current folder holds.

    Raises
    ------
    SettingsError
        If there is none.
    """
    return _first_with_workflow(_PLACES[1:])


def _first_with_workflow(places: Iterable[Path]) -> Path:
    for folder in places:
        if (folder / SNAKEFILE).is_file():
            return folder
    remedy = "Start drillid in the folder with the Snakefile, or install the package with pip"
    raise SettingsError(str(Path.cwd()), "holds no workflow", remedy)


def snakemake_words(profile: Path) -> list[str]:
    """Arguments of Snakemake's command for Snakefile and profile.

    Raises
    ------
    SettingsError
        If there is no workflow, or no such profile.
    """
    folder = workflow_folder()
    found = next((each for each in (profile, folder / profile) if each.is_dir()), None)
    if found is None:
        raise SettingsError(str(profile), "is not a folder with a profile", f"Use {PROFILE}, or correct the path")
    place = [] if folder == Path() else ["--snakefile", str(folder / SNAKEFILE)]
    return [*place, "--workflow-profile", str(found)]


def plugin_folders() -> list[Path]:
    """Folders with plugins for Snakemake, which finds them by name if they are on Python's path.

    Raises
    ------
    SettingsError
        If there is no workflow.
    """
    # the plugin that modifies Snakemake's own for Kubernetes cannot be imported without it
    found = {"progress": True, "kubernetes": find_spec("snakemake_executor_plugin_kubernetes") is not None}
    return [(workflow_folder() / _PLUGINS / name).resolve() for name, usable in found.items() if usable]


def write_example(folder: Path) -> list[Path]:
    """Write a configuration with empty sheets to fill in; existing files are kept.

    Raises
    ------
    SettingsError
        If there is no workflow to copy them from.
    """
    written = _copied(_TO_FILL_IN, folder)
    (folder / "config/rigs").mkdir(parents=True, exist_ok=True)
    return written


def write_demo(folder: Path = Path()) -> Path:
    """Write the demo's configuration unless it exists, and return its path.

    Raises
    ------
    SettingsError
        If there is no workflow to copy it from.
    """
    root = workflow_folder()
    files = [path.relative_to(root).as_posix() for path in sorted((root / _DEMO).rglob("*")) if path.is_file()]
    _copied(files, folder)
    return folder / _DEMO / "config.yaml"


def _copied(names: Iterable[str], folder: Path) -> list[Path]:
    """Copy files of the workflow's folder to the same places in another; existing files are kept."""
    source, written = workflow_folder(), []
    for name in names:
        path = folder / name
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source / name, path)
            written.append(path)
    return written

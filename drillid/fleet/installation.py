"""Where the workflow's files are: in the current folder, a checkout, or else in the installed package."""

from __future__ import annotations

import shutil
from pathlib import Path

from drillid.errors import SettingsError

SNAKEFILE = "Snakefile"
PROFILE = Path("workflow/profiles/default")
_INSTALLED = Path(__file__).resolve().parents[1] / "checkout"
_TO_FILL_IN = ("config/config.yaml", "config/wells.tsv", "config/logs.tsv", "config/README.md")


def workflow_folder() -> Path:
    """Folder with the Snakefile: the current one where it holds one, else that of the installed package.

    Raises
    ------
    SettingsError
        If neither holds a workflow.
    """
    for folder in (Path(), _INSTALLED):
        if (folder / SNAKEFILE).is_file():
            return folder
    remedy = "Start drillid in the folder with the Snakefile, or install the package by pip"
    raise SettingsError(str(Path.cwd()), "holds no workflow", remedy)


def snakemake_words(profile: Path) -> list[str]:
    """Snakefile and profile as Snakemake's command takes them.

    Raises
    ------
    SettingsError
        If there is no workflow, or no such profile.
    """
    folder = workflow_folder()
    found = next((each for each in (profile, folder / profile) if each.is_dir()), None)
    if found is None:
        raise SettingsError(str(profile), "is no folder with a profile", f"Take {PROFILE}, or correct the path")
    place = [] if folder == Path() else ["--snakefile", str(folder / SNAKEFILE)]
    return [*place, "--workflow-profile", str(found)]


def write_example(folder: Path) -> list[Path]:
    """Write a configuration with empty sheets to fill in; files that are there already are kept.

    Raises
    ------
    SettingsError
        If there is no workflow to take them from.
    """
    source, written = workflow_folder(), []
    for name in _TO_FILL_IN:
        path = folder / name
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source / name, path)
            written.append(path)
    (folder / "config/rigs").mkdir(parents=True, exist_ok=True)
    return written

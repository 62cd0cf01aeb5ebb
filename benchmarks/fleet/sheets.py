"""Folders with configuration, sheets and rig descriptions of a fleet, from which the workflow of this checkout runs."""

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parents[2]


def write_fleet(folder: Path, logs: Mapping[str, Sequence[str]], rigs: Mapping[str, Path], **settings: Any) -> None:
    """Write a configuration with its sheets and rig descriptions.

    Parameters
    ----------
    folder : of the configuration; the workflow is started in it
    logs : log files of every well, absolute or below the folder
    rigs : rig description of every well, which is copied under the name of the file
    settings : sections and keys of the configuration that differ from the defaults
    """
    (folder / "config/rigs").mkdir(parents=True, exist_ok=True)
    for rig in set(rigs.values()):
        shutil.copy(rig, folder / "config/rigs")
    shutil.copy(ROOT / "config/config.yaml", folder / "config")
    write_table(folder / "config/wells.tsv", ["well\trig", *(f"{well}\t{rigs[well].stem}" for well in logs)])
    rows = [f"{well}\t{log}" for well, paths in logs.items() for log in paths]
    write_table(folder / "config/logs.tsv", ["well\tlog", *rows])
    (folder / "fleet.yaml").write_text(yaml.safe_dump(settings))


def write_table(path: Path, rows: Sequence[str]) -> None:
    """A sheet of these rows."""
    path.write_text("\n".join(rows) + "\n")


def workflow(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run the workflow of this checkout on the fleet in a folder, by its default profile.

    Raises
    ------
    RuntimeError
        If it fails; the message holds the end of its output.
    """
    command = [sys.executable, "-m", "snakemake", *words, "--snakefile", str(ROOT / "Snakefile"), "--nolock"]
    command += ["--workflow-profile", str(ROOT / "workflow/profiles/default"), "--configfile", "fleet.yaml"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError("\n".join([*done.stdout.splitlines()[-20:], *done.stderr.splitlines()[-20:]]))
    return done

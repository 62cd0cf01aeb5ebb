"""Folders with configuration, sheets and rig descriptions of a fleet, and runs of this checkout's workflow in them."""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Run:
    """One run of the workflow with all of its jobs.

    output : of both streams
    seconds, clock : s, of one core and of the clock
    mebibytes : largest resident memory of a process
    """

    output: str
    seconds: float
    clock: float
    mebibytes: float


def write_fleet(folder: Path, logs: Mapping[str, Sequence[str]], rigs: Mapping[str, Path], **settings: Any) -> None:
    """Write a configuration, fleet.yaml, with its sheets and rig descriptions.

    Parameters
    ----------
    folder : of the configuration; the workflow is started in it
    logs : log files of every well, absolute or below the folder
    rigs : rig description of every well, which is copied under the name of the file
    settings : sections and keys of the configuration that differ from the defaults
    """
    (folder / "config/rigs").mkdir(parents=True, exist_ok=True)
    for rig in set(rigs.values()):
        shutil.copy2(rig, folder / "config/rigs")
    shutil.copy2(ROOT / "config/config.yaml", folder / "config")
    wells = ["well\trig", *(f"{well}\t{rigs[well].stem}" for well in logs)]
    rows = ["well\tlog", *(f"{well}\t{log}" for well, paths in logs.items() for log in paths)]
    for name, lines in (("wells", wells), ("logs", rows)):
        (folder / f"config/{name}.tsv").write_text("\n".join(lines) + "\n")
    (folder / "fleet.yaml").write_text(yaml.safe_dump(settings))


def workflow(folder: Path, *words: str) -> Run:
    """Run the workflow of this checkout on the fleet in a folder, by its default profile.

    Raises
    ------
    RuntimeError
        If it fails; the message holds the end of its output.
    """
    command = [sys.executable, "-m", "snakemake", *words, "--snakefile", str(ROOT / "Snakefile"), "--nolock"]
    command += ["--workflow-profile", str(ROOT / "workflow/profiles/default"), "--configfile", "fleet.yaml"]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    with tempfile.TemporaryFile("w+") as output:
        begin = time.perf_counter()
        process = subprocess.Popen(command, cwd=folder, env=environment, stdout=output, stderr=output)
        _, status, usage = os.wait4(process.pid, 0)
        clock, process.returncode = time.perf_counter() - begin, os.waitstatus_to_exitcode(status)
        output.seek(0)
        text = output.read()
    if process.returncode:
        raise RuntimeError("\n".join(text.splitlines()[-30:]))
    return Run(text, usage.ru_utime + usage.ru_stime, clock, usage.ru_maxrss / 1024)

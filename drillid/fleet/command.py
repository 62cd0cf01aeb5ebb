"""`drillid run`: Snakemake with what a nightly run needs besides.

A killed run needs no unlocking, a signal ends all processes, and failed wells are named in a closing line and show in
the exit code.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

from drillid.config.files import read_yaml
from drillid.fleet.installation import plugin_folders, snakemake_words
from drillid.fleet.lock import RUN, identity
from drillid.fleet.provenance import PACKAGE

OUTCOME = "DRILLID_OUTCOME"
"""Environment variable with the path of the file to which the workflow writes what became of its wells."""
FAILED_WELLS = 3
"""Exit code if the workflow completed but wells failed."""
_GRACE_S = 10.0
"""Time that all processes have to end by themselves before they are killed, s."""


@dataclass(frozen=True)
class RunOutcome:
    """How a run ended.

    code : exit code of the workflow, or FAILED_WELLS
    wells : number of `wells`, reason of each `failed` one, those `unfinished`, `missing_logs`, all as a `line`, and the
        path of the `report` if there is one; empty if the run did not get that far
    """

    code: int
    wells: dict[str, Any]


def run(arguments: Sequence[str], profile: Path, configuration: Path | None, jobs: str, strict: bool) -> RunOutcome:
    """Run the workflow of the current folder.

    Parameters
    ----------
    arguments : targets and options for Snakemake
    profile : workflow profile
    configuration : configuration file; config/config.yaml if None
    jobs : cores of this machine, or jobs on a cluster; the profile's if empty
    strict : whether failed wells make the exit code FAILED_WELLS

    Raises
    ------
    SettingsError
        If there is no workflow, or the configuration cannot be read.
    """
    read_yaml(configuration or "config/config.yaml")
    # targets come first: --configfile takes all arguments that follow it
    command = [sys.executable, "-m", "snakemake", *arguments, "--nolock", *snakemake_words(profile)]
    command += [] if "--logger" in arguments else ["--logger", "drillid"]
    command += ["--jobs", jobs] if jobs else []
    command += ["--configfile", str(configuration)] if configuration else []
    with tempfile.TemporaryDirectory(prefix="drillid-") as folder:
        outcome = Path(folder, "outcome.json")
        code = _supervised(command, os.environ | {RUN: identity(), OUTCOME: str(outcome), "PYTHONPATH": _path()})
        wells = json.loads(outcome.read_text()) if outcome.is_file() else {}
    if wells:
        print(wells["line"], *([f"The report is {wells['report']}"] if "report" in wells else []), file=sys.stderr)
    return RunOutcome(FAILED_WELLS if code == 0 and strict and wells.get("failed") else code, wells)


def _path() -> str:
    """Python's path, on which Snakemake finds its plugins, and the plugins find the library."""
    places = [*map(str, plugin_folders()), os.environ.get("PYTHONPATH"), str(PACKAGE.parent)]
    return os.pathsep.join(filter(None, places))


def _supervised(command: Sequence[str], environment: dict[str, str]) -> int:
    """Run a command in a process group of its own, ended as a whole when this process is told to end; its exit code."""
    stopped: list[int] = []
    with subprocess.Popen(command, env=environment, start_new_session=True) as child:

        def stop(number: int, _: FrameType | None) -> None:
            stopped.append(number)
            _signal_group(child.pid, signal.SIGTERM)
            signal.setitimer(signal.ITIMER_REAL, _GRACE_S)

        def kill(_: int, __: FrameType | None) -> None:
            _signal_group(child.pid, signal.SIGKILL)

        # what nohup or a shell has had ignored stays so
        ends = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
        heeded = [number for number in ends if signal.getsignal(number) is not signal.SIG_IGN]
        before = {number: signal.signal(number, stop) for number in heeded}
        before[signal.SIGALRM] = signal.signal(signal.SIGALRM, kill)
        try:
            code = child.wait()
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            for number, handler in before.items():
                signal.signal(number, handler)
        # however the command ended, nothing that it started may go on writing
        _signal_group(child.pid, signal.SIGKILL)
    return 128 + stopped[0] if stopped else code


def _signal_group(group: int, number: signal.Signals) -> None:
    try:
        os.killpg(group, number)
    except ProcessLookupError:
        return

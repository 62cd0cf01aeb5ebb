"""One run at a time on a folder of results, and no process of a run that outlives it.

A lock is an open file under `flock`: the kernel releases it when the last process that holds it ends, however it
ends, so a killed run leaves nothing to unlock.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TextIO

from drillid.errors import SettingsError

RUN = "DRILLID_RUN"
"""Environment variable that names the process on which a whole run depends: host, process ID and start time."""
_LOOK_EVERY_S = 0.5
_PATIENCE_S = 5.0
"""Time to wait for the processes of a run that has just been killed; they notice within _LOOK_EVERY_S."""
_held: list[TextIO] = []


def hold_results(results: Path) -> None:
    """Keep every other run away from the results until this process ends.

    Raises
    ------
    SettingsError
        If another run works on them; the message names its process.
    """
    results.mkdir(parents=True, exist_ok=True)
    _held.append(_taken(results))


@contextlib.contextmanager
def results_held(results: Path) -> Iterator[None]:
    """Keep every other run away from existing results for a moment; errors as of `hold_results`."""
    with _taken(results):
        yield


def _taken(results: Path) -> TextIO:
    """The lock of the results, which is released as it is closed."""
    file = (results / ".lock").open("a+")
    until = time.monotonic() + _PATIENCE_S
    while not _locked(file):
        if time.monotonic() > until:
            file.seek(0)
            holder = file.read().strip() or "an unknown process"
            raise SettingsError(
                str(results), f"another run works on these results ({holder})", "Wait until it ends, or stop it"
            )
        time.sleep(_LOOK_EVERY_S)
    file.truncate(0)
    file.write(f"process {os.getpid()} on {socket.gethostname()} since {time.strftime('%Y-%m-%d %H:%M:%S')}\n")
    file.flush()
    return file


def _locked(file: TextIO) -> bool:
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


@contextlib.contextmanager
def held(path: Path) -> Iterator[None]:
    """Wait for a lock and hold it; forked children hold it too, so no child of a killed job can still be writing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def name_run() -> None:
    """Name this process as the one on which the run depends; if one is named already, end when that one does."""
    if RUN in os.environ:
        end_with_run(_kill_group)
    else:
        os.environ[RUN] = identity()


def identity(process: int | None = None) -> str:
    """Host, process ID and start of a process, this one by default; unique to that process."""
    number = os.getpid() if process is None else process
    return f"{socket.gethostname()} {number} {_start(number)}"


def _start(process: int) -> str:
    """When a process started: on Linux in ticks since the machine did, as its clock may be set meanwhile."""
    import psutil

    try:
        # after the command in parentheses, which may hold anything, the third field is next; the start is the 22nd
        return Path(f"/proc/{process}/stat").read_text(errors="replace").rpartition(")")[2].split()[22 - 3]
    except (OSError, IndexError):
        return f"{psutil.Process(process).create_time():.2f}"


def end_with_run(end: Callable[[], None] | None = None) -> None:
    """End this process soon after the one on which its run depends; does nothing on other machines."""
    named = os.environ.get(RUN, "")
    host, _, rest = named.partition(" ")
    if host != socket.gethostname() or named == identity():
        return
    process = int(rest.split()[0])

    def watch() -> None:
        while _lives(process, named):
            time.sleep(_LOOK_EVERY_S)
        (end or _exit)()

    threading.Thread(target=watch, daemon=True).start()


def _lives(process: int, named: str) -> bool:
    import psutil

    try:
        return identity(process) == named
    except psutil.NoSuchProcess:
        return False


def _exit() -> None:
    os._exit(1)


def _kill_group() -> None:
    """End this process, with all that it started if it leads a process group of its own."""
    if os.getpgrp() == os.getpid():
        os.killpg(os.getpid(), signal.SIGKILL)
    os._exit(1)

"""A series of mutated files in a process of its own, with limits of time and memory for each file."""

import gc
import json
import os
import resource
import select
import signal
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.fuzz.trial import mutated, place, taken_through

LONGEST_S = 2.0
"""Time of the processor that a file may take, s; the process that reads for others has a limit of its own."""
LARGEST_MB = 500
"""Memory that a file may take beyond what the process holds, MB; the same holds for it."""
_STUCK_S = 300.0
"""Time after which the process is killed, s; on a busy machine it may stand still for a while."""
_HEADROOM_MB = 4000
"""Address space beyond what the process holds."""


@dataclass(frozen=True)
class Outcome:
    """What became of one file.

    fault : '' where all is well, else an exception that is not drillid's, 'slow', 'memory' or 'killed'
    """

    number: int
    suffix: str
    mutations: tuple[str, ...]
    ended: str
    fault: str
    seconds: float
    megabytes: float


def series(first: int, stop: int, seed: int, keep: Path | None = None) -> Iterator[Outcome]:
    """Outcomes of files `first` to `stop`; a file that its process dies of is an outcome too, and the others go on.

    Parameters
    ----------
    keep : folder for files that fail
    """
    number = first
    while number < stop:
        for outcome in _in_child(number, stop, seed):
            if outcome.fault and keep is not None:
                _keep(keep, outcome, seed)
            number = outcome.number + 1
            yield outcome


def _keep(folder: Path, outcome: Outcome, seed: int) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    mutated(outcome.number, seed).write(folder / f"{outcome.number}{outcome.suffix}")


def _in_child(first: int, stop: int, seed: int) -> Iterator[Outcome]:
    """Outcomes from a forked process, until it is done or dies."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(read)
        code = 1
        try:
            # what is imported already need not be looked at by each collection of garbage
            gc.freeze()
            with os.fdopen(write, "w", buffering=1) as lines:
                for number in range(first, stop):
                    lines.write(json.dumps(asdict(attempt(number, seed))) + "\n")
            code = 0
        finally:
            os._exit(code)
    os.close(write)
    number, fault = first, "killed"
    with os.fdopen(read, "rb", buffering=0) as lines:
        while number < stop:
            if not select.select([lines], [], [], _STUCK_S)[0]:
                os.kill(child, signal.SIGKILL)
                fault = f"no answer within {_STUCK_S:.0f} s"
                break
            line = _line(lines)
            if not line:
                break
            content = json.loads(line)
            yield Outcome(**content | {"mutations": tuple(content["mutations"])})
            number += 1
    os.waitpid(child, 0)
    if number < stop:
        file = mutated(number, seed)
        yield Outcome(number, file.suffix, file.mutations, "", fault, _STUCK_S, 0.0)


def _line(lines: object) -> bytes:
    """One line of a pipe, byte by byte, as a buffer would hide lines from select."""
    line = b""
    while not line.endswith(b"\n"):
        byte = lines.read(1)  # type: ignore[attr-defined]
        if not byte:
            return b""
        line += byte
    return line


def attempt(number: int, seed: int) -> Outcome:
    """Make one file and take it through the library, in this process."""
    file = mutated(number, seed)
    with TemporaryDirectory(prefix="fuzz-") as folder:
        path = Path(folder) / f"log{file.suffix}"
        file.write(path)
        held = _reset_peak()
        _limit_memory()
        ended, fault, begin = "", "", time.process_time()
        try:
            ended = taken_through(path)
        except Exception as error:  # this is what the search is for
            fault = place(error)
        seconds, megabytes = time.process_time() - begin, _peak() - held
    if not fault and seconds > LONGEST_S:
        fault = "slow"
    if not fault and megabytes > LARGEST_MB:
        fault = "memory"
    return Outcome(number, file.suffix, file.mutations, ended, fault, round(seconds, 3), round(megabytes, 1))


def _status(key: str) -> float:
    """A line of the process's status, MB."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(key):
            return int(line.split()[1]) / 1024
    return 0.0


def _reset_peak() -> float:
    """Forget the largest memory so far; what is held now, MB."""
    Path("/proc/self/clear_refs").write_text("5")
    return _status("VmRSS")


def _peak() -> float:
    return _status("VmHWM")


def _limit_memory() -> None:
    """An allocation that would endanger the machine fails."""
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (int((_status("VmSize") + _HEADROOM_MB) * 2**20), hard))

"""Readers that call C libraries, in a process of their own: damaged bytes may crash or hang it, and only a log fails.

One such process serves all logs of its parent and is replaced when it dies. It ends with its standard input, which the
kernel closes with the parent, however that ends.
"""

from __future__ import annotations

import contextlib
import importlib
import math
import os
import pickle
import resource
import select
import signal
import subprocess
import sys
import threading
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing.util import Finalize
from pathlib import Path
from typing import IO, Any, cast

from drillid.errors import is_of_machine
from drillid.formats.description import Dialect, Header, LogFormat, Unusable

_CPU_S, _CPU_S_PER_MB = 5.0, 2.0
"""Processor time that reading may take; logs are read at more than 10 MB/s."""
_PATIENCE = 20.0
"""A silence this many times as long counts as a hang, however busy the machine is."""
_SPACE_MB, _SPACE_MB_PER_MB = 2000.0, 60.0
"""Address space beyond that of an idle process; compressed logs take 37 times their size."""
_MB = 2**20
_PACKAGE = Path(__file__).parent


@dataclass(frozen=True)
class _Limits:
    """What reading one file may take: processor time and address space."""

    seconds: float
    megabytes: float

    @classmethod
    def of(cls, path: Path) -> _Limits:
        size = path.stat().st_size / _MB
        return cls(_CPU_S + _CPU_S_PER_MB * size, _SPACE_MB + _SPACE_MB_PER_MB * size)


@dataclass(frozen=True)
class Apart:
    """Reader interface whose work is done in the other process."""

    module: str
    SUFFIXES: tuple[str, ...]

    def headers(self, path: Path, dialect: Dialect) -> list[Header]:
        """Header of each table of the file.

        Raises
        ------
        ValueError
            If the file cannot be read, crashes the library, or takes too much time or memory.
        MemoryError
            If the process was killed from outside, as it is where memory is short.
        """
        found: list[Header] = _PROCESS.call(self.module, "headers", path, dialect)
        return found

    def read_columns(
        self, path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
    ) -> Any:
        """Columns as an Arrow table; the errors are those of `headers`."""
        return _PROCESS.call(self.module, "read_columns", path, header, list(columns), list(text), rows)


def apart(reader: Any) -> LogFormat:
    """The reader itself or, where it is declared FRAGILE, one that works in the other process."""
    if getattr(reader, "FRAGILE", False):
        return cast(LogFormat, Apart(reader.__name__, reader.SUFFIXES))
    return cast(LogFormat, reader)


class _Process:
    """The other process, started when it is first needed."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.started: tuple[int, subprocess.Popen[bytes]] | None = None

    def call(self, module: str, function: str, path: Path, *arguments: Any) -> Any:
        """The result of a function of a reader; its errors are raised here."""
        limits = _Limits.of(path)
        with self.lock:
            process = self._running()
            try:
                pickle.dump((module, function, (path.absolute(), *arguments), limits), process.stdin)
                process.stdin.flush()
                patient = select.select([process.stdout], [], [], _PATIENCE * limits.seconds)[0]
                kind, content = pickle.load(process.stdout) if patient else ("hung", None)
            except (OSError, EOFError, pickle.UnpicklingError):
                kind, content = "died", None
            if kind in ("hung", "died"):
                code = self._ended()
                raise _hang(limits) if kind == "hung" else _death(code, path, limits)
        if isinstance(content, Exception):
            raise content
        return content

    def close(self) -> None:
        """End the process, if one was started."""
        if self.started is not None and self.started[0] == os.getpid():
            with contextlib.suppress(BrokenPipeError), self.started[1] as process:
                process.kill()

    def _running(self) -> Any:
        if self.started is not None:
            parent, process = self.started
            # a forked child needs one of its own
            if parent == os.getpid() and process.poll() is None:
                return process
        paths = [str(_PACKAGE.parents[1]), os.environ.get("PYTHONPATH", "")]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
        command = [sys.executable, "-c", f"from {__name__} import serve; serve()"]
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment)
        self.started = os.getpid(), process
        return process

    def _ended(self) -> int:
        """Exit code of the process, which is given a moment to end and is then killed."""
        assert self.started is not None
        _, process = self.started
        self.started = None
        try:
            process.wait(timeout=1)
        except subprocess.TimeoutExpired:
            process.kill()
        with contextlib.suppress(BrokenPipeError), process:
            process.wait()
        return int(process.returncode)


_PROCESS = _Process()
# atexit does not run in forked children
Finalize(None, _PROCESS.close, exitpriority=1)


def _hang(limits: _Limits) -> Exception:
    return ValueError(f"reading it did not end within {_PATIENCE * limits.seconds:.0f} s")


def _death(code: int, path: Path, limits: _Limits) -> Exception:
    """What the end of the process says about the file, the machine or the program."""
    if code == -signal.SIGKILL:
        return MemoryError(f"the process that read {path} was killed, probably out of memory")
    if code == -signal.SIGXCPU:
        return ValueError(f"reading it takes more than {limits.seconds:.0f} s of processor time")
    if code < 0:
        return ValueError(f"the library that reads it crashed by {signal.Signals(-code).name}")
    return RuntimeError(f"the process that read {path} ended with code {code}")


def serve() -> None:
    """Answer requests on standard input until there are no more."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with os.fdopen(os.dup(0), "rb") as requests, os.fdopen(os.dup(1), "wb") as answers:
        # output of C libraries must not come between the answers
        os.dup2(2, 1)
        while (request := _next(requests)) is not None:
            module, function, arguments, limits = request
            _limit(limits)
            try:
                answer = "result", getattr(importlib.import_module(module), function)(*arguments)
            except Exception as error:
                answer = "error", _told(error, limits)
            pickle.dump(answer, answers, protocol=pickle.HIGHEST_PROTOCOL)
            answers.flush()


def _next(requests: IO[bytes]) -> Any:
    try:
        return pickle.load(requests)
    except EOFError:
        return None


def _limit(limits: _Limits) -> None:
    used = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    held = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    for kind, most in (
        (resource.RLIMIT_CPU, math.ceil(used + limits.seconds)),
        (resource.RLIMIT_AS, held + int(limits.megabytes * _MB)),
    ):
        hard = resource.getrlimit(kind)[1]
        resource.setrlimit(kind, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def _told(error: Exception, limits: _Limits) -> Exception:
    """The error as it is passed to the parent process: one from a library means damage, any other a fault of ours."""
    if isinstance(error, MemoryError):
        return ValueError(f"reading it takes more than {limits.megabytes:.0f} MB of memory")
    if isinstance(error, Unusable):
        return Unusable(error.what, error.remedy)
    if isinstance(error, FileNotFoundError | IsADirectoryError | PermissionError):
        return type(error)(*error.args)
    if isinstance(error, OSError) and error.errno is not None and is_of_machine(error):
        return OSError(error.errno, error.strerror)
    inside = Path(traceback.extract_tb(error.__traceback__)[-1].filename).is_relative_to(_PACKAGE)
    if inside and not isinstance(error, OSError | ValueError | EOFError):
        return RuntimeError("".join(traceback.format_exception(error)))
    return ValueError(str(error) or type(error).__name__)

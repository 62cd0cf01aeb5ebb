"""Snakemake and `drillid run` in children of one process that has imported what they take: imports are most of the time
of a start.
"""

import contextlib
import functools
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import IO, NoReturn

IMPORTED = (
    *("snakemake.cli", "snakemake.scheduling.job_scheduler", "snakemake.persistence.file", "snakemake.report"),
    *("nbformat", "boto3", "pandas", "xarray", "pydantic", "psutil", "grimp", "typer", "rich.console"),
    *("multiprocessing.popen_fork", "multiprocessing.synchronize", "rich._emoji_codes"),
    *("zarr.storage", "zarr.codecs", "matplotlib.backends.backend_agg"),
)
"""Nothing of the library, of which each checkout has its own, and nothing that starts threads."""


def snakemake(folder: Path, arguments: Sequence[str], environment: Mapping[str, str]) -> tuple[int, str]:
    """Exit code of `python -m snakemake` in a folder, and its output on both streams."""
    with tempfile.TemporaryFile("w+") as output:
        return _code("snakemake", folder, arguments, environment, [output, output]), _text(output)


def drillid_run(
    folder: Path, arguments: Sequence[str], environment: Mapping[str, str]
) -> subprocess.CompletedProcess[str]:
    """`python -m drillid run` of the folder's library, whose Snakemake is a forked child as well."""
    with tempfile.TemporaryFile("w+") as output, tempfile.TemporaryFile("w+") as errors:
        code = _code("drillid run", folder, arguments, environment, [output, errors])
        return subprocess.CompletedProcess(arguments, code, _text(output), _text(errors))


def _code(
    command: str, folder: Path, arguments: Sequence[str], environment: Mapping[str, str], streams: Sequence[IO[str]]
) -> int:
    """Exit code of a command, one of COMMANDS, in a child of the server."""
    server = _server()
    assert server.stdin is not None
    assert server.stdout is not None
    with tempfile.NamedTemporaryFile("w") as order:
        places = [f"/proc/{os.getpid()}/fd/{stream.fileno()}" for stream in streams]
        json.dump([command, str(folder), list(arguments), dict(environment), places], order)
        order.flush()
        server.stdin.write(f"{order.name}\n")
        server.stdin.flush()
        return int(server.stdout.readline())


def _text(stream: IO[str]) -> str:
    stream.seek(0)
    return stream.read()


@functools.cache
def _server() -> subprocess.Popen[str]:
    """Ends with this process, which closes its input."""
    return subprocess.Popen([sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def _serve() -> None:
    for module in IMPORTED:
        __import__(module)
    _leave_out_descriptions()
    for line in sys.stdin:
        child = os.fork()
        if not child:
            _run(*json.loads(Path(line.strip()).read_text()))
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)


def _leave_out_descriptions() -> None:
    """Of the settings' fields: pydantic seeks them among all that is imported, for a quarter of a start, and no run
    needs them.
    """
    from pydantic._internal import _fields

    _fields._update_fields_from_docstrings = lambda *_, **__: None


def _run(command: str, folder: str, arguments: list[str], environment: dict[str, str], places: list[str]) -> None:
    """As a process of its own would be: folder, environment, path and streams."""
    streams = [os.open(os.devnull, os.O_RDONLY), *(os.open(place, os.O_WRONLY | os.O_APPEND) for place in places)]
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
    os.chdir(folder)
    _take(environment)
    sys.path[0] = folder
    _end(lambda: COMMANDS[command](arguments))


def _take(environment: Mapping[str, str]) -> None:
    """Environment and path of a process that starts in it."""
    os.environ.clear()
    os.environ.update(environment)
    sys.path[1:1] = filter(None, environment.get("PYTHONPATH", "").split(os.pathsep))


def _end(work: Callable[[], object]) -> NoReturn:
    code = 1
    try:
        work()
        code = 0
    except SystemExit as error:
        code = error.code if isinstance(error.code, int) else int(bool(error.code))
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _snakemake(arguments: list[str]) -> None:
    from drillid.fleet import fork_server

    fork_server._started = _fork_server
    _hand_over_in_place()
    sys.modules["snakemake.cli"].main(arguments)


def _hand_over_in_place() -> None:
    """Let scripts run in a thread of Snakemake instead of a process of their own, which imports Snakemake again only to
    hand its job over to the fork server; where there is none, they run as ever.
    """
    from snakemake import script

    from drillid.fleet.job import SERVER

    execute = script.PythonScript.execute_script

    def execute_script(self: script.PythonScript, name: str, edit: bool = False) -> None:
        if SERVER not in os.environ:
            execute(self, name, edit=edit)
            return
        try:
            exec(compile(Path(name).read_text(), name, "exec"), {"__name__": "__main__", "__file__": name})
        except SystemExit as error:
            raise subprocess.CalledProcessError(int(error.code or 1), name) from None

    script.PythonScript.execute_script = execute_script
    # each script adds this process's path to the path, which here is the same
    script.get_snakemake_searchpaths = list


@contextlib.contextmanager
def _fork_server(place: str, modules: Sequence[str]) -> Iterator[SimpleNamespace]:
    """As `drillid.fleet.fork_server` starts it, but for what Snakemake has loaded already."""
    from drillid.fleet import fork_server

    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(place)
        listening.listen()
        theirs, ours = os.pipe()
        child = os.fork()
        if not child:
            os.close(ours)
            os.dup2(theirs, 0)
            sys.stdin = os.fdopen(0)
            _end(lambda: fork_server.main(listening.fileno(), modules))
    os.close(theirs)
    stream = os.fdopen(ours, "wb")
    yield SimpleNamespace(stdin=stream, wait=lambda: os.waitpid(child, 0))


def _drillid_run(arguments: list[str]) -> None:
    from drillid.commands import app
    from drillid.fleet import command

    command._supervised = _supervised
    app(["run", *arguments], prog_name="drillid")


def _supervised(command: Sequence[str], environment: Mapping[str, str]) -> int:
    """As that of `drillid.fleet.command`, which no signal reaches here."""
    child = os.fork()
    if not child:
        os.setsid()
        _take(environment)
        _end(lambda: _snakemake(list(command[3:])))
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    return code


COMMANDS = {"snakemake": _snakemake, "drillid run": _drillid_run}

if __name__ == "__main__":
    _serve()

"""Snakemake in children of one process that has imported what it takes: imports are most of the time of a start."""

import functools
import json
import os
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Sequence
from pathlib import Path

IMPORTED = (
    *("snakemake.cli", "snakemake.scheduling.job_scheduler", "snakemake.persistence.file", "snakemake.report"),
    *("nbformat", "boto3", "pandas", "xarray", "pydantic", "psutil", "grimp"),
)
"""Nothing of the library, of which each checkout has its own, and nothing that starts threads."""


def snakemake(folder: Path, arguments: Sequence[str], environment: dict[str, str]) -> tuple[int, str]:
    """Exit code of `python -m snakemake` in a folder, and its output on both streams."""
    server = _server()
    assert server.stdin is not None
    assert server.stdout is not None
    with tempfile.TemporaryFile("w+") as output, tempfile.NamedTemporaryFile("w") as order:
        json.dump([str(folder), list(arguments), environment, f"/proc/{os.getpid()}/fd/{output.fileno()}"], order)
        order.flush()
        server.stdin.write(f"{order.name}\n")
        server.stdin.flush()
        code = int(server.stdout.readline())
        output.seek(0)
        return code, output.read()


@functools.cache
def _server() -> subprocess.Popen[str]:
    """Ends with this process, which closes its input."""
    return subprocess.Popen([sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def _serve() -> None:
    for module in IMPORTED:
        __import__(module)
    for line in sys.stdin:
        child = os.fork()
        if not child:
            _run(*json.loads(Path(line.strip()).read_text()))
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)


def _run(folder: str, arguments: list[str], environment: dict[str, str], output: str) -> None:
    """As a process of its own would be: folder, environment, path and streams."""
    streams = (os.open(os.devnull, os.O_RDONLY), os.open(output, os.O_WRONLY | os.O_APPEND))
    for number, stream in enumerate((*streams, streams[1])):
        os.dup2(stream, number)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[0] = folder
    code = 1
    try:
        sys.modules["snakemake.cli"].main(arguments)
    except SystemExit as error:
        code = error.code if isinstance(error.code, int) else int(bool(error.code))
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


if __name__ == "__main__":
    _serve()

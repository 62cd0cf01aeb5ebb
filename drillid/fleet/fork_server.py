"""One process per run that loads what its jobs need, and a forked child of it for each job.

A job's own work may take less time than starting Python with all libraries and compiled kernels; here that is paid
once per run and machine instead of once per job. The server itself works on no well and opens no file of the results.
"""

from __future__ import annotations

import ast
import contextlib
import gc
import importlib
import importlib.util
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path

from drillid.fleet.children import end_with
from drillid.fleet.job import SERVER, TAKEN, called, receive
from drillid.fleet.provenance import PACKAGE, closure, source_hash
from drillid.fleet.stages import ALL_STAGES

RUN_STAGE = "drillid.fleet.run:run_configured"
_LIBRARIES = ("zarr.storage", "zarr.codecs", "matplotlib.backends.backend_agg")
"""Imported within functions only, so importing the library's modules does not load them."""
_REAP_EVERY_S, _PATIENCE_S = 5.0, 1.0
_LONGEST_FOLDER = 80


@contextlib.contextmanager
def served(rules: Collection[str]) -> Iterator[None]:
    """Run jobs started within this context as children of a server, which ends with this process at the latest.

    Parameters
    ----------
    rules : rules of the jobs; without a stage or library import among them no server is started
    """
    modules = [stage.module for name, stage in ALL_STAGES.items() if name in rules]
    modules += [module for rule in sorted(rules) for module in modules_of_script(rule)]
    if not modules:
        yield
        return
    with tempfile.TemporaryDirectory(prefix="drillid-", dir=_folder_of_sockets()) as folder:
        place = str(Path(folder, "jobs"))
        with _started(place, modules) as server:
            # the socket is bound already, so jobs wait there until the server has loaded everything
            os.environ[SERVER] = os.pathsep.join([sys.prefix, place])
            try:
                yield
            finally:
                os.environ.pop(SERVER, None)
                # the server ends when its standard input does
                if server.stdin is not None:
                    server.stdin.close()
                server.wait()


def _folder_of_sockets() -> str:
    """The folder for temporary files, or /tmp where its path is too long for that of a socket, of 107 bytes at most."""
    folder = tempfile.gettempdir()
    return folder if len(os.fsencode(folder)) <= _LONGEST_FOLDER else "/tmp"


def modules_of_script(rule: str) -> list[str]:
    """Modules of the library that the functions of a rule's script import; empty without a script or a function.

    A script imports within functions only, so that it loads nothing itself when it hands its job over.
    """
    try:
        script = importlib.util.find_spec(f"scripts.{rule}")
    except ModuleNotFoundError:
        return []
    if script is None or script.origin is None:
        return []
    functions = [each for each in ast.parse(Path(script.origin).read_bytes()).body if isinstance(each, ast.FunctionDef)]
    imports = [each for function in functions for each in ast.walk(function) if isinstance(each, ast.ImportFrom)]
    return [each.module for each in imports if each.module is not None and each.module.startswith(f"{PACKAGE.name}.")]


def _started(place: str, modules: Sequence[str]) -> subprocess.Popen[bytes]:
    """The server, the only process listening on the socket: if it dies, jobs are refused instead of left waiting."""
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(place)
        listening.listen(socket.SOMAXCONN)
        words = [sys.executable, "-P", "-m", __name__, str(listening.fileno()), *modules]
        return subprocess.Popen(words, stdin=subprocess.PIPE, pass_fds=[listening.fileno()])


def main(descriptor: int, modules: Sequence[str]) -> None:
    """Load what jobs need, then fork a child for each of them until the process that started this one ends."""
    # a terminal sends its interrupt to the jobs as well
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        _load(modules)
    except Exception:  # each job meets the error itself and logs it
        sys.exit(1)
    gc.collect()
    # memory pages with the server's objects stay shared with the children
    gc.freeze()
    listening = socket.socket(fileno=descriptor)
    while True:
        ready, _, _ = select.select([listening, sys.stdin], [], [], _REAP_EVERY_S)
        _reap()
        if sys.stdin in ready:
            break
        if listening in ready:
            client, _ = listening.accept()
            if not os.fork():
                listening.close()
                _work(client, os.getppid())
            client.close()
    until = time.monotonic() + _PATIENCE_S
    while _reap() and time.monotonic() < until:
        time.sleep(0.01)


def _reap() -> bool:
    """Reap children that have ended; returns whether any are still running."""
    with contextlib.suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            continue
        return True
    return False


def _load(modules: Sequence[str]) -> None:
    """Import modules with all modules of the library that they use, and load the compiled kernels of these."""
    importlib.import_module(RUN_STAGE.partition(":")[0])
    for module in modules:
        for each in sorted(closure(module)):
            importlib.import_module(each)
    for library in _LIBRARIES:
        with contextlib.suppress(ImportError):
            importlib.import_module(library)
    # a process that has built the import graph must not fork children that build another one
    for stage in ALL_STAGES.values():
        source_hash(stage.module, *(["drillid.config.rig"] if stage.rig else []))
    compiled = sys.modules.get("drillid.compiled")
    if compiled is not None:
        compiled.load_kernels()


def _work(client: socket.socket, server: int) -> None:
    """Do a job as the process that ordered it would, with its folder, environment and streams; never returns."""
    code = 1
    try:
        end_with(server)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        order, streams = receive(client)
        client.sendall(TAKEN)
        for number, stream in enumerate(streams):
            os.dup2(stream, number)
            os.close(stream)
        os.chdir(order["folder"])
        os.environ.clear()
        os.environ.update(order["environment"])
        threading.Thread(target=_end_with, args=(client,), daemon=True).start()
        called(order["function"])(**order["arguments"])
        code = 0
    except SystemExit as error:
        code = error.code if isinstance(error.code, int) else 1
    except BaseException:
        traceback.print_exc()
    finally:
        for text in (sys.stdout, sys.stderr):
            text.flush()
        with contextlib.suppress(OSError):
            client.sendall(bytes([code]))
        os._exit(code)


def _end_with(client: socket.socket) -> None:
    """End this process when the one that ordered the job is gone."""
    with contextlib.suppress(OSError):
        client.recv(1)
    os._exit(1)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2:])

"""A job of the workflow as its script starts it: in a child of the run's fork server if there is one, else here.

A script imports only this module, so that it has loaded nothing else when it hands its job over.
"""

from __future__ import annotations

import array
import importlib
import json
import os
import socket
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

SERVER = "DRILLID_FORK_SERVER"
"""Environment variable with the Python environment whose jobs the server takes, and the server's socket."""
TAKEN = b"+"
"""The server's answer once one of its children works on an order."""
_STREAMS = 3


def run_job(function: str, **arguments: Any) -> None:
    """Call a function, in a child of this run's fork server, where its module is already loaded, if there is one.

    Parameters
    ----------
    function : as `module:function`
    arguments : of the function; must be representable in JSON

    Raises
    ------
    SystemExit
        If the function fails in a child of the server, which has written its traceback to this process's streams.
    """
    server = _connected()
    code = _of_server(server, function, arguments) if server is not None else None
    if code is None:
        called(function)(**arguments)
    elif code:
        sys.exit(code)


def _of_server(server: socket.socket, function: str, arguments: dict[str, Any]) -> int | None:
    """Exit code of a job run by the server; None if the server ended before it took the job."""
    order = {"function": function, "arguments": arguments, "folder": str(Path.cwd()), "environment": dict(os.environ)}
    with server:
        try:
            send(server, order)
            taken = server.recv(1)
        except OSError:
            return None
        if taken != TAKEN:
            return None
        code = server.recv(1)
    if not code:
        print("The job's process was killed, probably out of memory", file=sys.stderr)
    return code[0] if code else 1


def run_stage_job(stage: str, snakemake: Any) -> None:
    """Run a stage on a batch of wells as a job.

    Parameters
    ----------
    stage : name of the stage
    snakemake : the object that Snakemake hands to a script
    """
    run_job(
        "drillid.fleet.run:run_configured",
        stage=stage,
        wells=list(snakemake.params.wells),
        config=dict(snakemake.config),
        log=str(snakemake.log[0]),
        manifest=str(snakemake.output.manifest),
        made_from=str(snakemake.params.made_from),
    )


def called(function: str) -> Callable[..., Any]:
    """The function named `module:function`."""
    module, _, name = function.partition(":")
    found: Callable[..., Any] = getattr(importlib.import_module(module), name)
    return found


def _connected() -> socket.socket | None:
    """A connection to the server; None if there is none, or if it runs in another Python environment."""
    prefix, _, place = os.environ.get(SERVER, "").rpartition(os.pathsep)
    if not place or prefix != sys.prefix:
        return None
    server = socket.socket(socket.AF_UNIX)
    try:
        server.connect(place)
    except OSError:
        server.close()
        return None
    return server


def send(server: socket.socket, order: dict[str, Any]) -> None:
    """Send an order, preceded by its length, with this process's streams."""
    content = json.dumps(order).encode()
    streams = array.array("i", range(_STREAMS))
    server.sendmsg([len(content).to_bytes(8, "big")], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, streams.tobytes())])
    server.sendall(content)


def receive(client: socket.socket) -> tuple[dict[str, Any], list[int]]:
    """An order, and the streams of the process that sent it.

    Raises
    ------
    EOFError
        If the process ended before it had sent all.
    """
    begun, streams, _, _ = socket.recv_fds(client, 8, _STREAMS)
    if len(begun) < 8:
        raise EOFError
    with client.makefile("rb") as file:
        content = file.read(int.from_bytes(begun, "big"))
    order: dict[str, Any] = json.loads(content)
    return order, streams

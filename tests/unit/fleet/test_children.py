"""Children of a job end with it at once, even in a call that holds the interpreter."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import psutil

from drillid.fleet.children import mapped_apart

JOB = """
import ctypes, os, sys, time
from drillid.fleet.children import mapped_apart

def busy(path):
    open(path, "w").write(str(os.getpid()))
    ctypes.PyDLL(None).sleep(60)  # without releasing the interpreter

list(mapped_apart(busy, [sys.argv[1]]))
"""


def ends_soon(item: int) -> int:
    """A task after which its process is killed, once, as by a machine that is out of memory."""
    if item == 0:
        threading.Timer(0.1, os._exit, [1]).start()
    return item


def test_a_child_that_is_killed_between_two_items_is_replaced() -> None:
    done = []
    for item, future in mapped_apart(ends_soon, [0, 1, 2]):
        time.sleep(0.5 if item == 0 else 0.0)
        done.append((item, future.result()))
    assert done == [(0, 0), (1, 1), (2, 2)]


def test_a_busy_child_ends_with_a_job_that_is_killed(tmp_path: Path) -> None:
    place = tmp_path / "pid"
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])}
    with subprocess.Popen([sys.executable, "-c", JOB, str(place)], env=environment) as job:
        until = time.monotonic() + 30
        while not (place.exists() and place.read_text()) and time.monotonic() < until:
            time.sleep(0.05)
        child = psutil.Process(int(place.read_text()))
        job.send_signal(signal.SIGKILL)
    assert not psutil.wait_procs([child], timeout=5)[1]

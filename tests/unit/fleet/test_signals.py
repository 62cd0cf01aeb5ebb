"""What ends a run, and what does not: signals, and the end of the process on which it depends."""

import os
import signal
import sys
from collections.abc import Iterator

import pytest

from drillid.fleet import lock
from drillid.fleet.command import _supervised

TOLD = "import os, signal, sys, time; os.kill(int(sys.argv[1]), signal.SIGHUP); time.sleep(float(sys.argv[2]))"


def supervised(seconds: float) -> int:
    """Exit code of a command that lasts some time and tells this process that the terminal has hung up."""
    return _supervised([sys.executable, "-c", TOLD, str(os.getpid()), str(seconds)], dict(os.environ))


@pytest.fixture(params=[signal.SIG_DFL, signal.SIG_IGN])
def heeded(request: pytest.FixtureRequest) -> Iterator[bool]:
    """Whether hang-ups are heeded, as they are but under nohup."""
    before = signal.signal(signal.SIGHUP, request.param)
    yield request.param is signal.SIG_DFL
    assert signal.signal(signal.SIGHUP, before) is request.param


def test_a_terminal_that_hangs_up_ends_a_run_but_under_nohup(heeded: bool) -> None:
    assert supervised(30.0 if heeded else 0.3) == (128 + signal.SIGHUP if heeded else 0)


def test_a_process_is_the_same_after_the_clock_was_set(monkeypatch: pytest.MonkeyPatch) -> None:
    psutil = pytest.importorskip("psutil._pslinux")
    named = lock.identity()
    later = psutil.boot_time() + 2.0
    monkeypatch.setattr(psutil, "boot_time", lambda: later)
    monkeypatch.setattr(psutil, "BOOT_TIME", later, raising=False)
    assert lock.identity() == named
    assert lock._lives(os.getpid(), named)
    assert not lock._lives(os.getpid(), lock.identity(os.getppid()))

"""`drillid run` in a checkout with toy stages, and what is left of it where one of its processes is killed."""

import hashlib
import os
import random
import shutil
import subprocess
import sys
import time
from pathlib import Path

import psutil

from drillid.fleet.crate import CRATE
from tests.workflow.forked import drillid_run
from tests.workflow.toys import ROOT, Checkout

WELLS = {"W1": ["a.csv", "b.csv"], "W-2": ["c.csv"], "W3": ["d.csv"]}


def words(*arguments: str) -> list[str]:
    """Of `drillid run` with the profile of `write_wells`."""
    return ["--jobs", "2", "--profile", "profile", *arguments]


def environment(checkout: Checkout) -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(checkout.root)}


def run(checkout: Checkout, *arguments: str) -> subprocess.CompletedProcess[str]:
    return drillid_run(checkout.root, words(*arguments), environment(checkout))


def command(*arguments: str) -> list[str]:
    """The same as a process of its own, which can be killed."""
    return [sys.executable, "-m", "drillid", "run", *words(*arguments)]


def started(checkout: Checkout, *arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        command(*arguments),
        cwd=checkout.root,
        env=environment(checkout),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def undisturbed(checkout: Checkout) -> float:
    """Duration of a whole run as a process of its own, s."""
    began = time.monotonic()
    running = started(checkout)
    output, _ = running.communicate()
    assert running.returncode == 0, output
    return time.monotonic() - began


def make_started(checkout: Checkout, *words: str) -> subprocess.Popen[str]:
    """`make` in the checkout, whose environment is lent by this one."""
    for name in ("Makefile", "scripts/drillid.sh", "requirements.lock"):
        shutil.copyfile(ROOT / name, checkout.root / name)
    binaries = checkout.root / ".venv/bin"
    binaries.mkdir(parents=True)
    (binaries / "python").write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    (binaries / "python").chmod(0o755)
    for name in ("ready", "kernels"):
        (checkout.root / ".venv" / name).touch()
    return subprocess.Popen(
        ["make", *words], cwd=checkout.root, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


def family(process: subprocess.Popen[str]) -> list[psutil.Process]:
    return [psutil.Process(process.pid), *psutil.Process(process.pid).children(recursive=True)]


def digests(results: Path) -> dict[str, str]:
    """Contents of everything that a user reads; logs, timings, locks and the run's dates differ from run to run."""
    kept = [path for path in results.rglob("*") if path.is_file() and not path.name.startswith((".", CRATE))]
    apart = {results / name for name in ("logs", "benchmarks")}
    return {
        str(path.relative_to(results)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(kept)
        if apart.isdisjoint(path.parents)
    }


def kill_some_process(checkout: Checkout, seconds: float, draw: random.Random) -> None:
    """Start a run and kill one of its processes outright after so many seconds; end only when the run has."""
    running = started(checkout)
    time.sleep(seconds)
    if running.poll() is None:
        victim = draw.choice(family(running))
        if victim.is_running():
            victim.kill()
    running.communicate(timeout=120)


def write_wells(checkout: Checkout, batch_size: int = 1) -> None:
    """Three wells, and a profile by which a run goes on where one of them fails."""
    checkout.sheets(WELLS)
    with (checkout.root / "config/config.yaml").open("a") as configuration:
        configuration.write(f"\nfleet: {{batch_size: {batch_size}, processes: 1}}\n")
    (checkout.root / "profile").mkdir()
    (checkout.root / "profile/config.yaml").write_text("scheduler: greedy\nkeep-going: true\nrerun-incomplete: true\n")

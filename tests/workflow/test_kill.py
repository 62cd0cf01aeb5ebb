"""`drillid run` killed at any moment, started twice, stopped, and with wells that fail: what it leaves, how it ends."""

import hashlib
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from tests.workflow.toys import Checkout

WELLS = {"W1": ["a.csv", "b.csv"], "W-2": ["c.csv"], "W3": ["d.csv"]}
POINTS = int(os.environ.get("DRILLID_KILL_POINTS", "4"))
"""`make bench-fleet` tries twenty."""


def command(checkout: Checkout, *arguments: str) -> tuple[list[str], dict[str, str]]:
    environment = os.environ | {"PYTHONPATH": str(checkout.root)}
    return [sys.executable, "-m", "drillid", "run", "--jobs", "2", "--profile", "profile", *arguments], environment


def run(checkout: Checkout, *arguments: str) -> subprocess.CompletedProcess[str]:
    words, environment = command(checkout, *arguments)
    return subprocess.run(words, cwd=checkout.root, env=environment, capture_output=True, text=True, check=False)


def started(checkout: Checkout, *arguments: str) -> subprocess.Popen[str]:
    words, environment = command(checkout, *arguments)
    return subprocess.Popen(
        words, cwd=checkout.root, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


def family(process: subprocess.Popen[str]) -> list[psutil.Process]:
    return [psutil.Process(process.pid), *psutil.Process(process.pid).children(recursive=True)]


def digests(results: Path) -> dict[str, str]:
    """Contents of everything that a user reads; logs, timings and locks differ from run to run."""
    kept = [path for path in results.rglob("*") if path.is_file() and not path.name.startswith(".")]
    apart = {results / name for name in ("logs", "benchmarks")}
    return {
        str(path.relative_to(results)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(kept)
        if apart.isdisjoint(path.parents)
    }


@pytest.fixture
def wells(checkout: Checkout) -> Checkout:
    checkout.sheets(WELLS)
    (checkout.root / "profile").mkdir()
    (checkout.root / "profile/config.yaml").write_text("scheduler: greedy\nkeep-going: true\nrerun-incomplete: true\n")
    return checkout


def test_a_run_killed_at_any_moment_ends_as_an_undisturbed_one(wells: Checkout) -> None:
    """Any process of the run is killed outright, time and again; each next run takes up by itself."""
    began = time.monotonic()
    assert run(wells).returncode == 0
    duration = time.monotonic() - began
    results = wells.root / "results/main"
    undisturbed = digests(results)
    draw = random.Random(4)
    for point in range(POINTS):
        if point % 5 == 0:
            (wells.root / "results").rename(wells.root / f"results-{point}")
        running = started(wells)
        time.sleep(draw.uniform(0.3, 0.8) * duration)
        if running.poll() is None:
            with_children = family(running)
            victim = draw.choice(with_children)
            if victim.is_running():
                victim.kill()
        running.communicate(timeout=60)
    last = run(wells)
    assert last.returncode == 0, last.stderr
    assert digests(results) == undisturbed


def test_a_second_run_at_once_is_refused_and_the_first_goes_on(wells: Checkout) -> None:
    (wells.root / "raw/d.csv").write_text("slow")
    first = started(wells)
    until = time.monotonic() + 60
    while not (wells.root / "journal.txt").exists() and time.monotonic() < until:
        time.sleep(0.1)
    second = run(wells)
    assert second.returncode == 1
    assert "another run works on these results (process" in second.stderr
    assert first.poll() is None
    first.send_signal(signal.SIGTERM)
    first.communicate(timeout=30)


def test_a_signal_ends_all_processes(wells: Checkout) -> None:
    (wells.root / "raw/d.csv").write_text("slow")
    running = started(wells)
    until = time.monotonic() + 60
    while not (wells.root / "journal.txt").exists() and time.monotonic() < until:
        time.sleep(0.1)
    processes = family(running)
    running.send_signal(signal.SIGTERM)
    running.communicate(timeout=30)
    assert running.returncode == 128 + signal.SIGTERM
    _, alive = psutil.wait_procs(processes, timeout=5)
    assert not alive
    (wells.root / "raw/d.csv").write_text("samples")
    assert run(wells).returncode == 0


def test_failed_wells_are_named_and_decide_the_exit_code(wells: Checkout) -> None:
    (wells.root / "raw/c.csv").write_text("bad")
    done = run(wells)
    assert done.returncode == 3
    assert "1 of 3 wells failed: W-2 (records: c.csv: is bad). See problems.csv for the remedies." in done.stderr
    assert run(wells, "--no-strict").returncode == 0
    (wells.root / "raw/c.csv").write_text("samples")
    done = run(wells)
    assert done.returncode == 0
    assert "3 of 3 wells done." in done.stderr


def test_a_corrected_rig_description_is_noticed_wherever_it_was_wrong(wells: Checkout) -> None:
    """The records use only time and channels of it, but none of it is believed while a part is wrong."""
    rig = wells.root / "config/rigs/toy.yaml"
    right = rig.read_text()
    rig.write_text(right + "pipe: {outer_diameter: 4 in, inner_diameter: 5 in}\n")
    done = run(wells)
    assert done.returncode == 3
    assert "3 of 3 wells failed" in done.stderr
    rig.write_text(right + "pipe: {outer_diameter: 5 in, inner_diameter: 4 in}\n")
    assert run(wells).returncode == 0
    wells.journal()
    rig.write_text(right + "pipe: {outer_diameter: 5 in, inner_diameter: 4.1 in}\n")
    assert run(wells).returncode == 0
    assert not [line for line in wells.journal() if line.startswith(("records", "windows"))]


def test_what_nobody_foresaw_is_tried_again_by_the_next_run(wells: Checkout) -> None:
    (wells.root / "raw/c.csv").write_text("crash")
    done = run(wells)
    assert done.returncode == 3
    assert "nobody foresaw this" in done.stderr
    wells.journal()
    assert run(wells).returncode == 3
    assert "records W-2" in wells.journal()


def test_a_damaged_key_is_no_key(wells: Checkout) -> None:
    assert run(wells).returncode == 0
    wells.journal()
    (wells.root / "results/main/fits/W-2/key.json").write_text("")
    assert run(wells).returncode == 0
    journal = wells.journal()
    assert "fits W-2" in journal
    assert "fits W1" not in journal
    assert "records W-2" not in journal


def test_a_fault_of_the_machine_fails_the_job_and_no_other_well(wells: Checkout) -> None:
    (wells.root / "raw/c.csv").write_text("full")
    done = run(wells)
    assert done.returncode == 1
    assert "1 of 3 wells failed: W-2" in done.stderr
    assert (wells.root / "results/main/depth/W1/key.json").exists()
    (wells.root / "raw/c.csv").write_text("samples")
    assert run(wells).returncode == 0

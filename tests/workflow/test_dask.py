"""Wells spread over processes: of this machine, and of a real dask scheduler with two workers."""

import contextlib
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from tests.workflow.killed import digests
from tests.workflow.toys import Checkout

WELLS = {
    "Good": ["a.csv"],
    "Bad": ["bad.csv"],
    "Fine": ["b.csv"],
    "Die": ["die.csv"],
    "Well": ["c.csv"],
    "Slow": ["slow.csv"],
}

RUN = """
import sys
from drillid.config.settings import FleetSettings, Settings
from drillid.fleet.run import run_stage

if __name__ == "__main__":
    fleet = FleetSettings(scheduler=sys.argv[1] or None, processes=int(sys.argv[3]))
    for outcome in run_stage("records", sys.argv[2].split(","), Settings(fleet=fleet), "records.log"):
        print(outcome.well, outcome.status)
"""


@pytest.fixture
def fleet(checkout: Checkout) -> Checkout:
    checkout.sheets(WELLS)
    for name in ("bad", "die"):
        (checkout.root / f"raw/{name}.csv").write_text(name)
    (checkout.root / "run.py").write_text(RUN)
    return checkout


def environment(fleet: Checkout) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(fleet.root), "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "5s"}


def run(fleet: Checkout, scheduler: str, *wells: str, processes: int = 2) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "run.py", scheduler, ",".join(wells), str(processes)],
        cwd=fleet.root,
        env=environment(fleet),
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )


@contextlib.contextmanager
def started(fleet: Checkout, *arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    command = [sys.executable, "-m", "dask", *arguments, "--no-dashboard"]
    with (fleet.root / "dask.log").open("a") as log:
        process = subprocess.Popen(command, cwd=fleet.root, env=environment(fleet), stdout=log, stderr=log)
        try:
            yield process
        finally:
            process.terminate()
            process.wait(20)


@contextlib.contextmanager
def head(fleet: Checkout) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Address of a scheduler, and the words by which a worker of one thread finds it."""
    file = fleet.root / "scheduler.json"
    with started(fleet, "scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file)):
        worker = ("worker", "--scheduler-file", str(file), "--nthreads", "1")
        yield str(awaited(lambda: json.loads(file.read_text())["address"])), worker


@pytest.fixture
def scheduler(fleet: Checkout) -> Iterator[str]:
    with head(fleet) as (address, worker), started(fleet, *worker, "--nworkers", "2"):
        yield address


LIMIT_S = 300.0


def awaited(look: Callable[[], Any]) -> Any:
    """What `look` gives once it gives something."""
    until = time.monotonic() + LIMIT_S
    while time.monotonic() < until:
        with contextlib.suppress(FileNotFoundError, json.JSONDecodeError, IndexError):
            if (found := look()) is not None:
                return found
        time.sleep(0.1)
    raise AssertionError(f"nothing came in {LIMIT_S:.0f} s")


def assert_all_but_the_bad_are_done(fleet: Checkout, done: subprocess.CompletedProcess[str]) -> None:
    assert done.returncode == 0, done.stderr
    outcomes = dict(line.split() for line in done.stdout.splitlines())
    assert outcomes == {"Good": "done", "Fine": "done", "Well": "done", "Bad": "failed"}
    bad = pd.read_csv(fleet.root / "results/main/records/Bad/problems.csv")
    assert bad[["where", "what"]].to_numpy().tolist() == [["bad.csv", "is bad"]]
    assert "4 of 4 wells" in done.stderr


def test_wells_go_over_the_processes_of_this_machine(fleet: Checkout) -> None:
    assert_all_but_the_bad_are_done(fleet, run(fleet, "", "Good", "Bad", "Fine", "Well"))
    processes = {line.split()[2] for line in fleet.pids()}
    assert len(processes) == 2


def test_wells_go_over_a_dask_scheduler_that_refuses_workers_with_older_code(fleet: Checkout, scheduler: str) -> None:
    assert_all_but_the_bad_are_done(fleet, run(fleet, scheduler, "Good", "Bad", "Fine", "Well"))
    assert len({line.split()[2] for line in fleet.pids()}) == 2
    fleet.edit("shared", "FURTHER = 2\n")
    refused = run(fleet, scheduler, "Good")
    assert refused.returncode != 0
    assert "Restart the dask workers" in refused.stderr


def test_a_worker_that_is_killed_in_mid_run_changes_no_result(fleet: Checkout) -> None:
    """Two workers are processes of their own; the other one takes the wells of the one that is killed."""
    wells = {f"W{number}": [f"{number}.csv"] for number in range(6)}
    fleet.sheets(wells)
    words = ("--until", "windows", "--config")
    fleet.run(*words, "fleet={batch_size: 6}")
    undisturbed = digests(fleet.root / "results/main")
    shutil.rmtree(fleet.root / "results")
    fleet.journal()
    with (
        head(fleet) as (address, worker),
        started(fleet, *worker, "--no-nanny", "--name", "A") as first,
        started(fleet, *worker, "--no-nanny", "--name", "B") as second,
        ThreadPoolExecutor() as threads,
    ):
        running = threads.submit(fleet.run, *words, f"fleet={{batch_size: 6, scheduler: '{address}'}}")
        awaited(lambda: f" {first.pid}\n" in (fleet.root / "journal.txt").read_text() or None)
        first.kill()
        running.result()
    assert digests(fleet.root / "results/main") == undisturbed
    done = [(line.split()[:2], int(line.split()[2])) for line in fleet.pids()]
    assert {process for _, process in done} == {first.pid, second.pid}
    assert {well for (stage, well), process in done if (stage, process) == ("windows", second.pid)} == wells.keys()


def assert_only_the_killed_failed(fleet: Checkout, done: subprocess.CompletedProcess[str]) -> None:
    assert done.returncode == 0, done.stderr
    outcomes = dict(line.split() for line in done.stdout.splitlines())
    assert outcomes["Die"] == "failed"
    # kept, where its outcome was lost with the process and asked for again
    assert {outcomes["Good"], outcomes["Fine"]} <= {"done", "kept"}
    row = pd.read_csv(fleet.root / "results/main/records/Die/problems.csv").iloc[0]
    assert row["what"] == "the process was killed, probably out of memory"
    assert "more memory" in row["remedy"]


@pytest.mark.parametrize("processes", [1, 2])
def test_a_well_that_kills_its_process_is_a_row_and_the_others_go_on(fleet: Checkout, processes: int) -> None:
    assert_only_the_killed_failed(fleet, run(fleet, "", "Good", "Die", "Fine", processes=processes))


def test_one_child_takes_the_wells_one_after_the_other_until_it_is_killed(fleet: Checkout) -> None:
    assert_only_the_killed_failed(fleet, run(fleet, "", "Good", "Well", "Die", "Fine", processes=1))
    good, well, die, fine = (line.split()[2] for line in fleet.pids())
    assert good == well == die != fine


def test_the_child_ends_when_its_job_is_killed(fleet: Checkout) -> None:
    (fleet.root / "raw/slow.csv").write_text("slow")
    command = [sys.executable, "run.py", "", "Slow", "1"]
    with subprocess.Popen(command, cwd=fleet.root, env=environment(fleet), stderr=subprocess.DEVNULL) as job:
        child = int(awaited(lambda: fleet.pids()[0].split()[2]))
        job.kill()
    assert awaited(lambda: not alive(child) or None)


def alive(process: int) -> bool:
    try:
        return "Z" not in Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False


def test_a_scheduler_that_does_not_answer_is_named(fleet: Checkout) -> None:
    done = run(fleet, "tcp://127.0.0.1:9", "Good")
    assert done.returncode != 0
    assert "no dask scheduler answers at tcp://127.0.0.1:9" in done.stderr

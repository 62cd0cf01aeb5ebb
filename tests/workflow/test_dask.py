"""Wells spread over processes: of this machine, and of a real dask scheduler with two workers."""

import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pandas as pd
import pytest

from tests.workflow.toys import Checkout

WELLS = {"Good": ["a.csv"], "Bad": ["bad.csv"], "Fine": ["b.csv"], "Die": ["die.csv"], "Well": ["c.csv"]}

RUN = """
import sys
from drillid.config import FleetSettings, Settings
from drillid.fleet import run_stage

if __name__ == "__main__":
    fleet = FleetSettings(scheduler=sys.argv[1] or None, processes=2)
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


def run(fleet: Checkout, scheduler: str, *wells: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "run.py", scheduler, ",".join(wells)],
        cwd=fleet.root,
        env=environment(fleet),
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )


@contextlib.contextmanager
def started(fleet: Checkout, *arguments: str) -> Iterator[None]:
    command = [sys.executable, "-m", "dask", *arguments, "--no-dashboard"]
    with (fleet.root / "dask.log").open("a") as log:
        process = subprocess.Popen(command, cwd=fleet.root, env=environment(fleet), stdout=log, stderr=log)
        try:
            yield
        finally:
            process.terminate()
            process.wait(20)


@pytest.fixture
def scheduler(fleet: Checkout) -> Iterator[str]:
    file = fleet.root / "scheduler.json"
    worker = ("worker", "--scheduler-file", str(file), "--nthreads", "1", "--nworkers", "2")
    head = ("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file))
    with started(fleet, *head), started(fleet, *worker):
        yield address(file)


def address(file: Path) -> str:
    for _ in range(300):
        with contextlib.suppress(FileNotFoundError, json.JSONDecodeError):
            return str(json.loads(file.read_text())["address"])
        time.sleep(0.1)
    raise AssertionError("the scheduler does not start")


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


def test_a_well_that_kills_its_process_is_a_row_and_the_others_go_on(fleet: Checkout) -> None:
    done = run(fleet, "", "Good", "Die")
    outcomes = dict(line.split() for line in done.stdout.splitlines())
    assert outcomes["Die"] == "failed"
    assert outcomes["Good"] in {"done", "kept"}  # kept, where its outcome was lost with the process and asked for again
    row = pd.read_csv(fleet.root / "results/main/records/Die/problems.csv").iloc[0]
    assert "KilledWorker" in row["what"]
    assert "memory" in row["remedy"]


def test_a_scheduler_that_does_not_answer_is_named(fleet: Checkout) -> None:
    done = run(fleet, "tcp://127.0.0.1:9", "Good")
    assert done.returncode != 0
    assert "no dask scheduler answers at tcp://127.0.0.1:9" in done.stderr

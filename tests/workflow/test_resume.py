"""A run that is killed outright while a stage works on a well: the next run takes up where it ended."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.workflow.toys import Checkout

PLAIN = "samples"
FIRST = ("--until", "records")
BATCHES = (*FIRST, "--config", "fleet={batch_size: 2, processes: 1}")


def killed_while_it_works_on(checkout: Checkout, well: str, *arguments: str) -> list[str]:
    """Kill Snakemake and all that it started once `records` of the well has begun; what the journal holds then."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    command = [sys.executable, "-m", "snakemake", "--cores", "1", "--scheduler", "greedy", *arguments]
    with (
        (checkout.root / "killed.log").open("w") as log,
        subprocess.Popen(
            command, cwd=checkout.root, env=environment, stdout=log, stderr=log, start_new_session=True
        ) as run,
    ):
        journal = checkout.root / "journal.txt"
        until = time.monotonic() + 60
        while not (journal.exists() and f"records {well} " in journal.read_text()):
            assert time.monotonic() < until, (checkout.root / "killed.log").read_text()
            time.sleep(0.05)
        os.killpg(run.pid, signal.SIGKILL)
    for process in {line.split()[2] for line in journal.read_text().splitlines()}:
        with contextlib.suppress(ProcessLookupError):
            os.kill(int(process), signal.SIGKILL)
    return checkout.journal()


@pytest.mark.parametrize("arguments", [FIRST, BATCHES])
def test_a_killed_run_is_taken_up_by_the_next(finished: Checkout, arguments: tuple[str, ...]) -> None:
    """The well is in the middle of its update: its old folder is gone, its new one is not done."""
    if arguments is BATCHES:
        finished.run(*arguments)
    finished.journal()
    log = finished.root / "raw/c.csv"
    log.write_text("slow")
    assert killed_while_it_works_on(finished, "W-2", *arguments) == ["records W-2"]
    folder = finished.root / "results/main/records/W-2"
    assert folder.is_dir()
    assert not (folder / "key.json").exists()
    log.write_text(PLAIN * 2)
    finished.run("--unlock", *arguments)
    finished.run(*arguments)
    done = [line for line in finished.journal() if line.startswith("records")]
    assert done == ["records W-2"]
    assert (folder / "records.zarr").is_dir()
    assert not Path(finished.root / ".snakemake/backups").exists()
    assert finished.would_run(*arguments) == []

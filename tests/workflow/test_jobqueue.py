"""Wells spread over workers that dask submits to Slurm, whose commands are stood in for by scripts."""

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from typing import Any

import pytest

from tests.workflow.test_dask import alive, awaited
from tests.workflow.toys import Checkout

LIMIT_S = 600
RUN = """
import json, sys
from drillid.config.settings import Settings
from drillid.errors import DrillidError
from drillid.fleet.run import run_stage

if __name__ == "__main__":
    settings = Settings.checked({"fleet": json.loads(sys.argv[1])}, "fleet")
    try:
        for outcome in run_stage("records", sys.argv[2].split(","), settings):
            print(outcome.well, outcome.status)
    except DrillidError as error:
        sys.exit(str(error))
"""

SBATCH = """#!/bin/sh
grep -q -e '--qos=none' "$1" && { echo "sbatch: error: Invalid qos specification" >&2; exit 1; }
cp "$1" "submitted-$$.sh"
setsid bash "submitted-$$.sh" > "worker-$$.log" 2>&1 &
until kill -s 0 -- "-$!"; do kill -s 0 "$!" || break; sleep 0.01; done
echo "Submitted batch job $!"
"""
"""Jobs submitted at the same moment have files of their own; each leads its group when the command returns."""
SCANCEL = """#!/bin/sh
echo "$1" >> cancelled
kill -- "-$1"
"""


@pytest.fixture
def fleet(checkout: Checkout) -> Checkout:
    checkout.sheets({"Good": ["a.csv"], "Fine": ["b.csv"], "Bad": ["bad.csv"]})
    (checkout.root / "raw/bad.csv").write_text("bad")
    (checkout.root / "run.py").write_text(RUN)
    for name, text in (("sbatch", SBATCH), ("scancel", SCANCEL)):
        path = checkout.root / "bin" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)
    return checkout


def run(fleet: Checkout, slurm: Mapping[str, Any]) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {
        "PYTHONPATH": str(fleet.root),
        "PATH": f"{fleet.root / 'bin'}:{os.environ['PATH']}",
        # a machine with other work on it starts Python slowly
        "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": f"{LIMIT_S}s",
        "DASK_JOBQUEUE__SLURM__DEATH_TIMEOUT": str(LIMIT_S),
    }
    command = [sys.executable, "run.py", json.dumps({"scheduler": {"slurm": slurm}}), "Good,Fine,Bad"]
    return subprocess.run(
        command, cwd=fleet.root, env=environment, capture_output=True, text=True, check=False, timeout=LIMIT_S
    )


def test_wells_go_over_workers_that_are_jobs_of_slurm_and_end_with_it(fleet: Checkout) -> None:
    done = run(fleet, {"jobs": 5, "processes": 2, "memory_mb": 2000})
    assert done.returncode == 0, done.stderr
    assert sorted(done.stdout.splitlines()) == ["Bad failed", "Fine done", "Good done"]
    # two jobs for three wells; both are taken back
    scripts = [path.read_text() for path in fleet.root.glob("submitted-*.sh")]
    assert len(scripts) == 2
    for script in scripts:
        assert "#SBATCH --cpus-per-task=2" in script
        assert f"export PYTHONPATH='{fleet.root}'" in script
    jobs = (fleet.root / "cancelled").read_text().split()
    assert len(jobs) == 2
    assert awaited(lambda: not any(alive(int(job)) for job in jobs) or None)


def test_jobs_that_slurm_refuses_are_told_with_its_words(fleet: Checkout) -> None:
    done = run(fleet, {"jobs": 1, "directives": ["--qos=none"]})
    assert done.returncode != 0
    assert "fleet.scheduler.slurm: Slurm refuses the workers' jobs" in done.stderr
    assert "Invalid qos specification" in done.stderr

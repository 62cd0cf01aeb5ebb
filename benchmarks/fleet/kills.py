"""Runs of which a process is killed outright, at random moments, against an undisturbed one."""

import random
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

from rich.console import Console

from benchmarks.parts import Measurement
from benchmarks.result import Result
from tests.workflow.killed import digests, kill_some_process, run, undisturbed, write_wells
from tests.workflow.toys import new_checkout

POINTS = 20
_SEED = 21


def measure(console: Console) -> Measurement:
    """Kill, run again, compare every file that a user reads, and do so from nothing at each moment."""
    draw, identical = random.Random(_SEED), 0
    with TemporaryDirectory(prefix="kills-") as folder:
        checkout = new_checkout(Path(folder))
        # jobs are what takes time: one batch has as many kinds of processes as many have
        write_wells(checkout, batch_size=25)
        duration, results = undisturbed(checkout), checkout.root / "results/main"
        expected = digests(results)
        for point in range(POINTS):
            for name in ("results", ".snakemake"):
                shutil.rmtree(checkout.root / name, ignore_errors=True)
            moment = draw.uniform(0.0, 1.0) * duration
            kill_some_process(checkout, moment, draw)
            again = run(checkout)
            same = again.returncode == 0 and digests(results) == expected
            identical += same
            console.print(f"{point + 1}: killed after {moment:.1f} s, {'identical' if same else 'DIFFERENT'}")
    meaning = f"runs as undisturbed after a kill, of {POINTS}"
    return Measurement([Result("kill_points_identical", meaning, identical, least=POINTS)])

"""Faults put into a copy of the library on purpose, each of which the tests of its room must find.

`python -m tests.mutants` tries all of them, `python -m tests.mutants records fits/joint` those of some rooms. The
checkout itself is never touched. It ends with a failure unless every fault is caught.
"""

import os
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import repeat
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from tests.mutants.fault import Fault
from tests.mutants.faults import FAULTS

ROOT = Path(__file__).resolve().parents[2]
COPIED = ("drillid", "tests", "benchmarks", "config", "workflow", "scripts", "envs", "Snakefile", "pyproject.toml")
CAUGHT, SURVIVED, NOT_FOUND = "caught", "survived", "text not found"
_PASSED, _FAILED = 0, 1
"""Exit codes of pytest; any other says that the tests did not run."""
_LONGEST_S = 900.0


@dataclass(frozen=True)
class Outcome:
    """What became of one fault."""

    fault: Fault
    verdict: str
    """`CAUGHT`, `SURVIVED`, `NOT_FOUND`, or why the tests did not run."""
    seconds: float


def copied(root: Path, folder: Path) -> None:
    """What the library's tests need, in a folder of its own."""
    for name in COPIED:
        source = root / name
        if source.is_dir():
            shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy2(source, folder / name)


def tested(folder: Path, tests: tuple[str, ...]) -> subprocess.CompletedProcess[str]:
    """The tests in a copy, until the first failure; compiled functions are kept in the copy."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(folder / "compiled"), "PYTHONPATH": ""}
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=_LONGEST_S
    )


def tried(fault: Fault, root: Path) -> Outcome:
    """Put a fault into a fresh copy of a checkout and run the tests that must find it."""
    begin = time.monotonic()
    with TemporaryDirectory(prefix="fault-") as name:
        folder = Path(name)
        copied(root, folder)
        path = folder / fault.file
        source = path.read_text() if path.is_file() else ""
        if source.count(fault.original) != 1:
            return Outcome(fault, NOT_FOUND, 0.0)
        path.write_text(source.replace(fault.original, fault.mutated))
        code = tested(folder, fault.tests).returncode
    verdict = {_PASSED: SURVIVED, _FAILED: CAUGHT}.get(code, f"tests did not run, pytest ended with {code}")
    return Outcome(fault, verdict, time.monotonic() - begin)


def check_sound(faults: tuple[Fault, ...], root: Path) -> None:
    """The chosen tests must pass without any fault, or catching one would say nothing."""
    done = tested(root, tuple(dict.fromkeys(test for fault in faults for test in fault.tests)))
    if done.returncode != _PASSED:
        typer.echo(done.stdout + done.stderr, err=True)
        typer.echo("the tests fail without any fault, so that nothing can be told from them", err=True)
        raise typer.Exit(2)


def printed(outcomes: list[Outcome]) -> Table:
    """One row a fault."""
    table = Table("room", "file", "fault", "outcome", "s")
    for one in outcomes:
        style = "" if one.verdict == CAUGHT else "bold red"
        table.add_row(one.fault.room, one.fault.file, one.fault.why, one.verdict, f"{one.seconds:.0f}", style=style)
    return table


def main(
    rooms: Annotated[list[str] | None, typer.Argument(help="Rooms whose faults are tried; all by default.")] = None,
    jobs: Annotated[int, typer.Option(help="Faults tried at the same time.")] = 2,
) -> None:
    """Try the faults, print a table, and fail unless all are caught."""
    known = {fault.room for fault in FAULTS}
    if unknown := set(rooms or ()) - known:
        raise typer.BadParameter(f"{', '.join(sorted(unknown))}: there are {', '.join(sorted(known))}")
    faults = tuple(fault for fault in FAULTS if not rooms or fault.room in rooms)
    with TemporaryDirectory(prefix="sound-") as name, ThreadPoolExecutor(jobs) as pool:
        # an edit of the checkout meanwhile touches no trial
        copied(ROOT, Path(name))
        check_sound(faults, Path(name))
        outcomes = list(pool.map(tried, faults, repeat(Path(name))))
    Console(width=None if sys.stdout.isatty() else 160).print(printed(outcomes))
    caught = sum(one.verdict == CAUGHT for one in outcomes)
    typer.echo(f"{caught} of {len(outcomes)} caught")
    if caught < len(outcomes):
        raise typer.Exit(1)


if __name__ == "__main__":
    typer.run(main)

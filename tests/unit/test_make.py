"""Compiled kernels are made when they are absent or older than their sources, and else left alone."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
COMPILES = "-m scripts.compile_kernels"


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Files of which `make setup` compares the times."""
    shutil.copy(ROOT / "Makefile", tmp_path)
    sources = ("drillid/compiled.py", *(f"drillid/{room}/a.py" for room in ("physics", "fits/joint", "simulation")))
    old = ("requirements.lock", "scripts/drillid.sh", *sources)
    for age, names in enumerate((old, (".venv/ready",), (".venv/bin/drillid", ".venv/kernels"))):
        for name in names:
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch()
            os.utime(path, (1e9 + age, 1e9 + age))
    return tmp_path


def would_run(checkout: Path) -> str:
    done = subprocess.run(["make", "-n", "setup"], cwd=checkout, capture_output=True, text=True, check=True)
    return done.stdout


def test_kernels_that_are_newer_than_their_sources_are_left_alone(checkout: Path) -> None:
    assert COMPILES not in would_run(checkout)


@pytest.mark.parametrize("source", ["drillid/compiled.py", "drillid/fits/joint/a.py", "drillid/simulation/a.py"])
def test_kernels_are_made_again_after_an_edit_of_a_source(checkout: Path, source: str) -> None:
    (checkout / source).touch()
    assert would_run(checkout).count(COMPILES) == 1


def test_absent_kernels_are_made(checkout: Path) -> None:
    (checkout / ".venv/kernels").unlink()
    assert would_run(checkout).count(COMPILES) == 1

"""The workflow as a module of another one, fetched from a Git server, as snakedeploy writes it."""

import os
import subprocess
import sys
from pathlib import Path

from tests.workflow.toys import Checkout, jobs_in

MODULE = """
configfile: "config/config.yaml"

module drillid:
    snakefile:
        github("drillid/drillid", path="workflow/Snakefile", branch="main", host="git.example")
    config:
        config

use rule * from drillid
"""
"""What `snakedeploy deploy-workflow` writes into workflow/Snakefile, but for the server."""


def served(checkout: Checkout, place: Path) -> dict[str, str]:
    """Environment in which Git finds the checkout's files on that server."""
    git = ("git", "-C", str(checkout.root), "-c", "user.name=t", "-c", "user.email=t@git.example")
    for words in (["init", "-q", "-b", "main"], ["add", "workflow", "scripts", "envs"], ["commit", "-q", "-m", "all"]):
        subprocess.run([*git, *words], check=True)
    redirection = {"GIT_CONFIG_COUNT": "1", "GIT_CONFIG_VALUE_0": "https://git.example/drillid/drillid"}
    redirection["GIT_CONFIG_KEY_0"] = f"url.{checkout.root}.insteadOf"
    return os.environ | redirection | {"XDG_CACHE_HOME": str(place / "cache"), "PYTHONPATH": str(checkout.root)}


def test_the_workflow_runs_as_a_module_with_the_installed_library(checkout: Checkout, tmp_path: Path) -> None:
    checkout.sheets({"W1": ["a.csv"]})
    place = tmp_path / "deployed"
    (place / "workflow").mkdir(parents=True)
    (place / "workflow/Snakefile").write_text(MODULE)
    for name in ("config", "raw"):
        (checkout.root / name).rename(place / name)
    words = [sys.executable, "-m", "snakemake", "--cores", "1", "--until", "windows"]
    done = subprocess.run(
        words, cwd=place, env=served(checkout, tmp_path), capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert jobs_in(done.stdout + done.stderr) == ["records W1", "windows W1"]
    assert (place / "results/main/windows/W1/key.json").exists()

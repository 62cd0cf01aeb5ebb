"""The wheel: it holds library, template and workflow, and its command works where no checkout is."""

import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
UV = Path(sys.executable).parent / "uv"


def run(*command: object, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """A command in a folder, without the checkout on Python's path."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "NUMBA"))}
    words = list(map(str, command))
    return subprocess.run(words, cwd=folder, env=kept | environment, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    done = run(UV, "build", "--wheel", "--out-dir", folder, ROOT, folder=folder)
    if done.returncode and any(word in done.stderr for word in ("Failed to fetch", "error sending request", "offline")):
        pytest.skip(f"the build backend cannot be had here: {done.stderr.strip().splitlines()[-1]}")
    assert done.returncode == 0, done.stderr
    (path,) = folder.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A new environment with the wheel; what it depends on is lent by this one."""
    folder = tmp_path_factory.mktemp("installed") / "venv"
    venv.create(folder, symlinks=True)
    done = run(UV, "pip", "install", "--offline", "--no-deps", "--python", folder / "bin/python", wheel, folder=folder)
    assert done.returncode == 0, done.stderr
    (site,) = folder.glob("lib/python*/site-packages")
    (site / "lent.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return folder


def test_the_wheel_holds_library_template_and_workflow_and_no_tests(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    own = {path.relative_to(ROOT).as_posix() for path in (ROOT / "drillid").rglob("*.py")}
    assert own <= names
    checkout = {
        path for folder in ("workflow", "scripts", "envs") for path in (ROOT / folder).rglob("*") if path.is_file()
    }
    needed = {
        f"drillid/checkout/{path.relative_to(ROOT).as_posix()}" for path in checkout if "__pycache__" not in path.parts
    }
    assert needed | {"drillid/report/templates/well.html.j2", "drillid/checkout/Snakefile"} <= names
    assert not [name for name in names if name.startswith(("tests", "benchmarks", "docs")) or name.endswith(".pyc")]


def test_the_command_explains_itself(installed: Path, tmp_path: Path) -> None:
    done = run(installed / "bin/drillid", "--help", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    for command in ("run", "check", "init", "simulate"):
        assert f" {command} " in done.stdout


def test_the_templates_are_found(installed: Path, tmp_path: Path) -> None:
    code = (
        "import drillid; from drillid.report.rendering import _environment as environment; print(drillid.__file__);"
        "print(*(environment().get_template(name).name for name in ('fleet.html.j2', 'well.html.j2')))"
    )
    done = run(installed / "bin/python", "-c", code, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    place, _, names = done.stdout.partition("\n")
    assert Path(place).is_relative_to(installed)
    assert names.split() == ["fleet.html.j2", "well.html.j2"]


def test_a_configuration_is_laid_out_and_the_workflow_runs_from_there(installed: Path, tmp_path: Path) -> None:
    done = run(installed / "bin/drillid", "init", ".", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "config/wells.tsv").read_text().startswith("well\trig")
    kept = (tmp_path / "config/config.yaml").read_text() + "# mine\n"
    (tmp_path / "config/config.yaml").write_text(kept)
    run(installed / "bin/drillid", "init", ".", folder=tmp_path)
    assert (tmp_path / "config/config.yaml").read_text() == kept
    dry = run(
        installed / "bin/drillid", "run", "--dry-run", folder=tmp_path, PATH=f"{installed}/bin:{os.environ['PATH']}"
    )
    assert dry.returncode == 1, dry.stdout + dry.stderr
    assert "config/wells.tsv: lists no wells. Add a row for each well" in dry.stdout + dry.stderr

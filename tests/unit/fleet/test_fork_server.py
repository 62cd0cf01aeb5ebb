"""Jobs as children of one process: what they are given, how they end, and what ends with what."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from drillid.fleet.fork_server import modules_of_script, served
from drillid.fleet.stages import ALL_STAGES

ROOT = Path(__file__).parents[3]
LIMIT_S = 60.0
JOBS = """
import os, sys, time
from pathlib import Path

def tell(place):
    loaded = "drillid.records.stage" in sys.modules
    Path(place).write_text(f"{os.getpid()} {os.getppid()} {Path.cwd()} {os.environ['MARK']} {loaded}")
    print("said")

def fail():
    raise RuntimeError("on purpose")

def leave():
    sys.exit(7)

def wait(place):
    Path(place).write_text(str(os.getpid()))
    time.sleep(600)
"""
CLIENT = "import sys, json; from drillid.fleet.job import run_job; run_job(sys.argv[1], **json.loads(sys.argv[2]))"


@pytest.fixture(scope="module")
def jobs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with a module of jobs, where a server loads what the records take."""
    folder = tmp_path_factory.mktemp("jobs")
    (folder / "toy_jobs.py").write_text(JOBS)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", os.pathsep.join([str(folder), str(ROOT)]))
        with served(["records"]):
            yield folder


def job(folder: Path, function: str, arguments: str = "{}", **environment: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", CLIENT, f"toy_jobs:{function}", arguments],
        cwd=folder,
        env=os.environ | {"MARK": "own"} | environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def content(path: Path) -> str:
    """What a job writes, once it has."""
    until = time.monotonic() + LIMIT_S
    while not (path.exists() and path.read_text()):
        assert time.monotonic() < until, f"{path} was not written"
        time.sleep(0.02)
    return path.read_text()


def server_of_this_process() -> psutil.Process:
    return next(each for each in psutil.Process().children() if "drillid.fleet.fork_server" in each.cmdline())


def test_a_job_has_its_own_folder_environment_and_streams_and_what_it_takes_is_loaded(jobs: Path) -> None:
    done = job(jobs, "tell", '{"place": "told.txt"}')
    said, errors = done.communicate(timeout=LIMIT_S)
    assert (done.returncode, said, errors) == (0, "said\n", "")
    process, parent, *rest = content(jobs / "told.txt").split()
    assert int(process) != done.pid
    assert int(parent) == server_of_this_process().pid
    assert rest == [str(jobs), "own", "True"]


def test_a_job_that_fails_fails_its_script(jobs: Path) -> None:
    done = job(jobs, "fail")
    assert "RuntimeError: on purpose" in done.communicate(timeout=LIMIT_S)[1]
    assert done.returncode == 1
    done = job(jobs, "leave")
    done.communicate(timeout=LIMIT_S)
    assert done.returncode == 7


def test_a_killed_job_fails_its_script_and_a_killed_script_ends_its_job(jobs: Path) -> None:
    first = job(jobs, "wait", '{"place": "first.txt"}')
    os.kill(int(content(jobs / "first.txt")), signal.SIGKILL)
    assert "The job's process was killed" in first.communicate(timeout=LIMIT_S)[1]
    assert first.returncode == 1
    second = job(jobs, "wait", '{"place": "second.txt"}')
    worker = psutil.Process(int(content(jobs / "second.txt")))
    second.kill()
    second.communicate(timeout=LIMIT_S)
    assert not psutil.wait_procs([worker], timeout=LIMIT_S)[1]


@pytest.mark.parametrize("place", ["", f"{sys.prefix}:/nowhere", "/another/environment:{server}"])
def test_without_a_server_of_its_environment_a_job_works_in_its_script(jobs: Path, place: str) -> None:
    address = os.environ["DRILLID_FORK_SERVER"].rpartition(":")[2]
    done = job(jobs, "tell", '{"place": "alone.txt"}', DRILLID_FORK_SERVER=place.format(server=address))
    assert done.communicate(timeout=LIMIT_S)[0] == "said\n"
    assert int((jobs / "alone.txt").read_text().split()[0]) == done.pid


def test_jobs_go_on_without_a_server_that_has_died(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "toy_jobs.py").write_text(JOBS)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), str(ROOT)]))
    before = set(psutil.Process().children())
    with served(["windows"]):
        (server,) = set(psutil.Process().children()) - before
        server.suspend()
        waiting = job(tmp_path, "tell", '{"place": "told.txt"}')
        with contextlib.suppress(subprocess.TimeoutExpired):
            waiting.wait(timeout=1.0)
        server.kill()
        for done in (waiting, job(tmp_path, "tell", '{"place": "told.txt"}')):
            assert done.communicate(timeout=LIMIT_S)[0] == "said\n"
            assert done.returncode == 0
            assert int((tmp_path / "told.txt").read_text().split()[0]) == done.pid


def test_jobs_are_served_however_long_the_folder_for_temporary_files_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "toy_jobs.py").write_text(JOBS)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), str(ROOT)]))
    long = tmp_path / ("a" * 100)
    long.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(long))
    with served(["windows"]):
        done = job(tmp_path, "tell", '{"place": "told.txt"}')
        assert done.communicate(timeout=LIMIT_S)[0] == "said\n"
        assert int((tmp_path / "told.txt").read_text().split()[0]) != done.pid


def test_rules_without_python_start_no_server() -> None:
    before = psutil.Process().children()
    with served(["all", "well"]):
        assert psutil.Process().children() == before


def test_all_that_a_script_imports_is_loaded_ahead() -> None:
    handed_over = [script.stem for script in (ROOT / "scripts").glob("*.py") if "run_job(" in script.read_text()]
    assert {"report", "fleet", "simulate"} <= set(handed_over)
    for rule in handed_over:
        source = (ROOT / "scripts" / f"{rule}.py").read_text()
        used = set(re.findall(r"^ +from (drillid\.[\w.]+) import", source, re.MULTILINE))
        assert used
        assert used == set(modules_of_script(rule))


def test_a_stage_has_its_module_and_no_more() -> None:
    assert [modules_of_script(stage) for stage in ALL_STAGES] == [[]] * len(ALL_STAGES)
    assert modules_of_script("well") == []

"""`drillid run` killed at any moment, started twice, stopped, and with wells that fail: what it leaves, how it ends."""

import random
import shutil
import signal
import time
from pathlib import Path

import psutil
import pytest

from tests.workflow.killed import (
    digests,
    family,
    kill_some_process,
    make_started,
    run,
    started,
    undisturbed,
    write_wells,
)
from tests.workflow.toys import Checkout, new_checkout

POINTS = 4
"""`make bench-fleet` tries twenty, one run each."""
FIRST = ("--until", "records")


@pytest.fixture(scope="module")
def finished_wells(tmp_path_factory: pytest.TempPathFactory) -> tuple[Checkout, float]:
    """Three wells in one batch that went through all stages, and how long that took, s."""
    checkout = new_checkout(tmp_path_factory.mktemp("undisturbed"))
    write_wells(checkout, batch_size=25)
    duration = undisturbed(checkout)
    checkout.journal()
    return checkout, duration


@pytest.fixture
def wells(finished_wells: tuple[Checkout, float], tmp_path: Path) -> Checkout:
    """A copy of these wells with their results."""
    return Checkout(shutil.copytree(finished_wells[0].root, tmp_path / "checkout"))


def manifests(checkout: Checkout) -> dict[str, int]:
    """When each manifest was written."""
    results = checkout.root / "results/main"
    return {str(path.relative_to(results)): path.stat().st_mtime_ns for path in results.glob("*/*.json")}


def test_a_second_run_at_once_is_refused_and_a_signal_ends_all_processes_of_the_first(wells: Checkout) -> None:
    (wells.root / "raw/d.csv").write_text("slow")
    first = started(wells, *FIRST)
    until = time.monotonic() + 60
    while not (wells.root / "journal.txt").exists() and time.monotonic() < until:
        time.sleep(0.1)
    before = manifests(wells)
    for words in (FIRST, ("--config", "fits={starts: 3}")):
        second = run(wells, *words)
        assert second.returncode == 1
        assert "another run works on these results (process" in second.stderr
        assert manifests(wells) == before
    assert first.poll() is None
    processes = family(first)
    assert len(processes) > 3
    first.send_signal(signal.SIGTERM)
    first.communicate(timeout=30)
    assert first.returncode == 128 + signal.SIGTERM
    _, alive = psutil.wait_procs(processes, timeout=5)
    assert not alive
    (wells.root / "raw/d.csv").write_text("samples")
    assert run(wells, *FIRST).returncode == 0


def test_a_signal_to_make_ends_all_processes(wells: Checkout) -> None:
    (wells.root / "raw/d.csv").write_text("slow")
    running = make_started(wells, "run", "JOBS=3", "PROFILE=profile")
    until = time.monotonic() + 60
    while not (wells.root / "journal.txt").exists() and time.monotonic() < until:
        time.sleep(0.1)
    processes = family(running)
    assert any("--jobs 3" in " ".join(process.cmdline()) for process in processes)
    running.send_signal(signal.SIGTERM)
    running.communicate(timeout=30)
    assert running.returncode != 0
    _, alive = psutil.wait_procs(processes, timeout=5)
    assert not alive


def test_failed_wells_are_named_and_decide_the_exit_code(wells: Checkout) -> None:
    (wells.root / "raw/c.csv").write_text("bad")
    done = run(wells, *FIRST)
    assert done.returncode == 3
    assert "1 of 3 wells failed: W-2 (records: c.csv: is bad). See problems.csv for the remedies." in done.stderr
    # a plain line a stage where there is no terminal, and no banner of any job
    assert "records: 1 of 1 job(s) done, 1 well(s) failed\n" in done.stderr
    assert "rule records" not in done.stderr
    again = run(wells, *FIRST)
    assert again.returncode == 3
    assert "Nothing to be done" in again.stderr
    assert "1 of 3 wells failed: W-2 (records: c.csv: is bad). See problems.csv for the remedies." in again.stderr
    assert run(wells, *FIRST, "--no-strict").returncode == 0
    dry = run(wells, *FIRST, "--dry-run")
    assert dry.returncode == 0
    assert "wells failed" not in dry.stderr
    (wells.root / "raw/c.csv").write_text("samples")
    done = run(wells, *FIRST)
    assert done.returncode == 0
    assert "3 of 3 wells done." in done.stderr


def test_a_corrected_rig_description_is_noticed_wherever_it_was_wrong(wells: Checkout) -> None:
    """The records use only time and channels of it, but none of it is believed while a part is wrong."""
    rig = wells.root / "config/rigs/toy.yaml"
    right = rig.read_text()
    # as another description, that the wells are not what they were
    wrong = right.replace("RPM", "TURNS") + "pipe: {outer_diameter: 4 in, inner_diameter: 5 in}\n"
    rig.write_text(wrong)
    done = run(wells, *FIRST)
    assert done.returncode == 3
    assert "3 of 3 wells failed" in done.stderr
    corrected = wrong.replace("4 in", "5.5 in")
    rig.write_text(corrected)
    assert run(wells, *FIRST).returncode == 0
    assert len(wells.journal()) == 3
    rig.write_text(corrected.replace("5 in}", "4.9 in}"))
    assert run(wells, *FIRST).returncode == 0
    assert wells.journal() == []


def test_what_nobody_foresaw_is_tried_again_by_the_next_run(wells: Checkout) -> None:
    (wells.root / "raw/c.csv").write_text("crash")
    done = run(wells, *FIRST)
    assert done.returncode == 3
    assert "nobody foresaw this" in done.stderr
    wells.journal()
    assert run(wells, *FIRST).returncode == 3
    assert wells.journal() == ["records W-2"]


def test_a_damaged_key_is_no_key(wells: Checkout) -> None:
    (wells.root / "results/main/fits/W-2/key.json").write_text("")
    assert run(wells, "--until", "fits").returncode == 0
    assert wells.journal() == ["fits W-2"]


def test_a_fault_of_the_machine_fails_the_job_and_no_other_well(wells: Checkout) -> None:
    (wells.root / "raw/c.csv").write_text("full")
    (wells.root / "raw/d.csv").write_text("other samples")
    done = run(wells, *FIRST)
    assert done.returncode == 1
    assert "1 of 3 wells failed: W-2" in done.stderr
    assert sorted(wells.journal()) == ["records W-2", "records W3"]
    assert (wells.root / "results/main/records/W3/key.json").exists()
    (wells.root / "raw/c.csv").write_text("samples")
    assert run(wells, *FIRST).returncode == 0


def test_a_run_killed_at_any_moment_ends_as_an_undisturbed_one(finished_wells: tuple[Checkout, float]) -> None:
    """Any process of the run is killed outright, time and again; each next run takes up by itself."""
    wells, duration = finished_wells
    expected = digests(wells.root / "results/main")
    for folder in ("results", ".snakemake"):
        shutil.rmtree(wells.root / folder)
    draw = random.Random(4)
    for _ in range(POINTS):
        kill_some_process(wells, draw.uniform(0.3, 0.8) * duration, draw)
    last = run(wells)
    assert last.returncode == 0, last.stderr
    assert digests(wells.root / "results/main") == expected

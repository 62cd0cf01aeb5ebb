"""Faults of files, channels and stores through the real stages: a row each that the report shows, no other suffers.

Full disks and results that may not be written are in tests/unit/fleet/test_machine.py, killed processes and two runs at
once in test_kill.py, lost workers in test_dask.py.
"""

import gzip
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
import yaml

from drillid.config.settings import Settings
from drillid.datasets.tables import write_table
from drillid.depth.changes import write_changes
from drillid.depth.fleet import write_fleet
from drillid.errors import LogError
from drillid.fleet.outcome import failed_wells
from drillid.fleet.run import collect_problems, drop_damaged, run_stage
from drillid.formats import read_log
from drillid.report.page import write_report
from tests.raw_logs import RIG, drilling, save

WELL = drilling(90.0)
STAGES = ("records", "windows", "spectra")
SECTIONS = {"windows": {"length_s": 85.0, "shortest_share": 0.9}}


def broken(change: Callable[[pd.DataFrame], pd.DataFrame]) -> Callable[[Path], None]:
    """A log that is sound but for a change of its table."""
    return lambda path: save(change(WELL.copy()), path) and None


def holes(log: pd.DataFrame) -> pd.DataFrame:
    log.loc[np.random.default_rng(3).random(len(log)) < 0.5, "RPM"] = np.nan
    return log


def cut(path: Path) -> None:
    """A file that a broken line left half copied, of whatever format its name says."""
    content = save(WELL, path.with_name(f"whole{path.suffix}")).read_bytes() if path.suffix == ".parquet" else b""
    content = content or gzip.compress(WELL.to_csv(index=False).encode())
    path.write_bytes(content[: 2 * len(content) // 3])


WELLS: dict[str, tuple[str, Callable[[Path], object], str]] = {
    "Good": ("a.csv", broken(lambda log: log), ""),
    "Corrupt": ("b.csv", broken(lambda log: log), "has changed"),
    "NoSpeed": ("c.csv", broken(lambda log: log.assign(RPM=np.nan)), "column 'RPM' holds no values"),
    "HalfSpeed": ("d.csv", broken(holes), "rows hold no speed"),
    "Absurd": ("e.csv", broken(lambda log: log.assign(SWEEP=log["SWEEP"] * 1e6)), "outside -200000 to 200000 N m"),
    "Short": ("f.csv", broken(lambda log: log[:1000]), "no window of steady drilling with the sweep on was found"),
    "Folder": ("g.csv", Path.mkdir, "is a folder, not a log file"),
    "Binary": ("h.csv", lambda path: path.write_bytes(bytes(range(256)) * 40), "its content is not text"),
    "CutParquet": ("i.parquet", cut, "cannot be read"),
    "CutGzip": ("j.csv.gz", cut, "cannot be read"),
}
"""A log each, and words of the row that it must leave."""


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of all wells up to the spectra, tables and report; Corrupt's records are damaged once they are made."""
    folder = tmp_path_factory.mktemp("fleet")
    listed(folder, {well: log for well, (log, _, _) in WELLS.items()})
    for log, write, _ in WELLS.values():
        write(folder / log)
    settings = settings_in(folder)
    results = Path(settings.results)
    run_stage("records", list(WELLS), settings)
    chunk = next(
        path for path in sorted((results / "records/Corrupt/records.zarr/speed").rglob("*")) if path.name == "0"
    )
    content = bytearray(chunk.read_bytes())
    content[len(content) // 2] ^= 1
    chunk.write_bytes(bytes(content))
    for stage in STAGES[1:]:
        run_stage(stage, list(WELLS), settings)
    drop_damaged(results, list(WELLS))
    write_fleet(results, list(WELLS))
    problems = collect_problems(results, list(WELLS))
    write_table(problems, results / "problems.csv")
    write_changes(results, list(WELLS), problems, failed_wells(results, list(WELLS)))
    write_report(settings, results, list(WELLS))
    return results


def listed(folder: Path, logs: dict[str, str]) -> None:
    """Sheets of wells with a log each, and their rig."""
    (folder / "rigs").mkdir()
    (folder / "rigs/r.yaml").write_text(yaml.safe_dump(RIG.model_dump(mode="json", exclude_unset=True)))
    (folder / "wells.tsv").write_text("well\trig\n" + "".join(f"{well}\tr\n" for well in logs))
    (folder / "logs.tsv").write_text("well\tlog\n" + "".join(f"{well}\t{folder / log}\n" for well, log in logs.items()))


def settings_in(folder: Path) -> Settings:
    places = {"wells": "wells.tsv", "logs": "logs.tsv", "rigs": "rigs", "results": "results"}
    return Settings.checked(SECTIONS | {name: str(folder / place) for name, place in places.items()}, "faults")


@pytest.mark.parametrize("well", [well for well in WELLS if well != "Good"])
def test_a_fault_is_a_row_that_the_report_shows(fleet: Path, well: str) -> None:
    problems = pd.read_csv(fleet / "problems.csv")
    own = problems[problems["well"] == well]
    words = WELLS[well][2]
    assert own["what"].str.contains(words, regex=False).any(), own["what"].tolist()
    assert own["remedy"].notna().all()
    assert not own["remedy"].str.contains("A fault in the program").any(), own["what"].tolist()
    page = (fleet / f"report/{well}.html").read_text()
    assert words in page.replace("&#39;", "'")
    assert well in (fleet / "report.html").read_text()


def test_the_sound_well_is_as_if_it_were_alone(fleet: Path, tmp_path: Path) -> None:
    assert not (pd.read_csv(fleet / "problems.csv")["well"] == "Good").any()
    listed(tmp_path, {"Good": "a.csv"})
    WELLS["Good"][1](tmp_path / "a.csv")
    for stage in STAGES:
        run_stage(stage, ["Good"], settings_in(tmp_path))
    for stage in STAGES:
        with (
            xr.open_zarr(fleet / stage / f"Good/{stage}.zarr") as among,
            xr.open_zarr(tmp_path / "results" / stage / f"Good/{stage}.zarr") as alone,
        ):
            assert among.identical(alone)


def test_damaged_records_are_made_again_by_the_next_run(fleet: Path) -> None:
    settings = settings_in(fleet.parent)
    ended = {outcome.well: outcome.status for outcome in run_stage("records", ["Good", "Corrupt"], settings)}
    assert ended == {"Good": "kept", "Corrupt": "done"}
    (again,) = run_stage("windows", ["Corrupt"], settings)
    assert again.status == "done"


def test_a_log_without_permission_is_told_as_such(tmp_path: Path) -> None:
    log = save(WELL[:100], tmp_path / "log.csv")
    # loads what another user may not be allowed to
    read_log(log, "Time", ["RPM"])
    log.chmod(0)
    tmp_path.chmod(0o755)
    user = os.geteuid()
    try:
        if user == 0:
            os.seteuid(65534)
        with pytest.raises(LogError, match=r"log\.csv: is not readable\. Ask for permission"):
            read_log(log, "Time", ["RPM"])
    finally:
        os.seteuid(user)


LIMITED = """
import resource, sys
from pathlib import Path
from drillid.fleet.run import process_well, run_stage, tasks_of
from tests.workflow.test_faults import settings_in

settings = settings_in(Path(sys.argv[1]))
# all that is imported is there before the limit
assert process_well(tasks_of("records", ["Warm"], settings)[0]).status == "done"
pages = int(Path("/proc/self/statm").read_text().split()[0])
limit = pages * resource.getpagesize() + 400 * 2**20
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
run_stage("records", ["First", "Huge", "Last"], settings)
"""


def test_a_log_too_large_for_the_memory_fails_the_job_after_the_other_wells(tmp_path: Path) -> None:
    listed(tmp_path, {"Warm": "w.parquet", "First": "a.parquet", "Huge": "huge.parquet", "Last": "b.parquet"})
    for name in ("w", "a", "b"):
        save(WELL[:1000], tmp_path / f"{name}.parquet")
    rows = 5_000_000
    stamps = pd.Timestamp("2025-03-03", tz="UTC") + pd.to_timedelta(np.arange(rows) * 20, unit="ms")
    huge = pd.DataFrame({name: np.ones(rows) for name in WELL.columns}).assign(Time=stamps)
    huge.to_parquet(tmp_path / "huge.parquet")
    command = [sys.executable, "-c", LIMITED, str(tmp_path)]
    done = subprocess.run(command, cwd=Path(__file__).parents[2], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "OSError: Huge:" in done.stderr
    row = pd.read_csv(tmp_path / "results/records/Huge/problems.csv").iloc[0]
    assert "memory" in row["what"].lower() + row["remedy"].lower()
    for well in ("First", "Last"):
        assert (tmp_path / f"results/records/{well}/key.json").exists()

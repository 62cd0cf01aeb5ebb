"""The profile for every night, and its examples for cron and systemd."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from drillid.config.settings import Settings, SimulateSettings
from drillid.demo.wells import write_demo_log
from drillid.fleet.stages import STAGES
from tests.nights import files, night
from tests.workflow.toys import ROOT, Checkout

PROFILE = "workflow/profiles/nightly"
FOLDER = ROOT / PROFILE


def test_a_night_works_on_the_wells_with_new_logs(checkout: Checkout) -> None:
    checkout.sheets({"W1": ["a.csv"], "W2": ["b.csv"]})
    checkout.run("--workflow-profile", PROFILE, "--until", "records")
    checkout.journal()
    checkout.sheets({"W1": ["a.csv", "c.csv"], "W2": ["b.csv"]})
    checkout.run("--workflow-profile", PROFILE, "--until", "records")
    assert checkout.journal() == ["records W1"]


def test_a_night_works_on_the_wells_whose_pattern_matches_new_logs(checkout: Checkout) -> None:
    checkout.sheets({"W1": ["w1_a.csv"], "W2": ["w2_a.csv"]})
    (checkout.root / "config/logs.tsv").write_text("well\tlog\nW1\traw/w1_*.csv\nW2\traw/w2_*.csv\n")
    checkout.run("--workflow-profile", PROFILE, "--until", "records")
    checkout.journal()
    (checkout.root / "raw/w2_b.csv").write_text("samples")
    checkout.run("--workflow-profile", PROFILE, "--until", "records")
    assert checkout.journal() == ["records W2"]


def test_a_well_that_grows_ends_in_every_stage_as_if_all_logs_had_come_at_once(tmp_path: Path) -> None:
    rig, logs = (
        ROOT / "config/demo/rigs/charlie.yaml",
        [tmp_path / f"D03_20250601T0{6 + hour}00.csv" for hour in range(3)],
    )
    for stand, path in enumerate(logs):
        write_demo_log("D03", stand, path, SimulateSettings(drilling_s=320.0, connection_s=60.0))
    settings = Settings.checked({"windows": {"length_s": 300.0}, "figures": {"dpi": 60}}, "test")
    for results, nights in (("grown", (logs[:2], logs)), ("at once", (logs,))):
        for known in nights:
            assert night(tmp_path / results, rig, known, list(STAGES), settings) == ["done"] * len(STAGES)
    grown, at_once = (files(tmp_path / results, list(STAGES)) for results in ("grown", "at once"))
    assert [name for name in at_once if grown.get(name) != at_once[name]] == []
    assert grown.keys() == at_once.keys()


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="needs systemd-analyze")
def test_the_units_are_valid(tmp_path: Path) -> None:
    command = tmp_path / "drillid/.venv/bin/drillid"
    command.parent.mkdir(parents=True)
    command.touch(mode=0o755)
    for name in ("drillid.service", "drillid.timer"):
        text = (FOLDER / name).read_text().replace("/srv/drillid", str(tmp_path / "drillid"))
        (tmp_path / name).write_text(text.replace("User=drilling", "User=root"))
    units = [str(tmp_path / name) for name in ("drillid.service", "drillid.timer")]
    checked = subprocess.run(["systemd-analyze", "verify", *units], capture_output=True, text=True, check=False)
    assert checked.returncode == 0, checked.stderr
    assert str(tmp_path) not in checked.stderr


def test_cron_and_systemd_start_the_same_command() -> None:
    command = re.search(r"ExecStart=/srv/drillid/(.*)", (FOLDER / "drillid.service").read_text())
    lines = [line for line in (FOLDER / "crontab").read_text().splitlines() if line[:1].isdigit()]
    assert command is not None
    assert [line.split(maxsplit=5)[5] for line in lines] == [f"cd /srv/drillid && {command[1]}"]
    assert command[1].endswith(f"drillid run --profile {PROFILE}")
    assert all(re.fullmatch(r"[\d*/,-]+", field) for line in lines for field in line.split(maxsplit=5)[:5])

"""The profile for every night, and its examples for cron and systemd."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

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

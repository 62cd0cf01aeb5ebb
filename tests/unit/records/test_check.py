"""`drillid check` names whatever a run would reject, in one go, and writes nothing."""

from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

from drillid.commands import app
from drillid.records.check import Checked, Finding, check
from tests.workflow.toys import RIG

LOG = "Time,SWEEP,RPM,DMEA\n" + "".join(f"2025-03-03T06:00:{s:02d}Z,1.0,120,{2000 + s / 100}\n" for s in range(60))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A configuration with one good well."""
    (tmp_path / "rigs").mkdir()
    (tmp_path / "rigs/toy.yaml").write_text(RIG)
    (tmp_path / "good.csv").write_text(LOG)
    places = "".join(f"{name}: {tmp_path}/{name}{ending}\n" for name, ending in PLACES.items())
    (tmp_path / "config.yaml").write_text(places)
    sheets(tmp_path, [("34/10-A-12 H", "toy", "good.csv")])
    return tmp_path


PLACES = {"wells": ".tsv", "logs": ".tsv", "rigs": "", "results": ""}


def sheets(folder: Path, rows: list[tuple[str, str, str]]) -> None:
    """A well a row with its rig and its log."""
    (folder / "wells.tsv").write_text("well\trig\n" + "".join(f"{well}\t{rig}\n" for well, rig, _ in rows))
    logs = [f"{well}\t{folder}/{log}\n" for well, _, log in rows if log]
    (folder / "logs.tsv").write_text("well\tlog\n" + "".join(logs))


def findings(folder: Path) -> list[Finding]:
    return list(check(folder / "config.yaml", Checked()))


def test_a_sound_configuration_has_no_findings_and_nothing_is_written(folder: Path) -> None:
    before = sorted(folder.rglob("*"))
    checked = Checked()
    assert [each for each in check(folder / "config.yaml", checked) if each.fails] == []
    assert checked == Checked(1, 1, 1)
    assert sorted(folder.rglob("*")) == before


def test_faults_of_all_kinds_are_named_at_once(folder: Path) -> None:
    (folder / "rigs/swapped.yaml").write_text(RIG + "pipe: {outer_diameter: 108.6 mm, inner_diameter: 127 mm}\n")
    (folder / "rigs/other.yaml").write_text(RIG.replace("RPM, unit", "ROTARY, unit"))
    (folder / "empty.csv").touch()
    (folder / "late.csv").write_text(LOG.replace("06:00:30", "half past"))
    rows = [("A", "toy", "good.csv"), ("B", "swapped", "b.csv"), ("C", "missing", "c.csv"), ("D", "other", "good2.csv")]
    rows += [("E", "toy", "empty.csv"), ("F", "toy", "none.csv"), ("G", "toy", "late.csv"), ("H", "toy", "")]
    (folder / "good2.csv").write_text(LOG)
    sheets(folder, [*rows, ("a", "toy", "x.csv")])
    with (folder / "logs.tsv").open("a") as sheet:
        sheet.write("A\t/etc/hostname\nZ\tz.csv\n")
    found = [f"{each.where}: {each.what}" for each in findings(folder) if each.fails]
    expected = [
        "log '/etc/hostname' lies in /etc",
        "outer 108.6 mm is smaller than inner 127 mm",
        "rig 'missing' has no description",
        "has no column 'ROTARY'",
        "is empty",
        "does not exist",
        "half past",
        "well 'H' has no logs",
        "wells 'A' and 'a' would share the folder",
        "log of the unknown well 'Z'",
    ]
    assert len(found) == len(expected), found
    for what, finding in zip(expected, found, strict=True):
        assert what in finding


def test_a_well_whose_only_log_is_refused_is_not_said_to_have_none(folder: Path) -> None:
    sheets(folder, [("A", "toy", "good.csv"), ("B", "toy", "good.csv")])
    (told,) = (each for each in findings(folder) if each.fails)
    assert "is already listed at" in told.what


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("wells: a\nwells: b\n", "the key 'wells' is already given in line 1"),
        ("- a\n", "holds no keys"),
        ("fits: 3\n", "fits"),
    ],
)
def test_a_configuration_that_cannot_be_used_is_one_finding(folder: Path, text: str, what: str) -> None:
    (folder / "config.yaml").write_text(text)
    (found,) = findings(folder)
    assert found.fails
    assert what in found.what


def test_a_unit_that_the_file_states_otherwise_is_told_and_the_description_may_be_preferred(folder: Path) -> None:
    (folder / "good.csv").write_text(LOG.replace("DMEA\n", "DMEA\n,kN.m,rpm,ft\n", 1))
    (told,) = (each for each in findings(folder) if each.fails)
    assert told.where.endswith("good.csv, column 'DMEA'")
    assert told.what == "has the unit 'ft' in the file, but 'm' in the rig description"
    (folder / "rigs/toy.yaml").write_text(RIG + "file: {ignore_units: true}\n")
    assert not any(each.fails for each in findings(folder))


def test_the_lack_of_controller_and_torque_command_is_told_where_no_log_holds_it(folder: Path) -> None:
    toy = yaml.safe_load(RIG)
    toy.pop("controller")
    (folder / "rigs/toy.yaml").write_text(yaml.safe_dump(toy))
    (told,) = (each for each in findings(folder) if each.fails)
    assert told.what.startswith("states no controller, and no log of the well '34/10-A-12 H' holds torque_command")
    (folder / "good.csv").write_text(LOG.replace("RPM", "TQA (kN.m),RPM").replace(",120,", ",7.5,120,"))
    assert not any(each.fails for each in findings(folder))


def test_logs_that_others_leave_nothing_of_or_not_all_are_told(folder: Path) -> None:
    (folder / "resent.csv").write_text(LOG.replace(",1.0,", ",1.1,"))
    (folder / "later.csv").write_text(LOG.replace("T06:00:", "T06:01:").replace("T06:01:0", "T06:00:5"))
    with (folder / "logs.tsv").open("a") as sheet:
        sheet.writelines(f"34/10-A-12 H\t{folder}/{name}.csv\n" for name in ("resent", "later"))
    told = [(Path(each.where).name, each.what, each.fails) for each in findings(folder) if "time of" in each.what]
    assert told == [("resent.csv", "lies entirely within the time of the logs up to 'good.csv' and is not used", True)]
    (part,) = (each for each in findings(folder) if "before the end of 'good.csv'" in each.what)
    assert (Path(part.where).name, part.fails) == ("later.csv", False)


def test_the_command_prints_a_row_a_finding_and_its_exit_code_says_whether_a_run_would_fail(folder: Path) -> None:
    sound = CliRunner().invoke(app, ["check", str(folder / "config.yaml")])
    assert sound.exit_code == 0, sound.output
    (folder / "good.csv").unlink()
    failing = CliRunner().invoke(app, ["check", str(folder / "config.yaml")])
    assert failing.exit_code == 1
    assert failing.stdout.splitlines() == [
        f"fails\t{folder}/good.csv\tdoes not exist\tCorrect its path",
    ]
    assert failing.stderr.splitlines() == [
        "1 well, 1 rig and 1 log checked: 1 problem would make a log, a well or the whole run fail. "
        "Correct each row marked 'fails' as its remedy says, and check again"
    ]
    assert CliRunner().invoke(app, ["check", "--no-logs", str(folder / "config.yaml")]).exit_code == 0

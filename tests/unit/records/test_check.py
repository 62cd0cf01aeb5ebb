"""`drillid check` names whatever a run would reject, in one go, and writes nothing."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from typer.testing import CliRunner

from drillid.commands import app
from drillid.records.check import Checked, Finding, check
from tests.raw_logs import RIG as MADE_UP
from tests.raw_logs import START, drilling, save
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


def test_what_a_run_refuses_once_rows_have_their_places_is_told(tmp_path: Path, folder: Path) -> None:
    """Channels that contradict each other, stamps that are too coarse, another rate."""
    (folder / "rigs/made_up.yaml").write_text(yaml.safe_dump(MADE_UP.model_dump(mode="json", exclude_none=True)))
    sound, coarse = drilling(400.0), drilling(60.0)
    coarse["Time"] = coarse["Time"].dt.floor("s") + pd.to_timedelta(np.arange(len(coarse)) % 37 // 11, unit="s")
    logs = {
        "sound": sound,
        "slower": drilling(400.0, start=START + pd.Timedelta(seconds=400)).iloc[::2],
        "feet": sound.assign(BIT=sound["BIT"] * 0.3048),
        "coarse": coarse.sort_values("Time", kind="stable"),
    }
    rows = [("A", "made_up", "sound.csv"), ("B", "made_up", "feet.csv"), ("C", "made_up", "coarse.csv")]
    for name, log in logs.items():
        save(log, folder / f"{name}.csv")
    sheets(folder, rows)
    with (folder / "logs.tsv").open("a") as sheet:
        sheet.write(f"A\t{folder}/slower.csv\n")
    told = [(Path(each.where).stem, each.what) for each in findings(folder) if each.fails]
    expected = [
        ("slower", "is sampled at 25 Hz, the well's other logs at 50 Hz"),
        ("feet", "the hole deepens while the bit is "),
        ("coarse", "its time stamps are coarser than its samples"),
    ]
    assert [name for name, _ in told] == [name for name, _ in expected], told
    for (_, what), (_, start) in zip(told, expected, strict=True):
        assert what.startswith(start)


WELL = """
top_drive: {inertia: 2000 kg m^2, proportional: 30e3 N m s/rad}
pipe: {outer_diameter: 5 in, inner_diameter: 4.276 in}
assembly: [{length: 100 m, outer_diameter: 6.5 in, inner_diameter: 2.8125 in}]
friction: {sliding: 0.2}
"""


def start_ups(folder: Path, *rows: str) -> None:
    """A sheet of starts of rotation beside the wells, with one's files."""
    (folder / "well.yaml").write_text(WELL)
    (folder / "survey.csv").write_text("depth_m,inclination_deg\n0,0\n900,40\n")
    samples = "".join(f"{time / 100},{time / 10},1\n" for time in range(100))
    (folder / "start.csv").write_text(f"t_s,td_rpm_measured,torque_knm_measured\n{samples}")
    head = "start_up\tdescription\tsurvey\tlog\tdepth_m\tfitted\n"
    (folder / "starts.tsv").write_text(head + "".join(f"{row.replace('@', str(folder))}\n" for row in rows))
    with (folder / "config.yaml").open("a") as configuration:
        configuration.write(f"start_up_sheet: {folder}/starts.tsv\n")


def test_sound_starts_of_rotation_have_no_findings(folder: Path) -> None:
    start_ups(folder, "A\t@/well.yaml\t@/survey.csv\t@/start.csv\t700\tsliding")
    checked = Checked()
    assert [each for each in check(folder / "config.yaml", checked) if each.fails] == []
    assert str(checked) == "1 well, 1 rig, 1 log and 1 start of rotation checked"


def test_faults_of_starts_of_rotation_are_named_as_their_stage_does(folder: Path) -> None:
    start_ups(
        folder,
        "A\t@/well.yaml\t@/survey.csv\t@/start.csv\t-5",
        "B\t@/no.yaml\t@/no-survey.csv\t@/no.csv\t700",
        "C\t@/well.yaml\t@/survey.csv\t@/start.csv\t700\tslide",
        "D\t@/well.yaml\t@/survey.csv\t@/start.csv\t2700",
        "E\t@/well.yaml\t@/survey.csv\t/etc/hostname\t700",
        "F\t@/well.yaml\t@/one.csv\t@/start.csv\t700",
    )
    (folder / "one.csv").write_text("depth_m,inclination_deg\n0,0\n")
    found = [f"{each.where}: {each.what}" for each in findings(folder) if each.fails]
    expected = ["starts.tsv, row 2: 'depth_m'", "no.yaml", "no-survey.csv", "no.csv"]
    expected += ["'C': fit of a start of rotation: ['slide']"]
    expected += ["starts.tsv, 'D': survey: it covers 0", "/etc/hostname", "one.csv: it needs two or more stations"]
    assert len(found) == len(expected), found
    for what, finding in zip(expected, found, strict=True):
        assert what in finding
    without_logs = [each.where for each in check(folder / "config.yaml", Checked(), logs=False)]
    assert not any(where.endswith("no.csv") for where in without_logs)
    assert any(where.endswith("no-survey.csv") for where in without_logs)


def test_a_sheet_of_starts_that_cannot_be_used_is_told_beside_the_wells(folder: Path) -> None:
    start_ups(folder)
    (folder / "starts.tsv").unlink()
    (folder / "good.csv").unlink()
    assert [each.what.split(" (")[0] for each in findings(folder)] == ["does not exist", "cannot be read"]
    (folder / "wells.tsv").unlink()
    assert [Path(each.where).name for each in findings(folder)] == ["wells.tsv", "starts.tsv"]


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


def test_a_weight_of_what_is_no_cause_is_found_before_a_run(folder: Path) -> None:
    with (folder / "config.yaml").open("a") as configuration:
        configuration.write("discrepancy: {cause_weights: {drive_lagg: 5}}\n")
    failing = CliRunner().invoke(app, ["check", "--no-logs", str(folder / "config.yaml")])
    assert failing.exit_code == 1
    assert "no cause is called drive_lagg\tDid you mean 'drive_lag'?" in failing.stdout

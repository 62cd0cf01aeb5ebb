"""The command line: what it writes, and what it says where it cannot."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import drillid
from drillid.commands import app
from drillid.config.settings import Settings
from drillid.errors import SettingsError
from drillid.fleet.command import RunOutcome
from drillid.simulation.start_up_files import COLUMNS, ramped_speed
from drillid.units import RPM

WELL = "benchmarks/field/well_b.yaml"
SURVEY = "depth_m,inclination_deg\n0,0\n300,0\n700,40\n2700,45\n"


@pytest.fixture
def survey(tmp_path: Path) -> Path:
    path = tmp_path / "survey.csv"
    path.write_text(SURVEY)
    return path


def call(*arguments: object) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, ["simulate", "start-up", WELL, *map(str, arguments)])
    assert result.exception is None or isinstance(result.exception, SystemExit)
    return result.exit_code, result.stdout, result.stderr


def test_a_ramp_is_simulated_and_written(survey: Path, tmp_path: Path) -> None:
    output = tmp_path / "deep" / "out.csv"
    code, said, _ = call("--depth", 900, "--survey", survey, "--duration", 20, "--rpm", 60, "--output", output)
    assert code == 0
    assert "900 m" in said
    assert str(output) in said
    table = pd.read_csv(output)
    assert tuple(table.columns) == COLUMNS
    np.testing.assert_allclose(np.diff(table["t_s"]), 0.01, atol=1e-6)
    np.testing.assert_allclose(table["td_rpm"], ramped_speed(60, 15, 20)[: len(table)] / RPM, atol=1e-3)
    assert table["torque_knm"].max() > 1.0
    assert f"{table['torque_knm'].max():.1f} kN m" in said
    np.testing.assert_allclose(table["bit_rpm"][25:], table["bit_rpm_now"][:-25], atol=1e-3)


def test_a_given_speed_is_followed_and_its_times_are_kept(survey: Path, tmp_path: Path) -> None:
    speed, output = tmp_path / "speed.csv", tmp_path / "out.csv"
    time = np.arange(0, 12, 0.02)
    pd.DataFrame({"t_s": 100 + time, "td_rpm_measured": np.clip((time - 2) * 8, 0, 50)}).to_csv(speed, index=False)
    code, _, _ = call("--depth", 900, "--survey", survey, "--top-speed", speed, "--output", output)
    assert code == 0
    table = pd.read_csv(output)
    assert table["t_s"].iloc[0] == 100.0
    assert table["t_s"].iloc[1] == pytest.approx(100.01)
    assert table["td_rpm"].iloc[-1] == pytest.approx(50.0)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("t_s,rpm\n0,0\n", "td_rpm_measured"),
        ("t_s,td_rpm_measured\n0,0\n1,0\n", "0.1 s"),
        ("t_s,td_rpm_measured\n0,0\n0.01,\n", "missing"),
        ("t_s,td_rpm_measured\n0,60\n0.01,60\n", "60.0 rpm"),
        ("t_s,td_rpm_measured\n0,0\n0.01,fast\n", "not numbers"),
    ],
)
def test_a_speed_that_cannot_be_followed_is_refused(content: str, said: str, survey: Path, tmp_path: Path) -> None:
    speed = tmp_path / "speed.csv"
    speed.write_text(content)
    code, _, told = call("--depth", 900, "--survey", survey, "--top-speed", speed)
    assert code == 1
    assert str(speed) in told
    assert said in told


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["init", "README.md"], "it cannot be written"),
        (["inspect", "README.md", "--output", "config"], "config: it cannot be written: it is a folder"),
        (["inspect", "README.md", "--output", "README.md/x.yaml"], "it cannot be written"),
        (["draw", "D01", "parameters", "--output", "config"], "config: it cannot be written: it is a folder"),
        (["draw", "D01", "parameters", "--output", "p.png", "--dpi", "0"], "--dpi"),
    ],
)
def test_outputs_that_cannot_be_are_refused(words: list[str], said: str) -> None:
    result = CliRunner().invoke(app, words)
    assert result.exit_code in (1, 2)
    assert isinstance(result.exception, SystemExit)
    assert said in " ".join(result.stderr.replace("│", " ").split())


def test_a_port_that_is_taken_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        raise OSError(98, "Address already in use")

    monkeypatch.setattr("drillid.report.explorer.start", refused)
    monkeypatch.setattr("drillid.report.explorer.wells", lambda _: {"W1": None})
    monkeypatch.setattr("drillid.commands.results._settings", lambda _: None)
    result = CliRunner().invoke(app, ["view", "results", "--port", "8080", "--no-browser"])
    assert result.exit_code == 1
    assert "port 8080: [Errno 98] Address already in use. Give another --port" in result.stderr


def test_depths_and_files_that_cannot_be_are_refused(survey: Path, tmp_path: Path) -> None:
    assert call("--depth", 100, "--survey", survey)[0] == 1
    code, _, told = call("--depth", 5000, "--survey", survey)
    assert code == 1
    assert "survey" in told
    code, _, told = call("--depth", 900, "--survey", tmp_path / "none.csv")
    assert code == 1
    assert "none.csv" in told
    assert call("--survey", survey)[0] == 2
    assert call("--depth", "nan", "--survey", survey)[0] == 2


def test_every_command_has_help_with_an_example() -> None:
    listed = CliRunner().invoke(app, ["--help"])
    for command in ("run", "demo", "init", "check", "explain", "fit", "tune", "blind"):
        assert f" {command} " in listed.stdout
        if command != "blind":
            assert "Example: drillid" in CliRunner().invoke(app, [command, "--help"]).stdout


def test_the_proof_needs_a_checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["blind"])
    assert result.exit_code == 1
    assert "checkout" in result.stderr


def test_help_of_the_proof_needs_no_checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["blind", "--help"])
    assert result.exit_code == 0
    assert "Example: drillid blind" in result.stdout


def test_the_version_is_printed() -> None:
    assert CliRunner().invoke(app, ["--version"]).stdout == f"drillid {drillid.__version__}\n"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["none.csv"], "none.csv: does not exist. Correct its path"),
        (["."], ".: is a folder, not a log file. Name the files in it"),
        (["README.md", "--plot", "mobility.bmp"], "mobility.bmp: is not a figure file. End its name in one of"),
        (["README.md", "--plot", "README.md/mobility.png"], "README.md/mobility.png: it cannot be written"),
        (["README.md", "--table", "config"], "config: it cannot be written: it is a folder. Give another path"),
    ],
)
def test_what_a_fit_cannot_use_is_refused_before_anything_is_computed(words: list[str], said: str) -> None:
    result = CliRunner().invoke(app, ["fit", *words, "--rig", "config/demo/rigs/bravo.yaml"])
    assert result.exit_code == 1
    assert said in result.stderr


def test_a_first_use_says_why_it_takes_long(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drillid.compiled.is_compiled", lambda *_: False)
    log, rig = tmp_path / "log.csv", tmp_path / "rig.yaml"
    log.write_text("")
    result = CliRunner().invoke(app, ["fit", str(log), "--rig", str(rig)])
    assert "compiling its kernels, once after installation" in result.stderr
    assert "rig.yaml" in result.stderr


@pytest.mark.parametrize(
    ("words", "reader"),
    [
        (["draw", "W1", "evidence", "--output", "a.pdf", "--configfile"], "drillid.figures.data.stored_results"),
        (["report", "--configfile"], "drillid.config.sheets.read_sheets"),
        (["view", "--no-browser"], "drillid.report.explorer.wells"),
        (["fit", "a.csv", "--rig", "rig.yaml", "--configfile"], "drillid.identification.identify"),
        (["tune", "a.csv", "--rig", "rig.yaml", "--configfile"], "drillid.identification.identify"),
        (["inspect", "a.csv", "--configfile"], "drillid.inspection.inspect.inspect"),
        (["check"], "drillid.records.check.read_sheets"),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else "",
)
def test_every_command_reads_the_configuration_that_a_run_would(
    words: list[str], reader: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "config").mkdir()
    (tmp_path / "config/config.yaml").write_text("results: here\nwindows: {length_s: 300, overlap: 0.5}\n")
    (tmp_path / "config/other.yaml").write_text("windows: {length_s: 200}\n")
    (tmp_path / "here").mkdir()
    for name in ("a.csv", "here/problems.csv"):
        (tmp_path / name).touch()
    found: list[Settings] = []

    def noted(*given: object) -> None:
        for each in given:
            found.extend(part for part in (each.values() if isinstance(each, dict) else [each]) if is_settings(part))
        raise SettingsError("a test", "needs no more", "Go on")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(reader, noted)
    monkeypatch.setattr("drillid.compiled.is_compiled", lambda *_: True)
    result = CliRunner().invoke(app, [*words, "config/other.yaml"])
    assert "a test" in result.output, result.output
    assert [(each.results, each.windows.length_s, each.windows.overlap) for each in found] == [("here", 200, 0.5)]


def is_settings(value: object) -> bool:
    return isinstance(value, Settings)


def test_a_run_tells_programs_how_it_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    wells = {"wells": 2, "failed": {"W1": "records: a.csv: is empty"}, "unfinished": [], "line": "1 of 2 wells failed"}
    monkeypatch.setattr("drillid.fleet.command.run", lambda *_: RunOutcome(3, wells))
    done = CliRunner().invoke(app, ["run", "--json"])
    assert done.exit_code == 3
    assert json.loads(done.stdout) == {"exit_code": 3, **wells}


@pytest.mark.parametrize("command", [command.name for command in app.registered_commands if command.name != "blind"])
def test_every_command_has_an_example(command: str) -> None:
    said = CliRunner().invoke(app, [command, "--help"]).stdout
    assert f"Example: drillid {command}" in said

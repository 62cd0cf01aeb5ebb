"""Commands on results that are there: the report is the same as a run's, a figure is drawn in any format."""

import json
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

from drillid.commands import app
from drillid.datasets.store import WellFolders
from drillid.errors import SettingsError
from drillid.figures.data import stored_results
from tests.unit.report.conftest import WELLS, Fleet


@pytest.fixture(scope="module")
def configuration(fleet: Fleet, tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("configuration") / "config.yaml"
    path.write_text(yaml.safe_dump(fleet.settings.model_dump(mode="json", exclude_none=True)))
    return str(path)


def test_results_of_an_earlier_version_are_refused(fleet: Fleet, monkeypatch: pytest.MonkeyPatch) -> None:
    read = WellFolders.read
    monkeypatch.setattr(WellFolders, "read", lambda *which: read(*which).drop_vars("advice", errors="ignore"))
    with pytest.raises(SettingsError, match=r"earlier version, which lack advice\. Run the workflow"):
        stored_results(fleet.settings, "W1")


def test_the_report_is_written_again_from_results(fleet: Fleet, configuration: str) -> None:
    before = fleet.page("W1")
    (fleet.results / "report/W1.html").unlink()
    done = CliRunner().invoke(app, ["report", "--configfile", configuration, "--json"])
    assert done.exit_code == 0, done.output
    named = json.loads(done.stdout)
    assert list(named["wells"]) == WELLS
    assert Path(named["wells"]["W1"]).read_text() == before


def test_without_results_there_is_no_report(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text(yaml.safe_dump({"results": str(tmp_path / "none")}))
    done = CliRunner().invoke(app, ["report", "--configfile", str(tmp_path / "config.yaml")])
    assert done.exit_code == 1
    assert "Run the workflow first" in done.stderr


def test_a_folder_without_a_run_cannot_be_viewed(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["view", str(tmp_path), "--no-browser"])
    assert done.exit_code == 1
    assert "Name the configuration of the run" in done.stderr


@pytest.mark.parametrize(
    ("well", "figure", "says"),
    [("W9", "evidence", "W1, W2"), ("W1", "nothing", "evidence"), ("W3", "evidence", "Run the workflow first")],
)
def test_what_cannot_be_drawn_is_refused(configuration: str, tmp_path: Path, well: str, figure: str, says: str) -> None:
    words = ["draw", well, figure, "--configfile", configuration, "--output", str(tmp_path / "figure.pdf")]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 1
    assert says in done.stderr


def test_a_figure_is_drawn_for_a_publication(configuration: str, tmp_path: Path) -> None:
    output = tmp_path / "verdicts.svg"
    words = ["draw", "W1", "verdicts", "--configfile", configuration, "--output", str(output), "--no-heading"]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    assert done.stdout.strip() == str(output)
    assert "<svg" in output.read_text()

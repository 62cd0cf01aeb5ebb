"""`drillid view`: wells are chosen, windows brushed, spectra follow; the page is served to a browser."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from bokeh.document import Document
from typer.testing import CliRunner

from drillid.commands import app
from drillid.figures.data import stored_results
from drillid.report.charts.well_data import in_order
from drillid.report.explorer import NOBODY, Explorer, wells
from tests.unit.report.conftest import Fleet
from tests.unit.report.test_browser import CHROMIUM, opened_browser


@pytest.fixture(scope="module")
def page(fleet: Fleet) -> Explorer:
    explorer = Explorer(wells({"one run": fleet.settings}))
    document = Document()
    explorer.add_to(document)
    document.validate()
    return explorer


def spectrum(fleet: Fleet, well: str, rows: slice) -> Any:
    results = stored_results(fleet.settings, well)
    return results.depth["command_mobility_fitted"].values[in_order(results)[rows]].mean(axis=0)


def test_wells_with_results_can_be_chosen_and_runs_are_told_apart(fleet: Fleet) -> None:
    assert list(wells({"one": fleet.settings})) == ["W1", "W2"]
    assert list(wells({"one": fleet.settings, "two": fleet.settings})) == ["one: W1", "one: W2", "two: W1", "two: W2"]


def test_spectra_are_those_of_the_windows_that_are_brushed(fleet: Fleet, page: Explorer) -> None:
    assert (page.first.value, page.second.value) == ("W1", "W2")
    for rows, indices in ((slice(None), []), (slice(0, 3), [0, 1, 2])):
        page.windows[0].selected.indices = indices
        shown = np.asarray(page.spectra[0].data["fitted"])
        np.testing.assert_allclose(shown, np.abs(spectrum(fleet, "W1", rows)) * 30e3 / np.pi)
    assert "3 of 10 windows" in page.told.text


def test_another_well_takes_the_place_of_the_first_and_none_that_of_the_second(page: Explorer) -> None:
    before = page.depths.start
    page.first.value, page.second.value = "W2", NOBODY
    assert len(page.windows[0].data["depth"]) == 1
    assert dict(page.windows[1].data) == {}
    assert page.depths.start < before
    page.first.value, page.second.value = "W1", "W2"
    assert len(page.windows[0].data["depth"]) == 10


def test_the_name_of_a_well_is_no_markup(fleet: Fleet) -> None:
    explorer = Explorer({"A<1> & B": (fleet.settings, "W1")})
    explorer.load()
    assert explorer.told.text == "A&lt;1&gt; &amp; B: spectra of 10 of 10 windows"


def test_without_results_there_is_nothing_to_view(tmp_path: Path) -> None:
    for name in ("wells", "logs"):
        (tmp_path / f"{name}.tsv").write_text({"wells": "well\trig\nA\trig\n", "logs": "well\tlog\nA\ta.csv\n"}[name])
    settings = {name: str(tmp_path / f"{name}.tsv") for name in ("wells", "logs")} | {"results": str(tmp_path / "no")}
    (tmp_path / "config.yaml").write_text(yaml.safe_dump(settings))
    done = CliRunner().invoke(app, ["view", str(tmp_path / "config.yaml"), "--no-browser"])
    assert done.exit_code == 1
    assert "no well has results" in done.stderr


@pytest.fixture
def address(fleet: Fleet, tmp_path: Path) -> Iterator[str]:
    (tmp_path / "config.yaml").write_text(yaml.safe_dump(fleet.settings.model_dump(mode="json", exclude_none=True)))
    command = [sys.executable, "-u", "-m", "drillid", "view", str(tmp_path / "config.yaml"), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as serving:
        assert serving.stdout is not None
        yield serving.stdout.readline().split()[0]
        serving.terminate()


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here; apt-get install chromium")
def test_the_page_is_drawn_and_brushing_in_the_browser_reaches_the_library(address: str) -> None:
    named = "Bokeh.documents[0].get_model_by_name"
    with opened_browser() as browser:
        shown, faults = browser.new_page(), list[str]()
        shown.on("pageerror", lambda error: faults.append(str(error)))
        shown.on("request", lambda request: faults.append(request.url) if "localhost" not in request.url else None)
        shown.goto(address)
        shown.wait_for_function("window.Bokeh?.documents?.[0]?.is_idle")
        assert "10 of 10 windows" in shown.evaluate(f"{named}('told').text")
        shown.evaluate(f"{named}('windows_first').selected.indices = [2, 3]")
        shown.wait_for_function(f"{named}('told').text.includes('2 of 10 windows')")
        assert faults == []

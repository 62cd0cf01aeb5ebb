"""Bokeh's script makes of a document without idle parts what it makes of the whole one."""

import json
import re
from typing import Any

import pytest

from drillid.config.sheets import read_sheets
from drillid.datasets.store import WellFolders
from drillid.datasets.tables import read_table
from drillid.figures.data import stored_results
from drillid.report import well_page
from drillid.report.charts.embedding import bokeh_script
from drillid.report.well_report import well_report
from tests.unit.report.conftest import Fleet
from tests.unit.report.test_browser import CHROMIUM, opened_browser

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here; apt-get install chromium")
MADE = """async (text) => {
  await Bokeh.embed.embed_items({ held: JSON.parse(text).document }, []);
  return Bokeh.documents.at(-1).to_json_string(true);
}"""
"""Text of a document → all of the models that Bokeh makes of it, with all of their properties."""


def models(made: str) -> Any:
    """The models with identifiers by the order in which they come."""
    names = {name: str(number) for number, name in enumerate(dict.fromkeys(re.findall(r'"id":"(\w+)"', made)))}
    return json.loads(re.sub(r'"id":"(\w+)"', lambda match: f'"id":"{names[match[1]]}"', made))["roots"]


def test_nothing_is_lost_by_leaving_idle_parts_out(fleet: Fleet) -> None:
    results, listing = stored_results(fleet.settings, "W1"), read_sheets(fleet.settings)["W1"]
    problems = read_table(fleet.results / "problems.csv", dtype=str, keep_default_na=False)
    well = well_report(WellFolders(fleet.results, "W1"), listing, problems)
    lean, whole = well_page._charts(well, results), well_page._charts.__wrapped__(well, results)
    with opened_browser() as browser:
        page = browser.new_page()
        page.set_content("<!doctype html><title>charts</title>")
        page.add_script_tag(content=bokeh_script()[1].decode())
        for name in ("log", "others"):
            assert len(lean[name]) < len(whole[name])
            made = [models(page.evaluate(MADE, each[name])) for each in (lean, whole)]
            assert made[0] == made[1]

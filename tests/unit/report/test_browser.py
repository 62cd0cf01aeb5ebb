"""The pages in Chromium: they load without a fault, charts are drawn, units, search and windows can be chosen."""

import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, sync_playwright

from drillid.report.page import fleet_page
from tests.unit.report.conftest import Fleet

CHROMIUM = shutil.which("chromium")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here; apt-get install chromium")
OPTIONS = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync"),
)
Theme = Literal["light", "dark"]
DRAWN = "document.documentElement.dataset.complete === 'true'"


@contextmanager
def opened_browser() -> Iterator[Any]:
    """Chromium, ended at the end."""
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=list(OPTIONS))
        yield started
        started.close()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with opened_browser() as started:
        yield started


@pytest.fixture(scope="module")
def well_page(browser: Any, fleet: Fleet) -> Iterator[Page]:
    """The page of a well, in metric units, in which windows have been chosen."""
    with opened(browser, fleet, "W1") as page:
        yield page


@contextmanager
def opened(browser: Any, fleet: Fleet, well: str = "", width: int = 1440, theme: str = "light") -> Iterator[Page]:
    """A page in a window, which must not report any fault."""
    context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=theme)
    page, faults = context.new_page(), list[str]()
    page.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.goto((fleet.results / (f"report/{well}.html" if well else "report.html")).as_uri())
    if well == "W1":
        page.wait_for_function(DRAWN)
    yield page
    assert faults == []
    context.close()


def grave_faults(page: Page) -> list[str]:
    """What axe-core finds serious or worse."""
    found = Axe().run(page).response["violations"]
    return [
        f"{each['id']}: {each['nodes'][0]['target']}" for each in found if each["impact"] in ("serious", "critical")
    ]


@pytest.mark.parametrize(("width", "themes"), [(1440, ("light", "dark")), (390, ("dark", "light"))])
@pytest.mark.parametrize("well", ["", "W1", "W4"])
def test_pages_load_fit_the_screen_and_have_no_serious_fault_of_access(
    browser: Any, fleet: Fleet, well: str, width: int, themes: tuple[Theme, Theme]
) -> None:
    """Loaded in one of the themes and changed to the other."""
    with opened(browser, fleet, well, width, themes[0]) as page:
        for theme in themes:
            if theme != themes[0]:
                page.click("[data-sets=theme]")
            assert page.evaluate("document.documentElement.dataset.theme") == theme
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            assert grave_faults(page) == []


def test_every_chart_is_drawn(well_page: Page) -> None:
    empty = "[...document.querySelectorAll('#log, .grid > div')].filter(e => e.clientHeight < 100).length"
    assert well_page.evaluate(empty) == 0
    assert well_page.evaluate("document.querySelectorAll('.grid > div').length") >= 12


def test_units_change_texts_and_charts_and_back(well_page: Page) -> None:
    depths = "Array.from(named('windows').data.depth)"
    shown = "[named('depths').start, named('depths').end]"
    metric, ends = well_page.evaluate(depths), well_page.evaluate(shown)
    assert ends[1] < min(metric) < max(metric) < ends[0]
    well_page.click("text=Oilfield units")
    assert well_page.evaluate(depths) == pytest.approx([depth / 0.3048 for depth in metric])
    assert well_page.evaluate(shown) == pytest.approx([end / 0.3048 for end in ends])
    assert well_page.locator(".metric:visible").count() == 0
    well_page.click("text=Oilfield units")
    assert well_page.evaluate(depths) == pytest.approx(metric)


def test_a_window_that_is_chosen_shows_its_spectra(well_page: Page) -> None:
    spectra = "Array.from(named('spectra').data.measured)"
    before = well_page.evaluate(spectra)
    well_page.click("text=Next window")
    assert well_page.evaluate(spectra) != before
    well_page.evaluate("named('windows').selected.indices = [0]")
    assert well_page.locator("#window-shown").inner_text().startswith("0, ")


POINT = """() => {
  const all = (view) => [view, ...[...view.children()].flatMap(all)];
  const label = ({ model }) => model.above?.[0]?.axis_label ?? "";
  const track = [...parts[0].content.views_manager.roots].flatMap(all).find((view) => label(view).startsWith("Weight"));
  const { weight, depth } = named("windows").data;
  const { left, top } = track.el.getBoundingClientRect();
  return [left + track.frame.x_scale.compute(weight[3]), top + track.frame.y_scale.compute(depth[3])];
}"""
"""Place on the screen of a window's point in the track of the weight on bit."""
TIPS = """() => {
  const texts = (node) => [...node.querySelectorAll("*")].filter((each) => each.shadowRoot).flatMap((each) => [
    ...[...each.shadowRoot.querySelectorAll(".bk-tooltip-content")].map((tip) => tip.textContent),
    ...texts(each.shadowRoot)]);
  return texts(document).join(" ");
}"""


def test_a_point_under_the_mouse_tells_its_value_with_its_unit(well_page: Page) -> None:
    well_page.locator("#log").scroll_into_view_if_needed()
    well_page.mouse.move(*well_page.evaluate(POINT))
    well_page.wait_for_function(f"({TIPS})().includes('100 kN')")
    well_page.click("text=Oilfield units")
    well_page.mouse.move(5, 5)
    well_page.mouse.move(*well_page.evaluate(POINT))
    well_page.wait_for_function(f"({TIPS})().includes('klbf')")
    well_page.click("text=Oilfield units")


def test_a_click_on_a_point_shows_the_spectra_of_its_window(well_page: Page) -> None:
    well_page.locator("#log").scroll_into_view_if_needed()
    assert not well_page.locator("#window-shown").inner_text().startswith("3, ")
    well_page.mouse.click(*well_page.evaluate(POINT))
    well_page.wait_for_function("document.getElementById('window-shown').textContent.startsWith('3, ')")


def test_search_kind_and_order_choose_wells(browser: Any, fleet: Fleet) -> None:
    shown = "[...document.querySelectorAll('#wells tbody tr')].filter(r => !r.hidden).map(r => r.cells[0].innerText)"
    with opened(browser, fleet) as page:
        page.fill("#search", "w2")
        assert [name[:2] for name in page.evaluate(shown)] == ["W2"]
        page.fill("#search", "")
        page.select_option("#kind", "No result")
        assert sorted(name[:2] for name in page.evaluate(shown)) == ["W3", "W4"]
        page.select_option("#kind", "")
        page.click("#wells th button >> text=Well")
        assert [name[:2] for name in page.evaluate(shown)] == ["W1", "W2", "W3", "W4"]
        page.click("#wells th button >> text=Well")
        assert [name[:2] for name in page.evaluate(shown)] == ["W4", "W3", "W2", "W1"]


def test_wells_are_ordered_by_their_shares_of_accepted_fits(browser: Any, fleet: Fleet, tmp_path: Path) -> None:
    shares = ["0 %", "< 1 %", "5 %", "> 99 %", "100 %"]
    wells = [
        {**json.loads((fleet.results / "report/W1.json").read_text()), "name": said, "accepted_share": said}
        | {"accepted": accepted, "windows": 1000}
        for said, accepted in zip(shares, (0, 1, 50, 999, 1000), strict=True)
    ]
    shown = "[...document.querySelectorAll('#wells tbody tr')].map(r => r.cells[0].innerText.split('\\n')[0])"
    with opened(browser, fleet) as page:
        (tmp_path / "fleet.html").write_text(fleet_page(fleet.settings, fleet.results, wells[::2] + wells[1::2]))
        page.goto((tmp_path / "fleet.html").as_uri())
        page.click("#wells th button >> text=Fits accepted")
        assert page.evaluate(shown) == shares

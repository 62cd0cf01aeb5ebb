"""The pages in Chromium: they load without a fault, charts are drawn, units, search and windows can be chosen."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, sync_playwright

from tests.unit.report.conftest import Fleet

CHROMIUM = shutil.which("chromium")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here; apt-get install chromium")
OPTIONS = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync"),
)
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


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("width", [1440, 390])
@pytest.mark.parametrize("well", ["", "W1", "W4"])
def test_pages_load_fit_the_screen_and_have_no_serious_fault_of_access(
    browser: Any, fleet: Fleet, well: str, width: int, theme: str
) -> None:
    with opened(browser, fleet, well, width, theme) as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert grave_faults(page) == []


def test_every_chart_is_drawn(browser: Any, fleet: Fleet) -> None:
    with opened(browser, fleet, "W1") as page:
        empty = "[...document.querySelectorAll('#log, .grid > div')].filter(e => e.clientHeight < 100).length"
        assert page.evaluate(empty) == 0
        assert page.evaluate("document.querySelectorAll('.grid > div').length") >= 12


def test_units_change_texts_and_charts_and_back(browser: Any, fleet: Fleet) -> None:
    depths = "Array.from(named('windows').data.depth)"
    shown = "[named('depths').start, named('depths').end]"
    with opened(browser, fleet, "W1") as page:
        metric, ends = page.evaluate(depths), page.evaluate(shown)
        assert ends[1] < min(metric) < max(metric) < ends[0]
        page.click("text=Oilfield units")
        assert page.evaluate(depths) == pytest.approx([depth / 0.3048 for depth in metric])
        assert page.evaluate(shown) == pytest.approx([end / 0.3048 for end in ends])
        assert page.locator(".metric:visible").count() == 0
        page.click("text=Oilfield units")
        assert page.evaluate(depths) == pytest.approx(metric)


def test_a_window_that_is_chosen_shows_its_spectra(browser: Any, fleet: Fleet) -> None:
    spectra = "Array.from(named('spectra').data.measured)"
    with opened(browser, fleet, "W1") as page:
        before = page.evaluate(spectra)
        page.click("text=Next window")
        assert page.evaluate(spectra) != before
        page.evaluate("named('windows').selected.indices = [0]")
        assert page.locator("#window-shown").inner_text().startswith("0, ")


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


def test_a_point_under_the_mouse_tells_its_value_with_its_unit(browser: Any, fleet: Fleet) -> None:
    with opened(browser, fleet, "W1") as page:
        page.locator("#log").scroll_into_view_if_needed()
        page.mouse.move(*page.evaluate(POINT))
        page.wait_for_function(f"({TIPS})().includes('100 kN')")
        page.click("text=Oilfield units")
        page.mouse.move(5, 5)
        page.mouse.move(*page.evaluate(POINT))
        page.wait_for_function(f"({TIPS})().includes('klbf')")


def test_a_click_on_a_point_shows_the_spectra_of_its_window(browser: Any, fleet: Fleet) -> None:
    with opened(browser, fleet, "W1") as page:
        page.locator("#log").scroll_into_view_if_needed()
        page.mouse.click(*page.evaluate(POINT))
        page.wait_for_function("document.getElementById('window-shown').textContent.startsWith('3, ')")


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

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
DRAWN = "document.documentElement.dataset.drawn === 'true' && Bokeh.documents[0].is_idle"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=list(OPTIONS))
        yield started
        started.close()


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
    depths = "Array.from(drawn.get_model_by_id(held.looked_up.named.windows).data.depth)"
    with opened(browser, fleet, "W1") as page:
        metric = page.evaluate(depths)
        page.click("text=Oilfield units")
        assert page.evaluate(depths) == pytest.approx([depth / 0.3048 for depth in metric])
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


def test_tracks_have_tips_with_units(browser: Any, fleet: Fleet) -> None:
    tooltip = "[...named('windows').document.all_models].some(m => m.type === 'HoverTool' && m.active)"
    with opened(browser, fleet, "W1") as page:
        assert page.evaluate(tooltip)
        tips = page.evaluate(
            "[...named('windows').document.all_models].filter(m => m.type === 'HoverTool').map(m => m.tooltips).flat(2)"
        )
        assert any(str(tip).endswith("kN") for tip in tips)


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

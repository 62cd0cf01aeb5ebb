"""The report's pages in Chromium: a fleet of 200 wells, and wells of as many windows as a page may have to hold.

The wells are those of `make demo`: the fleet lists them again and again, and their windows are laid end to end. Times
are the least of some tries, as anything else on the machine makes them longer, never shorter.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from rich.console import Console

from benchmarks.fleet.measurement import FOLDER
from benchmarks.parts import Measurement
from benchmarks.result import Result
from drillid.config.settings import Settings
from drillid.config.sheets import read_sheets
from drillid.datasets.store import WellFolders
from drillid.datasets.tables import read_table
from drillid.errors import SettingsError
from drillid.figures.data import WellResults, stored_results
from drillid.report.charts.embedding import bokeh_script
from drillid.report.page import PAGES, fleet_page
from drillid.report.summary import summary
from drillid.report.well_page import well_page
from drillid.report.well_report import well_report

WELLS, TRIES = 200, 5
COPIES = (1, 4, 20)
"""How often the windows of a well are laid end to end."""
_CONFIGURATION = Path("config/demo/config.yaml")
_WELL = "D01"
_LIMIT_BYTES = 2e6
_OPTIONS = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync"),
)
_OPENED = {
    "index": "document.readyState === 'complete' && document.getElementById('count').textContent !== ''",
    "well": "document.documentElement.dataset.drawn === 'true'",
}
"""What holds as soon as a reader sees the page's first screen whole."""


def measure(console: Console) -> Measurement:
    """Write the pages and open each some times."""
    folder = FOLDER / "pages"
    shutil.rmtree(folder, ignore_errors=True)
    pages = {"index": write_fleet(folder), **{f"well_{copies}": write_well(folder, copies) for copies in COPIES}}
    results = []
    with _chromium() as browser:
        for name, path in pages.items():
            size, (clock, processor) = path.stat().st_size, opened(browser, path)
            what = f"{WELLS} wells" if name == "index" else f"a well of {_windows(path)} windows"
            console.print(f"{what}: {size / 1e6:.2f} MB, {clock:.2f} s of the clock, {processor:.2f} s of a core")
            most = 1.0 if name == "index" else 2.0
            results += [
                Result(f"page_{name}_s", f"page of {what}: opened after, s", clock, most=most),
                Result(f"page_{name}_core_s", f"page of {what}: time of a core, s", processor),
                Result(f"page_{name}_mb", f"page of {what}: size, MB", size / 1e6, most=_LIMIT_BYTES / 1e6),
            ]
    shutil.rmtree(folder)
    return Measurement(results)


def write_fleet(folder: Path) -> Path:
    """The page of a fleet in which the demo's wells come again and again."""
    settings, listings = _demo()
    problems = read_table(Path(settings.results) / "problems.csv", dtype=str, keep_default_na=False)
    summaries = [
        summary(
            well_report(WellFolders(Path(settings.results), name), listing, problems), stored_results(settings, name)
        )
        for name, listing in listings.items()
    ]
    rows = [summaries[number % len(summaries)] | {"name": f"W{number:03d}"} for number in range(WELLS)]
    path = folder / "report.html"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(fleet_page(settings, Path(settings.results), rows), encoding="utf-8")
    return path


def write_well(folder: Path, copies: int) -> Path:
    """The page of a well whose windows are those of one of the demo's, so many times."""
    settings, listings = _demo()
    folders = WellFolders(Path(settings.results), _WELL)
    problems = read_table(Path(settings.results) / "problems.csv", dtype=str, keep_default_na=False)
    name, script = bokeh_script()
    path = folder / PAGES / f"well_{copies}.html"
    path.parent.mkdir(parents=True, exist_ok=True)
    (path.parent / name).write_bytes(script)
    longer = repeated(stored_results(settings, _WELL), copies)
    report = well_report(folders, listings[_WELL], problems)
    path.write_text(well_page(report, longer, folders, ("", ""), name), encoding="utf-8")
    return path


def repeated(results: WellResults, copies: int) -> WellResults:
    """A well with its windows laid end to end so many times, each time below the last."""
    datasets = {
        each.name: getattr(results, each.name)
        for each in fields(results)
        if isinstance(getattr(results, each.name), xr.Dataset)
    }
    step = float(np.ptp(results.windows[["depth_from", "depth_to"]].to_array().values))
    return replace(results, **{name: _repeated(dataset, copies, step) for name, dataset in datasets.items()})


def _repeated(dataset: xr.Dataset, copies: int, step: float) -> xr.Dataset:
    along = next((name for name in ("window", "depth") if name in dataset.sizes), None)
    if along is None or dataset.sizes[along] < 2:
        return dataset
    alike = [name for name, variable in dataset.variables.items() if along not in variable.dims]
    pieces = []
    for copy in range(copies):
        piece = dataset.drop_vars(alike)
        moved = {name for name in piece.variables if "depth" in str(name) and piece[name].dtype.kind == "f"}
        shifted = {name: piece[name] + copy * step for name in moved}
        numbers = {"window": piece["window"] + copy * dataset.sizes[along]} if "window" in piece.variables else {}
        pieces.append(piece.assign_coords({**shifted, **numbers}).reset_coords(moved - set(piece.coords)))
    return xr.concat(pieces, along, data_vars="minimal").assign(dataset[alike].variables)


def _demo() -> tuple[Settings, dict[str, Any]]:
    settings = Settings.from_yaml(_CONFIGURATION)
    if not (Path(settings.results) / "report.html").is_file():
        raise SettingsError(settings.results, "holds no results", "Run make demo first")
    return settings, read_sheets(settings)


@contextmanager
def _chromium() -> Iterator[Any]:
    from playwright.sync_api import sync_playwright

    path = shutil.which("chromium")
    if path is None:
        raise SettingsError("chromium", "is not installed", "apt-get install chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(_OPTIONS))
        yield browser
        browser.close()


def opened(browser: Any, path: Path) -> tuple[float, float]:
    """Least time of the clock from the navigation on, and least time of a core of the page's process, s."""
    tries = [_opened(browser, path) for _ in range(TRIES)]
    clock, processor = np.min(tries, axis=0)
    return float(clock), float(processor)


def _opened(browser: Any, path: Path) -> Sequence[float]:
    context = browser.new_context(viewport={"width": 1400, "height": 900})
    page = context.new_page()
    session = context.new_cdp_session(page)
    session.send("Performance.enable")
    page.goto(path.resolve().as_uri(), wait_until="commit")
    page.wait_for_function(_OPENED["index" if path.name == "report.html" else "well"], polling="raf")
    clock = page.evaluate("new Promise(done => requestAnimationFrame(() => done(performance.now())))") / 1e3
    metrics = {each["name"]: each["value"] for each in session.send("Performance.getMetrics")["metrics"]}
    context.close()
    return clock, metrics["ProcessTime"]


def _windows(path: Path) -> int:
    return (
        path.read_text(encoding="utf-8").partition('<select id="window">')[2].partition("</select>")[0].count("<option")
    )

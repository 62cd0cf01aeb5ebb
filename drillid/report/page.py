"""The report: `<results>/report.html` over the fleet, and a page for each well in the folder `report` beside it."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

import drillid
from drillid.config.listing import Listing
from drillid.config.sheets import read_sheets, read_start_ups
from drillid.datasets.memory import WellReadOnce
from drillid.datasets.reuse import digest
from drillid.datasets.store import WellFolders
from drillid.datasets.tables import read_table
from drillid.figures.data import WellResults
from drillid.fleet.manifest import stored_key, write_whole
from drillid.fleet.provenance import source_hash, template_hash
from drillid.fleet.stages import STAGES
from drillid.report.attention import KINDS
from drillid.report.charts.embedding import bokeh_script
from drillid.report.learnt import learnt_rows
from drillid.report.rendering import render
from drillid.report.rig_page import write_rig_pages
from drillid.report.start_ups import start_up_rows
from drillid.report.summary import new_since, summary, totals
from drillid.report.well_page import well_page
from drillid.report.well_report import well_report

if TYPE_CHECKING:
    from drillid.config.settings import Settings

PAGES = "report"
"""Folder of the wells' pages."""
_WITHOUT_EFFECT = {"fleet", "wells", "logs", "rigs", "start_up_sheet", "results", "mirror"}
"""Settings without effect on the report."""


def write_report(settings: Settings, results: Path, wells: Sequence[str]) -> dict[str, float]:
    """Write the pages of the wells, as far as anything in them has changed, and then that of the fleet.

    Returns
    -------
    Time of one core that each well's page took, s.

    Raises
    ------
    SettingsError
        If the sheets or the rig description of a well with results cannot be read.
    """
    results, listings = Path(results), read_sheets(settings)
    pages = results / PAGES
    pages.mkdir(parents=True, exist_ok=True)
    name = _write_script(pages)
    problems = read_table(results / "problems.csv", dtype=str, keep_default_na=False)
    basis = [source_hash("drillid.report.page", "drillid.config.rig"), template_hash(), name, drillid.__version__]
    neighbours = dict(zip(wells, zip(["", *wells], [*wells[1:], ""], strict=False), strict=False))
    summaries, spent = list[dict[str, Any]](), dict[str, float]()
    for well in wells:
        began, folders = time.process_time(), WellReadOnce(results, well)
        summaries.append(_summary(settings, folders, listings[well], problems, neighbours[well], basis))
        spent[well] = time.process_time() - began
    groups = write_rig_pages(results, pages, {listings[well].name: well for well in wells})
    kept = {
        name,
        *(f"{well}.{end}" for well in wells for end in ("html", "json")),
        *(group["file"] for group in groups),
    }
    for path in pages.iterdir():
        if path.name not in kept:
            path.unlink()
    starts = start_up_rows(results, read_start_ups(settings), problems)
    write_whole(results / "report.html", fleet_page(settings, results, summaries, groups, starts))
    return spent


def _write_script(pages: Path) -> str:
    """Write the script that all pages share, unless it is there as a whole; its name."""
    name, content = bokeh_script()
    script = pages / name
    if not script.exists() or script.stat().st_size != len(content):
        write_whole(script, content)
    return name


def _summary(
    settings: Settings,
    folders: WellFolders,
    listing: Listing,
    problems: pd.DataFrame,
    neighbours: tuple[str, str],
    basis: Sequence[Any],
) -> dict[str, Any]:
    """What the fleet's page needs of a well; its own page is written unless it is there as it would be."""
    pages = folders.results / PAGES
    page, remembered = pages / f"{folders.well}.html", pages / f"{folders.well}.json"
    own = problems[problems["well"] == listing.name]
    stages = [stored_key(folders.stage(stage)) for stage in STAGES]
    known = digest([basis, stages, own.to_numpy().tolist(), listing.name, listing.description, neighbours])
    if all(stages) and page.exists():
        earlier = _read(remembered)
        if earlier.get("key") == known:
            return earlier
    well = well_report(folders, listing, problems)
    drawn = WellResults.load(listing.load(), folders, settings.discrepancy.error_rate) if well.identified else None
    write_whole(page, well_page(well, drawn, folders, neighbours, bokeh_script()[0]))
    found: dict[str, Any] = {"key": known, **summary(well, drawn)}
    write_whole(remembered, json.dumps(found, ensure_ascii=False))
    return found


def _read(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def fleet_page(
    settings: Settings,
    results: Path,
    wells: Sequence[Mapping[str, Any]],
    groups: Sequence[Mapping[str, str]] = (),
    starts: Sequence[Mapping[str, Any]] = (),
) -> str:
    """The fleet's page as text.

    Parameters
    ----------
    wells : their summaries
    groups : what several wells have in common, as `write_rig_pages` tells of it
    starts : measured starts of rotation, as `start_up_rows` tells of them
    """
    import yaml

    used = settings.model_dump(mode="json", exclude=_WITHOUT_EFFECT, exclude_none=True)
    attention = [{**item, "well": well["name"], "folder": well["folder"]} for well in wells for item in well["items"]]
    kinds = {item["kind"] for item in attention}
    return render(
        "fleet.html.j2",
        title=settings.report.title,
        wells=wells,
        groups=groups,
        starts=starts,
        learnt=learnt_rows(results),
        attention=sorted(attention, key=lambda item: (item["level"], -item["strength"])),
        kinds=[kind for kind in KINDS if kind in kinds],
        totals=totals(wells),
        new=new_since(results),
        newest=max((well["newest"] for well in wells), default=""),
        version=drillid.__version__,
        settings=yaml.safe_dump(used, sort_keys=False, allow_unicode=True),
        pages=PAGES,
    )

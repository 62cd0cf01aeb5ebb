"""The page of one well: what the report tells of it, with its charts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

import drillid
from drillid.discrepancy.catalogue import words_of
from drillid.figures.captions import FIGURES
from drillid.figures.data import WellResults
from drillid.report.attention import items
from drillid.report.charts.embedding import document, without_idle_parts
from drillid.report.rendering import render
from drillid.report.well_report import WellReport

if TYPE_CHECKING:
    from drillid.datasets.store import WellFolders

_EVIDENT_ROWS = 8
"""Causes of a set with the largest evidence that are shown at once."""
_CONTROL_ROWS = 4
"""Deepest depths whose advised settings are shown at once."""


def well_page(
    well: WellReport,
    results: WellResults | None,
    folders: WellFolders,
    neighbours: tuple[str, str],
    script: str,
) -> str:
    """The page as text.

    Parameters
    ----------
    results : None where the well has no results
    neighbours : folders of the wells before and behind it; empty where there is none
    script : name of the file with Bokeh beside the page
    """
    charts = _charts(well, results) if results is not None else {"log": "", "places": {}, "missing": ()}
    pictures = [name for name in FIGURES if (folders.stage("figures") / f"{name}.png").exists()]
    return render(
        "well.html.j2",
        well=well,
        items=items(well),
        charts=charts,
        evidence={} if results is None else {number: _evidence(results, number) for number in well.told},
        evident_rows=_EVIDENT_ROWS,
        control_rows=_CONTROL_ROWS,
        pictures=pictures,
        neighbours=neighbours,
        script=script,
        version=drillid.__version__,
    )


@without_idle_parts()
def _charts(well: WellReport, results: WellResults) -> dict[str, Any]:
    """The JSON of the log plot and that of the other charts, and for each kind the elements that they are drawn in.

    The log plot is a document of its own, which the page shows before it reads the other.
    """
    from drillid.report.charts import discovery, well_data
    from drillid.report.charts.log_plot import log_plot
    from drillid.report.charts.maps import map_charts, map_source, spectrum_charts, spectrum_source
    from drillid.report.charts.style import depth_range

    cells = well_data.cell_columns(results)
    depths, map_depths = (depth_range(float(cells["cell_top"][0]), float(cells["cell_bottom"][-1])) for _ in range(2))
    log = log_plot(results, well.verdicts, depths)
    maps = well_data.maps(results)
    rows = map_source(results, maps)
    spectra, steps = spectrum_source(maps, rows, len(maps.rows) // 2)
    places = {"maps": map_charts(results, maps, rows, map_depths), "spectra": spectrum_charts(results, spectra, steps)}
    for number in well.told:
        held_out = discovery.held_out_chart(results, number)
        charts = {"held_out": held_out, "residuals": discovery.residual_chart(results, number)}
        charts["law"] = discovery.law_chart(results, number)
        places[f"set{number}"] = {name: chart for name, chart in charts.items() if chart is not None}
    drawn = {f"{place}-{name}": chart for place, charts in places.items() for name, chart in charts.items()}
    columns = (rows.data[name] for name in ("window", "depth", "start"))
    windows = [
        {"number": int(number), "depth": float(depth), "start": start}
        for number, depth, start in zip(*columns, strict=True)
    ]
    log_data = {"windows": log.windows, "shown": log.shown, "depths": depths}
    data = {"maps": rows, "spectra": spectra, "steps": steps, "map_depths": map_depths}
    return {
        "log": document({"log": log.chart}, log_data, "l"),
        "others": document(drawn, data, "o"),
        "places": {place: [f"{place}-{name}" for name in charts] for place, charts in places.items()},
        "missing": log.missing,
        "states": log.states,
        "windows": windows,
        "shown": len(maps.rows) // 2,
    }


def _evidence(results: WellResults, number: int) -> list[dict[str, Any]]:
    """Evidence for every cause and for something unknown in a set, the largest first; None for what was not tested."""
    examined = results.examination.isel(set=number)
    rows = [
        _row(words_of(str(cause)), linear, detected)
        for cause, linear, detected in zip(
            examined["cause"].values,
            examined["log_evidence"].values,
            examined["detection_log_evidence"].values,
            strict=True,
        )
    ]
    ports = zip(examined["port"].values, examined["unknown_evidence"].values, strict=True)
    rows += [_row(f"something unknown: {port}", linear, np.nan) for port, linear in ports]
    return sorted(rows, key=_least_first)


def _row(cause: str, linear: float, detected: float) -> dict[str, Any]:
    return {"cause": cause, "linear": _tested(linear), "detected": _tested(detected)}


def _tested(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _least_first(row: dict[str, Any]) -> float:
    return -max(value for value in (row["linear"], row["detected"], -np.inf) if value is not None)

"""`drillid view`: depth, frequency and time of wells brushed against each other, and two wells or runs compared.

A Bokeh server holds the page, so that every window is shown at the full resolution of its datasets.
"""

from __future__ import annotations

import functools
import html
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from bokeh.layouts import column, gridplot, row
from bokeh.models import ColorBar, ColumnDataSource, Div, FixedTicker, LogColorMapper, LogTicker, Range1d, Select
from bokeh.plotting import figure

from drillid.arrays import Floats, Indices
from drillid.config.sheets import read_sheets
from drillid.datasets.codes import Gate
from drillid.datasets.store import WellFolders
from drillid.figures.captions import DISPLAYED_PARAMETERS, RPM_PER_KILONEWTON_METRE
from drillid.figures.data import WellResults, cell_edges, stored_results
from drillid.report.charts.maps import TICKS
from drillid.report.charts.well_data import cell_columns, in_order, operation_columns, parameter_columns

if TYPE_CHECKING:
    from bokeh.document import Document

    from drillid.config.settings import Settings

NOBODY = "–"
"""Choice of no second well."""
_LOOKS = (("#1f3b57", "circle", "solid"), ("#d9822b", "triangle", "dashed"))
"""Colour, marker and dash of the first well and of the second."""
_TRACKS = ("damping_bha", "inertia_bha", "kappa", "delta")
_OPERATION = {"rotation": "Rotation [rpm]", "weight": "Weight on bit [kN]"}
_TOOLS = "ybox_select,ybox_zoom,ypan,ywheel_zoom,reset"
_LEAST_SHOWN = 1e-9
_LINE = 14
"""Characters of a line of a track's name."""


def wells(chosen: Mapping[str, Settings]) -> dict[str, tuple[Settings, str]]:
    """Settings and name of every well that has results, by the words that a reader chooses it by.

    Parameters
    ----------
    chosen : settings of each run by its name; with several runs, a well's words hold the run's name
    """
    found = {}
    for run, settings in chosen.items():
        for listing in read_sheets(settings).values():
            folders = WellFolders(Path(settings.results), listing.folder)
            if folders.has("depth", "depth") and folders.read("depth", "depth").sizes["depth"]:
                words = f"{run}: {listing.name}" if len(chosen) > 1 else listing.name
                found[words] = settings, listing.name
    return found


class Explorer:
    """The page: two wells, whose windows are chosen by depth or by time, and the spectra of those that are chosen.

    Parameters
    ----------
    known : of `wells`
    """

    def __init__(self, known: Mapping[str, tuple[Settings, str]]) -> None:
        self._known = known
        self._results = functools.lru_cache(maxsize=4)(lambda words: stored_results(*known[words]))
        names = list(known)
        second = names[1] if len(names) > 1 else NOBODY
        self.first = Select(title="Well", value=names[0], options=names, name="first")
        self.second = Select(title="Compared with", value=second, options=[NOBODY, *names], name="second")
        self.windows = [ColumnDataSource({}, name=f"windows_{place}") for place in ("first", "second")]
        self.spectra = [ColumnDataSource({}, name=f"spectra_{place}") for place in ("first", "second")]
        self.map = ColumnDataSource({}, name="map")
        self.told = Div(text="", name="told")
        self.depths, self.frequencies = Range1d(1.0, 0.0), Range1d(0.05, 4.0)
        self.colours = LogColorMapper("Viridis256", low=1.0, high=100.0)
        for select in (self.first, self.second):
            select.on_change("value", lambda attr, old, new: self.load())
        for source in self.windows:
            source.selected.on_change("indices", lambda attr, old, new: self.show_spectra())

    def add_to(self, document: Document) -> None:
        """Fill a document with the page."""
        self.load()
        tracks = [self._track(name, _axis_name(name)) for name in _TRACKS]
        tracks += [self._track(name, words) for name, words in _OPERATION.items()]
        document.title = "drillid view"
        words = "Drag over depths in a track, or over times below, to choose windows; the spectra are of those chosen."
        document.add_root(
            column(
                row(self.first, self.second, Div(text=words, width=420)),
                gridplot([tracks], toolbar_location="right", toolbar_options={"logo": None}),
                row(self._map(), self._spectra()),
                row(self._times(), self.told),
            )
        )

    def load(self) -> None:
        """Take the data of the chosen wells."""
        chosen = [self.first.value, self.second.value]
        held = [None if words == NOBODY else self._results(words) for words in chosen]
        for source, results in zip(self.windows, held, strict=True):
            source.selected.indices = []
            source.data = {} if results is None else window_columns(results)
        first = held[0]
        assert first is not None
        ends = [end for each in held if each is not None for end in _reach(each)]
        self.depths.update(start=max(ends), end=min(ends))
        self.frequencies.update(start=first.band[0], end=first.band[1])
        self.map.data = map_columns(first)
        values = np.concatenate([each.ravel() for each in self.map.data["image"]])
        finite = values[np.isfinite(values) & (values > _LEAST_SHOWN)]
        if finite.size:
            low, high = np.percentile(finite, [1, 99.5])
            self.colours.update(low=float(low), high=float(max(high, 1.001 * low)))
        self.show_spectra()

    def show_spectra(self) -> None:
        """The mean spectra of the windows that are chosen, or of all."""
        words = []
        for select, windows, spectra in zip((self.first, self.second), self.windows, self.spectra, strict=True):
            if select.value == NOBODY:
                spectra.data = {"frequency": [], "measured": [], "fitted": []}
                continue
            results, rows = self._results(select.value), np.array(sorted(windows.selected.indices), dtype=int)
            order = in_order(results)
            spectra.data = spectrum_columns(results, order[rows] if rows.size else order)
            words.append(f"{select.value}: spectra of {rows.size or order.size} of {order.size} windows")
        self.told.text = "<br>".join(map(html.escape, words))

    def _track(self, name: str, words: str) -> Any:
        chart = figure(height=430, width=200, y_range=self.depths, tools=_TOOLS, x_axis_location="above", name=name)
        chart.toolbar.update(active_drag=chart.tools[0])
        for source, (colour, marker, dash) in zip(self.windows, _LOOKS, strict=True):
            if name in _TRACKS:
                line = chart.line(f"{name}_joint", "depth", source=source, color=colour, line_dash=dash, line_width=2)
                line.update(nonselection_glyph=None, selection_glyph=None)
            chart.scatter(name, "depth", source=source, color=colour, marker=marker, size=6, nonselection_alpha=0.15)
        chart.xaxis[0].update(axis_label=words)
        chart.xaxis[0].ticker.update(desired_num_ticks=3)
        chart.yaxis[0].axis_label = "Measured depth [m]"
        return chart

    def _map(self) -> Any:
        chart = figure(
            height=360, width=600, y_range=self.depths, x_range=self.frequencies, x_axis_type="log", name="map",
            title="Bit mobility of the well, as controlled", tools="box_zoom,pan,wheel_zoom,reset",
        )  # fmt: skip
        place = {"x": "left", "y": "top", "dw": "width", "dh": "height"}
        chart.image("image", **place, source=self.map, color_mapper=self.colours)
        chart.add_layout(ColorBar(color_mapper=self.colours, ticker=LogTicker(), title="rpm per kN m"), "right")
        chart.xaxis[0].update(axis_label="Frequency [Hz]", ticker=FixedTicker(ticks=list(TICKS)))
        chart.yaxis[0].update(axis_label="Measured depth [m]")
        chart.toolbar.update(logo=None)
        return chart

    def _spectra(self) -> Any:
        chart = figure(
            height=360, width=600, x_range=self.frequencies, x_axis_type="log", y_axis_type="log", name="spectra",
            title="Command mobility, mean of the chosen windows", tools="box_zoom,pan,wheel_zoom,reset",
        )  # fmt: skip
        for place, source, (colour, marker, dash) in zip(("well", "compared"), self.spectra, _LOOKS, strict=True):
            measured = f"{place}, measured"
            chart.scatter("frequency", "measured", source=source, color=colour, marker=marker, legend_label=measured)
            fitted = {"line_dash": dash, "line_width": 2, "legend_label": f"{place}, identified"}
            chart.line("frequency", "fitted", source=source, color=colour, **fitted)
        chart.xaxis[0].update(axis_label="Frequency [Hz]", ticker=FixedTicker(ticks=list(TICKS)))
        chart.yaxis[0].update(axis_label="rpm per kN m")
        chart.toolbar.update(logo=None)
        chart.legend[0].update(background_fill_alpha=0.7, label_text_font_size="10px", location="bottom_left")
        return chart

    def _times(self) -> Any:
        chart = figure(
            height=220, width=800, x_axis_type="datetime", tools="xbox_select,pan,wheel_zoom,reset", name="times",
            title="The same windows over time",
        )  # fmt: skip
        for source, (colour, marker, _) in zip(self.windows, _LOOKS, strict=True):
            chart.scatter("time", "damping_bha", source=source, color=colour, marker=marker, size=6)
        chart.toolbar.update(active_drag=chart.tools[0], logo=None)
        chart.xaxis[0].axis_label, chart.yaxis[0].axis_label = "Start, UTC", _axis_name("damping_bha")
        return chart


def window_columns(results: WellResults) -> dict[str, Any]:
    """What the tracks show of each window, in order of depth."""
    cells, operation = cell_columns(results), operation_columns(results)
    columns: dict[str, Any] = {"depth": cells["depth"], "window": cells["window"]}
    columns["time"] = results.windows["start"].values[in_order(results)]
    for name in _TRACKS:
        fitted = parameter_columns(results, name, DISPLAYED_PARAMETERS[name].factor)
        columns |= {name: fitted[name], f"{name}_joint": fitted[f"{name}_joint"]}
    return columns | {name: operation[name] for name in _OPERATION}


def map_columns(results: WellResults) -> dict[str, Any]:
    """Bit mobility of each window over frequency at the dataset's resolution: one image a window."""
    cells, frequency = cell_columns(results), results.depth["frequency"].values
    inside = (frequency >= results.band[0]) & (frequency <= results.band[1])
    grid = np.geomspace(*results.band, int(inside.sum()))
    rows = np.abs(results.depth["bit_mobility_controlled"].values[in_order(results)]) * RPM_PER_KILONEWTON_METRE
    edges = np.exp(cell_edges(np.log(grid)))
    return {
        "image": [np.interp(grid, frequency, each)[None] for each in rows],
        "left": np.full(rows.shape[0], edges[0]),
        "width": np.full(rows.shape[0], edges[-1] - edges[0]),
        "top": cells["cell_top"],
        "height": cells["cell_height"],
    }


def spectrum_columns(results: WellResults, rows: Indices) -> dict[str, Floats]:
    """Mean command mobility of some windows, measured where the gate passes it and identified, rpm per kN m."""
    depth = results.depth.isel(depth=rows)
    used = depth["gate"].values == Gate.USED
    measured = np.where(used, depth["command_mobility"].values, 0.0).sum(axis=0)
    count = used.sum(axis=0)
    fitted = depth["command_mobility_fitted"].values
    known = np.isfinite(fitted).all(axis=1)
    missing = np.full(fitted.shape[1], np.nan)
    return {
        "frequency": results.depth["frequency"].values,
        "measured": np.where(count > 0, np.abs(measured) / np.maximum(count, 1), np.nan) * RPM_PER_KILONEWTON_METRE,
        "fitted": np.abs(fitted[known].mean(axis=0)) * RPM_PER_KILONEWTON_METRE if known.any() else missing,
    }


def _reach(results: WellResults) -> Sequence[float]:
    cells = cell_columns(results)
    return float(cells["cell_top"].min()), float(cells["cell_bottom"].max())


def _axis_name(name: str) -> str:
    shown = DISPLAYED_PARAMETERS[name]
    return "\n".join([*textwrap.wrap(shown.name, _LINE), f"[{shown.unit}]"])


def start(known: Mapping[str, tuple[Settings, str]], port: int) -> Any:
    """A running Bokeh server on this machine alone; `server.io_loop.start()` serves until it is interrupted.

    Parameters
    ----------
    port : 0 for any free one
    """
    from bokeh.server.server import Server

    server = Server({"/": lambda document: Explorer(known).add_to(document)}, port=port, address="127.0.0.1")
    server.start()
    return server

"""How charts look and what the page's script changes in them: colours with light and dark, units, ranges of depth.

Bokeh has no variables for colours or units. A model's tags say which of its properties have which of the page's
colours, and what they are in metric and in oilfield units; `charts.js` sets them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, FixedTicker, Glyph, HoverTool, Range1d, Span, Tool
from bokeh.plotting import figure
from bokeh.settings import settings

from drillid.arrays import Floats
from drillid.report.quantities import QUANTITIES

# as by default; Bokeh looks at the environment for each model of a chart unless a program says so
settings.simple_ids.set_value(True)
settings.serialize_include_defaults.set_value(False)

FONT = "system-ui, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif"
ROOM = 0.08
"""Margin of an axis beyond its values, as a share of their spread."""
_TOOLS = ("box_zoom", "pan", "wheel_zoom", "reset")
_DIGIT, _OVER, _MOST_TICKS = 6.0, 4.0, 3
"""Pixels of a digit, and those by which a number may leave its axis; numbers of a narrow axis."""
_LEAST_SPREAD = 0.2
"""Of an axis, as a share of its values."""


def tagged(
    model: Any,
    colours: Mapping[str, str] | None = None,
    metric: Mapping[str, Any] | None = None,
    oilfield: Mapping[str, Any] | None = None,
    scale: float | Mapping[str, float] | None = None,
) -> Any:
    """The model with tags for the page's script.

    Parameters
    ----------
    colours : names of the page's colours by the model's properties
    metric, oilfield : values of properties in each of the units
    scale : oilfield values per metric ones, of a range or of the columns of a data source
    """
    tags = {"colours": colours, "metric": metric, "oilfield": oilfield, "scale": scale}
    model.update(tags=[{name: value for name, value in tags.items() if value}])
    return model


_NOTHING = np.array([])


def depth_range(top: float, bottom: float) -> Range1d:
    """Depth downwards, shared by all charts of a well; metric at first."""
    room = ROOM / 2 * (bottom - top) or 1.0
    reach = (bottom + room, top - room)
    limits = (top - 4 * room, bottom + 4 * room)
    return tagged(Range1d(*reach, bounds=limits), scale=QUANTITIES["depth"].per_metric)


def value_range(
    *values: Floats, quantity: str = "", zero: bool = False, share: float = 2.0, kept: Floats = _NOTHING
) -> Range1d:
    """Range that holds all values but the outermost few.

    Parameters
    ----------
    zero : begin at zero
    share : of the values, percent, that may lie beyond either end
    kept : further values (N,) that may not
    """
    pooled = np.concatenate([np.ravel(each) for each in values]) if values else np.array([])
    finite = pooled[np.isfinite(pooled)]
    low, high = (0.0, 1.0) if not finite.size else np.percentile(finite, [share, 100 - share])
    kept = kept[np.isfinite(kept)]
    low, high = np.min([low, *kept]), np.max([high, *kept])
    if zero:
        low = min(0.0, low)
    # a channel that hardly changes is a straight line
    missing = _LEAST_SPREAD * max(abs(low), abs(high)) - (high - low)
    low, high = (low - missing / 2, high + missing / 2) if missing > 0 else (low, high)
    room = ROOM * (high - low) or 1.0
    return _scaled(Range1d(float(low if zero and low == 0 else low - room), float(high + room)), quantity)


def _scaled(axis: Range1d, quantity: str) -> Range1d:
    return tagged(axis, scale=QUANTITIES[quantity].per_metric) if quantity else axis


def labels(name: str, quantity: str, joint: str = "\n") -> tuple[str, str]:
    """Label of an axis in both units."""
    scales = (QUANTITIES[quantity].metric, QUANTITIES[quantity].oilfield)
    metric, oilfield = (f"{name}{joint}[{scale.shown}]" for scale in scales)
    return metric, oilfield


def label_axis(axis: Any, name: str, quantity: str = "", unit: str = "", joint: str = "\n") -> None:
    """Give an axis its label, with the unit of a quantity that changes or one that does not."""
    if quantity:
        metric, oilfield = labels(name, quantity, joint)
        axis.update(axis_label=metric)
        _dressed(axis, {"axis_label": metric}, {"axis_label": oilfield})
    else:
        axis.update(axis_label=f"{name}{joint}[{unit}]" if unit else name)
        _dressed(axis, None, None)


def set_ticks(chart: Any, quantity: str) -> None:
    """Ticks of an axis across that is not zoomed, in both units, with numbers clear of those of charts beside it."""
    across, per_metric = chart.x_range, QUANTITIES[quantity].per_metric
    ticks = [clear_ticks(across.start * factor, across.end * factor, chart.width) for factor in (1.0, per_metric)]
    chart.xaxis[0].ticker = tagged(FixedTicker(ticks=ticks[0]), None, {"ticks": ticks[0]}, {"ticks": ticks[1]})


def clear_ticks(start: float, end: float, width: int) -> list[float]:
    """At most three round numbers between the ends of an axis whose labels neither touch nor leave it.

    Parameters
    ----------
    width : pixels
    """
    span = end - start
    decade = 10.0 ** np.floor(np.log10(span))
    for step in (scale * decade for scale in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)):
        ticks = [float(f"{number * step:.6g}") for number in range(int(np.ceil(start / step)), int(end // step) + 1)]
        halves = [_DIGIT * len(f"{tick:.6g}") / 2 for tick in ticks]
        places = [(tick - start) / span * width for tick in ticks]
        fitting = [
            number
            for number, (place, half) in enumerate(zip(places, halves, strict=True))
            if half - _OVER <= place <= width - half
        ]
        apart = all(
            places[right] - places[left] > halves[left] + halves[right] + _DIGIT for left, right in pairwise(fitting)
        )
        if fitting and apart and len(fitting) <= _MOST_TICKS:
            return [ticks[number] for number in fitting]
    return [float(f"{(start + end) / 2:.2g}")]


_AXIS_COLOURS = {
    "axis_label_text_color": "ink",
    "major_label_text_color": "muted",
    "axis_line_color": "line",
    "major_tick_line_color": "line",
    "minor_tick_line_color": "none",
}


def _dressed(axis: Any, metric: Mapping[str, Any] | None, oilfield: Mapping[str, Any] | None) -> None:
    tagged(axis, _AXIS_COLOURS, metric, oilfield)
    axis.update(axis_label_text_font_size="11px", axis_label_text_font=FONT, axis_label_text_font_style="normal")
    axis.update(axis_label_standoff=4, major_label_text_font_size="10px", major_label_text_font=FONT)


def new_chart(width: int | None, height: int, tools: Iterable[Tool | str] = _TOOLS, **options: Any) -> Any:
    """An empty chart in the page's colours.

    Parameters
    ----------
    width : pixels; None to fill the page's column
    tools : models, or Bokeh's names of them
    options : of `bokeh.plotting.figure`
    """
    sizes: dict[str, Any] = {"width": width} if width else {"sizing_mode": "stretch_width"}
    chart = figure(height=height, output_backend="canvas", tools=[], **sizes, **options)
    chart.add_tools(*tools)
    chart.toolbar.update(logo=None, autohide=True)
    tagged(
        chart,
        {"background_fill_color": "paper", "border_fill_color": "paper", "outline_line_color": "line"},
    )
    for grid in chart.grid:
        tagged(grid, {"grid_line_color": "grid"})
    if chart.title is not None:
        tagged(chart.title, {"text_color": "ink"})
        chart.title.update(text_font=FONT, text_font_size="12px")
    return chart


def source(columns: Mapping[str, Any], quantities: Mapping[str, str]) -> ColumnDataSource:
    """A data source whose columns change with the units.

    Parameters
    ----------
    quantities : of columns, by their names
    """
    scale = {name: QUANTITIES[quantity].per_metric for name, quantity in quantities.items() if name in columns}
    held = ColumnDataSource(dict(columns))
    return tagged(held, scale={name: factor for name, factor in scale.items() if factor != 1})


def hover(rows: Sequence[tuple[str, str, str]], renderers: Sequence[Any] | str = "auto") -> HoverTool:
    """A tool that tells values with their units.

    Parameters
    ----------
    rows : words, the value's template such as '@weight{0.0}', and its quantity, or a unit that does not change
    """
    metric, oilfield = ([_tip(row, number) for row in rows] for number in (0, 1))
    tool = HoverTool(tooltips=metric, renderers=renderers, point_policy="snap_to_data")
    return tagged(tool, None, {"tooltips": metric}, {"tooltips": oilfield})


def _tip(row: tuple[str, str, str], number: int) -> tuple[str, str]:
    words, template, quantity = row
    chosen = QUANTITIES.get(quantity)
    unit = quantity if chosen is None else (chosen.metric, chosen.oilfield)[number].shown
    return words, f"{template} {unit}".strip()


def drawn(
    chart: Any,
    data: ColumnDataSource,
    glyph: Glyph,
    metric: Mapping[str, Any] | None = None,
    oilfield: Mapping[str, Any] | None = None,
    *,
    name: str | None = None,
    **colours: str,
) -> Any:
    """The renderer of a glyph that is added to a chart; what is selected looks like all else.

    The methods of `figure`, such as `line`, make three more glyphs for what is selected, not selected and muted.

    Parameters
    ----------
    metric, oilfield : values of the glyph's properties in each of the units
    name : words of the chart's legend, if it has one
    colours : of the page, by the glyph's properties
    """
    alike = dict.fromkeys(("selection_glyph", "nonselection_glyph", "muted_glyph"), glyph)
    tagged(glyph, colours, metric, oilfield)
    return chart.add_glyph(data, glyph, name=name, **alike)


def level(depth: float | None, colour: str, **look: Any) -> Span:
    """A line at a depth through all charts that have it; the page's script places one without any.

    Parameters
    ----------
    depth : m
    colour : of the page
    look : other properties of the line
    """
    line = Span(location=depth, dimension="width", **look)
    if depth is None:
        return tagged(line, {"line_color": colour})
    places = (depth, depth * QUANTITIES["depth"].per_metric)
    return tagged(line, {"line_color": colour}, *({"location": place} for place in places))

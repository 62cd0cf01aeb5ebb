"""Maps of a well over depth and frequency or time, and the spectra of one window of it."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models import (
    ColorBar,
    ColumnDataSource,
    FixedTicker,
    Image,
    Legend,
    LegendItem,
    Line,
    LinearColorMapper,
    LogColorMapper,
    Range1d,
    Scatter,
    Segment,
)

from drillid.arrays import Floats
from drillid.figures.captions import RPM_PER_KILONEWTON_METRE
from drillid.figures.data import WellResults, cell_edges
from drillid.report.charts import well_data
from drillid.report.charts.style import FONT, drawn, hover, label_axis, new_chart, source, tagged
from drillid.report.charts.well_data import Maps
from drillid.report.quantities import QUANTITIES

_HEIGHT, _SPECTRUM_HEIGHT = 360, 250
_AMPLITUDE, _SIGNED = "Viridis256", "Cividis256"
_RESIDUAL_LIMIT = 4.0
TICKS = (0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10)
_TITLES = {
    "measured": "Command mobility, measured",
    "fitted": "Command mobility, identified",
    "bit_stiff": "Bit mobility, top drive clamped",
    "bit_controlled": "Bit mobility, as controlled",
    "residual_before": "Residual of the base model",
    "residual_after": "Residual of the extended model",
    "step_stiff": "Bit step response, top drive clamped",
    "step_controlled": "Bit step response, as controlled",
}
_DEPTHS = ("depth", "depth_from", "depth_to", "cell_top", "cell_bottom", "cell_height")
_MOBILITIES = ("measured", "fitted", "bit_stiff", "bit_controlled", "step_stiff", "step_controlled")


def map_source(results: WellResults, maps: Maps) -> ColumnDataSource:
    """Rows of all maps; mobilities in rpm per kN m, single precision."""
    cells = well_data.cell_columns(results)
    columns: dict[str, Any] = {name: np.asarray(values)[maps.rows] for name, values in cells.items()}
    for name, image in maps.images.items():
        factor = RPM_PER_KILONEWTON_METRE if name in _MOBILITIES else 1.0
        columns[name] = [(factor * row)[None].astype(np.float32) for row in image]
    return source(columns, dict.fromkeys(_DEPTHS, "depth") | dict.fromkeys(_MOBILITIES, "mobility"))


def map_charts(results: WellResults, maps: Maps, rows: ColumnDataSource, depths: Range1d) -> dict[str, Any]:
    """Every map by its name, all on the same range of depth.

    Parameters
    ----------
    rows : of `map_source`
    depths : range shared with the log plot
    """
    frequencies = Range1d(*results.band)
    lags = Range1d(0.0, float(maps.lag[-1]))
    charts = {}
    for name, title in _TITLES.items():
        if name not in maps.images:
            continue
        over_time = name.startswith("step")
        chart = new_chart(
            None,
            _HEIGHT,
            title=title,
            y_range=depths,
            x_range=lags if over_time else frequencies,
            x_axis_type="linear" if over_time else "log",
        )
        points = maps.lag if over_time else maps.frequency
        mapper = _colours(name, maps)
        edges = cell_edges(points) if over_time else np.exp(cell_edges(np.log(points)))
        across = {"x": float(edges[0]), "dw": float(edges[-1] - edges[0])}
        image = drawn(chart, rows, Image(image=name, y="cell_top", dh="cell_height", color_mapper=mapper, **across))
        if not over_time and not name.startswith("residual"):
            _mode_lines(chart, maps, rows)
        quantity = "mobility" if name in _MOBILITIES else "standard deviations"
        _finish(chart, image, name, quantity, "s" if over_time else "Hz")
        charts[name] = chart
    return charts


def _colours(name: str, maps: Maps) -> Any:
    """Colours with limits that related maps share."""
    if name.startswith("residual"):
        return LinearColorMapper(_AMPLITUDE, low=0.0, high=_RESIDUAL_LIMIT)
    kind = "step" if name.startswith("step") else "bit" if name.startswith("bit") else "fitted"
    alike = [np.abs(image) for other, image in maps.images.items() if other.startswith(kind) and "phase" not in other]
    values = RPM_PER_KILONEWTON_METRE * np.concatenate([image.ravel() for image in alike])
    low, high = _limits(values)
    low = -high if kind == "step" else low
    mapper = LinearColorMapper(_SIGNED) if kind == "step" else LogColorMapper(_AMPLITUDE)
    mapper.update(low=low, high=high)
    ratio = QUANTITIES["mobility"].per_metric
    limits = ({"low": low * factor, "high": high * factor} for factor in (1.0, ratio))
    return tagged(mapper, None, *limits)


def _limits(values: Floats) -> tuple[float, float]:
    finite = values[np.isfinite(values) & (values > 0)]
    if not finite.size:
        return 1e-3, 1.0
    low, high = np.percentile(finite, [0.5, 99.5])
    return float(low), float(max(high, 1.001 * low))


def _mode_lines(chart: Any, maps: Maps, rows: ColumnDataSource) -> None:
    """Modes of the identified system, in every window."""
    top, bottom = (np.asarray(rows.data[f"cell_{end}"]) for end in ("top", "bottom"))
    counts = [modes.size for modes in maps.modes]
    columns = {
        "frequency": np.concatenate([*maps.modes, np.array([])]),
        "top": np.repeat(top, counts),
        "bottom": np.repeat(bottom, counts),
    }
    modes = source(columns, {"top": "depth", "bottom": "depth"})
    look = {"line_color": "white", "line_dash": "dotted", "line_width": 1.5}
    drawn(chart, modes, Segment(x0="frequency", x1="frequency", y0="top", y1="bottom", **look))


def _finish(chart: Any, image: Any, name: str, quantity: str, across: str) -> None:
    mapper, scales = image.glyph.color_mapper, QUANTITIES.get(quantity)
    titles = (quantity, quantity) if scales is None else (scales.metric.shown, scales.oilfield.shown)
    bar = ColorBar(color_mapper=mapper, title=titles[0], width=10, padding=4, title_text_font_size="10px")
    bar.update(major_label_text_font_size="10px", title_text_font=FONT, title_text_font_style="normal")
    tagged(
        bar,
        {"title_text_color": "ink", "major_label_text_color": "muted", "background_fill_color": "paper"},
        metric={"title": titles[0]},
        oilfield={"title": titles[1]},
    )
    chart.add_layout(bar, "right")
    label_axis(chart.xaxis[0], "Frequency" if across == "Hz" else "Time since the step", unit=across, joint=" ")
    if across == "Hz":
        chart.xaxis[0].update(ticker=FixedTicker(ticks=list(TICKS)))
    label_axis(chart.yaxis[0], "Measured depth", "depth", joint=" ")
    place = "Frequency" if across == "Hz" else "Time"
    rows = [("Value", f"@{name}{{0.000}}", quantity), (place, "$x{0.00}", across), ("Depth", "@depth{0.0}", "depth")]
    chart.add_tools(hover([*rows, ("Window", "@window", "")], [image]))
    for grid in chart.grid:
        grid.update(visible=False)


def spectrum_source(maps: Maps, rows: ColumnDataSource, shown: int) -> tuple[ColumnDataSource, ColumnDataSource]:
    """Spectra over frequency and steps over time of one row of the maps; the page's script shows others."""

    def of(name: str) -> Floats:
        return np.asarray(rows.data[name][shown][0])

    over_frequency = ("measured", "measured_phase", "fitted", "fitted_phase", "coherence_map", "bit_controlled")
    spectra: dict[str, Any] = {"frequency": maps.frequency.astype(np.float32)}
    spectra |= {name: of(name) for name in (*over_frequency, "bit_stiff")}
    steps: dict[str, Any] = {"lag": maps.lag.astype(np.float32)}
    steps |= {name: of(name) for name in ("step_stiff", "step_controlled")}
    return tuple(source(columns, dict.fromkeys(_MOBILITIES, "mobility")) for columns in (spectra, steps))


def spectrum_charts(results: WellResults, spectra: ColumnDataSource, steps: ColumnDataSource) -> dict[str, Any]:
    """Amplitude, phase, coherence and bit mobility of a window over frequency, and its steps over time."""
    frequencies = Range1d(*results.band)
    amplitude = _spectrum("Command mobility", "", frequencies, quantity="mobility", logarithmic=True)
    _dots(amplitude, spectra, "measured")
    _line(amplitude, spectra, "fitted", "identified", "joint", "solid")
    phase = _spectrum("Phase", "°", frequencies)
    _dots(phase, spectra, "measured_phase")
    _line(phase, spectra, "fitted_phase", "identified", "joint", "solid")
    coherent = _spectrum("Coherence γ²", "–", frequencies, y_range=Range1d(0, 1.03))
    _dots(coherent, spectra, "coherence_map")
    bit = _spectrum("Bit mobility", "", frequencies, quantity="mobility", logarithmic=True)
    _line(bit, spectra, "bit_stiff", "top drive clamped", "flag", "dashed")
    _line(bit, spectra, "bit_controlled", "as controlled", "ink", "solid")
    step = new_chart(None, _SPECTRUM_HEIGHT, title="Bit speed after a torque step")
    label_axis(step.xaxis[0], "Time since the step", unit="s", joint=" ")
    label_axis(step.yaxis[0], "Bit speed per torque", "mobility", joint=" ")
    _line(step, steps, "step_stiff", "top drive clamped", "flag", "dashed", across="lag")
    _line(step, steps, "step_controlled", "as controlled", "ink", "solid", across="lag")
    charts = {"amplitude": amplitude, "phase": phase, "coherence": coherent, "bit": bit, "step": step}
    for chart in charts.values():
        if len(chart.renderers) > 1:
            legend(chart)
    return charts


def legend(chart: Any) -> None:
    """A legend of what has a name, in the page's colours, small and above the chart, where it covers no line."""
    items = [LegendItem(label=each.name, renderers=[each]) for each in chart.renderers if each.name]
    box = Legend(items=items, label_text_font_size="10px", label_text_font=FONT, padding=4, spacing=16, glyph_width=24)
    box.update(orientation="horizontal", location="right", background_fill_alpha=0, margin=0)
    chart.add_layout(tagged(box, {"label_text_color": "ink", "border_line_color": "none"}), "above")


def _spectrum(
    title: str,
    unit: str,
    frequencies: Range1d,
    *,
    quantity: str = "",
    logarithmic: bool = False,
    y_range: Range1d | None = None,
) -> Any:
    chart = new_chart(
        None,
        _SPECTRUM_HEIGHT,
        title=title,
        x_axis_type="log",
        y_axis_type="log" if logarithmic else "linear",
        x_range=frequencies,
        **({} if y_range is None else {"y_range": y_range}),
    )
    chart.xaxis[0].update(ticker=FixedTicker(ticks=list(TICKS)))
    label_axis(chart.xaxis[0], "Frequency", unit="Hz", joint=" ")
    label_axis(chart.yaxis[0], title, quantity, unit, joint=" ")
    return chart


def _dots(chart: Any, spectra: ColumnDataSource, name: str) -> None:
    glyph = Scatter(x="frequency", y=name)
    dots = drawn(chart, spectra, glyph, name="measured", fill_color="ink", line_color="ink")
    chart.add_tools(hover([("Measured", f"@{name}{{0.000}}", ""), ("Frequency", "@frequency{0.00}", "Hz")], [dots]))


def _line(
    chart: Any, data: ColumnDataSource, name: str, words: str, colour: str, dash: str, across: str = "frequency"
) -> None:
    drawn(chart, data, Line(x=across, y=name, line_width=2, line_dash=dash), name=words, line_color=colour)

"""The log plot of a well: tracks side by side on a common depth axis."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from bokeh.models import (
    BoxZoomTool,
    ColumnDataSource,
    FixedTicker,
    GridPlot,
    HArea,
    HoverTool,
    HStrip,
    Line,
    PanTool,
    Quad,
    Range1d,
    ResetTool,
    Scatter,
    Segment,
    Span,
    TapTool,
    Text,
    Tool,
    Toolbar,
    ToolProxy,
    WheelZoomTool,
)

from drillid.figures.captions import DISPLAYED_PARAMETERS
from drillid.figures.data import WellResults
from drillid.figures.style import well_marks
from drillid.report.charts import well_data
from drillid.report.charts.style import (
    drawn,
    hover,
    label_axis,
    level,
    new_chart,
    set_ticks,
    source,
    value_range,
)
from drillid.report.sentences import PARAMETER_QUANTITIES
from drillid.report.verdicts import VerdictText, percent

_HEIGHT = 760
_LEFT = 62
"""Pixels of the depth axis."""
_NARROW, _WIDE = 74, 98
_LINE = 13
"""Characters of a line of a track's name."""
_VERDICT_LINE = 11
"""The same of a verdict's title."""
_HEADER = 74
"""Pixels of the tracks' scales above them."""
_DEPTHS = ("depth", "depth_from", "depth_to", "cell_top", "cell_bottom", "cell_height")
_QUANTITIES = {
    **dict.fromkeys(_DEPTHS, "depth"),
    **{channel.column: channel.quantity for channel in well_data.OPERATION},
    "lowest_rotation": "rotation",
    "tuned_proportional": "proportional",
    "present_proportional": "proportional",
    "tuned_integral": "integral",
    "present_integral": "integral",
    **{
        f"{name}{end}": PARAMETER_QUANTITIES[name]
        for name in well_data.PARAMETERS_SHOWN
        for end in ("", "_low", "_high", "_joint", "_joint_lower", "_joint_upper")
    },
}
_UPRIGHT = {"dimensions": "height"}
_TOOLS: dict[type[Tool], dict[str, str]] = {
    BoxZoomTool: _UPRIGHT,
    PanTool: _UPRIGHT,
    WheelZoomTool: _UPRIGHT,
    ResetTool: {},
    TapTool: {},
}
"""Tools of each track with their properties; the first one drags."""
_SIDES = {side: side for side in ("left", "right", "top", "bottom")}
"""Columns of the ends of bars."""
_WORDS = {"text_font_size": "10px", "text_baseline": "top", "y_offset": 2}
_PERCENT = (-12.0, 115.0)
"""Ends of an axis of shares: the numbers 0 and 100 are clear of those of the tracks beside it."""
_STATES = {
    "drilling": "joint",
    "connection": "line",
    "off_bottom": "muted",
    "reaming": "flag",
    "sweep_off": "sheet",
    "unknown": "paper",
}
"""Colours of the rig's states."""


@dataclass(frozen=True)
class LogPlot:
    """The tracks in one chart, their data, and what could not be shown."""

    chart: Any
    windows: ColumnDataSource
    shown: Span
    """At the depth of the window whose spectra are shown; the page's script places it."""
    missing: tuple[str, ...]
    """Channels that are not logged, in words."""
    states: dict[str, str]
    """States of the rig that are shown, in words, with their colours."""


def log_plot(results: WellResults, verdicts: Sequence[VerdictText], depths: Range1d) -> LogPlot:
    """All tracks of a well.

    Parameters
    ----------
    depths : range shared with other charts
    """
    windows = window_source(results)
    builder = _Tracks(results, windows, depths)
    missing = []
    builder.hole()
    states = builder.states()
    for channel in well_data.OPERATION:
        if np.isfinite(windows.data[channel.column]).any():
            builder.operation(channel)
        else:
            missing.append(channel.name.lower())
    for name in well_data.PARAMETERS_SHOWN:
        builder.parameter(name)
    builder.coherence()
    builder.verdicts(verdicts)
    if np.isfinite(windows.data["tuned_proportional"]).any():
        builder.control()
    return LogPlot(builder.side_by_side(), windows, builder.shown, tuple(missing), states)


def window_source(results: WellResults) -> ColumnDataSource:
    """One row for each window."""
    rows = well_data.in_order(results)
    accepted = results.fits["accepted"].values[rows].astype(bool)
    flagged = results.discrepancy["flagged"].values[rows].astype(bool)
    columns = well_data.cell_columns(results) | well_data.operation_columns(results)
    for name in well_data.PARAMETERS_SHOWN:
        factor = DISPLAYED_PARAMETERS[name].factor
        columns |= well_data.parameter_columns(results, name, factor)
    columns |= well_data.control_columns(results)
    columns |= {
        "coherence": well_data.coherence(results),
        "accepted": np.where(accepted, "accepted", "not accepted"),
        "fill": np.where(accepted, 1.0, 0.0),
        "marker": np.where(flagged, "triangle", "circle"),
        "size": np.where(flagged, 9, 5),
    }
    return source(columns, _QUANTITIES)


class _Tracks:
    """Builds the tracks one by one; all share the data of the windows and the range of depth."""

    def __init__(self, results: WellResults, windows: ColumnDataSource, depths: Range1d) -> None:
        self.results, self.windows, self.depths = results, windows, depths
        self.tracks: list[Any] = []
        begin, end = float(windows.data["cell_top"][0]), float(windows.data["cell_bottom"][-1])
        self.marks, self.oilfield_marks = (
            well_marks(results, begin, end, oilfield=oilfield) for oilfield in (False, True)
        )
        intervals = [mark for mark in self.marks if mark.until is not None]
        self.flagged = source(
            {"top": [mark.depth for mark in intervals], "bottom": [float(mark.until or 0) for mark in intervals]},
            {"top": "depth", "bottom": "depth"},
        )
        boundaries = [mark.depth for mark in self.marks if mark.until is None and mark.line]
        self.shown = level(None, "accent", line_width=2, line_alpha=0.7)
        self.lines = [*(level(depth, "muted", line_dash="dashed") for depth in boundaries), self.shown]

    def _new(self, width: int, across: Range1d) -> Any:
        first = not self.tracks
        track = new_chart(
            width + _LEFT * first,
            _HEIGHT,
            y_range=self.depths,
            x_range=across,
            x_axis_location="above",
            y_axis_type="auto" if first else None,
            title=None,
            toolbar_location=None,
            tools=[kind(**look) for kind, look in _TOOLS.items()],
            min_border_top=_HEADER,
            min_border_bottom=4,
            min_border_left=_LEFT if first else 3,
            min_border_right=3,
        )
        track.toolbar.update(active_scroll=None, active_drag=track.tools[0])
        if first:
            label_axis(track.yaxis[0], "Measured depth", "depth", joint=" ")
        else:
            track.add_layout(self.tracks[0].ygrid[0])
        if self.flagged.data["top"]:
            drawn(track, self.flagged, HStrip(y0="top", y1="bottom", fill_alpha=0.18, line_alpha=0), fill_color="flag")
        for line in self.lines:
            track.add_layout(line)
        self.tracks.append(track)
        return track

    def side_by_side(self) -> GridPlot:
        """The tracks as one chart with one toolbar."""
        tools = [tool for track in self.tracks for tool in track.tools]
        alike = [[tool for tool in tools if isinstance(tool, kind)] for kind in _TOOLS]
        alike += [[tool] for tool in tools if isinstance(tool, HoverTool)]
        merged = [ToolProxy(tools=each) for each in alike]
        toolbar = Toolbar(tools=merged, logo=None, active_drag=merged[0], active_scroll=None)
        places = [(track, 0, place) for place, track in enumerate(self.tracks)]
        return GridPlot(children=places, toolbar=toolbar, toolbar_location="above")

    def _dots(self, track: Any, column: str, colour: str = "ink", **look: Any) -> Any:
        """Points of the windows over depth."""
        glyph = Scatter(x=column, y="depth", **{"size": 5} | look)
        return drawn(track, self.windows, glyph, fill_color=colour, line_color=colour)

    def hole(self) -> None:
        """Hole sections and assembly runs in words."""
        track = self._new(_WIDE, Range1d(0, 1))
        words, oilfield = (
            [mark for mark in marks if mark.until is None] for marks in (self.marks, self.oilfield_marks)
        )
        columns = {"depth": [mark.depth for mark in words], "metric": [mark.text for mark in words]}
        texts = source(columns | {"oilfield": [mark.text for mark in oilfield]}, _QUANTITIES)
        units = ({"text": {"field": name}} for name in ("metric", "oilfield"))
        drawn(track, texts, Text(x=0.03, y="depth", text="metric", **_WORDS), *units, text_color="ink")
        label_axis(track.xaxis[0], "Hole and\nassembly")
        track.xaxis[0].update(ticker=FixedTicker(ticks=[]))
        track.xgrid[0].update(visible=False)
        measured = Segment(x0=0, x1=0, y0="depth_from", y1="depth_to", line_width=5)
        drawn(track, self.windows, measured, line_color="ink")

    def states(self) -> dict[str, str]:
        """Shares of the rig's states in the time since the window before; the colour of each that has any."""
        track = self._new(_NARROW, Range1d(*_PERCENT))
        left = np.zeros(len(self.windows.data["depth"]))
        shares = well_data.state_shares(self.results)
        for state, share in shares.items():
            words = state.replace("_", " ")
            right = left + 100 * share
            ends = {side: self.windows.data[f"cell_{side}"] for side in ("top", "bottom")}
            data = source({"left": left, "right": right, **ends, "share": 100 * share}, dict.fromkeys(ends, "depth"))
            hatch = {"reaming": "/", "off_bottom": ".", "sweep_off": "\\"}.get(state, " ")
            quad = Quad(**_SIDES, fill_alpha=0.75, line_width=0.5, hatch_pattern=hatch, hatch_alpha=0.6)
            bars = drawn(track, data, quad, fill_color=_STATES[state], line_color="paper", hatch_color="ink")
            track.add_tools(hover([(words, "@share{0}", "% of the time")], [bars]))
            left = right
        label_axis(track.xaxis[0], "Rig state", unit="% of time")
        track.xaxis[0].update(ticker=FixedTicker(ticks=[0, 50]))
        return {state.replace("_", " "): _STATES[state] for state, share in shares.items() if share.any()}

    def operation(self, channel: well_data.Channel) -> None:
        """One channel of what the rig did."""
        values = [np.asarray(self.windows.data[channel.column])]
        rotation = channel.column == "rotation"
        if rotation:
            values.append(np.asarray(self.windows.data["lowest_rotation"]))
        across = value_range(*values, quantity=channel.quantity, zero=channel.column in ("weight", "penetration"))
        track = self._new(_NARROW, across)
        line = Segment(x0=channel.column, x1=channel.column, y0="cell_top", y1="cell_bottom", line_width=1.2)
        drawn(track, self.windows, line, line_color="ink")
        dots = self._dots(track, channel.column)
        rows = [(channel.name, f"@{channel.column}{{{_pattern(channel.decimals)}}}", channel.quantity)]
        if rotation and np.isfinite(self.windows.data["lowest_rotation"]).any():
            limit = Line(x="lowest_rotation", y="depth", line_width=2, line_dash="dashed")
            drawn(track, self.windows, limit, line_color="named")
            rows.append(("Lowest stable speed", "@lowest_rotation{0}", "rotation"))
        if rotation:
            self._draw_unstable(track)
        track.add_tools(hover([*rows, *_place()], [dots]))
        label_axis(track.xaxis[0], _wrapped(channel.name), channel.quantity)
        set_ticks(track, channel.quantity)

    def _draw_unstable(self, track: Any) -> None:
        """The windows in which no speed is stable."""
        never = np.isposinf(self.windows.data["lowest_rotation"])
        if not never.any():
            return
        ends = {side: np.asarray(self.windows.data[f"cell_{side}"])[never] for side in ("top", "bottom")}
        strips = HStrip(y0="top", y1="bottom", fill_alpha=0.15, line_alpha=0.0, hatch_pattern="x", hatch_alpha=0.4)
        data = source(ends, dict.fromkeys(ends, "depth"))
        bars = drawn(track, data, strips, fill_color="named", hatch_color="named")
        track.add_tools(hover([("Lowest stable speed", "none", "")], [bars]))

    def parameter(self, name: str) -> None:
        """A parameter window by window with its intervals, and from all windows together with its band."""
        shown, data = DISPLAYED_PARAMETERS[name], self.windows.data
        quantity = PARAMETER_QUANTITIES[name]
        used = np.asarray(data["accepted"]) == "accepted"
        held = [np.asarray(data[f"{name}_joint{end}"]) for end in ("_lower", "_upper")]
        flagged = np.asarray(data["marker"]) == "triangle"
        kept = np.concatenate([np.asarray(data[column])[flagged] for column in (name, f"{name}_joint")])
        told = np.asarray(data[name])[used if used.any() else slice(None)]
        across = value_range(told, *held, quantity=quantity, kept=kept)
        track = self._new(_WIDE, across)
        band = HArea(x1=f"{name}_joint_lower", x2=f"{name}_joint_upper", y="depth", fill_alpha=0.3)
        drawn(track, self.windows, band, fill_color="joint")
        drawn(track, self.windows, Line(x=f"{name}_joint", y="depth", line_width=2), line_color="joint")
        bars = Segment(x0=f"{name}_low", x1=f"{name}_high", y0="depth", y1="depth", line_alpha=0.5)
        drawn(track, self.windows, bars, line_color="ink")
        dots = self._dots(track, name, size="size", marker="marker", fill_alpha="fill", line_width=1.2)
        rows = [
            (shown.name, f"@{name}{{0.[00]}}", quantity),
            ("95 % interval", f"@{name}_low{{0.[00]}} to @{name}_high{{0.[00]}}", quantity),
            ("All windows together", f"@{name}_joint{{0.[00]}}", quantity),
            ("Fit", "@accepted", ""),
        ]
        track.add_tools(hover([*rows, *_place()], [dots]))
        symbol = shown.symbol + {"bha": "\u00a0bha"}.get(shown.index, "")
        label_axis(track.xaxis[0], _wrapped(f"{shown.name} {symbol}"), quantity)
        set_ticks(track, quantity)

    def coherence(self) -> None:
        """How much of the speed follows the sweep."""
        track = self._new(_NARROW, Range1d(*(end / 100 for end in _PERCENT)))
        drawn(track, self.windows, Line(x="coherence", y="depth"), line_color="ink")
        dots = self._dots(track, "coherence")
        track.add_tools(hover([("Median coherence", "@coherence{0.00}", ""), *_place()], [dots]))
        label_axis(track.xaxis[0], "Coherence\nγ²", unit="–", joint=" ")
        track.xaxis[0].update(ticker=FixedTicker(ticks=[0, 1]))

    def verdicts(self, verdicts: Sequence[VerdictText]) -> None:
        """Verdicts over their depths, beside each other where they overlap."""
        lanes = pd.Series([0] * len(verdicts), dtype=int)
        ends: list[float] = []
        for number, verdict in enumerate(verdicts):
            lane = next((index for index, end in enumerate(ends) if verdict.from_m >= end), len(ends))
            ends[lane : lane + 1] = [verdict.to_m]
            lanes[number] = lane
        track = self._new(_WIDE, Range1d(0, max(len(ends), 1)))
        look = {"named": ("named", "/", 0.8), "unknown": ("unknown", "x", 0.7)}
        for kind in {verdict.kind for verdict in verdicts}:
            colour, hatch, alpha = look.get(kind, ("muted", " ", 0.12))
            chosen = [(lane, verdict) for lane, verdict in zip(lanes, verdicts, strict=True) if verdict.kind == kind]
            columns = {
                "left": [lane + 0.04 for lane, _ in chosen],
                "right": [lane + 0.24 for lane, _ in chosen],
                "text_at": [lane + 0.29 for lane, _ in chosen],
                "top": [verdict.from_m for _, verdict in chosen],
                "bottom": [max(verdict.to_m, verdict.from_m + 0.5) for _, verdict in chosen],
                "title": [_lines(verdict.title) for _, verdict in chosen],
                "probability": [percent(verdict.probability) for _, verdict in chosen],
            }
            data = source(columns, {"top": "depth", "bottom": "depth"})
            quad = Quad(**_SIDES, fill_alpha=alpha, hatch_pattern=hatch)
            bars = drawn(track, data, quad, fill_color=colour, line_color=colour, hatch_color="paper")
            drawn(track, data, Text(x="text_at", y="top", text="title", **_WORDS), text_color="ink")
            rows = [("Verdict", "@title", ""), ("Probability", "@probability", "")]
            rows += [("From", "@top{0.0}", "depth"), ("To", "@bottom{0.0}", "depth")]
            track.add_tools(hover(rows, [bars]))
        label_axis(track.xaxis[0], "Verdicts")
        track.xaxis[0].update(ticker=FixedTicker(ticks=[]))
        track.xgrid[0].update(visible=False)

    def control(self) -> None:
        """The proportional gain with the least bit vibration beside the present one."""
        data = self.windows.data
        values = [np.asarray(data[name]) for name in ("tuned_proportional", "present_proportional")]
        track = self._new(_WIDE, value_range(*values, quantity="proportional", zero=True, share=0.0))
        present = Line(x="present_proportional", y="depth", line_width=2, line_dash="dashed")
        drawn(track, self.windows, present, line_color="muted")
        tuned = self._dots(track, "tuned_proportional", "joint", size=8, marker="diamond")
        rows = [
            ("Advised proportional gain", "@tuned_proportional{0.000}", "proportional"),
            ("at present", "@present_proportional{0.000}", "proportional"),
            ("Advised integral gain", "@tuned_integral{0.00}", "integral"),
            ("at present", "@present_integral{0.00}", "integral"),
        ]
        track.add_tools(hover([*rows, *_place()], [tuned]))
        label_axis(track.xaxis[0], "Advised gain", "proportional")
        set_ticks(track, "proportional")


def _lines(title: str) -> str:
    """A verdict's title in lines that its track has room for."""
    return "\n".join(textwrap.wrap(title.replace(" or ", " or\u00a0"), _VERDICT_LINE))


def _wrapped(name: str) -> str:
    return "\n".join(textwrap.wrap(name, _LINE))


def _pattern(decimals: int) -> str:
    return "0." + "0" * decimals if decimals else "0"


def _place() -> list[tuple[str, str, str]]:
    return [("Depth", "@depth{0.0}", "depth"), ("Start, UTC", "@start", ""), ("Window", "@window", "")]

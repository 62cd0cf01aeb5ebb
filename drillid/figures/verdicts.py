"""Figures of the verdicts: their depths, the evidence for every cause, the distinguishability of causes."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.patches import Patch

from drillid.arrays import Floats
from drillid.discrepancy.catalogue import words_of
from drillid.figures.captions import share
from drillid.figures.data import WellResults, shown_set, shown_sets
from drillid.figures.layout import TITLED, Margins, colour_bar, new_figure, panels, room_for, room_for_marks
from drillid.figures.style import DATA_SHEET, FLAGGED, INK, MUTED, NO_DATA, ROOM, depth_axis

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_NAMED, _UNKNOWN = "#c2416c", "#7d5ba6"
"""Colours of named causes and of what is unknown."""
_WORDS_WIDTH = 22
_SAME_DEPTH_M = 1.0
_CHANNELS = (("linear responses", INK, 0.19), ("detections in the records", FLAGGED, -0.19))
"""Channels of evidence with the colours of their bars, and the bars' places beside a cause."""
_UNTESTED: dict[str, Any] = {"va": "center", "size": 5, "style": "italic", "color": MUTED}
_LEAST_SHOWN = -10.0
"""Smaller evidence is drawn at this value: it is clearly against the cause."""
_TITLE_CHARACTERS = 58
"""Longest title of a set's panel, characters."""
_LINEAR_ABOVE = 10.0
"""The evidence axis is linear up to here and logarithmic beyond."""


def verdict_colour(verdict: str) -> str:
    """Grey for no cause, else a colour for a named cause or for an unknown one."""
    return {"none": MUTED, "unknown": _UNKNOWN}.get(verdict, _NAMED)


def note_missing(axis: Axes, words: str) -> None:
    """A note in place of missing data."""
    axis.grid(False)
    axis.text(0.5, 0.5, words, transform=axis.transAxes, ha="center", va="center", color=MUTED)


def set_title(results: WellResults, number: int) -> str:
    """Depths of a set and its verdicts in verdicts.csv, the likeliest first, with its probability.

    The examination's own verdict is that of the set alone; an interval within the set may have another.
    """
    begin, end = (float(results.examination[name][number]) for name in ("from_m", "to_m"))
    table = results.verdicts
    inside = table[(table["from_m"] <= end) & (table["to_m"] >= begin)]
    wrong = inside[inside["verdict"] != "none"]
    chosen = (wrong if len(wrong) else inside).sort_values("probability", ascending=False, kind="stable")
    words = f"{begin:.0f}–{end:.0f} m"
    if not len(chosen):
        return words
    first = chosen.iloc[0]
    verdict = words_of(first["verdict"])
    place = f" at {first['from_m']:.0f}–{first['to_m']:.0f} m" if _narrower(first, begin, end) else ""
    more = f", and {len(chosen) - 1} more" if len(chosen) > 1 else ""
    return f"{words}: {verdict}{place}, {share(first['probability'], 1.0)}{more}"


def _narrower(row: pd.Series, begin: float, end: float) -> bool:
    """Whether a verdict holds for only part of the set."""
    return bool(row["from_m"] > begin + _SAME_DEPTH_M or row["to_m"] < end - _SAME_DEPTH_M)


def verdicts(results: WellResults) -> Figure:
    """Every verdict over its depths, with its probability and its predictive gain."""
    figure = new_figure(results, "verdicts", 11, 5.6)
    margins = Margins(right=room_for_marks(results), bottom=0.65, across=0.19)
    track, probability, gain = panels(figure, margins, 1, 3, sharey=True, width_ratios=[2.2, 1, 1.2])
    lanes: list[float] = []
    for row in results.verdicts.to_dict("records"):
        lane = next((number for number, end in enumerate(lanes) if row["from_m"] >= end), len(lanes))
        lanes[lane : lane + 1] = [row["to_m"]]
        _draw_verdict((track, probability, gain), row, lane)
    track.set_xlim(-0.1, max(len(lanes), 2) + 0.1)
    track.set_xticks([])
    track.set_xlabel("Verdicts side by side where they overlap [–]")
    probability.set_xlim(-0.03, 1.03)
    probability.set_xlabel("Probability [–]")
    gain.axvline(0, color=MUTED, linewidth=0.9)
    gain.set_xscale("symlog", linthresh=1.0)
    gain.set_xlabel("Predictive gain on a held-out window\n[units of log-likelihood]")
    for axis in (track, probability, gain):
        depth_axis(axis, results, label=axis is track, labels=axis is gain, room=ROOM)
    if not len(results.verdicts):
        note_missing(track, "no window has a fit,\nso nothing was examined")
    return figure


def _draw_verdict(axes: tuple[Axes, Axes, Axes], row: dict[Any, Any], lane: int) -> None:
    track, probability, gain = axes
    colour, middle = verdict_colour(row["verdict"]), (row["from_m"] + row["to_m"]) / 2
    height = max(row["to_m"] - row["from_m"], 0.5)
    bar: dict[str, Any] = {"color": colour, "alpha": 0.25 if row["verdict"] == "none" else 0.75, "linewidth": 0}
    track.bar(lane + 0.06, height, width=0.1, bottom=row["from_m"], align="center", **bar)
    words = words_of(row["verdict"]).replace(" or ", "\nor ")
    if np.isfinite(row["location_m"]):
        words += f"\nat {row['location_m']:.0f} m"
    note: dict[str, Any] = {"va": "center", "size": 8, "color": colour}
    track.text(lane + 0.16, middle, words, **note)
    ends = [row["from_m"], row["to_m"]]
    probability.plot([row["probability"]] * 2, ends, color=colour, linewidth=3, solid_capstyle="butt")
    probability.plot(row["probability"], middle, "o", color=colour, markersize=5)
    if np.isfinite(row["predictive_gain"]):
        low, high = (
            row[name] if np.isfinite(row[name]) else row["predictive_gain"]
            for name in ("predictive_gain_low", "predictive_gain_high")
        )
        gain.hlines(middle, low, high, colour, linewidth=1.5)
        gain.plot(row["predictive_gain"], middle, "o", color=colour, markersize=5)


def evidence(results: WellResults) -> Figure:
    """Log Bayes factors of all causes and of unknown disturbances, a panel for each set, of the most telling ones."""
    examination, shown = results.examination, shown_sets(results.examination)
    sets = len(shown)
    figure = new_figure(results, "evidence", 5.6 * min(max(sets, 2), 3), 7.6)
    margins = Margins(left=room_for(_names(examination)), bottom=0.75, top=TITLED, across=0.17)
    axes = np.atleast_1d(panels(figure, margins, 1, max(sets, 1), sharey=True))
    for place, axis in enumerate(axes):
        axis.set_xlabel("Log Bayes factor against the model without it [–]")
        if place < sets:
            number = shown[place]
            _evidence_bars(axis, examination.isel(set=number))
            title = textwrap.shorten(set_title(results, number), _TITLE_CHARACTERS, placeholder=" …")
            axis.set_title(title, size=8.5)
        else:
            note_missing(axis, "nothing was examined")
    handles = [Patch(color=colour, label=label) for label, colour, _ in _CHANNELS]
    figure.legend(handles=handles, loc="lower center", ncols=2)
    return figure


def _names(examined: xr.Dataset) -> list[str]:
    """Causes of the catalogue, and ports of unknown disturbances, in words."""
    causes = [words_of(str(name)) for name in examined["cause"].values]
    return causes + [f"unknown: {port}" for port in examined["port"].values]


def _evidence_bars(axis: Axes, examined: xr.Dataset) -> None:
    """Linear evidence and that of detections beside each other; words where a channel has not tested a cause."""
    names = _names(examined)
    position = np.arange(len(names))[::-1]
    linear = np.concatenate([examined["log_evidence"].values, examined["unknown_evidence"].values])
    detections = np.concatenate([examined["detection_log_evidence"].values, np.full(examined.sizes["port"], np.nan)])
    for values, (_, colour, shift) in zip((linear, detections), _CHANNELS, strict=True):
        finite = np.isfinite(values)
        length = np.maximum(values[finite], _LEAST_SHOWN)
        axis.barh(position[finite] + shift, length, height=0.36, color=colour)
        for place in position[~finite]:
            axis.annotate("not tested", (0, place + shift), (2, 0), textcoords="offset points", **_UNTESTED)
    axis.axvline(0, color=MUTED, linewidth=0.9)
    axis.set_xscale("symlog", linthresh=_LINEAR_ABOVE)
    largest = float(np.nanmax(np.concatenate([linear, detections, [1.0]])))
    ticks = [tick for tick in (-10, -5, 0, 5, 10, 100, 1000, 10_000, 100_000) if tick <= max(10, 2 * largest)]
    axis.set_xticks(ticks, [f"{tick:,}".replace(",", "\u202f").replace("-", "−") for tick in ticks])
    axis.set_xlim(_LEAST_SHOWN - 1, max(11.0, 1.6 * largest))
    axis.minorticks_off()
    axis.set_yticks(position, names, size=7.5)
    axis.set_ylim(-0.7, len(names) - 0.3)


def distinguishability(results: WellResults) -> Figure:
    """Distance of each linear cause from the best fit by another one, and the smallest detectable size."""
    figure = new_figure(results, "distinguishability", 11, 7.0)
    room = room_for(_names(results.examination))
    margins = Margins(left=room, bottom=0.2 + room, top=TITLED, across=0.75 + room)
    matrix, sizes = panels(figure, margins, 1, 2, width_ratios=[1.55, 1])
    number = shown_set(results.examination)
    if number is None:
        note_missing(matrix, "nothing was examined")
        note_missing(sizes, "nothing was examined")
        return figure
    examined = results.examination.isel(set=number)
    rows = np.flatnonzero(np.isfinite(examined["typical_size"].values))
    names = [words_of(str(name)) for name in examined["cause"].values[rows]]
    distance = examined["separation"].values[np.ix_(rows, rows)].copy()
    np.fill_diagonal(distance, np.nan)
    matrix.set_facecolor(NO_DATA)
    mesh = matrix.pcolormesh(np.ma.masked_invalid(np.maximum(distance, 0.1)), cmap="viridis", norm=LogNorm(0.1, 100))
    colour_bar(mesh, [matrix], "Distance [standard deviations]", 0.1)
    entry: dict[str, Any] = {"ha": "center", "va": "center", "size": 5.5, "parse_math": False}
    for (down, across), value in np.ndenumerate(distance):
        if np.isfinite(value):
            text = f"{value:.0f}" if value >= 9.5 else f"{value:.1f}"
            shade = "white" if value < 4 else INK
            matrix.text(across + 0.5, down + 0.5, text, color=shade, **entry)
    middle = np.arange(len(rows)) + 0.5
    matrix.set_xticks(middle, names, rotation=90, size=7.5)
    matrix.set_yticks(middle, names, size=7.5)
    matrix.invert_yaxis()
    matrix.grid(False)
    matrix.set_title(set_title(results, number))
    matrix.set_xlabel("mistaken for [–]")
    _smallest_sizes(sizes, examined["smallest_detectable"].values[rows] / examined["typical_size"].values[rows], names)
    return figure


def _smallest_sizes(axis: Axes, ratio: Floats, names: list[str]) -> None:
    position = np.arange(len(names))
    drawn = np.clip(ratio, 1e-3, 1e3)
    axis.hlines(position, 1e-3, drawn, INK, linewidth=0.9, alpha=0.5)
    axis.plot(drawn, position, "o", color=INK, markersize=4.5)
    axis.axvline(1, color=DATA_SHEET, linewidth=1.6)
    axis.set_xscale("log")
    axis.set_xlim(1e-3, 1.5e3)
    axis.set_yticks(position, names, size=7.5)
    axis.set_ylim(len(names) - 0.4, -0.6)
    axis.set_title("Smallest detectable size")
    axis.set_xlabel("Three standard deviations per usual size [–]")

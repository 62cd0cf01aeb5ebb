"""Common style of all figures: fonts, colours, headings, depth axes, and marks of hole sections, runs and intervals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.transforms import blended_transform_factory

from drillid.arrays import Floats, Integers
from drillid.figures.data import WellResults, cell_edges
from drillid.units import to_si_factor

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh

    from drillid.config.rig import Collars


STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9,
    "axes.edgecolor": "#5b6670",
    "axes.labelcolor": "#26323c",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "text.color": "#26323c",
    "xtick.color": "#5b6670",
    "ytick.color": "#5b6670",
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e8eb",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "lines.linewidth": 1.2,
    "figure.facecolor": "white",
    # letters in PDF files are text that can be found and edited
    "pdf.fonttype": 42,
    # identifiers in SVG files are the same in every run
    "svg.hashsalt": "drillid",
}
INK, MUTED, FLAGGED, DATA_SHEET, REJECTED = "#1f3b57", "#5b6670", "#d9822b", "#7fa8d1", "#9aa3ab"
"""Colours of values, secondary marks, flagged intervals, the rig's data sheets, and fits not accepted."""
JOINT, CHANGE = "#00806b", "#c2416c"
"""Colours of tracks from all windows together, and of depths where one jumps."""
NO_DATA = "#d5d9dc"
"""Background of images: not measured, or rejected by the gate."""
AMPLITUDE, PHASE, SIGNED = "viridis", "plasma", "RdBu_r"
ROOM = 0.012
"""Margin above and below the markers, as a share of the depths, so that the outermost are whole."""

_COLUMNS = 400
"""Columns of an image; about as many as it has pixels in a row."""
_LABEL_SPACING = 0.034
"""Least distance of labels beside an axis, as a share of its height."""


def depth_axis(
    axis: Axes,
    results: WellResults,
    *,
    label: bool = True,
    labels: bool = True,
    room: float = 0.0,
    shaded: bool = False,
    line: str = MUTED,
) -> None:
    """Depth downwards over all windows, with the measured intervals as bars at the left edge and the well's marks.

    Parameters
    ----------
    label, labels : whether the axis has its name, and the marks their labels
    room : margin above and below, as a share of the depths
    shaded, line : flagged intervals as shades rather than bars; colour of boundaries
    """
    cells = results.cells
    margin = room * float(cells.edges[-1] - cells.edges[0])
    axis.set_ylim(cells.edges[-1] + margin, cells.edges[0] - margin)
    if label:
        axis.set_ylabel("Measured depth [m]")
    beside = blended_transform_factory(axis.transAxes, axis.transData)
    start, end = cells.measured.T
    measured: dict[str, Any] = {"linewidth": 2.5, "transform": beside, "clip_on": False}
    axis.plot(np.full(3 * start.size, -0.008), apart(start, end), INK, solid_capstyle="butt", **measured)
    marks = well_marks(results, cells.edges[0], cells.edges[-1])
    _draw_marks(axis, marks, shaded=shaded, line=line)
    if labels:
        _label_marks(axis, marks)


def apart(begin: Floats, end: Floats) -> Floats:
    """Ends of successive lines with gaps between them: a single path is drawn faster than one for each line."""
    return np.stack([begin, end, np.full_like(begin, np.nan)], axis=-1).ravel()


def horizontal(axis: Axes, height: Floats, begin: Floats, end: Floats, colour: str, alpha: float) -> None:
    """A thin horizontal line at each height."""
    look: dict[str, Any] = {"linewidth": 0.9, "alpha": alpha, "solid_capstyle": "butt"}
    axis.plot(apart(begin, end), np.repeat(height, 3), colour, **look)


def depth_image(axis: Axes, results: WellResults, points: Floats, rows: Floats, **colours: Any) -> QuadMesh:
    """Rows (window, point) as an image over the points and the depths of the windows; grey where there are no data.

    Points that are too close to be distinguished are thinned out.
    """
    cells, seen = results.cells, _seen(points)
    points, rows = points[seen], rows[:, seen]
    axis.set_facecolor(NO_DATA)
    mesh = axis.pcolormesh(cell_edges(points), cells.edges, cells.image(rows), rasterized=True, **colours)
    axis.grid(False)
    return mesh


def _seen(points: Floats) -> Integers:
    """Places of the points; of many, those nearest to a logarithmic grid, or to an even one where they begin at 0."""
    if points.size <= _COLUMNS:
        return np.arange(points.size)
    first, last = float(points[0]), float(points[-1])
    even = np.linspace(first, last, _COLUMNS) if first <= 0 else np.geomspace(first, last, _COLUMNS)
    return np.unique(np.searchsorted((points[1:] + points[:-1]) / 2, even))


@dataclass(frozen=True)
class Mark:
    """A labelled depth: a boundary, or an interval down to `until`; m."""

    depth: float
    text: str
    until: float | None = None
    line: bool = True
    """False for a section or run that began above and has a label only."""


def well_marks(results: WellResults, shallowest: float, deepest: float, *, oilfield: bool = False) -> list[Mark]:
    """Hole sections and assembly runs that begin in the drawn depths or just before them, and flagged intervals.

    Parameters
    ----------
    oilfield : sizes of collars in feet and inches
    """
    beginnings: dict[float, list[str]] = {}
    for begin, text in [
        *((section.from_depth, f"{section.diameter} hole") for section in results.rig.hole_sections),
        *((run.from_depth, _collars(run, oilfield=oilfield)) for run in results.rig.collars),
    ]:
        beginnings.setdefault(begin, []).append(text)
    above = [begin for begin in beginnings if begin <= shallowest]
    marks = [Mark(begin, "\n".join(texts)) for begin, texts in beginnings.items() if shallowest < begin < deepest]
    if above:
        latest: dict[bool, str] = {}
        for begin in sorted(above):
            latest |= {text.endswith("hole"): text for text in beginnings[begin]}
        marks.append(Mark(shallowest, "\n".join(text for _, text in sorted(latest.items(), reverse=True)), line=False))
    for begin, end in results.intervals[["from_m", "to_m"]].to_numpy(dtype=float):
        marks.append(Mark(float(begin), f"flagged\n{begin:.0f}–{end:.0f} m", float(end)))
    return sorted(marks, key=lambda mark: mark.depth)


def _collars(run: Collars, *, oilfield: bool) -> str:
    if oilfield:
        length, diameter = (
            value / to_si_factor(unit, "m") for value, unit in ((run.length, "ft"), (run.outer_diameter, "in"))
        )
        return f"{length:.0f} ft collars\nOD {diameter:.3g} in"
    return f"{run.length:.0f} m collars\nOD {run.outer_diameter * 1e3:.0f} mm"


def _draw_marks(axis: Axes, marks: list[Mark], *, shaded: bool, line: str) -> None:
    """Boundaries as dashed lines; flagged intervals shaded, or as a bar at the right edge of an image."""
    beside = blended_transform_factory(axis.transAxes, axis.transData)
    for mark in marks:
        if mark.until is None:
            if mark.line:
                axis.axhline(mark.depth, color=line, linewidth=0.9, linestyle=(0, (5, 3)))
        elif shaded:
            axis.axhspan(mark.depth, mark.until, color=FLAGGED, alpha=0.22, linewidth=0)
        else:
            axis.vlines(1.012, mark.depth, mark.until, FLAGGED, linewidth=4, transform=beside, clip_on=False)
            axis.hlines([mark.depth, mark.until], 0, 1, FLAGGED, linewidth=0.9, transform=beside)


def _label_marks(axis: Axes, marks: list[Mark]) -> None:
    """Texts to the right of the axis, moved down where they would overlap."""
    bottom, top = axis.get_ylim()
    lowest = -1.0
    for mark in marks:
        rows = mark.text.count("\n") + 1
        position = (mark.depth - top) / (bottom - top)
        if mark.until is not None:
            position = ((mark.depth + mark.until) / 2 - top) / (bottom - top) - rows * _LABEL_SPACING / 2
        position = max(position, lowest)
        lowest = position + rows * _LABEL_SPACING + 0.01
        colour = MUTED if mark.until is None else "#a85a0c"
        axis.annotate(
            mark.text, (1.0, 1 - position), (8, 0), "axes fraction", "offset points", va="top", color=colour, size=8
        )


def frequency_axis(axis: Axes, band: tuple[float, float], *, label: bool = True) -> None:
    """Logarithmic frequency with plain numbers."""
    axis.set_xscale("log")
    axis.set_xlim(*band)
    ticks = [tick for tick in (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20) if band[0] <= tick <= band[1]]
    axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.minorticks_off()
    if label:
        axis.set_xlabel("Frequency [Hz]")

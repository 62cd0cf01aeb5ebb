"""Sheets that figures are drawn on: a heading, panels at fixed distances from the edges, colour bars beside panels.

An engine that measures all texts to find their places takes longer than the drawing itself, so that every figure states
its margins in inches. Only the room for labels beside the last panel depends on the labels: on their longest line.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from drillid.errors import SettingsError
from drillid.figures.captions import FIGURES
from drillid.figures.style import MUTED, STYLE, well_marks

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable
    from matplotlib.colorbar import Colorbar

    from drillid.figures.data import WellResults

_HEADING: dict[str, Any] = {"size": 12, "weight": "bold", "parse_math": False}
"""Look of headings; the name of a well is not a formula."""
_HEADING_HEIGHT = 0.3
_CAPTION_LINE_HEIGHT = 0.165
_CHARACTERS = 15.5
"""Characters of a caption per inch."""
_CHARACTER = 0.067
"""Width of a character of a label beside an axis, inches."""
TITLED = 0.23
"""Top margin of panels with titles, inches."""
_BESIDE = 0.12
"""Distance from an axis to its labels, inches."""
_THIRD, _NUMBERS = 2.6, 0.6
"""Width of the panel beside two images, and of its numbers and name to the left of it, inches."""
_SHARE = 0.92
"""Length of a colour bar, as a share of its panels'."""
_THICKNESS = 0.15
_COMPRESSION = 3
"""Level of zlib; higher ones take twice the time for files that are a tenth smaller."""
FORMATS = ("png", "svg", "pdf")
"""Suffixes of the files that figures are written to."""
_UNDATED: dict[str, dict[str, None]] = {"svg": {"Date": None}, "pdf": {"CreationDate": None, "Producer": None}}


@dataclass(frozen=True)
class Margins:
    """Distances of panels from the edges of their sheet and from each other, inches; the top is below the heading."""

    left: float = 0.63
    right: float = 0.11
    bottom: float = 0.44
    top: float = 0.06
    across: float = 0.3
    """Between columns of panels."""
    down: float = 0.3
    """Between rows of panels."""


def new_figure(results: WellResults, name: str, width: float, height: float) -> Figure:
    """A figure with the well's name and the figure's title and caption above the room for its panels, in inches."""
    text = FIGURES[name]
    lines = textwrap.wrap(text.caption, int(width * _CHARACTERS))
    heading = _HEADING_HEIGHT + _CAPTION_LINE_HEIGHT * len(lines) + 0.08
    total = height + heading
    figure = Figure(figsize=(width, total))
    FigureCanvasAgg(figure)
    figure.subplots_adjust(top=height / total)
    figure.text(0.1 / width, 1 - 0.07 / total, f"{results.name} · {text.title}", va="top", **_HEADING)
    below = 1 - _HEADING_HEIGHT / total
    figure.text(0.1 / width, below, "\n".join(lines), size=8.5, color=MUTED, va="top", linespacing=1.3)
    return figure


def panels(figure: Figure, margins: Margins, rows: int = 1, columns: int = 1, **options: Any) -> Any:
    """Rows and columns of panels within margins; an axis, or an array of axes as from `Figure.subplots`.

    Parameters
    ----------
    options : of `Figure.subplots`, such as `sharex` and `width_ratios`
    """
    width, total = figure.get_size_inches()
    height = figure.subplotpars.top * total
    wide = width - margins.left - margins.right - (columns - 1) * margins.across
    high = height - margins.bottom - margins.top - (rows - 1) * margins.down
    grid = {
        "left": margins.left / width,
        "right": 1 - margins.right / width,
        "bottom": margins.bottom / total,
        "top": (height - margins.top) / total,
        "wspace": margins.across * columns / wide,
        "hspace": margins.down * rows / high,
    }
    return figure.subplots(rows, columns, gridspec_kw=grid, **options)


def image_pair(figure: Figure, results: WellResults) -> tuple[tuple[Axes, Axes], Axes]:
    """Two images against depth with room for their colour bar below them, and a panel to the right of both."""
    beside = room_for_marks(results) + _THIRD + _NUMBERS
    first, second = panels(figure, Margins(right=beside, bottom=1.1, top=TITLED, across=0.5), 1, 2)
    left = float(figure.get_size_inches()[0]) - _THIRD
    return (first, second), panels(figure, Margins(left=left, bottom=1.1, top=TITLED))


def colour_bar(
    mesh: ScalarMappable, axes: Sequence[Axes], label: str, distance: float, *, below: bool = False, **options: Any
) -> Colorbar:
    """A colour bar beside panels, or below them.

    Parameters
    ----------
    axes : the panels
    distance : inches from the panels
    options : of `Figure.colorbar`, such as `ticks`
    """
    figure = axes[0].get_figure()
    assert isinstance(figure, Figure)
    corners = np.array([axis.get_position().extents for axis in axes])
    first, last = corners[:, :2].min(axis=0), corners[:, 2:].max(axis=0)
    away, thick = (np.array([distance, _THICKNESS])[:, None] / figure.get_size_inches())[:, 1 if below else 0]
    along = 0 if below else 1
    start, length = first[along] + (1 - _SHARE) / 2 * (last - first)[along], _SHARE * (last - first)[along]
    place = (start, first[1] - away - thick, length, thick) if below else (last[0] + away, start, thick, length)
    axis = figure.add_axes(place, label="<colorbar>")
    orientation = "horizontal" if below else "vertical"
    return figure.colorbar(mesh, cax=axis, orientation=orientation, label=label, extend="both", **options)


def room_for(texts: Sequence[str]) -> float:
    """Inches that the longest line of some labels and its distance from the axis take; 0 without labels."""
    longest = max((len(line) for text in texts for line in text.split("\n")), default=0)
    return _BESIDE + _CHARACTER * longest if longest else 0.0


def room_for_marks(results: WellResults) -> float:
    """Inches that the labels of a well's hole sections, runs and intervals take beside a depth axis."""
    edges = results.cells.edges
    return room_for([mark.text for mark in well_marks(results, edges[0], edges[-1])])


def save(figure: Figure, path: Path, dpi: int, *, heading: bool = True) -> None:
    """Write a PNG, SVG or PDF file, by its suffix, that depends on its content alone.

    Parameters
    ----------
    dpi : resolution of a PNG, and of the images in the other formats
    heading : False for the panels alone, for a publication with a caption of its own

    Raises
    ------
    SettingsError
        If the suffix is none of these.
    """
    suffix = path.suffix.lower().removeprefix(".")
    if suffix not in FORMATS:
        raise SettingsError(str(path), "is not a figure file", f"End its name in one of {', '.join(FORMATS)}")
    if not heading:
        figure = _without_heading(figure)
    figure.set_dpi(dpi)
    with rc_context(STYLE):
        if suffix == "png":
            # Figure.savefig would draw everything twice
            canvas: Any = FigureCanvasAgg(figure)
            canvas.print_png(path, metadata={"Software": None}, pil_kwargs={"compress_level": _COMPRESSION})
        else:
            figure.savefig(path, dpi=dpi, metadata={"Creator": None, **_UNDATED[suffix]})


def _without_heading(figure: Figure) -> Figure:
    """The figure without its heading and the room for it; panels keep their places in inches."""
    width, total = figure.get_size_inches()
    height = figure.subplotpars.top * total
    for text in list(figure.texts):
        text.remove()
    for axis in figure.axes:
        left, bottom, wide, high = axis.get_position().bounds
        axis.set_position((left, bottom * total / height, wide, high * total / height))
    figure.set_size_inches(width, height)
    return figure

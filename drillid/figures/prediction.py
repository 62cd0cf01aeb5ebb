"""Figures of base against extended model: their residuals, a held-out window, and the reflectogram."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import Normalize

from drillid.datasets.codes import Gate
from drillid.figures.data import WellResults, shown_set
from drillid.figures.layout import TITLED, Margins, colour_bar, image_pair, new_figure, panels
from drillid.figures.style import (
    DATA_SHEET,
    FLAGGED,
    INK,
    MUTED,
    NO_DATA,
    SIGNED,
    depth_axis,
    depth_image,
    frequency_axis,
)
from drillid.figures.verdicts import note_missing, set_title
from drillid.figures.windows import MOBILITY_LABEL, degrees
from drillid.statistics import TWO_SIDED

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_BASE, _EXTENDED = FLAGGED, INK
_BASE_WIDTH, _EXTENDED_WIDTH = 3.2, 1.1
"""Line widths: the base model shows on both sides of an extended one that is drawn over it."""
_LIMIT = 4.0
"""Standard deviations at the ends of the residuals' colours."""
_SEGMENT = 0.25
"""Share of the sweep's period that is drawn in time, from the middle on."""


def model_residuals(results: WellResults) -> Figure:
    """Real part of the whitened residuals before and after, and their mean square over frequency."""
    figure = new_figure(results, "model_residuals", 11, 5.2)
    images, mean_square = image_pair(figure, results)
    if not results.examination.sizes["set"]:
        for axis in (*images, mean_square):
            note_missing(axis, "nothing was examined")
        return figure
    frequency = results.examination["frequency"].values
    colours: dict[str, Any] = {"norm": Normalize(-_LIMIT, _LIMIT), "cmap": SIGNED}
    models = (("residual_before", "Base model"), ("residual_after", "Extended model"))
    for axis, (name, title) in zip(images, models, strict=True):
        if name == "residual_after" and not results.examination.sizes["extension"]:
            note_missing(axis, "no cause is named,\nso no model is extended")
            axis.set_xticks([])
            depth_axis(axis, results, label=False, line=INK)
            continue
        mesh = depth_image(axis, results, frequency, results.examination[name].values.real, **colours)
        frequency_axis(axis, results.band)
        axis.set_title(title)
        depth_axis(axis, results, label=axis is images[0], labels=axis is images[1], line=INK)
    colour_bar(mesh, images, "Residual, real part [standard deviations]", 0.49, below=True)
    _mean_squares(mean_square, results)
    return figure


def _mean_squares(axis: Axes, results: WellResults) -> None:
    """Mean over all windows of the squared residual, smoothed over 13 frequencies; 1 for a correct model."""
    frequency = results.examination["frequency"].values
    axis.axhline(1, color=MUTED, linewidth=0.9)
    before, after = (results.examination[f"residual_{end}"].values for end in ("before", "after"))
    extended = not np.array_equal(before, after, equal_nan=True)
    lines = [("residual_before", "base model", _BASE, _BASE_WIDTH if extended else _EXTENDED_WIDTH)]
    if extended:
        lines.append(("residual_after", "extended model", _EXTENDED, _EXTENDED_WIDTH))
    for name, label, colour, width in lines:
        power = np.abs(results.examination[name].values) ** 2 / 2
        used = np.isfinite(power)
        kernel = np.ones(13)
        total = np.convolve(np.where(used, power, 0.0).sum(axis=0), kernel, "same")
        count = np.convolve(used.sum(axis=0).astype(float), kernel, "same")
        smooth = np.where(count > 0, total / np.maximum(count, 1.0), np.nan)
        axis.plot(frequency, smooth, color=colour, linewidth=width, label=label)
    frequency_axis(axis, results.band)
    axis.set_yscale("log")
    low, high = axis.get_ylim()
    low, high = min(low, 0.5), max(high, 2.0)
    axis.set_ylim(low, high)
    ticks = [tick for tick in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 1000) if low <= tick <= high]
    axis.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.minorticks_off()
    axis.set_title("Mean square of all windows")
    axis.set_ylabel("Per noise variance [–]")
    axis.legend(loc="upper right")


def held_out(results: WellResults) -> Figure:
    """A held-out window over frequency and over a segment of its sweep's period, as both models predict it."""
    figure = new_figure(results, "held_out", 10.5, 7.6)
    margins = Margins(left=0.95, top=TITLED, down=0.42)
    amplitude, phase, time = panels(figure, margins, 3, 1, height_ratios=[1.7, 1.1, 1.5])
    phase.sharex(amplitude)
    number = shown_set(results.examination)
    if number is None:
        for axis in (amplitude, phase, time):
            note_missing(axis, "nothing was examined")
        return figure
    examined = results.examination.isel(set=number)
    row = int(np.flatnonzero(results.windows["window"].values == int(examined["held_out_window"]))[0])
    frequency = examined["frequency"].values
    window = results.mobility.isel(window=row)
    used = window["gate"].values == Gate.USED
    measured = np.where(used, window["command_mobility"].values, np.nan)
    size, margin = np.abs(measured), TWO_SIDED * np.sqrt(window["command_mobility_variance"].values / 2)
    bars: dict[str, Any] = {"color": DATA_SHEET, "alpha": 0.45, "linewidth": 1.2}
    amplitude.vlines(frequency, np.maximum(size - margin, size * 0.02), size + margin, **bars)
    amplitude.plot(frequency, size, ".", color=MUTED, markersize=3, label="measured, with 95 % bands")
    phase.plot(frequency, degrees(measured), ".", color=MUTED, markersize=3)
    for name, label, colour, width in _predictions(examined, "held_out"):
        line: dict[str, Any] = {"color": colour, "linewidth": width, "label": label}
        amplitude.plot(frequency, np.abs(examined[name].values), **line)
        phase.plot(frequency, degrees(examined[name].values), **line)
    frequency_axis(amplitude, results.band, label=False)
    finite = size[np.isfinite(size)]
    amplitude.set_yscale("log")
    amplitude.set_ylim(float(np.percentile(finite, 0.3)) / 1.5, float(finite.max()) * 1.5)
    amplitude.set_ylabel(f"Command m{MOBILITY_LABEL[1:]}")
    depth = float(results.windows["hole_depth"][row])
    amplitude.set_title(f"{set_title(results, number)}; held out: the window at {depth:.1f} m")
    amplitude.legend(loc="best")
    phase.set_ylabel("Phase [°]")
    phase.set_xlabel("Frequency [Hz]")
    _in_time(time, examined)
    return figure


def _predictions(examined: xr.Dataset, stem: str) -> list[tuple[str, str, str, float]]:
    """Variables with labels, colours and widths; one line where no cause extends the model."""
    extended = not np.array_equal(examined[f"{stem}_base"].values, examined[f"{stem}_extended"].values, equal_nan=True)
    if not extended:
        return [(f"{stem}_base", "base model of the other windows", _BASE, _EXTENDED_WIDTH)]
    return [
        (f"{stem}_base", "base model of the other windows", _BASE, _BASE_WIDTH),
        (f"{stem}_extended", "extended model of the other windows", _EXTENDED, _EXTENDED_WIDTH),
    ]


def _in_time(axis: Axes, examined: xr.Dataset) -> None:
    """The part of the sweep's period with the largest speed response."""
    axis.set_xlabel("Time in the sweep [s]")
    axis.set_ylabel("Top-drive speed\nless its mean [rad/s]")
    time, speed = examined["period_time"].values, examined["period_speed"].values
    if not np.isfinite(time).all():
        note_missing(axis, "the sweep is not periodic")
        return
    length = int(_SEGMENT * time.size)
    power = np.convolve(speed**2, np.ones(length), "valid")
    first = int(np.argmax(power))
    chosen = slice(first, first + length)
    margin = TWO_SIDED * float(examined["period_error"])
    if np.isfinite(margin):
        axis.fill_between(
            time[chosen], speed[chosen] - margin, speed[chosen] + margin, color=DATA_SHEET, alpha=0.35, linewidth=0
        )
    axis.plot(time[chosen], speed[chosen], color=MUTED, linewidth=1.0, label="measured, mean of the periods")
    for name, label, colour, width in _predictions(examined, "period"):
        error = float(np.sqrt(np.mean((speed - examined[name].values) ** 2)))
        words = f"{label.split(' of ')[0]}, error {1e3 * error:.1f} mrad/s rms"
        axis.plot(time[chosen], examined[name].values[chosen], color=colour, linewidth=width, label=words)
    axis.legend(loc="best", ncols=3)


def reflectogram(results: WellResults) -> Figure:
    """Measured less modelled reflection against distance along the string, before and after."""
    figure = new_figure(results, "reflectogram", 10, 3.6)
    axis = panels(figure, Margins(left=0.93, top=TITLED))
    axis.set_xlabel("Distance along the string from its top [m]")
    axis.set_ylabel("Reflection that the\nmodel lacks [–]")
    number = shown_set(results.examination)
    if number is None:
        note_missing(axis, "nothing was examined")
        return figure
    examined = results.examination.isel(set=number)
    distance, level = examined["distance"].values, examined["reflection_level"].values
    axis.fill_between(distance, -level, level, color=NO_DATA, alpha=0.7, linewidth=0, label="noise")
    before, after = examined["reflection_before"].values, examined["reflection_after"].values
    extended = not np.array_equal(before, after)
    width = _BASE_WIDTH if extended else _EXTENDED_WIDTH
    axis.plot(distance, before, color=_BASE, linewidth=width, label="base model")
    if extended:
        axis.plot(distance, after, color=_EXTENDED, linewidth=_EXTENDED_WIDTH, label="extended model")
    rows = results.examination["window_set"].values == number
    ends = results.windows["bit_depth"].values[rows]
    axis.axvspan(float(ends.min()), float(ends.max()), color=DATA_SHEET, alpha=0.3, linewidth=0, label="bit")
    axis.set_xlim(0, distance[-1])
    axis.set_title(set_title(results, number))
    axis.legend(loc="upper right", ncols=2)
    return figure

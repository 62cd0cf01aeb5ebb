"""Tracks against depth, as in a well log: the eight parameters, and anomalies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from drillid.arrays import Booleans, Floats
from drillid.discrepancy.stage import RESIDUAL_TESTS
from drillid.figures.captions import DISPLAYED_PARAMETERS, LENGTH_LESS_DEPTH
from drillid.figures.data import DepthCells, WellResults, drilled_length
from drillid.figures.layout import Margins, new_figure, panels, room_for_marks
from drillid.figures.style import CHANGE, DATA_SHEET, FLAGGED, INK, JOINT, MUTED, REJECTED, ROOM, depth_axis, horizontal
from drillid.physics.parameters import BOUNDS, PARAMETERS
from drillid.statistics import TWO_SIDED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_SHARE_SHOWN = (2.0, 98.0)
"""Percentiles of the windows' values, or of the ends of their bars, that an axis must hold."""
_ORDER = ("inertia_bha", "damping_bha", "kappa", "delta", "length", "polar_moment", "inertia_td", "delay")
"""From parameters that change with the hole to those of the rig."""
_SMALLEST_P_VALUE = 1e-6
"""Smaller p-values are drawn at this value."""


def parameters(results: WellResults) -> Figure:
    """All eight parameters with their errors, the rig's data sheets, sections, runs and flagged intervals."""
    figure = new_figure(results, "parameters", 11, 9.2)
    margins = Margins(right=room_for_marks(results), bottom=0.62, across=0.27, down=0.67)
    axes = panels(figure, margins, 2, 4, sharey=True)
    cells = results.cells
    for axis, name in zip(axes.flat, _ORDER, strict=True):
        _track(axis, results, cells, name)
        left, right = axis in axes[:, 0], axis in axes[:, -1]
        depth_axis(axis, results, label=left, labels=right, room=ROOM, shaded=True)
    return figure


def _track(axis: Axes, results: WellResults, cells: DepthCells, name: str) -> None:
    """One parameter with its bars, one-sided where it lies at a bound."""
    quantity, fits = DISPLAYED_PARAMETERS[name], results.fits.sel(parameter=name)
    shift = drilled_length(results.rig, results.windows["bit_depth"].values) if name == "length" else 0.0
    value = (fits["value"].values - shift) * quantity.factor
    margin = TWO_SIDED * fits["standard_error"].values * quantity.factor
    depth, accepted = results.windows["hole_depth"].values, fits["accepted"].values
    least, most = (bound - shift for bound in BOUNDS[:, list(PARAMETERS).index(name)])
    at_low = fits["at_bound"].values & (fits["value"].values - shift < (least + most) / 2)
    at_high = fits["at_bound"].values & ~at_low
    low = np.where(at_low, value, np.maximum(value - margin, least * quantity.factor))
    high = np.where(at_high, value, np.minimum(value + margin, most * quantity.factor))
    data_sheet = (fits["prior"].values - shift) * quantity.factor
    band = joint_band(results, name, shift, quantity.factor)
    axis.set_xlim(*_limits(low, high, value, accepted, data_sheet, band))
    order = cells.order[cells.order >= 0]
    _draw_data_sheet(axis, cells, data_sheet[order], (TWO_SIDED * quantity.factor * fits["prior_error"].values)[order])
    for member, colour in ((accepted, INK), (~accepted, REJECTED)):
        horizontal(axis, depth[member], low[member], high[member], colour, 0.4)
    kinds = (("o", ~at_low & ~at_high), ("<", at_low), (">", at_high))
    for marker, member in kinds:
        _points(axis, value, depth, member & accepted, marker, INK, filled=marker == "o")
        _points(axis, value, depth, member & ~accepted, marker, REJECTED, filled=False)
    draw_joint(axis, results, name, band)
    axis.set_xlabel(LENGTH_LESS_DEPTH if name == "length" else quantity.axis_label)


def _points(
    axis: Axes, value: Floats, depth: Floats, member: Booleans, marker: str, colour: str, *, filled: bool
) -> None:
    """Markers; a value outside of the axis is an arrow at its edge."""
    low, high = axis.get_xlim()
    outside = member & ((value < low) | (value > high))
    face = colour if filled else "white"
    inside = member & ~outside
    look: dict[str, Any] = {"linestyle": "none", "markeredgecolor": colour, "markeredgewidth": 0.9}
    axis.plot(value[inside], depth[inside], marker=marker, markersize=3.8, markerfacecolor=face, zorder=3, **look)
    for end, direction in ((low, "$\\leftarrow$"), (high, "$\\rightarrow$")):
        beyond = outside & ((value < low) if end == low else (value > high))
        if beyond.any():
            arrows: dict[str, Any] = {"marker": direction, "markersize": 8, "linestyle": "none", "clip_on": False}
            axis.plot(np.full(beyond.sum(), end), depth[beyond], color=colour, **arrows)


def _draw_data_sheet(axis: Axes, cells: DepthCells, prior: Floats, margin: Floats) -> None:
    """The data sheets' value with its 95 % band from the first edge to the last; rows in order of depth."""
    stated = np.isfinite(prior)
    if not stated.any():
        return
    depth = np.concatenate([cells.edges[:1], cells.measured.mean(axis=1)[stated], cells.edges[-1:]])
    value, half = (np.pad(row[stated], 1, mode="edge") for row in (prior, margin))
    axis.fill_betweenx(depth, value - half, value + half, color=DATA_SHEET, alpha=0.25, linewidth=0)
    axis.plot(value, depth, color=DATA_SHEET, linewidth=1.6)


def _limits(
    low: Floats, high: Floats, value: Floats, accepted: Booleans, data_sheet: Floats, band: Floats
) -> tuple[float, float]:
    """Limits for the joint fit's band and the accepted windows' values; without a band, for the windows' bars."""
    member = accepted & np.isfinite(low) & np.isfinite(high)
    if not member.any():
        member = np.isfinite(low) & np.isfinite(high)
    has_band = np.isfinite(band).all()
    least, most = (value, value) if has_band else (low, high)
    ends = (
        [
            *np.percentile(least[member], _SHARE_SHOWN[:1], method="lower"),
            *np.percentile(most[member], _SHARE_SHOWN[1:], method="higher"),
        ]
        if member.any()
        else []
    )
    ends += [*data_sheet[np.isfinite(data_sheet)], *(band.ravel() if has_band else [])]
    if not ends:
        return 0.0, 1.0
    room = 0.06 * (max(ends) - min(ends)) or 0.05 * abs(max(ends)) or 1.0
    return min(ends) - room, max(ends) + room


def anomaly(results: WellResults) -> Figure:
    """Pulls of BHA damping and inertia with the limit of flagging, chi-squared, and p-values of the residual tests."""
    figure = new_figure(results, "anomaly", 11, 5.8)
    margins = Margins(right=room_for_marks(results), bottom=0.65, across=0.17)
    axes = panels(figure, margins, 1, 4, sharey=True)
    depth, discrepancy = results.windows["hole_depth"].values, results.discrepancy
    for axis, name, title in (
        (axes[0], "damping_pull", "BHA damping"),
        (axes[1], "inertia_pull", "BHA inertia"),
    ):
        _pull_track(axis, depth, discrepancy[name].values, discrepancy["flagged"].values, results.flagging_level())
        axis.set_xlabel(f"{title} less its run's level\n[standard deviations]")
    chi2 = results.fits["chi2_per_dof"].values
    axes[2].axvline(1, color=DATA_SHEET, linewidth=1.6)
    axes[2].plot(chi2, depth, "o", color=INK, markersize=3.8)
    axes[2].set_xlabel("χ² per degree of freedom\n[–]")
    _p_value_track(axes[3], results)
    for axis in axes:
        depth_axis(axis, results, label=axis is axes[0], labels=axis is axes[-1], room=ROOM, shaded=True)
    return figure


def _pull_track(axis: Axes, depth: Floats, pull: Floats, flagged: Booleans, limit: float) -> None:
    axis.axvline(0, color=MUTED, linewidth=0.9)
    if np.isfinite(limit):
        axis.axvline(limit, color=FLAGGED, linewidth=1.2, linestyle=(0, (4, 2)))
    horizontal(axis, depth, np.zeros_like(pull), pull, INK, 0.6)
    axis.plot(pull[~flagged], depth[~flagged], "o", color=INK, markersize=3.8)
    axis.plot(pull[flagged], depth[flagged], "o", color=FLAGGED, markeredgecolor="#a85a0c", markersize=6)
    if not np.isfinite(pull).any():
        axis.set_xlim(-4, 4)
        note: dict[str, Any] = {"bbox": {"facecolor": "white", "edgecolor": "none"}, "ha": "center", "color": MUTED}
        axis.text(0.5, 0.5, "too few accepted\nwindows for a level", transform=axis.transAxes, **note)


def _p_value_track(axis: Axes, results: WellResults) -> None:
    discrepancy, depth = results.discrepancy, results.windows["hole_depth"].values
    labels = {name: name.removesuffix("_p_value") for name in RESIDUAL_TESTS}
    tests, looks = {"chi2_p_value": "size"} | labels, (("o", INK), ("s", DATA_SHEET), ("^", "#5a9367"))
    for (name, label), (marker, colour) in zip(tests.items(), looks, strict=True):
        p_value = np.maximum(discrepancy[name].values, _SMALLEST_P_VALUE)
        axis.plot(p_value, depth, marker, color=colour, markersize=3.6, label=label)
    axis.set_xscale("log")
    axis.set_xlim(_SMALLEST_P_VALUE / 2, 2)
    level = results.residual_level()
    if np.isfinite(level):
        axis.axvline(level, color=FLAGGED, linewidth=1.2, linestyle=(0, (4, 2)))
    axis.set_xlabel("p-value of the residuals\nunder the model [–]")
    axis.legend(loc="upper left", fontsize=7.5, handletextpad=0.1)


def joint_band(results: WellResults, name: str, shift: Floats | float, factor: float) -> Floats:
    """Lower end, value and upper end as drawn, shape (3, window)."""
    fit = results.joint.sel(parameter=name)
    return np.stack([(fit[end].values - shift) * factor for end in ("lower", "value", "upper")])


def draw_joint(axis: Axes, results: WellResults, name: str, band: Floats) -> None:
    """The band and the value, and a line at each depth where the parameter jumps."""
    depth = results.windows["hole_depth"].values
    order = np.argsort(depth, kind="stable")
    jumps = results.joint["change_parameter"].values == name
    changes = np.sort(results.joint["change_depth"].values[jumps])
    piece = np.searchsorted(changes, depth[order])
    for number in range(changes.size + 1):
        members = order[piece == number]
        if not members.size or not np.isfinite(band[:, members]).all():
            continue
        before, behind = changes[max(number - 1, 0) : number], changes[number : number + 1]
        reach = np.concatenate([before, depth[members], behind])
        lower, value, upper = (np.pad(row[members], (before.size, behind.size), mode="edge") for row in band)
        axis.fill_betweenx(reach, lower, upper, color=JOINT, alpha=0.32, linewidth=0, zorder=2.2)
        axis.plot(value, reach, color=JOINT, linewidth=2.0, zorder=3.5)
    for change in changes:
        axis.axhline(change, color=CHANGE, linewidth=1.1, zorder=2.1)

"""Images against depth: command mobility, bit-speed steps, bit mobility (paper, figures 9 to 13) and residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import LogNorm, Normalize

from drillid.arrays import Complex, Floats
from drillid.datasets.codes import Gate
from drillid.figures.captions import RPM_PER_KILONEWTON_METRE
from drillid.figures.data import WellResults
from drillid.figures.layout import TITLED, Margins, colour_bar, image_pair, new_figure, panels, room_for_marks
from drillid.figures.style import (
    AMPLITUDE,
    INK,
    MUTED,
    PHASE,
    SIGNED,
    depth_axis,
    depth_image,
    frequency_axis,
)
from drillid.figures.windows import degrees

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh
    from matplotlib.figure import Figure


_UNIT = "rad/(N m s)"
_BAR = 1.0
"""Room for a colour bar with its numbers and its name, inches."""
_COLUMNS = 200
"""Frequencies, evenly spaced on the logarithmic axis, that determine the range of colours."""
_RESIDUAL_LIMIT = 4.0
"""Standard deviations at the ends of the residuals' colours."""


def command_mobility_depth(results: WellResults) -> Figure:
    """Amplitude and phase, measured beside identified, in the same colours."""
    figure = new_figure(results, "command_mobility_depth", 10.5, 10.0)
    room = room_for_marks(results)
    axes = panels(
        figure, Margins(right=room + _BAR, top=TITLED, across=0.25, down=0.33), 2, 2, sharex=True, sharey=True
    )
    used = results.depth["gate"].values == Gate.USED
    measured = np.where(used, results.depth["command_mobility"].values, np.nan)
    fitted = results.depth["command_mobility_fitted"].values
    colours: dict[str, Any] = {"norm": _logarithmic(results, fitted), "cmap": AMPLITUDE}
    phases: dict[str, Any] = {"norm": Normalize(-180, 90), "cmap": PHASE}
    images = (
        ("Amplitude, measured", np.abs(measured), colours),
        ("Amplitude, identified", np.abs(fitted), colours),
        ("Phase, measured", degrees(measured), phases),
        ("Phase, identified", degrees(fitted), phases),
    )
    meshes = []
    for axis, (title, rows, kind) in zip(axes.flat, images, strict=True):
        meshes.append(_frequency_image(axis, results, rows, **kind))
        axis.set_title(title)
        left, right = axis in axes[:, 0], axis in axes[:, 1]
        depth_axis(axis, results, label=left, labels=right, line="white")
        axis.set_xlabel("Frequency [Hz]" if axis in axes[1] else "")
    colour_bar(meshes[1], axes[0], f"Command mobility [{_UNIT}]", room)
    colour_bar(meshes[3], axes[1], "Phase [°]", room, ticks=range(-180, 91, 45))
    return figure


def bit_step_stiff(results: WellResults) -> Figure:
    """Bit speed after a torque step at the bit, top drive clamped."""
    return _bit_step(results, "bit_step_stiff")


def bit_step_controlled(results: WellResults) -> Figure:
    """Bit speed after a torque step at the bit, top drive as controlled."""
    return _bit_step(results, "bit_step_controlled")


def _bit_step(results: WellResults, name: str) -> Figure:
    both = np.stack([results.depth[step].values for step in ("bit_step_stiff", "bit_step_controlled")])
    limit = _percentile(np.abs(both) * RPM_PER_KILONEWTON_METRE, 99.8, otherwise=1.0)
    figure = new_figure(results, name, 9, 5.6)
    room = room_for_marks(results)
    axis = panels(figure, Margins(right=room + _BAR))
    lag, rows = results.depth["lag"].values, results.depth[name].values * RPM_PER_KILONEWTON_METRE
    mesh = depth_image(axis, results, lag, rows, cmap=SIGNED, vmin=-limit, vmax=limit)
    axis.set_xlim(0, float(lag[-1]))
    axis.set_xlabel("Time since the torque step [s]")
    depth_axis(axis, results, line=INK)
    colour_bar(mesh, [axis], "Bit speed per torque [rpm per kN m]", room)
    return figure


def bit_mobility_stiff(results: WellResults) -> Figure:
    """Bit mobility with the top drive clamped."""
    return _bit_mobility(results, "bit_mobility_stiff")


def bit_mobility_controlled(results: WellResults) -> Figure:
    """Bit mobility with the top drive as controlled."""
    return _bit_mobility(results, "bit_mobility_controlled")


def _bit_mobility(results: WellResults, name: str) -> Figure:
    norm = _logarithmic(
        results, *(results.depth[variable].values for variable in ("bit_mobility_stiff", "bit_mobility_controlled"))
    )
    figure = new_figure(results, name, 9, 5.6)
    room = room_for_marks(results)
    axis = panels(figure, Margins(right=room + _BAR))
    mesh = _frequency_image(axis, results, np.abs(results.depth[name].values), norm=norm, cmap=AMPLITUDE)
    axis.set_xlabel("Frequency [Hz]")
    depth_axis(axis, results, line="white")
    colour_bar(mesh, [axis], f"Bit mobility [{_UNIT}]", room)
    return figure


def residuals(results: WellResults) -> Figure:
    """Whitened residuals of all windows over frequency, and their quantiles against the normal distribution."""
    white = results.discrepancy["whitened_residual"].values
    figure = new_figure(results, "residuals", 11, 5.2)
    (real, imaginary), quantiles = image_pair(figure, results)
    norm = Normalize(-_RESIDUAL_LIMIT, _RESIDUAL_LIMIT)
    for axis, part, title in ((real, white.real, "Real part"), (imaginary, white.imag, "Imaginary part")):
        mesh = _frequency_image(axis, results, part, norm=norm, cmap=SIGNED)
        axis.set_xlabel("Frequency [Hz]")
        axis.set_title(title)
        depth_axis(axis, results, label=axis is real, labels=axis is imaginary, line=INK)
    colour_bar(mesh, [real, imaginary], "Residual [standard deviations]", 0.49, below=True)
    pooled = np.concatenate([white.real.ravel(), white.imag.ravel()])
    _normal_quantiles(quantiles, pooled[np.isfinite(pooled)])
    return figure


def _normal_quantiles(axis: Axes, pooled: Floats) -> None:
    """Normal quantile plot; all values in the tails, thinned out in the middle."""
    from scipy.special import ndtri

    axis.set_title("Against the normal distribution")
    axis.set_xlabel("Normal quantile [standard deviations]")
    axis.set_ylabel("Residual quantile [standard deviations]")
    axis.set_aspect("equal")
    axis.axline((0, 0), slope=1, color=MUTED, linewidth=0.9)
    if not pooled.size:
        return
    expected = ndtri((np.arange(pooled.size) + 0.5) / pooled.size)
    chosen = np.unique(np.searchsorted(expected, np.linspace(expected[0], expected[-1], 300)).clip(0, pooled.size - 1))
    axis.plot(expected[chosen], np.sort(pooled)[chosen], ".", color=INK, markersize=4)
    deviation = float(np.std(pooled))
    axis.text(
        0.04,
        0.96,
        f"{pooled.size} residuals\nstandard deviation {deviation:.3f}",
        transform=axis.transAxes,
        va="top",
        size=8,
    )


def _frequency_image(axis: Axes, results: WellResults, rows: Floats, **colours: Any) -> QuadMesh:
    mesh = depth_image(axis, results, results.depth["frequency"].values, rows, **colours)
    frequency_axis(axis, results.band, label=False)
    return mesh


def _logarithmic(results: WellResults, *rows: Complex) -> LogNorm:
    """Colours over the middle 99 % of all amplitudes, with equal weight of every octave of the band."""
    frequency = results.depth["frequency"].values
    columns = np.searchsorted(frequency, np.geomspace(*results.band, _COLUMNS)).clip(0, frequency.size - 1)
    values = np.abs(np.concatenate(rows)[:, columns])
    low, high = _percentile(values, 0.5, otherwise=1e-5), _percentile(values, 99.5, otherwise=1e-3)
    return LogNorm(low, max(high, low * 1.001))


def _percentile(values: Floats, share: float, *, otherwise: float) -> float:
    finite = values[np.isfinite(values) & (values > 0)]
    return float(np.percentile(finite, share)) if finite.size else otherwise

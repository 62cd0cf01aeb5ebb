"""Figures of single windows: spectrograms, and command mobility of successive windows (paper, figures 6 to 8)."""

from __future__ import annotations

import string
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.transforms import blended_transform_factory

from drillid.arrays import Complex, Floats
from drillid.datasets.codes import Gate
from drillid.figures.data import SuccessiveWindows, WellResults, cell_edges, successive_windows
from drillid.figures.layout import TITLED, Margins, colour_bar, new_figure, panels
from drillid.figures.style import AMPLITUDE, INK, MUTED, frequency_axis
from drillid.fits.datasheet import data_sheet, stored_controller
from drillid.physics.eight_parameters import drilling_system
from drillid.physics.responses import bit_mobility, command_mobility, laplace
from drillid.statistics import TWO_SIDED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_STACKED = Margins(left=0.97, down=0.15)
_SPECTROGRAM_TICKS = (0.05, 0.1, 0.2, 0.5, 1, 2, 4)
MOBILITY_LABEL = "Mobility\n[rad/(N m s)]"
_EMPTY_AMPLITUDE = (1e-6, 1e-2)
"""Limits of an amplitude axis without data, rad/(N m s)."""
_LOWEST_PHASE = -240.0
"""Degrees; a phase is drawn within one turn above it, as a delayed passive mobility lies within that."""


def degrees(mobility: Complex) -> Floats:
    """Phase within −240° and 120°, so that a delayed passive mobility has no jump."""
    return (np.angle(mobility, deg=True) - _LOWEST_PHASE) % 360 + _LOWEST_PHASE


def spectrograms(results: WellResults) -> Figure:
    """Torque command and top-drive speed of the middle window, in dB over time and frequency."""
    window = results.spectra.isel(window=results.middle)
    frequency, time = window["spectrogram_frequency"].values, window["spectrogram_time"].values
    keep = frequency > 0
    figure = new_figure(results, "spectrograms", 10, 4.2)
    axes = panels(figure, Margins(right=0.93, top=TITLED, across=0.93), 1, 2, sharey=True)
    channels = (
        ("torque_spectrogram", "Torque command", "dB re 1 (N m)²/Hz"),
        ("speed_spectrogram", "Top-drive speed", "dB re 1 (rad/s)²/Hz"),
    )
    for axis, (name, title, unit) in zip(axes, channels, strict=True):
        power = 10 * np.log10(np.maximum(window[name].values[keep], np.finfo(np.float32).tiny))
        low, high = np.percentile(power, [12, 99.8])
        colours: dict[str, Any] = {"cmap": "magma", "vmin": low, "vmax": high}
        mesh = axis.pcolormesh(cell_edges(time) / 60, cell_edges(frequency[keep]), power, rasterized=True, **colours)
        colour_bar(mesh, [axis], unit, 0.19)
        start = str(np.datetime_as_string(window["start"].values, unit="m")).replace("T", " ")
        axis.set_title(
            f"{title}, window at {float(window['hole_depth']):.1f} m, {start} UTC", weight="normal", size=8.5
        )
        axis.set_xlabel("Time in the window [min]")
        axis.grid(False)
    axes[0].set_yscale("log")
    axes[0].set_ylim(1.5 * frequency[keep][0], min(frequency[-1], results.band[1]))
    axes[0].set_yticks(_SPECTROGRAM_TICKS, [f"{tick:g}" for tick in _SPECTROGRAM_TICKS])
    axes[0].minorticks_off()
    axes[0].set_ylabel("Frequency [Hz]")
    beside = blended_transform_factory(axes[1].transAxes, axes[1].transData)
    axes[1].hlines(_modes(results), 1.005, 1.035, INK, linewidth=1.6, transform=beside, clip_on=False)
    return figure


def _modes(results: WellResults) -> Floats:
    """Modes of the whole system in the middle window: peaks of the controlled bit mobility, Hz."""
    from scipy.signal import find_peaks

    amplitude = np.abs(results.depth["bit_mobility_controlled"].values[results.middle])
    if not np.isfinite(amplitude).all():
        return np.array([])
    return np.asarray(results.depth["frequency"].values[find_peaks(np.log(amplitude), prominence=0.02)[0]])


def command_mobility_measured(results: WellResults) -> Figure:
    """Amplitude, phase and coherence of successive windows and of their stack."""
    shown, frequency = successive_windows(results), results.mobility["frequency"].values
    figure = new_figure(results, "command_mobility_measured", 9, 6.6)
    amplitude, phase, coherence = panels(figure, _STACKED, 3, 1, sharex=True, height_ratios=[2.2, 1.3, 1])
    for number, (row, colour) in enumerate(zip(shown.rows, _colours(shown), strict=True)):
        window = results.mobility.isel(window=row)
        used = window["gate"].values == Gate.USED
        mobility = np.where(used, window["command_mobility"].values, np.nan)
        dots: dict[str, Any] = {"color": colour, "linestyle": "none", "marker": ".", "markersize": 3.2}
        amplitude.plot(frequency, np.abs(mobility), label=_label(results, number, row), **dots)
        phase.plot(frequency, degrees(mobility), **dots)
        values = window["coherence"].values
        coherence.plot(frequency, np.where(used, values, np.nan), **dots)
        coherence.plot(frequency[~used], values[~used], "x", color=MUTED, markersize=3.5, markeredgewidth=0.8)
    amplitude.set_ylim(*_amplitude_limits(results, shown.rows))
    if shown.stack is not None:
        _draw_measured_stack(results, shown.stack, amplitude, phase)
    _finish_mobility(results, amplitude, phase)
    coherence.set_ylabel("Coherence γ²\nof speed and\nsweep [–]")
    coherence.set_ylim(-0.03, 1.03)
    coherence.set_xlabel("Frequency [Hz]")
    return figure


def _amplitude_limits(results: WellResults, rows: list[int]) -> tuple[float, float]:
    """Limits for all but the lowest few of the used amplitudes, which noise can reduce to zero."""
    chosen = results.mobility.isel(window=rows)
    amplitude = np.abs(chosen["command_mobility"].values[chosen["gate"].values == Gate.USED])
    if not amplitude.size:
        return _EMPTY_AMPLITUDE
    return float(np.percentile(amplitude, 0.3)) / 1.5, float(amplitude.max()) * 1.5


def _draw_measured_stack(results: WellResults, row: int, amplitude: Axes, phase: Axes) -> None:
    stack, frequency = results.stacks.isel(stack=row), results.stacks["frequency"].values
    mobility = np.where(stack["gate"].values == Gate.USED, stack["command_mobility"].values, np.nan)
    size, angle = np.abs(mobility), degrees(mobility)
    margin = TWO_SIDED * np.sqrt(stack["command_mobility_variance"].values / 2)
    band: dict[str, Any] = {"color": "black", "alpha": 0.22, "linewidth": 0}
    amplitude.fill_between(frequency, np.maximum(size - margin, size * 0.01), size + margin, **band)
    amplitude.plot(frequency, size, color="black", linewidth=1.3, label="stacked, with 95 % band")
    turn = np.degrees(np.minimum(margin / size, np.pi))
    phase.fill_between(frequency, angle - turn, angle + turn, **band)
    phase.plot(frequency, angle, color="black", linewidth=1.3)


def command_mobility_fitted(results: WellResults) -> Figure:
    """Fitted command mobility of successive windows and of their stack, and the stiff bit mobility."""
    shown, frequency = successive_windows(results), results.depth["frequency"].values
    figure = new_figure(results, "command_mobility_fitted", 9, 6.6)
    amplitude, phase, bit = panels(figure, _STACKED, 3, 1, sharex=True, height_ratios=[2, 1.2, 1.6])
    measured = (
        results.mobility.isel(window=shown.rows[len(shown.rows) // 2])
        if shown.stack is None
        else results.stacks.isel(stack=shown.stack)
    )
    used = measured["gate"].values == Gate.USED
    dots: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 3.5, "color": "#b4bac0"}
    mobility = measured["command_mobility"].values[used]
    amplitude.plot(frequency[used], np.abs(mobility), label="measured", **dots)
    phase.plot(frequency[used], degrees(mobility), **dots)
    for number, (row, colour) in enumerate(zip(shown.rows, _colours(shown), strict=True)):
        window = results.depth.isel(depth=row)
        line: dict[str, Any] = {"color": colour, "linestyle": "-" if bool(window["accepted"]) else ":"}
        suffix = "" if bool(window["accepted"]) else ", not accepted"
        fitted = window["command_mobility_fitted"].values
        amplitude.plot(frequency, np.abs(fitted), label=_label(results, number, row) + suffix, **line)
        phase.plot(frequency, degrees(fitted), **line)
        bit.plot(frequency, np.abs(window["bit_mobility_stiff"].values), **line)
    if shown.stack is not None:
        _draw_fitted_stack(results, shown.stack, amplitude, phase, bit)
    _finish_mobility(results, amplitude, phase)
    _logarithmic_amplitude(bit)
    bit.set_ylabel(f"Bit mobility, stiff\ntop drive\n{MOBILITY_LABEL.splitlines()[1]}")
    bit.set_xlabel("Frequency [Hz]")
    return figure


def _draw_fitted_stack(results: WellResults, row: int, amplitude: Axes, phase: Axes, bit: Axes) -> None:
    fit, frequency = results.stack_fits.isel(stack=row), results.depth["frequency"].values
    equipment = data_sheet(results.rig, stored_controller(fit), float(fit["hole_depth"])).equipment
    system, s = drilling_system(fit["value"].values, equipment), laplace(frequency)
    fitted = command_mobility(system, s)
    line: dict[str, Any] = {"color": "black", "linewidth": 1.4, "linestyle": "-" if bool(fit["accepted"]) else ":"}
    label = "stacked" if bool(fit["accepted"]) else "stacked, fit not accepted"
    amplitude.plot(frequency, np.abs(fitted), label=label, **line)
    phase.plot(frequency, degrees(fitted), **line)
    bit.plot(frequency, np.abs(bit_mobility(system, s, stiff=True)), **line)


def _finish_mobility(results: WellResults, amplitude: Axes, phase: Axes) -> None:
    frequency_axis(amplitude, results.band, label=False)
    _logarithmic_amplitude(amplitude)
    amplitude.set_ylabel(f"Command m{MOBILITY_LABEL[1:]}")
    amplitude.legend(ncols=2, loc="best")
    phase.set_ylabel("Phase [°]")
    phase.set_yticks(np.arange(-180, 91, 90))
    phase.set_ylim(-215, 105)


def _logarithmic_amplitude(axis: Axes) -> None:
    """Logarithmic axis, with limits and a note where there are no data."""
    if not any(np.isfinite(np.asarray(line.get_ydata(), dtype=float)).any() for line in axis.lines):
        axis.set_ylim(*_EMPTY_AMPLITUDE)
        axis.text(0.5, 0.5, "no data", transform=axis.transAxes, ha="center", color=MUTED)
    axis.set_yscale("log")


def _colours(shown: SuccessiveWindows) -> list[Any]:
    return [colormaps[AMPLITUDE](position) for position in np.linspace(0.05, 0.9, len(shown.rows))]


def _label(results: WellResults, number: int, row: int) -> str:
    """A, B, … as in the paper, with the depth."""
    letter = string.ascii_uppercase[number] if number < len(string.ascii_uppercase) else str(number + 1)
    return f"{letter}  {float(results.windows['hole_depth'][row]):.1f} m"

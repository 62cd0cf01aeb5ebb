"""Figures of speed control: the stick-slip map, and the bit's mobility under several controllers."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from drillid.figures.style import DATA_SHEET, FLAGGED, INK, MUTED, STYLE, frequency_axis
from drillid.physics.responses import bit_mobility, laplace

if TYPE_CHECKING:
    from drillid.control.stick_slip import StickSlipMap
    from drillid.physics.equipment import DrillingSystem


_LOOKS = ((INK, "-"), (FLAGGED, "--"), ("#4f8f6b", "-."), (DATA_SHEET, ":"), (MUTED, (0, (5, 1, 1, 1, 1, 1))))
"""Colours and dashes of the controllers' lines, distinguishable in greyscale too; more controllers have them again."""
_RPM = 30 / np.pi


def draw_stick_slip_map(stability: StickSlipMap, simulated: Mapping[str, tuple[float, float]] | None = None) -> Figure:
    """Lowest stable rpm against weight on bit, one line per controller; stick-slip below the line.

    Parameters
    ----------
    simulated : by controller's name, weight (N) and lowest stable speed (rad/s) in the time-domain simulator
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(7.0, 4.4), layout="constrained")
        FigureCanvasAgg(figure)
        axis = figure.subplots()
        for (colour, dash), (name, speed) in zip(cycle(_LOOKS), stability.speed.items(), strict=False):
            frequency = stability.frequency[name]
            label = f"{name}: unstable" if np.isnan(frequency) else f"{name}: vibrates at {frequency:.2f} Hz"
            axis.plot(stability.weight / 1e3, speed * _RPM, color=colour, linestyle=dash, label=label)
            if simulated and name in simulated:
                weight, least = simulated[name]
                axis.plot(weight / 1e3, least * _RPM, "o", color=colour, label="_", markerfacecolor="white")
        axis.set(xlabel="Weight on bit [kN]", ylabel="Lowest stable speed [rpm]")
        axis.set_ylim(bottom=0)
        note = "; circles: time-domain simulation" if simulated else ""
        axis.set_title(f"Stick-slip below each line{note}")
        axis.legend()
    return figure


def draw_bit_mobility(systems: Mapping[str, DrillingSystem], band: tuple[float, float] = (0.05, 5.0)) -> Figure:
    """Amplitude of bit speed per torque on the bit against frequency, one line per controller.

    Parameters
    ----------
    systems : by controller's name; of parameters (sample, 1) the first is drawn as a line, the range as a shade
    band : Hz
    """
    frequency = np.geomspace(*band, 1500)
    with rc_context(STYLE):
        figure = Figure(figsize=(7.0, 4.4), layout="constrained")
        FigureCanvasAgg(figure)
        axis = figure.subplots()
        for (colour, dash), (name, system) in zip(cycle(_LOOKS), systems.items(), strict=False):
            size = np.atleast_2d(np.abs(bit_mobility(system, laplace(frequency)))) * _RPM * 1e3
            axis.plot(frequency, size[0], color=colour, linestyle=dash, label=name)
            axis.fill_between(frequency, size.min(axis=0), size.max(axis=0), color=colour, alpha=0.15, linewidth=0)
        axis.set_yscale("log")
        frequency_axis(axis, band)
        axis.set(ylabel="Bit speed per torque [rpm/(kN m)]")
        axis.set_title("Bit mobility: bit speed per torque on the bit")
        axis.legend()
    return figure

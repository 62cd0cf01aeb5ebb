"""The figure of a start of rotation: torque and bit speed, measured and simulated."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from drillid.figures.style import DATA_SHEET, FLAGGED, INK, JOINT, MUTED, STYLE
from drillid.units import RPM

if TYPE_CHECKING:
    import xarray as xr

_COLOURS = (DATA_SHEET, FLAGGED, JOINT)
_CAPTION = (
    "Models are fitted to the time before the dotted line and judged on the time after it. Bit speed: the shading "
    "spans the measured half-second extremes."
)


def draw(name: str, depth: float, dataset: xr.Dataset) -> Figure:
    """Draw the dataset of one start of rotation, with the bit at a depth, m."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 6.4), layout=ConstrainedLayoutEngine(rect=(0.0, 0.0, 1.0, 0.9)))
        FigureCanvasAgg(figure)
        torque, speed = figure.subplots(2, 1, sharex=True)
        time = dataset["time"].values
        torque.plot(time, dataset["torque"] / 1e3, color=INK, lw=0.9, label="measured")
        speed.plot(time, dataset["top_speed"] / RPM, color=MUTED, lw=0.8, label="top drive, measured")
        extremes = dataset["bit_slowest"] / RPM, dataset["bit_fastest"] / RPM
        speed.fill_between(time, *extremes, color=MUTED, alpha=0.4, lw=0, label="bit, measured")
        for number, model in enumerate(dataset["model"].values):
            own, held = dataset.isel(model=number), dataset.isel(model=number, span=-1)
            colour = _COLOURS[number % len(_COLOURS)]
            told = f"{model}: {float(held['torque_rms']) / 1e3:.2f} kN m rms held out"
            torque.plot(time, own["simulated_torque"] / 1e3, color=colour, lw=1.0, label=told)
            speed.plot(time, own["simulated_bit_speed"] / RPM, color=colour, lw=1.0)
        for axis in (torque, speed):
            axis.axvline(float(dataset["span_from"][-1]), color=INK, ls=":", lw=1.0)
            axis.legend(ncols=4, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)
        torque.set_ylabel("Torque of the drive [kN m]")
        speed.set(xlabel="Time [s]", ylabel="Speed [rpm]")
        heading = f"{name} · start of rotation, bit at {depth:g} m"
        figure.text(0.01, 0.99, heading, va="top", size=12, weight="bold", parse_math=False)
        figure.text(0.01, 0.95, "\n".join(textwrap.wrap(_CAPTION, 135)), size=8.5, color=MUTED, va="top")
    return figure

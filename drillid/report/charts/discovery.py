"""Charts of what an extended model gains: a held-out window in time, residuals over frequency, and a learnt law."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models import FixedTicker, HSpan, Line, VArea

from drillid.arrays import Floats
from drillid.figures.data import WellResults
from drillid.report.charts.maps import TICKS, legend
from drillid.report.charts.style import drawn, hover, label_axis, new_chart, source
from drillid.statistics import TWO_SIDED
from drillid.units import RPM

_HEIGHT = 260
_SEGMENT = 0.25
"""Share of the sweep's period that is drawn: where the response is largest."""
_SMOOTHED = 13
"""Frequencies over which mean squares are smoothed."""


def held_out_chart(results: WellResults, number: int) -> Any | None:
    """The held-out window of a set as both models predict it, rpm; None where its sweep is not periodic."""
    examined = results.examination.isel(set=number)
    time, speed = examined["period_time"].values, examined["period_speed"].values
    if not np.isfinite(time).all() or not np.isfinite(speed).all():
        return None
    length = int(_SEGMENT * time.size)
    first = int(np.argmax(np.convolve(speed**2, np.ones(length), "valid")))
    chosen = slice(first, first + length)
    columns = {"time": time[chosen]}
    columns |= {name: examined[f"period_{name}"].values[chosen] / RPM for name in ("speed", "base", "extended")}
    margin = TWO_SIDED * np.nan_to_num(float(examined["period_error"])) / RPM
    columns |= {"low": columns["speed"] - margin, "high": columns["speed"] + margin}
    data = source({name: values.astype(np.float32) for name, values in columns.items()}, {})
    chart = new_chart(None, _HEIGHT, title="Top-drive speed in a held-out window")
    drawn(chart, data, VArea(x="time", y1="low", y2="high", fill_alpha=0.25), fill_color="ink")
    measured = drawn(chart, data, Line(x="time", y="speed"), name="measured", line_color="ink")
    for name, words, colour, dash in _models(np.array_equal(columns["base"], columns["extended"])):
        line = Line(x="time", y=name, line_width=2, line_dash=dash)
        drawn(chart, data, line, name=words, line_color=colour)
    rows = [("Measured", "@speed{0.00}", "rpm"), ("Base model", "@base{0.00}", "rpm")]
    rows += [("Extended model", "@extended{0.00}", "rpm"), ("Time", "@time{0.0}", "s")]
    chart.add_tools(hover(rows, [measured]))
    label_axis(chart.xaxis[0], "Time in the sweep", unit="s", joint=" ")
    label_axis(chart.yaxis[0], "Speed less its mean", unit="rpm", joint=" ")
    legend(chart)
    return chart


def residual_chart(results: WellResults, number: int) -> Any:
    """Mean square of the residuals of a set per noise variance over frequency, without and with the named cause."""
    examination = results.examination
    frequency = examination["frequency"].values
    member = examination["window_set"].values == number
    before, after = (_mean_square(examination[f"residual_{end}"].values[member]) for end in ("before", "after"))
    inside = (frequency >= results.band[0]) & (frequency <= results.band[1])
    columns = {"frequency": frequency, "base": before, "extended": after}
    data = source({name: values[inside].astype(np.float32) for name, values in columns.items()}, {})
    title, logarithmic = "Residuals: mean square over noise variance", {"x_axis_type": "log", "y_axis_type": "log"}
    chart = new_chart(None, _HEIGHT, title=title, **logarithmic)
    drawn(chart, source({"y": [1.0]}, {}), HSpan(y="y", line_dash="dotted", line_width=1.5), line_color="muted")
    for name, words, colour, dash in _models(np.array_equal(before, after, equal_nan=True)):
        width = 3 if dash == "dashed" else 1.6
        line = Line(x="frequency", y=name, line_width=width, line_dash=dash)
        drawn(chart, data, line, name=words, line_color=colour)
    chart.add_tools(hover([("Base model", "@base{0.00}", ""), ("Frequency", "@frequency{0.00}", "Hz")]))
    chart.xaxis[0].update(ticker=FixedTicker(ticks=list(TICKS)))
    label_axis(chart.xaxis[0], "Frequency", unit="Hz", joint=" ")
    label_axis(chart.yaxis[0], "1 for a correct model", joint=" ")
    legend(chart)
    return chart


def law_chart(results: WellResults, number: int) -> Any | None:
    """The learnt law with its 95 % band: of bit or control kN m against rpm, of a coupling mrad against kN m; None
    where none is offered.
    """
    examined = results.examination.isel(set=number)
    for names, units, scales, words in _LAWS:
        place, value, error = (examined[name].values for name in names)
        if np.isfinite(value).all():
            columns = place / scales[0], value / scales[1], TWO_SIDED * error / scales[1]
            return _law_chart(*columns, units, words)
    return None


_LAWS = (
    (
        ("law_speed", "law_torque", "law_error"),
        ("rpm", "kN m"),
        (RPM, 1e3),
        ("Learnt law of the bit", "Bit speed", "Torque relative to that at the mean speed"),
    ),
    (
        ("coupling_torque", "coupling_twist", "coupling_error"),
        ("kN m", "mrad"),
        (1e3, 1e-3),
        ("Learnt law of a coupling", "Torque", "Twist less its tangent"),
    ),
    (
        ("control_speed_error", "control_torque", "control_torque_error"),
        ("rpm", "kN m"),
        (RPM, 1e3),
        ("Learnt law of the speed control", "Speed error", "Torque in addition to that of its gains"),
    ),
)
"""Variables of each kind of law, its units, their sizes in SI, and title and axes."""


def _law_chart(
    place: Floats, value: Floats, margin: Floats, units: tuple[str, str], words: tuple[str, str, str]
) -> Any:
    columns = {"place": place, "value": value, "low": value - margin, "high": value + margin}
    data = source({name: values.astype(np.float32) for name, values in columns.items()}, {})
    chart = new_chart(None, _HEIGHT, title=f"{words[0]}, with its 95 % band")
    drawn(chart, data, VArea(x="place", y1="low", y2="high", fill_alpha=0.25), fill_color="ink")
    line = drawn(chart, data, Line(x="place", y="value", line_width=2), line_color="joint")
    rows = [(words[2].split()[0], "@value{0.00}", units[1]), (words[1], "@place{0.0}", units[0])]
    chart.add_tools(hover(rows, [line]))
    label_axis(chart.xaxis[0], words[1], unit=units[0], joint=" ")
    label_axis(chart.yaxis[0], words[2], unit=units[1], joint=" ")
    return chart


def _models(same: bool) -> list[tuple[str, str, str, str]]:
    """Columns with words, colours and dashes; one line where no cause extends the model."""
    lines = [("base", "base model", "flag", "dashed"), ("extended", "extended model", "joint", "solid")]
    return [("base", "model", "joint", "solid")] if same else lines


def _mean_square(residual: Any) -> Floats:
    power = np.abs(residual) ** 2 / 2
    used = np.isfinite(power)
    kernel = np.ones(_SMOOTHED)
    total = np.convolve(np.where(used, power, 0.0).sum(axis=0), kernel, "same")
    count = np.convolve(used.sum(axis=0).astype(float), kernel, "same")
    return np.where(count > 0, total / np.maximum(count, 1.0), np.nan)

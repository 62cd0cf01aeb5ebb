"""Causes that make one window's response change while it is measured."""

from typing import Any

from drillid.discrepancy.catalogue.cause import Cause, OperatingPoint, Size, WindowModel

_PARTS = 5
"""Of a window, in each of which a figure that moves stands still."""


class LengthGrowth(Cause):
    """The string grows within the window."""

    name, family, port = "length_growth", "time", "string"
    meaning = "the string grows longer while the window lasts"
    looks_like = ("clock_drift", "parameter_drift")
    separated_by = "shorter windows"
    regime = True
    size = Size("growth within the window", "m", 20.0, 0.0, 200.0)


class ParameterDrift(Cause):
    """Damping or inertia drift within the window."""

    name, family, port = "parameter_drift", "time", "bit"
    meaning = "damping at the bit drifts while the window lasts"
    looks_like = ("length_growth", "regime_change")
    separated_by = "shorter windows"
    regime = True
    moves = True
    size = Size("change of bit damping within the window", "N m s/rad", 200.0, -5e3, 5e3)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Evenly more damping than at first."""
        return window_model.with_course([size * ((part + 0.5) / _PARTS) for part in range(_PARTS)])


class RegimeChange(Cause):
    """The response jumps within the window."""

    name, family, port = "regime_change", "time", "disturbance"
    meaning = "the way of drilling changes at once within the window"
    looks_like = ("parameter_drift",)
    separated_by = "windows cut at the change"
    regime = True
    moves = True
    size = Size("jump of bit damping", "N m s/rad", 200.0, -5e3, 5e3)
    shapes = tuple(part / _PARTS for part in range(1, _PARTS))
    shape_meaning = "moment of the jump, share of the window"

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """All of it from a moment on."""
        return window_model.with_course([size * (part >= round(shape * _PARTS)) for part in range(_PARTS)])

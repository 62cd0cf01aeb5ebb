"""Causes that make the response change within a window."""

import re
from typing import Any

from drillid.discrepancy.catalogue.cause import Cause, OperatingPoint, Size, WindowModel
from drillid.discrepancy.detectors.change import ChangeDetector
from drillid.physics.parameters import DAMPING_BHA, LENGTH

_PARTS = 5
"""Number of parts of a window in each of which a changing parameter is constant."""


class LengthGrowth(Cause):
    """The string grows within the window."""

    name, family, port = "length_growth", "time", "string"
    headline = "the string grows by {size} within a window: use shorter windows at this rate of penetration"
    meaning = "the string becomes longer within the window"
    looks_like = ("clock_drift", "parameter_drift")
    separated_by = "shorter windows"
    action = "Nothing on the rig is wrong."
    distorts_responses = True
    size = Size("growth within the window", "m", 20.0, 0.0, 200.0)
    detector = ChangeDetector(LENGTH, one_sided=True)


class ParameterDrift(Cause):
    """Damping at the bit drifts within the window."""

    name, family, port = "parameter_drift", "time", "bit"
    headline = "the damping at the bit drifts during drilling: check formation, weight on bit and hole cleaning"
    meaning = "damping at the bit drifts within the window"
    looks_like = ("length_growth", "regime_change")
    separated_by = "shorter windows"
    action = "The log plot shows weight on bit, torque and rate of penetration beside it."
    distorts_responses = True
    time_varying = True
    size = Size("change of bit damping within the window", "N m s/rad", 200.0, -5e3, 5e3)
    detector = ChangeDetector(DAMPING_BHA)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Damping that grows linearly."""
        return window_model.with_course([size * ((part + 0.5) / _PARTS) for part in range(_PARTS)])


class RegimeChange(Cause):
    """Damping at the bit jumps within the window."""

    name, family, port = "regime_change", "time", "disturbance"
    headline = "the damping at the assembly jumps {up}: check hole size, cuttings and formation"
    meaning = "the drilling regime changes abruptly within the window"
    looks_like = ("parameter_drift",)
    separated_by = "windows that begin or end at the change"
    action = "The log plot shows weight on bit, torque and rate of penetration beside it."
    distorts_responses = True
    time_varying = True
    size = Size("jump of bit damping", "N m s/rad", 200.0, -5e3, 5e3)
    detector = ChangeDetector(DAMPING_BHA, jumps=True)
    marks_intervals = True
    shapes = tuple(part / _PARTS for part in range(1, _PARTS))

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Additional damping from a moment on."""
        return window_model.with_course([size * (part >= round(shape * _PARTS)) for part in range(_PARTS)])

    def described(self, evidence: str) -> str:
        """The rise, for an interval change of fitted parameters; else the meaning."""
        if risen(evidence):
            return f"the assembly moves differently from the rest of the run: {evidence}"
        return self.meaning


def rise(name: str, deviations: float) -> str:
    """Evidence that a fitted parameter rose in an interval."""
    return f"{name} up by {deviations:.1f} standard deviations"


def risen(evidence: str) -> list[str]:
    """Names of the parameters that rose, in evidence made of `rise`."""
    return [name.strip() for name in re.findall(r"([\w ]+?) up by ", evidence)]


CAUSES = (LengthGrowth, ParameterDrift, RegimeChange)
"""What the catalogue takes from this file."""

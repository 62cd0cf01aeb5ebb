"""The speed's scale from a logged set point: a control with an integral part holds the means of both equal.

It is found from a whole set of windows, not from one window's record: rounding of the set point is an error that all
windows share, so that the set has one detection.
"""

import numpy as np
from scipy.special import ndtr

from drillid.arrays import Floats
from drillid.discrepancy.detectors.detection import Detection
from drillid.discrepancy.detectors.score import normal_of_p_value
from drillid.discrepancy.rules import SET_POINT_ERROR
from drillid.physics.equipment import Controller

CAUSE = "speed_scale"


def holds_set_point(controller: Controller) -> bool:
    """Whether a control leaves no error of the mean speed."""
    return bool(controller.integral > 0 and controller.matching is None)


def speed_ratio(speed: Floats, set_point: Floats) -> float:
    """Mean speed over mean set point of a window, both (samples,); NaN where either is missing or the string stands."""
    target = float(np.mean(set_point))
    return float(np.mean(speed)) / target if target else float("nan")


def set_point_detection(ratios: Floats) -> Detection | None:
    """Detection of a speed scale from the ratios of a set's windows, (W,); None where no set point is logged."""
    known = ratios[np.isfinite(ratios)]
    if known.size == 0:
        return None
    scatter = float(np.std(known, ddof=1) / np.sqrt(known.size)) if known.size > 1 else 0.0
    size, error = float(np.mean(known)) - 1, float(np.hypot(SET_POINT_ERROR, scatter))
    normal = normal_of_p_value(2 * float(ndtr(-abs(size) / error)))
    return Detection(CAUSE, 0, normal, size, error, size**2 / (2 * error**2))

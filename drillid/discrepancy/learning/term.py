"""Terms of learnt extensions: each is a cause with one size."""

from __future__ import annotations

from typing import Any

import numpy as np

from drillid.discrepancy.catalogue.cause import Cause, OperatingPoint, WindowModel
from drillid.physics.equipment import Shaping

TOP, BIT = 0.0, 1.0
"""Places at either end of the string."""
FACTOR_OF = {"record": "the record of the speed", "drive": "the drive's torque", "control": "the speed control"}
"""Ports whose transfer has a factor, in words."""


class Term(Cause):
    """One parameter of an element."""

    family, port = "learnt", "string"
    separated_by = "the same measurement in other wells, and a look at what stands at that place"
    action = "Compare with what stands there: this was learnt from the data, and nobody has named it."


def depth_of(place: Any, window_model: WindowModel, operating_point: OperatingPoint) -> Any:
    """Depth (m) of a place that goes down with the string.

    Parameters
    ----------
    place : share of the string's length from the top, in the mean over the windows; 0 stays at the top
    """
    total = sum(section.length for section in window_model.system.string)
    if place <= TOP:
        return 0.0 * total
    share = (1 - place) * np.mean(operating_point.length) / operating_point.length
    return total * np.maximum(1 - share, 0.0)


def shaping_at(port: str, window_model: WindowModel) -> Shaping:
    """The factor at one of the ports of FACTOR_OF."""
    top_drive = window_model.system.top_drive
    found = {
        "drive": top_drive.shaping,
        "control": top_drive.controller.shaping,
        "record": window_model.recording.shaping,
    }[port]
    return found or Shaping()


def with_shaping(port: str, window_model: WindowModel, shaping: Shaping) -> WindowModel:
    """The window model with another factor at one of the ports of FACTOR_OF."""
    if port == "drive":
        return window_model.with_top_drive(shaping=shaping)
    if port == "control":
        return window_model.with_controller(shaping=shaping)
    return window_model.with_recording(shaping=shaping)

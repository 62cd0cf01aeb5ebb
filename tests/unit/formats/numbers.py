"""The simulated log that is written in every shape, and its times."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from tests.raw_logs import drilling

SECONDS = 30
LOG = drilling(SECONDS).round({"TQ": 5, "SWEEP": 5, "RPM": 4, "HOLE": 3, "BIT": 3})
LOG["HOLE"] *= 0.3048
LOG["BIT"] *= 0.3048
LOG = LOG.round({"HOLE": 4, "BIT": 4})
UNITS = {"TQ": "kN.m", "SWEEP": "kN.m", "RPM": "rpm", "SET": "rpm", "HOLE": "m", "BIT": "m", "FLOW": "L/min"}
NUMBERS = list(UNITS)
_EPOCH = pd.Timestamp("1970-01-01")


def since_1970(log: pd.DataFrame) -> np.ndarray:
    """Times of the rows, s since 1970."""
    return (log["Time"] - _EPOCH).dt.total_seconds().to_numpy()


def iso(log: pd.DataFrame) -> Any:
    """Times of the rows as ISO text, UTC."""
    return log["Time"].dt.strftime("%Y-%m-%dT%H:%M:%S.%fZ")

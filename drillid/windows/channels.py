"""The samples of one window in a well's records."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from drillid.arrays import Floats

CHANNELS = ("torque_sweep", "speed", "torque_command")
"""Channels from which the responses of a window are estimated."""
_FIRST_SAMPLES = 1000


def sample_rate(records: xr.Dataset) -> float:
    """Samples per second of the records; a gap among their first samples is passed over."""
    steps = np.diff(records["time"][:_FIRST_SAMPLES].values.astype("datetime64[ns]").astype(np.int64))
    return float(1e9 / steps[np.argmax(steps < 1.5 * np.min(steps))])


def window_channels(
    records: xr.Dataset,
    windows: xr.Dataset,
    row: int,
    names: Sequence[str] = CHANNELS,
) -> Floats:
    """Channels of the window in a row of `windows`, shape (name, samples), in the records' units."""
    first, samples = int(windows["first_sample"][row]), int(windows["samples"][row])
    return np.array([records[name][first : first + samples].values for name in names], dtype=float)

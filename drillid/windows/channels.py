"""The samples of one window, and the bounds of each log, in a well's records."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from drillid.arrays import Floats

_BLOCK = 1_000_000
_FIRST_SAMPLES = 1000


def sample_rate(records: xr.Dataset) -> float:
    """Samples per second of the records; a gap among their first samples is passed over."""
    steps = np.diff(records["time"][:_FIRST_SAMPLES].values.astype("datetime64[ns]").astype(np.int64))
    return float(1e9 / steps[np.argmax(steps < 1.5 * np.min(steps))])


def window_channels(
    records: xr.Dataset,
    windows: xr.Dataset,
    row: int,
    names: Sequence[str] = ("torque_sweep", "speed", "torque_command"),
) -> Floats:
    """Channels of the window in a row of `windows`, shape (name, samples), in the records' units."""
    first, samples = int(windows["first_sample"][row]), int(windows["samples"][row])
    return np.array([records[name][first : first + samples].values for name in names], dtype=float)


def log_bounds(records: xr.Dataset) -> Iterator[tuple[int, int]]:
    """First and last-plus-one sample of each log, in order; read block by block."""
    size, begin, current = records.sizes["time"], 0, None
    for block in range(0, size, _BLOCK):
        numbers = records["log"][block : block + _BLOCK].values
        previous = numbers[0] if current is None else current
        for change in (np.flatnonzero(np.diff(numbers, prepend=previous)) + block).tolist():
            yield begin, change
            begin = change
        current = numbers[-1]
    yield begin, size

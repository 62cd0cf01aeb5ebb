"""Rows that hold the samples of a slower control between them."""

from __future__ import annotations

import numpy as np

from drillid.arrays import Floats, Integers

_UNEVEN = 0.02
"""Largest share of the runs of a held record with neither of the two lengths that an interval gives."""
_LEAST_HELD = 0.02
"""Least share of repeated rows of a held record."""
_LEAST_SAMPLES = 8
_ROUNDS = 3
"""Number of fits of a line to the samples' places, each of which numbers the samples anew."""


def held_samples(channels: Floats) -> tuple[Floats, Integers] | None:
    """Places of the samples and a row that shows each, both (sample,) in rows; None where the rows hold no samples.

    In a record that holds its values, all channels repeat a row at once, so that runs of equal rows have at most two
    lengths, which are successive. The first row of each sample is late by half a row on average.

    Parameters
    ----------
    channels : shape (channel, time), finite
    """
    changed = np.any(np.diff(channels, axis=1) != 0, axis=0)
    first = np.flatnonzero(changed) + 1
    if first.size < _LEAST_SAMPLES or changed.mean() > 1 - _LEAST_HELD:
        return None
    lengths = np.diff(first)
    mean = float(lengths.mean())
    if np.mean(np.abs(lengths - mean) >= 1) > _UNEVEN:
        return None
    # two samples may be equal by chance, and a row out of turn is not a sample of its own
    passed = np.where(lengths <= np.ceil(mean), 1.0, np.rint(lengths / mean))
    number = np.append(0.0, np.cumsum(passed))
    for _ in range(_ROUNDS):
        offset, step = np.polynomial.polynomial.polyfit(number, first - 0.5, 1)
        number = np.rint((first - 0.5 - offset) / step)
    number, kept = np.unique(number, return_index=True)
    return offset + step * number, first[kept].astype(np.int64)

"""Rows that hold the samples of a slower control between them, as the samples themselves."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import make_interp_spline

from drillid.arrays import Floats
from drillid.records.quality import held_interval

_ROUNDS = 3
"""Fits of a line to the samples' places, each of which numbers them anew."""
_DEGREE = 5
"""Of the spline through the samples: at a fifth of their rate its gain is right to 1e-4."""


def released(channels: Floats, rate: float) -> Floats:
    """Channels of a record that holds its values, on a smooth curve through the samples that it holds.

    Rows that hold samples of another rate have different ages, which repeats the spectrum of the signals at other
    frequencies. The first row of each sample is late by half a row in the mean, for all channels alike. Other records
    are returned as they are.

    Parameters
    ----------
    channels : shape (channel, time); those that are not finite are left alone
    rate : rows per second
    """
    finite = np.isfinite(channels).all(axis=1)
    interval = held_interval(channels[finite], rate) * rate if finite.any() else np.nan
    if not np.isfinite(interval):
        return channels
    first = np.flatnonzero(np.any(np.diff(channels[finite], axis=1) != 0, axis=0)) + 1
    if first.size <= _DEGREE:
        return channels
    # two samples may be the same by chance, and a row out of turn is no sample of its own
    number = np.cumsum(np.rint(np.diff(first, prepend=first[0]) / interval))
    for _ in range(_ROUNDS):
        offset, step = np.polynomial.polynomial.polyfit(number, first - 0.5, 1)
        number = np.rint((first - 0.5 - offset) / step)
    number, kept = np.unique(number, return_index=True)
    rows, samples = np.arange(channels.shape[1]), channels[finite][:, first[kept]]
    smooth = channels.copy()
    smooth[finite] = make_interp_spline(offset + step * number, samples, k=_DEGREE, axis=1)(rows)
    return smooth

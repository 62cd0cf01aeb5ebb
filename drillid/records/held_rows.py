"""Rows that hold the samples of a slower control between them, as the samples themselves."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import make_interp_spline

from drillid.arrays import Floats
from drillid.records.quality import held_interval

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
    # two samples may be the same by chance
    number = np.cumsum(np.rint(np.diff(first, prepend=first[0]) / interval))
    place = np.polynomial.Polynomial.fit(number, first - 0.5, 1)(number)
    rows = np.arange(channels.shape[1])
    smooth = channels.copy()
    smooth[finite] = make_interp_spline(place, channels[finite][:, first], k=_DEGREE, axis=1)(rows)
    return smooth

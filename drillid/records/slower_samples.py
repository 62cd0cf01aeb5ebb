"""Rows that show the samples of a slower control, held or on lines between them, as the samples themselves."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline

from drillid.arrays import Floats
from drillid.records.held_rows import held_samples
from drillid.records.interpolated_rows import line_samples

_DEGREE = 5
"""Of the spline through the samples: at a fifth of their rate its gain is right to 1e-4."""


class Released(NamedTuple):
    """Channels on smooth curves through the samples that their rows show."""

    channels: Floats
    """(channel, time); as they are where each row is a sample of its own."""
    interval: float
    """s, between samples; NaN where each row is a sample of its own."""


def released(channels: Floats, rate: float) -> Released:
    """Channels of a record that holds or interpolates its samples, on a smooth curve through these.

    Rows that hold samples of another rate have different ages, which repeats the spectrum of the signals at other
    frequencies; so do rows on lines between them.

    Parameters
    ----------
    channels : shape (channel, time), the first being the injected torque; those that are not finite are left alone
    rate : rows per second
    """
    finite = np.isfinite(channels).all(axis=1)
    shown = _samples(channels[finite]) if finite.any() else None
    if shown is None:
        return Released(channels, float("nan"))
    places, samples = shown
    smooth = channels.copy()
    smooth[finite] = make_interp_spline(places, samples, k=_DEGREE, axis=1)(np.arange(channels.shape[1]))
    return Released(smooth, float(np.median(np.diff(places))) / rate)


def _samples(channels: Floats) -> tuple[Floats, Floats] | None:
    """Places (sample,) in rows and samples (channel, sample); None where each row is a sample of its own."""
    held = held_samples(channels)
    if held is None:
        return line_samples(channels)
    places, rows = held
    return places, channels[:, rows]

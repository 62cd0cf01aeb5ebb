"""Samples of a control from rows that are not in step with it: rows that hold its samples, that lie on lines between
slower samples, or that each show the last sample of a faster control.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline

from drillid.arrays import Floats
from drillid.records.held_rows import held_samples
from drillid.records.interpolated_rows import line_samples
from drillid.records.uneven_rows import aged_samples, off_their_lines

_DEGREE = 5
"""Degree of the spline through the samples; at a fifth of their rate its gain is right to 1e-4."""


class Samples(NamedTuple):
    """Samples that a record's rows show."""

    places: Floats
    """(sample,), in rows."""
    channels: Floats
    """(channel, sample), the finite channels."""
    interval: float
    """Interval between the control's samples, rows."""


class Released(NamedTuple):
    """Channels on smooth curves through the samples that their rows show."""

    channels: Floats
    """(channel, time); unchanged where the rows are even."""
    interval: float
    """Interval between the control's samples, s; NaN where the rows do not show it."""
    samples: Samples | None = None
    """The samples themselves; None where the rows do not show them."""


def released(channels: Floats, rate: float) -> Released:
    """Channels of a record whose rows are not in step with the control, on a smooth curve through its samples.

    Rows that hold samples of another rate have varying ages, which repeats the spectrum of the signals at other
    frequencies; so do rows on lines between samples.

    Parameters
    ----------
    channels : shape (channel, time), the first being the injected torque; those that are not finite are left alone
    rate : rows per second
    """
    finite = np.isfinite(channels).all(axis=1)
    if not finite.any():
        return Released(channels, float("nan"))
    shown = _samples(channels[finite])
    found = off_their_lines(channels[finite]) if shown is None else (_curves(shown, channels.shape[1]), shown.interval)
    if found is None:
        return Released(channels, float("nan"))
    smooth = channels.copy()
    smooth[finite], interval = found
    return Released(smooth, interval / rate, shown)


def _curves(shown: Samples, rows: int) -> Floats:
    """Channels (channel, rows) on a smooth curve through their samples."""
    spline = make_interp_spline(shown.places, shown.channels, k=_DEGREE, axis=1)
    return np.asarray(spline(np.arange(rows)), dtype=float)


def _samples(channels: Floats) -> Samples | None:
    """The samples that the rows hold, or between which they lie on lines; None where the rows show no samples."""
    held = held_samples(channels)
    if held is not None:
        places, rows = held
        return Samples(places, channels[:, rows], float(np.median(np.diff(places))))
    on_lines = line_samples(channels)
    if on_lines is not None:
        places, samples = on_lines
        return Samples(places, samples, float(np.median(np.diff(places))))
    aged = aged_samples(channels)
    return None if aged is None else Samples(aged[0], channels, aged[1])

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


class Released(NamedTuple):
    """Channels on smooth curves through the samples that their rows show."""

    channels: Floats
    """(channel, time); unchanged where the rows are even."""
    interval: float
    """Interval between the control's samples, s; NaN where the rows do not show it."""


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
    found = _right(channels[finite]) if finite.any() else None
    if found is None:
        return Released(channels, float("nan"))
    smooth = channels.copy()
    smooth[finite], interval = found
    return Released(smooth, interval / rate)


def _right(channels: Floats) -> tuple[Floats, float] | None:
    """Corrected channels (channel, time), and the control's interval in rows; None where nothing is to be corrected."""
    shown = _samples(channels)
    if shown is None:
        return off_their_lines(channels)
    spline = make_interp_spline(shown.places, shown.samples, k=_DEGREE, axis=1)
    return np.asarray(spline(np.arange(channels.shape[1])), dtype=float), shown.interval


class _Samples(NamedTuple):
    places: Floats
    """(sample,), in rows."""
    samples: Floats
    """(channel, sample)."""
    interval: float
    """Interval between the control's samples, rows."""


def _samples(channels: Floats) -> _Samples | None:
    """The samples that the rows hold, or between which they lie on lines; None where the rows show no samples."""
    held = held_samples(channels)
    if held is not None:
        places, rows = held
        return _Samples(places, channels[:, rows], float(np.median(np.diff(places))))
    on_lines = line_samples(channels)
    if on_lines is not None:
        places, samples = on_lines
        return _Samples(places, samples, float(np.median(np.diff(places))))
    aged = aged_samples(channels)
    return None if aged is None else _Samples(aged[0], channels, aged[1])

"""Rows that show the samples of a control that is not in step with them, as the samples themselves: held, on lines
between slower samples, or each the last one of a faster control.
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
"""Of the spline through the samples: at a fifth of their rate its gain is right to 1e-4."""


class Released(NamedTuple):
    """Channels on smooth curves through the samples that their rows show."""

    channels: Floats
    """(channel, time); as they are where the rows are even."""
    interval: float
    """s, between the control's samples; NaN where the rows do not show it."""


def released(channels: Floats, rate: float) -> Released:
    """Channels of a record whose rows are not in step with the control, on a smooth curve through its samples.

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
    smooth = channels.copy()
    spline = make_interp_spline(shown.places, shown.samples, k=_DEGREE, axis=1)
    smooth[finite] = spline(np.arange(channels.shape[1]))
    return Released(smooth, shown.interval / rate)


class _Samples(NamedTuple):
    places: Floats
    """(sample,), in rows."""
    samples: Floats
    """(channel, sample)."""
    interval: float
    """Of the control, rows."""


def _samples(channels: Floats) -> _Samples | None:
    """The samples that the rows show; None where each row is a sample of its own."""
    held = held_samples(channels)
    if held is not None:
        places, rows = held
        return _Samples(places, channels[:, rows], float(np.median(np.diff(places))))
    on_lines = line_samples(channels)
    if on_lines is not None:
        places, samples = on_lines
        return _Samples(places, samples, float(np.median(np.diff(places))))
    aged = aged_samples(channels)
    if aged is not None:
        places, interval = aged
        return _Samples(places, channels, interval)
    straightened = off_their_lines(channels)
    if straightened is not None:
        samples, interval = straightened
        return _Samples(np.arange(channels.shape[1], dtype=float), samples, interval)
    return None

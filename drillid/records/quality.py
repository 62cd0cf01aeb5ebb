"""Samples that cannot be true: spikes and stuck sensors; and runs of samples."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import median_filter

from drillid.arrays import Booleans, Floats, Integers

_WIDEST_SPIKE = 3
_NEIGHBOURS = 2
"""Good samples on either side from which a spike's true value is judged."""
_LOCAL_S = 2.0
"""Interval over which a signal's roughness is taken as the same, s."""
_MEDIAN_DEGREES = 0.18
"""Degrees of freedom that a sample adds to a scale from a median: 37 % efficiency, half for neighbours being alike."""
_LEFT_ROUGH = 0.1
"""Share of a spike's height that may be left of roughness once it is replaced, such as a kink beneath it."""

_REPEATED = 3
"""Times that a value must occur to count as a step and not as chance."""
_TOLERANCE = 0.02
"""Of a step."""
_ON_LATTICE = 0.8
"""Share of samples that must lie on whole steps; interpolated rows do not."""


def runs(mask: Booleans) -> Integers:
    """First and last-plus-one of every run of True, shape (run, 2)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return edges.reshape(-1, 2).astype(np.int64)


def spikes(signal: Floats, rate: float, error_rate: float) -> Booleans:
    """Isolated samples that an inertia cannot make: away and back within three samples.

    A sample is suspect where it differs from the cubic through its four neighbours by more than
    the local roughness (median absolute difference over 2 s, with its own uncertainty) allows at
    `error_rate`. Suspects are spikes where leaving out one to three samples makes their whole
    neighbourhood as smooth as the signal is there, or ten times smoother, and where they lie
    further off than their neighbours' whole range; so steps and kinks are none.

    Parameters
    ----------
    signal : shape (time,), without NaN
    rate : samples per second
    error_rate : share of good samples of Gaussian roughness that may be taken for spikes
    """
    from scipy.stats import norm, t

    found = np.zeros(signal.size, dtype=bool)
    if signal.size < 2 * _NEIGHBOURS + 2 * _WIDEST_SPIKE:
        return found
    off = _off_neighbours(signal)
    changes = np.abs(np.diff(signal))
    quantum = changes[changes > 0].min() if np.any(changes > 0) else 0.0
    around = 2 * round(_LOCAL_S * rate / 2) + 1
    roughness = np.pad(median_filter(np.abs(off[2:-2]), around, mode="reflect"), 2, mode="edge") / norm.isf(0.25)
    limit = t.isf(error_rate / 2, _MEDIAN_DEGREES * around) * np.maximum(roughness, quantum / 2)
    suspects = np.flatnonzero((np.abs(off) > limit) & (limit > 0))
    if suspects.size == 0:
        return found
    for cluster in np.split(suspects, np.flatnonzero(np.diff(suspects) > _NEIGHBOURS) + 1):
        first, last = _explained(signal, limit, int(cluster[0]), int(cluster[-1]) + 1)
        found[first:last] = True
    return found


def _off_neighbours(signal: Floats) -> Floats:
    """Difference of each sample from the cubic through two samples on either side; zero at the ends."""
    off = np.zeros(signal.size)
    off[2:-2] = signal[2:-2] - (4 * (signal[1:-3] + signal[3:-1]) - signal[:-4] - signal[4:]) / 6
    return off


def _explained(signal: Floats, limit: Floats, first: int, stop: int) -> tuple[int, int]:
    """The smallest run of samples whose replacement makes the suspects from `first` to `stop` smooth; empty if none."""
    for width in range(1, _WIDEST_SPIKE + 1):
        for start in range(max(first, _NEIGHBOURS), min(stop, signal.size - _NEIGHBOURS - width + 1)):
            low, high = max(0, start - 5), min(signal.size, start + width + 5)
            piece, inside = signal[low:high].copy(), np.arange(start, start + width) - low
            beside = np.r_[inside[0] - _NEIGHBOURS : inside[0], inside[-1] + 1 : inside[-1] + 1 + _NEIGHBOURS]
            likely = np.polyval(np.polyfit(beside - inside[0], piece[beside], 3), inside - inside[0])
            if np.any(np.abs(piece[inside] - likely) <= np.ptp(piece[beside])):
                continue
            left = _LEFT_ROUGH * np.min(np.abs(piece[inside] - likely))
            piece[inside] = likely
            judged = slice(max(0, first - low), max(stop, start + width) - low)
            if np.all(np.abs(_off_neighbours(piece))[judged] <= np.maximum(limit[low:high], left)[judged]):
                return start, start + width
    return first, first


def stuck(signal: Floats, others_move: Booleans, rate: float, longest_s: float) -> Booleans:
    """Samples of runs longer than `longest_s` in which the signal keeps one value other than zero while others move.

    Parameters
    ----------
    signal : shape (time,)
    others_move : samples at which another signal shows that this one should change, shape (time,)
    rate : samples per second
    longest_s : longest unchanged run of a working sensor, s
    """
    same = np.concatenate([[False], np.diff(signal) == 0]) & (signal != 0)
    found = np.zeros(signal.size, dtype=bool)
    for first, stop in runs(same):
        whole = slice(first - 1, stop)
        if stop - first + 1 > longest_s * rate and np.mean(others_move[whole]) > 0.5:
            found[whole] = True
    return found


def quantisation_step(values: Floats) -> float | None:
    """Step of which nearly all values are whole multiples, from a common origin; None where there is none."""
    found, counts = np.unique(values, return_counts=True)
    often = found[counts >= _REPEATED]
    if often.size < 2 or counts[counts >= _REPEATED].sum() < _ON_LATTICE * values.size:
        return None
    apart = np.diff(often)
    apart = apart[apart > 1e-9 * np.abs(often).max()]
    if apart.size == 0:
        return None
    least = float(apart.min())
    step = float(np.sum(apart) / np.sum(np.rint(apart / least)))
    place = (values - often[0]) / step
    return step if np.mean(np.abs(place - np.rint(place)) < _TOLERANCE) >= _ON_LATTICE else None

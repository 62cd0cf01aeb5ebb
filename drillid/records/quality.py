"""Invalid samples: spikes and stuck sensors; the quantisation step; and runs of samples."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import median_filter
from scipy.special import ndtri, stdtrit

from drillid.arrays import Booleans, Floats, Integers

_WIDEST_SPIKE = 3
_NEIGHBOURS = 2
"""Good samples on either side from which a spike's true value is interpolated."""
_ROUNDING = 1e-9
"""Relative difference of two ways to compute a cubic that is far above rounding."""
_LOCAL_S = 2.0
"""Interval over which a signal's roughness is taken as constant, s."""
_MEDIAN_DEGREES = 0.18
"""Degrees of freedom per sample of a scale from a median: 37 % efficiency, halved as neighbours are correlated."""
_LEFT_ROUGH = 0.1
"""Share of a spike's height that may remain as roughness once it is replaced, such as a kink beneath it."""

_REPEATED = 3
"""Least number of occurrences of a value that belongs to a quantised record."""
_TOLERANCE = 0.02
"""Tolerance, as a share of a step."""
_ON_STEPS = 0.8
"""Least share of samples on whole multiples of the step; interpolated rows are not."""


def runs(mask: Booleans) -> Integers:
    """First and last-plus-one of every run of True, shape (run, 2)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return edges.reshape(-1, 2).astype(np.int64)


def spikes(signal: Floats, rate: float, error_rate: float) -> Booleans:
    """Isolated samples that an inertia cannot follow: away and back within three samples.

    A sample is suspect where it differs from the cubic through its four neighbours by more than
    the local roughness (median absolute difference over 2 s, with its own uncertainty) allows at
    `error_rate`. Suspects are spikes where omitting one to three samples makes their whole
    neighbourhood as smooth as the signal is there, or ten times smoother, and where they deviate
    by more than their neighbours' whole range; so steps and kinks are not spikes.

    Parameters
    ----------
    signal : shape (time,), without NaN
    rate : samples per second
    error_rate : share of good samples of Gaussian roughness that may be taken as spikes
    """
    spiky = np.zeros(signal.size, dtype=bool)
    if signal.size < 2 * _NEIGHBOURS + 2 * _WIDEST_SPIKE:
        return spiky
    deviation = _from_neighbours(signal)
    changes = np.abs(np.diff(signal))
    quantum = changes[changes > 0].min() if np.any(changes > 0) else 0.0
    around = 2 * round(_LOCAL_S * rate / 2) + 1
    roughness = np.pad(median_filter(np.abs(deviation[2:-2]), around, mode="reflect"), 2, mode="edge") / -ndtri(0.25)
    limit = -stdtrit(_MEDIAN_DEGREES * around, error_rate / 2) * np.maximum(roughness, quantum / 2)
    suspects = np.flatnonzero((np.abs(deviation) > limit) & (limit > 0))
    if suspects.size == 0:
        return spiky
    possible = _beyond_neighbours(signal, suspects)
    for cluster in np.split(suspects, np.flatnonzero(np.diff(suspects) > _NEIGHBOURS) + 1):
        first, last = _explained(signal, limit, possible, int(cluster[0]), int(cluster[-1]) + 1)
        spiky[first:last] = True
    return spiky


def _beyond_neighbours(signal: Floats, suspects: Integers) -> Booleans:
    """Whether one to three samples from a suspect on may deviate by more than their neighbours' range, shape (3, time).

    Those certainly within it, as most suspects are, are left out, because fitting each takes time.
    """
    possible = np.zeros((_WIDEST_SPIKE, signal.size), dtype=bool)
    near = np.unique(np.concatenate([suspects + step for step in range(_NEIGHBOURS)]))
    for width in range(1, _WIDEST_SPIKE + 1):
        start = near[(near >= _NEIGHBOURS) & (near <= signal.size - _NEIGHBOURS - width)]
        place = np.r_[-_NEIGHBOURS:0, width : width + _NEIGHBOURS]
        through = np.vander(np.arange(width), 4) @ np.linalg.inv(np.vander(place, 4))
        beside = signal[start[:, None] + place]
        off = np.abs(signal[start[:, None] + np.arange(width)] - beside @ through.T).min(axis=1)
        certain = np.ptp(beside, axis=1) - _ROUNDING * np.abs(beside).max(axis=1)
        possible[width - 1, start] = off > certain
    return possible


def _from_neighbours(signal: Floats) -> Floats:
    """Difference of each sample from the cubic through two samples on either side; zero at the ends."""
    deviation = np.zeros(signal.size)
    deviation[2:-2] = signal[2:-2] - (4 * (signal[1:-3] + signal[3:-1]) - signal[:-4] - signal[4:]) / 6
    return deviation


def _explained(signal: Floats, limit: Floats, possible: Booleans, first: int, stop: int) -> tuple[int, int]:
    """The smallest run of samples whose replacement makes the suspects from `first` to `stop` smooth; empty if none."""
    for width in range(1, _WIDEST_SPIKE + 1):
        for start in range(max(first, _NEIGHBOURS), min(stop, signal.size - _NEIGHBOURS - width + 1)):
            if not possible[width - 1, start]:
                continue
            low, high = max(0, start - 5), min(signal.size, start + width + 5)
            piece, inside = signal[low:high].copy(), np.arange(start, start + width) - low
            beside = np.r_[inside[0] - _NEIGHBOURS : inside[0], inside[-1] + 1 : inside[-1] + 1 + _NEIGHBOURS]
            likely = np.polyval(np.polyfit(beside - inside[0], piece[beside], 3), inside - inside[0])
            if np.any(np.abs(piece[inside] - likely) <= np.ptp(piece[beside])):
                continue
            remaining = _LEFT_ROUGH * np.min(np.abs(piece[inside] - likely))
            piece[inside] = likely
            judged = slice(max(0, first - low), max(stop, start + width) - low)
            if np.all(np.abs(_from_neighbours(piece))[judged] <= np.maximum(limit[low:high], remaining)[judged]):
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
    unchanged = np.zeros(signal.size, dtype=bool)
    for first, stop in runs(same):
        whole = slice(first - 1, stop)
        if stop - first + 1 > longest_s * rate and np.mean(others_move[whole]) > 0.5:
            unchanged[whole] = True
    return unchanged


def quantisation_step(values: Floats) -> float | None:
    """Step of which nearly all values are whole multiples, from a common origin; None where there is none."""
    distinct, counts = np.unique(values, return_counts=True)
    repeated = distinct[counts >= _REPEATED]
    if repeated.size < 2 or counts[counts >= _REPEATED].sum() < _ON_STEPS * values.size:
        return None
    difference = np.diff(repeated)
    difference = difference[difference > 1e-9 * np.abs(repeated).max()]
    if difference.size == 0:
        return None
    least = float(difference.min())
    step = float(np.sum(difference) / np.sum(np.rint(difference / least)))
    multiple = (values - repeated[0]) / step
    return step if np.mean(np.abs(multiple - np.rint(multiple)) < _TOLERANCE) >= _ON_STEPS else None

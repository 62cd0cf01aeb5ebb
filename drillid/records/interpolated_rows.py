"""Rows that lie on lines between the samples of a slower control.

The lines bend only at the samples. A bend between two rows appears in the second differences at both, the more the
nearer it is, and nowhere else. Where samples are at least two rows apart, each row belongs to one bend at most.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import make_lsq_spline

from drillid.arrays import Floats

_SHORTEST, _LONGEST = 2.0, 12.0
"""Shortest and longest interval between samples, rows."""
_FIRST_ROWS, _LONGER = 48, 3
"""Rows of the first search, made where the record bends most, and factor by which each further one is longer."""
_RESOLUTION, _FINER = 0.12, 0.02
"""Resolution of a sample's place in the first search, and in the others, rows."""
_MULTIPLES = 6
"""Largest multiple of the interval found that is tried, as its places include those of samples farther apart."""
_WORTH_A_SEARCH, _ON_LINES = 0.3, 0.1
"""Largest misfit, relative to that of samples a row later, at which the search goes on, and at which rows are on lines;
in other records the two misfits are alike."""


def line_samples(channels: Floats) -> tuple[Floats, Floats] | None:
    """Places (sample,) in rows of the samples that the rows interpolate, and the samples (channel, sample).

    None where the rows are not on lines.

    Parameters
    ----------
    channels : shape (channel, time), finite, all recorded alike; the first is the one with the least noise
    """
    found = _bends(channels[0])
    if found is None:
        return None
    first, step = found
    places = np.arange(first, channels.shape[1] - 1, step)
    rows = np.arange(np.ceil(places[0]), places[-1])
    lines = make_lsq_spline(rows, channels[:, rows.astype(int)].T, np.r_[places[0], places, places[-1]], k=1)
    return places, np.asarray(lines.c.T, dtype=float)


def _bends(channel: Floats) -> tuple[float, float] | None:
    """Place of the first sample and interval between samples, both in rows; None where the rows are not on lines."""
    second = np.concatenate([[0.0], np.diff(channel, 2), [0.0]])
    if second.size <= 2 * _FIRST_ROWS:
        return None
    rows = _FIRST_ROWS
    energy = np.convolve(second**2, np.ones(rows), "same")
    middle = int(np.clip(np.argmax(energy), rows // 2, second.size - rows // 2))
    step, offset = _searched(second, middle)
    if not _ratio(second, middle, rows, step, offset) < _WORTH_A_SEARCH:
        return None
    resolution = _RESOLUTION
    while rows < second.size:
        reach, rows = 3 * resolution * step / rows, min(_LONGER * rows, second.size)
        steps = step + np.arange(-reach, reach, 2 * _FINER * step / rows)
        offsets, resolution = offset + np.arange(-2 * resolution, 2 * resolution, _FINER), 2 * _FINER
        candidates = [np.ravel(values) for values in np.meshgrid(steps, offsets)]
        best = np.argmin(_misfit(second, middle, rows, *candidates))
        step, offset = (float(values[best]) for values in candidates)
    farther = [(m * step, offset + number * step) for m in range(1, _MULTIPLES + 1) for number in range(m)]
    bent = [found for found in farther if _ratio(second, middle, rows, *found) < _ON_LINES]
    if not bent:
        return None
    step, offset = max(bent)
    return (middle + offset) % step, step


def _searched(second: Floats, middle: int) -> tuple[float, float]:
    """Interval between samples and place of one, in rows from the middle, that fit best where the record bends most."""
    count = round(np.log(_LONGEST / _SHORTEST) * _FIRST_ROWS / (2 * _RESOLUTION))
    distances = np.geomspace(_SHORTEST, _LONGEST, count)
    within = [np.arange(0.0, distance, _RESOLUTION) for distance in distances]
    steps, offsets = np.repeat(distances, [each.size for each in within]), np.concatenate(within)
    misfit = _misfit(second, middle, _FIRST_ROWS, steps, offsets)
    best = np.argmin(misfit)
    return float(steps[best]), float(offsets[best])


def _ratio(second: Floats, middle: int, rows: int, step: float, offset: float) -> float:
    """Misfit relative to that of samples a row later."""
    here, later = _misfit(second, middle, rows, np.full(2, step), offset + np.array([0.0, 1.0]))
    return float(here / later) if later > 0 else np.inf


def _misfit(second: Floats, middle: int, rows: int, steps: Floats, offsets: Floats) -> Floats:
    """Share (candidate,) of the power of the second differences that bends at the given places do not explain.

    Parameters
    ----------
    second : (time,) second differences, zero at either end
    rows : number of rows compared, about the middle
    steps, offsets : (candidate,) interval between samples and place of one, in rows from the middle
    """
    low, high = max(middle - rows // 2, 0), min(middle + rows // 2, second.size)
    part = second[low:high]
    first = np.ceil((low - middle - offsets) / steps)
    numbers = first[:, None] + np.arange(rows // steps.min() + 1)
    places = middle - low + offsets[:, None] + steps[:, None] * numbers
    row = np.floor(places).astype(int)
    share, inside = places - row, row < part.size - 1
    row = np.where(inside, row, 0)
    along = (1 - share) * part[row] + share * part[row + 1]
    explained = np.sum(np.where(inside, along**2 / ((1 - share) ** 2 + share**2), 0.0), axis=1)
    # up to the first bend and after the last one, the rows show parts of others
    power = np.cumsum(np.append(0.0, part**2))
    compared = power[row.max(axis=1) + 2] - power[row[:, 0]]
    return np.asarray(1 - explained / np.where(compared > 0, compared, np.inf), dtype=float)

"""Rows that hold the samples of a slower control between them."""

from __future__ import annotations

import numpy as np

from drillid.arrays import Booleans, Floats, Integers

_UNEVEN = 0.02
"""Largest share of the runs of a held record with neither of the two lengths that an interval gives, and of those that
show no sample of their own.
"""
_LEAST_HELD = 0.02
"""Least share of repeated rows of a held record."""
_LEAST_SAMPLES = 8
_ROUNDS = 3
"""Number of fits of a line to the samples' places, each of which numbers the samples anew."""
_STEPS = 2.0
"""Least power of a held channel's changes between samples relative to those within one; 1 where it is not held."""


def held_samples(channels: Floats) -> tuple[Floats, Integers] | None:
    """Places of the samples and a row that shows each, both (sample,) in rows; None where the rows hold no samples.

    In a record that holds its values, all channels repeat a row at once, so that runs of equal rows have at most two
    lengths, which are successive. The first row of each sample is late by half a row on average. Where something is
    added to a held channel, such as a tone, the others show its samples.

    Parameters
    ----------
    channels : shape (channel, time), finite
    """
    changes = np.diff(channels, axis=1)
    shown = _changed(changes)
    first = np.flatnonzero(shown) + 1
    if first.size < _LEAST_SAMPLES or shown.mean() > 1 - _LEAST_HELD:
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
    # rows that are equal by rounding are not at a sample's end
    if kept.size < (1 - _UNEVEN) * first.size or step < 1 + _LEAST_HELD:
        return None
    return offset + step * number, first[kept].astype(np.int64)


def _changed(changes: Floats) -> Booleans:
    """Whether a row shows another sample than the one before, (time - 1,), by the channels that only change then.

    Parameters
    ----------
    changes : shape (channel, time - 1)
    """
    repeated = changes[0] == 0
    if not repeated.any() or repeated.all():
        return np.asarray(~repeated, dtype=bool)
    within, between = ((changes[:, rows] ** 2).mean(axis=1) for rows in (repeated, ~repeated))
    has_more = ((changes[:, repeated] != 0).mean(axis=1) > 0.5) & (between > _STEPS * within)
    return np.asarray((changes[~has_more] != 0).any(axis=0), dtype=bool)

"""Intervals of a control that samples and holds, to be tried where no data sheet states one and no row shows one."""

from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.special import erf

from drillid.arrays import Floats
from drillid.fits.datasheet import SHOWN_INTERVAL_ERROR, DataSheet

_USUAL = 0.025
"""s, scale of the half-normal prior of an interval that is not known."""
_INTERVALS = (0.0, *np.geomspace(0.01, 0.05, 15).tolist())
"""s, none, then up to one that hardly any speed control exceeds, so closely spaced that none in between fits much
better.
"""
_RELATIVE = 0.03
"""Relative standard uncertainty about each of these."""
_PARTS = (4, 3, 2, 1)
"""Numbers of intervals that an even row may last."""
_APART = 0.05
"""Probability that rows are even though the control's interval is none of these, as a recorder that reads sweep and
speed apart from the control makes them.
"""


class Usual(NamedTuple):
    """An interval that stands for those near it."""

    interval: float
    """s; 0 where control is continuous."""
    relative: float
    """Relative standard uncertainty."""
    cost: float
    """Logarithm of the prior odds of continuous control against it."""


def usual_intervals(sheet: DataSheet) -> tuple[Usual, ...]:
    """The intervals to try, with their prior costs.

    Rows out of step with the control are uneven, so that an interval that even rows do not show is probably a whole
    part of theirs.
    """
    return _usual(float(sheet.even_rows))


@cache
def _usual(row: float) -> tuple[Usual, ...]:
    grid = np.array(_INTERVALS)
    if np.isnan(row):
        return _with_costs(grid, np.full(grid.size, _RELATIVE), _prior(grid, np.inf))
    parts = np.append(0.0, row / np.array(_PARTS))
    in_step, apart = (1 - _APART) * _prior(parts, row), _APART * _prior(grid, np.inf)[1:]
    errors = np.repeat([SHOWN_INTERVAL_ERROR, _RELATIVE], [parts.size, grid.size - 1])
    return _with_costs(np.append(parts, grid[1:]), errors, np.append(in_step, apart))


def _with_costs(intervals: Floats, errors: Floats, prior: Floats) -> tuple[Usual, ...]:
    columns = intervals.tolist(), errors.tolist(), np.log(prior[0] / prior).tolist()
    return tuple(Usual(*each) for each in zip(*columns, strict=True))


def _prior(intervals: Floats, longest: float) -> Floats:
    """Prior probability, up to the longest, of the range about each of increasing intervals, halfway in their effect,
    which grows with the square of the interval.
    """
    between = np.sqrt(np.convolve(np.square(intervals), [0.5, 0.5], "valid"))
    below = erf(np.array([0.0, *between, longest]) / (np.sqrt(2) * _USUAL))
    return np.asarray(np.diff(below) / below[-1], dtype=float)

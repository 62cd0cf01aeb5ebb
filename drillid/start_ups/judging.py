"""Models of a start of rotation, each judged beside the one before it on the part of the log that no fit has seen.

The squared errors of held-out time are averaged over blocks longer than a cycle of stick-slip, which are taken as
independent; a model is kept where the lower end of what it saves is above zero.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from drillid.arrays import Floats
from drillid.simulation.start_up import RATE
from drillid.simulation.start_up_fit import MeasuredStartUp, StartUpModel
from drillid.statistics import ONE_SIDED, student

BLOCK_S = 4.0
"""s; strings of a few kilometres stick and slip within two to eight seconds, and most of a cycle counts."""
_LEAST_BLOCKS = 3
DESCRIBED, FITTED = "described", "fitted"


@dataclass(frozen=True)
class Gain:
    """Share of the held-out squared error that a model saves, with its 90 % interval by Student's t over blocks."""

    value: float
    half_width: float

    @property
    def low(self) -> float:
        """Lower end, a one-sided 95 % limit."""
        return self.value - self.half_width

    @property
    def high(self) -> float:
        """Upper end; no model saves more than all."""
        return min(self.value + self.half_width, 1.0)


@dataclass(frozen=True, eq=False)
class Judged:
    """Models of one log, with what each saves of the held-out squared error of the best one before it."""

    models: Mapping[str, StartUpModel]
    gains: Mapping[str, Gain]
    kept: str
    """Name of the model with which to predict."""


def judged(models: Mapping[str, StartUpModel], log: MeasuredStartUp, seen: float) -> Judged:
    """Judge models, from the simplest, on the time after `seen`, s."""
    (kept, first), *later = models.items()
    gains, errors = {kept: Gain(0.0, 0.0)}, held_out_errors(first, log, seen)
    for name, model in later:
        own = held_out_errors(model, log, seen)
        gains[name] = gain(errors, own)
        if gains[name].low > 0:
            kept, errors = name, own
    return Judged(models, gains, kept)


def held_out_errors(model: StartUpModel, log: MeasuredStartUp, seen: float) -> Floats:
    """Mean squared error in each block of the time after `seen` (s), (blocks,)."""
    errors = model.squared_errors(log)[round(seen * RATE) :]
    return np.array([block.mean() for block in np.array_split(errors, max(round(errors.size / RATE / BLOCK_S), 1))])


def gain(before: Floats, after: Floats) -> Gain:
    """Saving of the second of two models, relative to the error of the first; unbounded below three blocks."""
    saved = (before - after) / max(float(before.mean()), np.finfo(float).tiny)
    if saved.size < _LEAST_BLOCKS:
        return Gain(float(saved.mean()), np.inf)
    error = float(saved.std(ddof=1) / np.sqrt(saved.size))
    return Gain(float(saved.mean()), student(ONE_SIDED, saved.size - 1) * error)

"""Signs of a response to the sweep that changes while the window lasts.

The change of the response with a figure of the model, times how far that figure has moved, is looked for in what
does not repeat with the sweep. The sweep is known, so that the noise has no part in what is looked for.
Here the change is taken as its first derivative; `signs_path` follows one that is in sight.
"""

import numpy as np
from numpy.typing import NDArray

from drillid.discrepancy.signs_record import Remainder
from drillid.discrepancy.signs_score import Candidate
from drillid.physics.model import DAMPING_BHA, DELAY, INERTIA_TD, LENGTH

Floats = NDArray[np.float64]

CHANGES = np.linspace(0.15, 0.85, 15)
"""Shares of the window at which the response is tried to jump."""

_MOVING = (LENGTH, DELAY, INERTIA_TD, DAMPING_BHA)
"""Figures of the model that may move evenly when it is not asked why."""
_SETTLING_S = 10.0
"""s, over which the string takes up a jump; a sudden one would have power at all frequencies."""


def time_candidates(remainder: Remainder) -> list[Candidate]:
    """Growth, drift and jump, and clocks that run apart where no command tells that better; none where the sweep does
    not repeat.
    """
    if not remainder.periods:
        return []
    derivatives, passed = remainder.derivatives, remainder.passed
    by_length, by_damping, by_clock = (
        remainder.swept(transfer)
        for transfer in (derivatives[LENGTH], derivatives[DAMPING_BHA], -remainder.s * remainder.mobility)
    )
    duration = remainder.samples / remainder.record.rate
    drift = (
        [] if remainder.record.has_command else [Candidate("clock_drift", ((passed - 0.5) * duration * by_clock)[None])]
    )
    return [
        *drift,
        Candidate("length_growth", ((passed - 0.5) * by_length)[None], one_sided=True),
        Candidate("parameter_drift", ((passed - 0.5) * by_damping)[None]),
        Candidate("regime_change", jump(remainder, CHANGES) * by_damping),
    ]


def trend_candidate(remainder: Remainder) -> Candidate | None:
    """All that a response which moves evenly would show, whichever figures of the model move; None without periods."""
    if not remainder.periods:
        return None
    moved = remainder.swept(remainder.derivatives[list(_MOVING)])
    return Candidate("trend", (remainder.passed - 0.5) * moved, together=True)


def jump(remainder: Remainder, moments: Floats) -> Floats:
    """From 0 to 1 at each of some moments (jumps,), shares of the window; shape (jumps, samples)."""
    since = (remainder.passed - moments[:, None]) * remainder.samples / remainder.record.rate
    return np.asarray(np.sin(np.pi / 2 * np.clip(since / _SETTLING_S + 0.5, 0.0, 1.0)) ** 2, dtype=float)

"""Sign of clocks that run apart, from the logged torque command.

The control answers the speed that it reads itself by its own clock. Where the recorded speed comes from another clock,
the command lags the answer to it by an offset, and a drift is an offset that grows. The whole motion of the rig tells
it, not only the answer to the sweep.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft
from scipy.ndimage import median_filter

from drillid.discrepancy.signs_record import TAPER_S, Remainder
from drillid.discrepancy.signs_score import Candidate, Score, score, without
from drillid.physics.top_drive import control

Floats = NDArray[np.float64]

_LOWEST = 0.5
"""Hz, below which the control's integral answers tapered ends for longer than a block of the noise, and clocks show
least."""
_CLEAR = 10.0
"""Power of the answer to the recorded speed per power of what the command has beside it, from which a line is taken as
recorded; at others it is reckoned from the sweep, as noise in what is looked for would make it seem smaller."""
_LINES = 61
"""Lines over which these powers are taken together."""
_ENDS = 2.0
"""Tapers at either end that are left out: the control's answer to a speed that fades is not a fading answer."""


def control_scores(remainder: Remainder) -> dict[str, Score | None]:
    """Scores of an offset that grows, beside wrong gains and a steady offset, and of an answer that moves in any way;
    for records with a command.
    """
    inside, s = remainder.inside & (remainder.frequency > _LOWEST), remainder.s
    told = np.ravel(control(remainder.system.top_drive.controller, s))
    speed, given, sweep = (
        rfft((series - series.mean()) * remainder.taper)
        for series in (remainder.speed, remainder.command - remainder.sweep, remainder.sweep)
    )
    beyond = given + told * speed
    answered, missing = (median_filter(np.abs(lines) ** 2, _LINES, mode="nearest") for lines in (told * speed, beyond))
    moved = np.where(answered > _CLEAR * missing, speed, remainder.mobility * sweep)

    whole = np.minimum(remainder.time, remainder.time[::-1]) > _ENDS * TAPER_S

    def series(lines: NDArray[np.complex128]) -> Floats:
        return np.asarray(irfft(np.where(inside, lines, 0.0), remainder.samples) * whole, dtype=float)

    earlier = series(-s * told * moved)
    beside = np.stack([series(moved), series(moved / s), earlier])
    passed = remainder.time - remainder.time.mean()
    moving = without(passed * beside, beside)
    left = without(series(beyond)[None], beside)[0]
    return {
        "clock_drift": score(Candidate("clock_drift", moving[2:]), left, remainder, inflation=1.0),
        "control_trend": score(Candidate("control_trend", moving, together=True), left, remainder),
    }

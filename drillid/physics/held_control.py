"""Control that samples and holds: a computer reads the speed at an interval h and holds its command in between.

A command that is held for h is late by a uniformly distributed time: the drive is multiplied by
(1 − e^(−sh))/(sh) = e^(−sh/2) sinh(sh/2)/(sh/2), a delay by h/2, which counts as part of T_d, and a variance of h²/12
(Åström and Wittenmark 1997, Computer-Controlled Systems, chapters 2 and 3). The readings fold what the steps of the
command add at multiples of their rate. There the top drive's inertia J is the load, whose speed at the readings follows
exactly: where the drive itself is late by m + f intervals, m whole ones and a part f,

    z^(−m) (1 − f + f/z) h/(J (z − 1)) = e^(−sT_d)/(J s) (1 + s²h² (f(1 − f)/2 − 1/24) + …),   z = e^(sh),

so that altogether the variance is v = h² (f(1 − f) − 1/12): h²/12 in the mean over f, and between −h²/12 and h²/6. The
next term of the logarithm is −s³ κ/6 with the third cumulant κ = h³ f(1 − f)(1 − 2f), at most 0.1 h³.

A recorder whose clock is late by t₀ against the control's holds what the readings would be if the drive were later by
t₀: its time stamps have the difference of v, and of κ, at T_d + t₀ and at T_d.
"""

from typing import Any

import numpy as np

from drillid.physics.dual_numbers import primal

LONGEST = 0.05
"""s, beyond which hardly any speed control has its interval."""
USUAL = LONGEST / 2
"""s, scale of the half-normal prior of an interval that is not known."""


def cumulants(interval: Any, delay: Any) -> tuple[Any, Any]:
    """v (s²) and κ (s³) of the drive at an interval h and a whole delay T_d, which includes h/2; both in s, and broadcast.

    Either may be a Dual. Both are continuous where T_d is a multiple of h and a half, though v has a kink there.
    """
    beyond = delay / interval - 0.5
    part = beyond - np.floor(primal(beyond))
    spread = part * (1 - part)
    return interval**2 * (spread - 1 / 12), interval**3 * spread * (1 - 2 * part)

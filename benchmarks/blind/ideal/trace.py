"""What a cause that acts beyond a threshold leaves in the records: the same rig and noise, with it and without."""

from dataclasses import replace

import numpy as np
from scipy.fft import rfft, rfftfreq

from benchmarks.blind.generator.cases import RATE, Case, simulate_case
from benchmarks.blind.ideal.theory import noise_density
from drillid.physics.responses import laplace

_ABSENT = {"torque_limit": np.inf, "torque_rate_limit": np.inf, "gear_backlash": 1e-9}
"""Size at which each of these causes does nothing, whatever the drive is asked for; a gear of none is rigid."""
_BAND_HZ = (0.02, 9.0)
"""Where the recorder hears; a trend is no trace."""


def trace(case: Case) -> float:
    """√λ of the speed that such causes leave out or add, known in all its course; NaN where none is hidden.

    It is 0 where a limit is never reached or a play never opens, and bounds from above what any test finds that has to
    learn the rig's figures from the same records.
    """
    if not case.answer & set(_ABSENT):
        return float("nan")
    hidden = tuple(replace(one, size=_ABSENT.get(one.name, one.size)) for one in case.hidden)
    without = replace(case, hidden=hidden)
    left = simulate_case(case).speed - simulate_case(without).speed
    frequency = rfftfreq(left.shape[1], 1 / RATE)
    heard = (frequency > _BAND_HZ[0]) & (frequency < _BAND_HZ[1])
    energy = np.abs(rfft(left) / RATE)[:, heard] ** 2
    s = laplace(frequency[heard])
    density = np.stack([noise_density(without, without.world(number), number, s) for number in range(left.shape[0])])
    return float(np.sqrt(np.sum(4 * energy / density) * frequency[1]))

"""Trace in the records of a cause that acts beyond a threshold: the same rig and noise, with and without it."""

from dataclasses import replace

import numpy as np
from scipy.fft import rfft, rfftfreq

from benchmarks.blind.generator.cases import RATE, Case, simulate_case
from benchmarks.blind.ideal.theory import noise_density
from drillid.physics.responses import laplace

_ABSENT = {"torque_limit": np.inf, "torque_rate_limit": np.inf, "gear_backlash": 1e-9}
"""Size at which each of these causes has no effect, whatever the torque; a gear with zero play would be rigid."""
_BAND_HZ = (0.02, 9.0)
"""Band of the recorder; a trend does not count as trace."""


def trace(case: Case) -> float:
    """√λ of the speed that such causes add, sample by sample; NaN where none is hidden.

    It is 0 where a limit is never reached or a play never opens, and an upper bound for any test that has to estimate
    the rig's parameters from the same records.
    """
    if not case.hidden_names & set(_ABSENT):
        return float("nan")
    hidden = tuple(replace(cause, size=_ABSENT.get(cause.name, cause.size)) for cause in case.hidden)
    without = replace(case, hidden=hidden)
    difference = simulate_case(case).speed - simulate_case(without).speed
    frequency = rfftfreq(difference.shape[1], 1 / RATE)
    in_band = (frequency > _BAND_HZ[0]) & (frequency < _BAND_HZ[1])
    energy = np.abs(rfft(difference) / RATE)[:, in_band] ** 2
    s = laplace(frequency[in_band])
    density = np.stack(
        [noise_density(without, without.world(number), number, s) for number in range(difference.shape[0])]
    )
    return float(np.sqrt(np.sum(4 * energy / density) * frequency[1]))

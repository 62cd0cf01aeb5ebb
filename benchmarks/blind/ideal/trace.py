"""Trace in the records of a cause that acts beyond a threshold: the same rig and noise, with and without it."""

from dataclasses import replace

import numpy as np
from scipy.fft import rfft, rfftfreq

from benchmarks.blind.hidden import Hidden
from benchmarks.blind.ideal.of_case import ideal_of
from benchmarks.blind.ideal.responses import RATE
from benchmarks.blind.world import AnyCase, records_of

_ABSENT = {"torque_limit": np.inf, "torque_rate_limit": np.inf, "gear_backlash": 1e-9}
"""Size at which each of these causes has no effect, whatever the torque; a gear with zero play would be rigid."""
_BAND_HZ = (0.02, 9.0)
"""Band of the recorder; a trend does not count as trace."""


def trace(case: AnyCase) -> float:
    """√λ of the speed that such causes add, sample by sample; NaN where none is hidden.

    It is 0 where a limit is never reached or a play never opens, and an upper bound for any test that has to estimate
    the rig's parameters from the same records.
    """
    if not case.hidden_names & set(_ABSENT):
        return float("nan")
    return difference(case, tuple(replace(each, size=_ABSENT.get(each.name, each.size)) for each in case.hidden))


def difference(case: AnyCase, hidden: tuple[Hidden, ...]) -> float:
    """√λ of what is hidden against other causes, by simulating both under the same noise."""
    without = replace(case, hidden=hidden)
    added = records_of(case).speed - records_of(without).speed
    frequency = rfftfreq(added.shape[1], 1 / RATE)
    in_band = (frequency > _BAND_HZ[0]) & (frequency < _BAND_HZ[1])
    energy = np.abs(rfft(added) / RATE)[:, in_band] ** 2
    s = np.asarray(2j * np.pi * frequency[in_band], dtype=complex)
    responses = ideal_of(without).responses
    density = np.stack([responses.noise_density(number, hidden, s) for number in range(added.shape[0])])
    return float(np.sqrt(np.sum(4 * energy / density) * frequency[1]))

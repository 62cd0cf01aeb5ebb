"""Trace in the records of a cause that acts beyond a threshold: the same rig and noise, with and without it."""

from dataclasses import replace

import numpy as np
from scipy.fft import rfft, rfftfreq

from benchmarks.blind.hidden import Hidden
from benchmarks.blind.ideal.of_case import ideal_of
from benchmarks.blind.ideal.responses import NUISANCES, RATE
from benchmarks.blind.world import AnyCase, records_of, simulated

_ABSENT = {"torque_limit": np.inf, "torque_rate_limit": np.inf, "gear_backlash": 1e-9}
"""Size at which each of these causes has no effect, whatever the torque; a gear with zero play would be rigid."""
_BAND_HZ = (0.02, 9.0)
"""Band of the recorder; a trend does not count as trace."""
_DELAY = list(NUISANCES).index("delay")
_STEP = 0.1
"""Of the delay, 1 ms, by which its effect on the records is computed."""


def trace(case: AnyCase) -> float:
    """√λ of the speed that such causes add, sample by sample, to a drive of any delay; NaN where none is hidden.

    It is 0 where a limit is never reached or a play never opens, and an upper bound for any test that has to estimate
    further parameters of the rig from the same records. A limit that acts at every slew mostly delays the torque.
    """
    if not case.hidden_names & set(_ABSENT):
        return float("nan")
    return difference(case, tuple(replace(each, size=_ABSENT.get(each.name, each.size)) for each in case.hidden))


def difference(case: AnyCase, hidden: tuple[Hidden, ...]) -> float:
    """√λ of what is hidden against other causes in a rig of any delay, by simulating all under the same noise."""
    without = replace(case, hidden=hidden)
    before, ideal = records_of(without).speed, ideal_of(without)
    delayed = np.stack(
        [simulated(without, window, _STEP * np.eye(len(NUISANCES))[_DELAY])["speed"] for window in ideal.windows]
    )
    frequency = rfftfreq(before.shape[1], 1 / RATE)
    in_band = (frequency > _BAND_HZ[0]) & (frequency < _BAND_HZ[1])
    s = np.asarray(2j * np.pi * frequency[in_band], dtype=complex)
    density = np.stack([ideal.responses.noise_density(window, hidden, s) for window in ideal.windows])
    weight = np.sqrt(4 * frequency[1] / density) / RATE
    added, slope = (rfft(each - before)[:, in_band] * weight for each in (records_of(case).speed, delayed))
    explained = np.vdot(added, slope).real ** 2 / (
        np.vdot(slope, slope).real + (_STEP / ideal.priors.shared[_DELAY]) ** 2
    )
    return float(np.sqrt(np.vdot(added, added).real - explained))

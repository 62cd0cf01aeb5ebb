"""Torques that excite the string: the injected sweep and the coloured torque noise of the bit."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

SWEEP_BANDS = ((0.05, 0.215), (0.215, 0.93), (0.93, 4.0))
"""Lower and upper frequency (Hz) of the three simultaneous sweeps, about two octaves each."""
SWEEP_PERIOD = 120.0
"""Seconds after which the sweeps repeat."""


def exponential_sweeps(
    time: ArrayLike,
    amplitude: float,
    bands: Sequence[tuple[float, float]] = SWEEP_BANDS,
    period: float = SWEEP_PERIOD,
) -> NDArray[np.float64]:
    """Sum of simultaneous exponential sweeps, repeated for ever.

    The instantaneous frequency rises as f₁ r^(t/T) with r = f₂/f₁, so the phase in closed form is
    φ(t) = 2π f₁ T/ln r (r^(t/T) − 1). The cycles of one period are brought to the nearest whole number,
    by scaling f₁ and f₂ alike, so that the torque and not only its bands repeat without a jump; that
    moves a band's edges by at most half a cycle in its count.

    Parameters
    ----------
    time : s since the start of a period, any shape
    amplitude : N m, of each sweep
    bands : Hz, lower and upper frequency of each sweep
    period : s

    Returns
    -------
    Torque, N m, in the shape of `time`.
    """
    share: NDArray[np.float64] = np.mod(np.asarray(time, dtype=float), period) / period
    torque: NDArray[np.float64] = np.zeros_like(share)
    for lower, upper in bands:
        ratio = upper / lower
        cycles = max(1, round(lower * period * (ratio - 1) / np.log(ratio)))
        torque += np.sin(2 * np.pi * cycles * (ratio**share - 1) / (ratio - 1))
    return amplitude * torque


def coloured_noise(
    generator: np.random.Generator, samples: int, time_step: float, rms: float, bandwidth: float
) -> NDArray[np.float64]:
    """Stationary Gaussian noise behind a first-order low pass.

    Parameters
    ----------
    samples : length of the series
    time_step : s
    rms : root mean square in the mean over realisations, unit of the result
    bandwidth : Hz, corner frequency of the low pass

    Returns
    -------
    Noise, shape (samples,), stationary from its first sample on.
    """
    from scipy.signal import lfilter

    memory = float(np.exp(-2 * np.pi * bandwidth * time_step))
    steps = generator.standard_normal(samples) * rms
    steps[1:] *= np.sqrt(1 - memory**2)
    return np.asarray(lfilter([1.0], [1.0, -memory], steps), dtype=float)

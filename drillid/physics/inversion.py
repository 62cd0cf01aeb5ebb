"""From the Laplace variable to time: the inverse transform by one FFT, right of the imaginary axis.

On the line s = a + jω the transform belongs to the response times e^(−at), so that what an FFT wraps
around comes back smaller by e^(−a period) (Dubner and Abate 1968, Journal of the ACM 15, 115–123). What
remains is the transform beyond the highest frequency; callers take steps and kinks out in closed form first.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len

from drillid.physics.dual import linear
from drillid.physics.line import Complex

Floats = NDArray[np.float64]

IMAGES = 1e-12
"""Size of the periodic images."""
FINEST_INTERVAL_S = 0.004
"""Spacing in time at which the transform is computed."""


def inverse_laplace(transform: Callable[[Complex], Any], duration: float, interval: float) -> tuple[Floats, Any]:
    """Response in time of a transform that is analytic right of Re s = 13.8/duration.

    A response that grows faster than e^(13.8 t/duration) is not represented; a stable one always is.

    Parameters
    ----------
    transform : takes s of shape (frequency,), returns an array or a Dual of shape (..., frequency)
    duration, interval : length and spacing of the lags, s

    Returns
    -------
    lags : shape (lag,), s, from 0
    response : shape (..., lag); a Dual where the transform is one
    """
    lags = np.arange(0.0, duration + interval / 2, interval)
    oversampling = int(np.ceil(interval / FINEST_INTERVAL_S))
    points = next_fast_len(2 * lags.size * oversampling, real=True)
    period = points * interval / oversampling
    shift = -np.log(IMAGES) / period
    s = shift + 2j * np.pi * np.arange(points // 2 + 1) / period

    def to_time(spectrum: NDArray[Any]) -> NDArray[Any]:
        wrapped = irfft(spectrum, points)[..., : lags.size * oversampling : oversampling]
        return np.asarray(wrapped * (np.exp(shift * lags) * points / period))

    return lags, linear(to_time, transform(s))

"""Posterior of a cause's size, under the prior by which its evidence is counted."""

import numpy as np
from scipy.optimize import brentq
from scipy.special import log_ndtr, ndtr, softmax

from drillid.discrepancy.catalogue import Size
from drillid.discrepancy.rules import WIDE_PRIOR

_LEVEL = 0.95


def size_interval(estimate: float, error: float, size: Size) -> tuple[float, float]:
    """Central 95 % interval of the posterior, which is a mixture of two normal ones, within the size's bounds.

    The prior is half a normal one with the usual size, half one WIDE_PRIOR times as wide, each cut at zero where the
    size cannot be negative. It draws towards zero a size that was named because noise made it look large.

    Parameters
    ----------
    estimate, error : of the fit, whose prior is the wider normal one
    """
    usual, wide = size.typical**2, (WIDE_PRIOR * size.typical) ** 2
    precision = max(error**-2 - 1 / wide, 1e-12 * error**-2)
    by_data, variance = estimate * error**-2 / precision, 1 / precision
    priors = np.array([usual, wide])
    mean, deviation = by_data * priors / (priors + variance), np.sqrt(priors * variance / (priors + variance))
    least = 0.0 if size.low >= 0 else -np.inf
    logs = -0.5 * by_data**2 / (priors + variance) - 0.5 * np.log(priors + variance)
    weight = softmax(logs + log_ndtr((mean - least) / deviation))

    cut = ndtr((least - mean) / deviation)

    def beyond(value: float, share: float) -> float:
        """Posterior probability of a smaller size, less a share."""
        below = (ndtr((value - mean) / deviation) - cut) / np.maximum(1 - cut, np.finfo(float).tiny)
        return float(weight @ below) - share

    reach = 10 * float(deviation.max())
    ends = max(float(mean.min()) - reach, least), float(mean.max()) + reach
    low, high = (float(brentq(beyond, *ends, args=(share,))) for share in ((1 - _LEVEL) / 2, (1 + _LEVEL) / 2))
    return max(min(low, estimate), size.low), min(max(high, estimate), size.high)

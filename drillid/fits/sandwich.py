"""Errors of a fit whose model is not quite right: the scores' spread sandwiched between inverse curvatures.

Where the model is right, the scores of neighbouring frequencies are independent and their spread is the curvature.
Where it is misspecified, residuals are alike over many frequencies: the scores' covariance over neighbours then
holds both the noise and the model's error (Huber 1967; White 1982, Econometrica 50; Newey and West 1987, ibid. 55).
"""

import numpy as np

from drillid.arrays import Complex, Floats

_REACH = 20
"""Neighbours up to which scores are taken as correlated, twice as far as a model's errors are alike: at the usual
1/120 Hz half the spacing of a string's modes at 5 km."""


def error_factors(error: Complex, derivatives: Complex, variance: Floats, freedom: Floats, prior: Floats) -> Floats:
    """Factors (n,) by which the scores' spread makes standard errors larger than the curvature does; at least 1.

    The likelihood is that of `fits.likelihood`, Student's t of the errors over their estimated variance.

    Parameters
    ----------
    error : (frequency,) fitted less measured mobility
    derivatives : (n, frequency) of the fitted mobility
    variance, freedom : (frequency,) of the measured mobility, and its complex degrees of freedom
    prior : (n,) precisions of what is known beforehand
    """
    information = 2 * (freedom + 1) / ((freedom + 2) * variance)
    pull = 2 * (freedom + 1) / (freedom * variance + np.abs(error) ** 2)
    scores = pull * (np.conj(derivatives) * error).real
    curvature = (np.conj(derivatives) * information @ derivatives.T).real + np.diag(prior)
    spread = scores @ scores.T + np.diag(prior)
    for lag in range(1, min(_REACH, scores.shape[1] - 1) + 1):
        both = scores[:, lag:] @ scores[:, :-lag].T
        spread += (1 - lag / (_REACH + 1)) * (both + both.T)
    # in standard errors, as the parameters' units differ by many orders
    scale = 1 / np.sqrt(np.diag(curvature))
    inverse = np.linalg.inv(curvature * np.outer(scale, scale))
    robust = inverse @ (spread * np.outer(scale, scale)) @ inverse
    return np.asarray(np.sqrt(np.maximum(np.diag(robust) / np.diag(inverse), 1.0)), dtype=float)

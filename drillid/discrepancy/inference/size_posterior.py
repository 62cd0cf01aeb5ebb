"""Posterior of a cause's size, under the prior with which its evidence is computed."""

from collections.abc import Sequence

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import brentq
from scipy.special import log_ndtr, softmax
from scipy.stats import norm

from drillid.arrays import Floats
from drillid.discrepancy.catalogue import Size
from drillid.discrepancy.inference.coordinates import DATA_SHEET, SHARED, Extension
from drillid.discrepancy.inference.heavy_tails import HeavyTailedFit
from drillid.discrepancy.inference.priors import Priors
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.rules import STUDENT_TAIL, WIDE_PRIOR

_LEVEL = 0.95
_TAILS = ((1 - _LEVEL) / 2, (1 + _LEVEL) / 2)
_REACH, _POINTS = 10.0, 201
"""Standard errors on either side of an estimate over which a posterior is computed, and the number of sizes."""
_NEGLIGIBLE = 1e-4
"""Share of the posterior mass up to which a fit is left out."""
_FAR = 1e3
"""Offset, in tolerances, at which a data-sheet value has practically no weight."""


def fitted_size_interval(
    fits: Sequence[tuple[SetFit, float]], extensions: tuple[Extension, ...], place: int
) -> tuple[float, float]:
    """Central 95 % interval of the posterior of one of a fit's sizes, that of the first of the fits.

    Errors of data-sheet values have heavy tails. Where two values together determine a size, they may contradict each
    other, and the posterior then allows for either being wrong: it is computed size by size, with all else at its
    optimum there, and its volume by Laplace's approximation.

    Parameters
    ----------
    fits : by models with the same extensions, each with the logarithm of its posterior mass, up to a constant
    place : index of the size among those of the fits
    """
    size, estimate = extensions[place].cause.size, float(fits[0][0].point.sizes[place])
    shares = softmax([log_mass for _, log_mass in fits])
    # a fit that was stopped far from its optimum may have no error of its size
    counted = shares > _NEGLIGIBLE
    curves = [_cumulative(fit, extensions, place) for (fit, _), counts in zip(fits, counted, strict=True) if counts]
    sizes = np.unique(np.concatenate([at for at, _ in curves]))
    below = sum(share * np.interp(sizes, *curve) for share, curve in zip(shares[counted], curves, strict=True))
    low, high = np.interp(_TAILS, below / shares[counted].sum(), sizes)
    return max(min(float(low), estimate), size.low), min(max(float(high), estimate), size.high)


def _cumulative(fit: SetFit, extensions: tuple[Extension, ...], place: int) -> tuple[Floats, Floats]:
    """Sizes, and the posterior probability that one of a fit's is smaller, each (N,)."""
    size = extensions[place].cause.size
    estimate, error = float(fit.point.sizes[place]), float(fit.size_errors[place])
    low, high = max(estimate - _REACH * error, size.low), min(estimate + _REACH * error, size.high)
    sizes = np.linspace(low, high, _POINTS)
    usual, wide = (norm.logpdf(sizes, scale=scale * size.typical) for scale in (1.0, WIDE_PRIOR))
    # the fit has the wide prior alone
    log_prior = np.logaddexp(usual, wide) - wide
    log_density = _log_density(fit, extensions, SHARED + place, sizes) + log_prior
    below = cumulative_trapezoid(np.exp(log_density - log_density.max()), sizes, initial=0.0)
    return sizes, below / below[-1]


def _log_density(fit: SetFit, extensions: tuple[Extension, ...], index: int, values: Floats) -> Floats:
    """Log density of a size at N values (N,), up to a constant, with the prior that the fit used."""
    at = np.append(fit.off_data_sheet * fit.priors.error, fit.point.coordinates(extensions)[SHARED:])
    right = fit.information @ at
    information = fit.information.copy()
    rig = np.arange(SHARED)
    information[rig, rig] -= fit.priors.precision(fit.off_data_sheet)
    others = np.delete(np.arange(at.size), index)
    degrees = fit.priors.degrees.copy()
    degrees[list(DATA_SHEET)] = STUDENT_TAIL
    rig_priors = Priors(fit.priors.error, degrees, np.zeros(SHARED, dtype=bool))
    priors = rig_priors.and_normal(np.full(at.size - SHARED, np.inf))
    equations = HeavyTailedFit(information, priors).of(others)
    documented = np.flatnonzero(np.isfinite(degrees))
    rest = right[others] - values[:, None] * information[others, index]
    # disbelieve each data-sheet value in turn
    starts = [np.zeros(others.size), *(_FAR * priors.error[one] * (others == one) for one in documented)]
    optima = equations.optima(rest, [np.broadcast_to(start, rest.shape) for start in starts])
    squares = 0.5 * information[index, index] * values**2 - right[index] * values
    return np.asarray(-squares - optima.cost - 0.5 * optima.log_volume, dtype=float)


def size_interval(estimate: float, error: float, size: Size) -> tuple[float, float]:
    """Central 95 % interval of the posterior, which is a mixture of two normal ones, within the size's bounds.

    The prior is an equal mixture of a normal one with the usual size as its standard deviation and one WIDE_PRIOR times
    as wide, each truncated at zero where the size cannot be negative. It shrinks a size that was named because noise
    made it look large.

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
    above_least = log_ndtr((mean - least) / deviation)
    weight = softmax(logs + above_least)

    def beyond(value: float, share: float) -> float:
        """Posterior probability of a smaller size, less a share."""
        below = -np.expm1(log_ndtr((mean - value) / deviation) - above_least)
        return float(weight @ below) - share

    reach = 10 * float(deviation.max())
    ends = max(float(mean.min()) - reach, least), max(float(mean.max()), least) + reach
    low, high = (float(brentq(beyond, *ends, args=(share,))) for share in _TAILS)
    return max(min(low, estimate), size.low), min(max(high, estimate), size.high)

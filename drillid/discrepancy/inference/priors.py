"""Independent priors of coordinates about their means: normal ones, and others for values that may be wrong.

A value that no one measures is now and then plainly wrong: its error has Student's t. A measured one is as good as its
tolerance says, but not every tolerance can be trusted: a normal distribution, contaminated by a wider one (Tukey 1960).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from drillid.arrays import Booleans, Floats, Indices
from drillid.discrepancy.rules import UNDERSTATED, UNDERSTATED_BY


@dataclass(frozen=True, eq=False)
class Priors:
    """Priors of P coordinates."""

    error: Floats
    """(P,) standard deviations, or scales of Student's t; infinite without a prior."""
    degrees: Floats
    """(P,) degrees of freedom of Student's t; infinite where the prior is normal."""
    doubted: Booleans
    """(P,) whether a normal prior's error is UNDERSTATED_BY a factor with probability UNDERSTATED."""

    def precision(self, off: Floats) -> Floats:
        """Precision (..., P) of the normal priors that pull alike at offsets (..., P) from the means, given in errors.

        It falls as the offset grows: the weight of reweighted least squares (Lange, Little and Taylor 1989).
        """
        weight = np.asarray((1 + 1 / self.degrees) / (1 + off**2 / self.degrees), dtype=float)
        understated = expit(_log_odds(off[..., self.doubted]))
        weight[..., self.doubted] = 1 - understated * (1 - UNDERSTATED_BY**-2.0)
        return np.asarray(weight * self.error**-2.0, dtype=float)

    def precision_and_pull(self, off: Floats) -> tuple[Floats, Floats]:
        """The precision (..., P) and the falling slope of the cost (..., P) in the coordinates, at such offsets."""
        precision = self.precision(off)
        return precision, np.asarray(-precision * off * self.error, dtype=float)

    def cost(self, off: Floats) -> Floats:
        """Fall of the log density (..., P) from its peak at offsets (..., P) from the means, given in errors."""
        cost, heavy = np.asarray(0.5 * off**2, dtype=float), np.isfinite(self.degrees)
        degrees = self.degrees[heavy]
        cost[..., heavy] = 0.5 * (degrees + 1) * np.log1p(off[..., heavy] ** 2 / degrees)
        log_odds = _log_odds(off[..., self.doubted])
        cost[..., self.doubted] += np.logaddexp(0.0, _log_odds(0.0)) - np.logaddexp(0.0, log_odds)
        return cost

    def log_density(self, off: Floats) -> Floats:
        """Log density (..., P) at offsets (..., P) from the means, given in errors."""
        from scipy.stats import t

        understated = np.where(self.doubted, UNDERSTATED * (1 - 1 / UNDERSTATED_BY), 0.0)
        peak = t.logpdf(0.0, self.degrees) + np.log1p(-understated)
        return np.asarray(peak - self.cost(off), dtype=float)

    def drawn(self, count: int, generator: np.random.Generator) -> Floats:
        """Offsets drawn from the priors, in errors, (count, P)."""
        off, heavy = generator.standard_normal((count, self.error.size)), np.isfinite(self.degrees)
        off[:, heavy] = generator.standard_t(self.degrees[heavy], (count, np.count_nonzero(heavy)))
        understated = generator.random((count, np.count_nonzero(self.doubted))) < UNDERSTATED
        off[:, self.doubted] *= np.where(understated, UNDERSTATED_BY, 1.0)
        return off

    def of(self, coordinates: Indices) -> Priors:
        """Those of some of the coordinates."""
        return Priors(self.error[coordinates], self.degrees[coordinates], self.doubted[coordinates])

    def and_normal(self, error: Floats) -> Priors:
        """These, followed by normal ones with errors (K,)."""
        more = np.size(error)
        degrees = np.append(self.degrees, np.full(more, np.inf))
        return Priors(np.append(self.error, error), degrees, np.append(self.doubted, np.zeros(more, dtype=bool)))

    def all_normal(self) -> Priors:
        """Normal ones with the same errors."""
        return Priors(self.error, np.full_like(self.degrees, np.inf), np.zeros_like(self.doubted))


def _log_odds(off: Floats | float) -> Floats:
    """Log odds that an error is understated, given an offset (..., P) in units of it."""
    before = np.log(UNDERSTATED / (1 - UNDERSTATED) / UNDERSTATED_BY)
    return np.asarray(before + 0.5 * (1 - UNDERSTATED_BY**-2.0) * np.square(off), dtype=float)

"""Independent priors of coordinates about their means: normal ones, and Student's t for values that may be wrong."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from drillid.arrays import Floats, Indices


@dataclass(frozen=True, eq=False)
class Priors:
    """Priors of P coordinates."""

    error: Floats
    """(P,) standard deviations, or scales of Student's t; infinite without a prior."""
    degrees: Floats
    """(P,) degrees of freedom of Student's t; infinite where the prior is normal."""

    def precision(self, off: Floats) -> Floats:
        """Precision (..., P) of the normal priors that pull alike at offsets (..., P) from the means, given in errors.

        That of Student's t falls as its offset grows: the weight of reweighted least squares (Lange, Little and Taylor
        1989).
        """
        return np.asarray((1 + 1 / self.degrees) / (1 + off**2 / self.degrees) * self.error**-2.0, dtype=float)

    def pull(self, off: Floats) -> Floats:
        """Falling slope of the cost (..., P) in the coordinates, at offsets (..., P) given in errors."""
        return np.asarray(-self.precision(off) * off * self.error, dtype=float)

    def cost(self, off: Floats) -> Floats:
        """Fall of the log density (..., P) from its peak at offsets (..., P) from the means, given in errors."""
        cost, heavy = 0.5 * off**2, np.isfinite(self.degrees)
        degrees = self.degrees[heavy]
        cost[..., heavy] = 0.5 * (degrees + 1) * np.log1p(off[..., heavy] ** 2 / degrees)
        return np.asarray(cost, dtype=float)

    def drawn(self, count: int, generator: np.random.Generator) -> Floats:
        """Offsets drawn from the priors, in errors, (count, P)."""
        off, heavy = generator.standard_normal((count, self.error.size)), np.isfinite(self.degrees)
        off[:, heavy] = generator.standard_t(self.degrees[heavy], (count, np.count_nonzero(heavy)))
        return off

    def of(self, coordinates: Indices) -> Priors:
        """Those of some of the coordinates."""
        return Priors(self.error[coordinates], self.degrees[coordinates])

    def and_normal(self, error: Floats) -> Priors:
        """These, followed by normal ones with errors (K,)."""
        return Priors(np.append(self.error, error), np.append(self.degrees, np.full(np.size(error), np.inf)))

    def all_normal(self) -> Priors:
        """Normal ones with the same errors."""
        return replace(self, degrees=np.full_like(self.error, np.inf))

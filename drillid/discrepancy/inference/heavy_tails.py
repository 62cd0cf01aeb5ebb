"""Fits that are linear but for the heavy tails of their priors: many at once, by reweighted least squares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from drillid.arrays import Booleans, Floats, Indices
from drillid.discrepancy.inference.priors import Priors

_ROUNDS = 12
"""Iterations of reweighted least squares from each start."""


@dataclass(frozen=True, eq=False)
class Optima:
    """Optima of N fits in P coordinates."""

    at: Floats
    """(N, P)"""
    cost: Floats
    """(N,) ½ xᵀ I x − bᵀ x, with the costs of the priors."""
    curvature: Floats
    """(N, P, P), with each prior replaced by the normal one that gives the same optimum."""

    def where(self, chosen: Booleans) -> Optima:
        """The chosen ones."""
        return Optima(*(getattr(self, each.name)[chosen] for each in fields(self)))

    @property
    def log_volume(self) -> Floats:
        """(N,) log determinants of the curvatures."""
        return np.asarray(np.linalg.slogdet(self.curvature)[1], dtype=float)


@dataclass(frozen=True, eq=False)
class HeavyTailedFit:
    """Linear equations I x = b whose coordinates have priors about zero, some with heavy tails."""

    information: Floats
    """(P, P), I."""
    priors: Priors

    def optima(self, right: Floats, starts: Sequence[Floats]) -> Optima:
        """The best fit from several starts, for each right-hand side.

        Parameters
        ----------
        right : (N, P), b
        starts : (N, P) each
        """
        fits = [self._descended(right, start) for start in starts]
        best = np.argmin([fit.cost for fit in fits], axis=0), np.arange(len(right))
        return Optima(*(np.stack([getattr(fit, each.name) for fit in fits])[best] for each in fields(Optima)))

    def of(self, coordinates: Indices) -> HeavyTailedFit:
        """The same in some of the coordinates, with the others held at zero."""
        return HeavyTailedFit(self.information[np.ix_(coordinates, coordinates)], self.priors.of(coordinates))

    def _descended(self, right: Floats, start: Floats) -> Optima:
        at: Floats = start
        for _ in range(_ROUNDS):
            precision = self.priors.precision(at / self.priors.error)
            curvature = self.information + precision[..., None] * np.eye(at.shape[-1])
            at = np.asarray(np.linalg.solve(curvature, right[..., None])[..., 0], dtype=float)
        squares = 0.5 * np.einsum("np,np->n", at @ self.information, at) - np.einsum("np,np->n", at, right)
        return Optima(at, squares + self.priors.cost(at / self.priors.error).sum(axis=1), curvature)

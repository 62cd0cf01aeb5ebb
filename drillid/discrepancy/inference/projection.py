"""How well a set of windows can tell causes, past all figures that are not known: before any of them is looked for.

About the fitted base model every cause moves the whitened responses along a direction of its own. What of it the
nuisance figures cannot follow is its projected information; the cosine between two projected directions says how
much alike two causes are (Pukelsheim 2006, Optimal Design of Experiments, chapter 3).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drillid.arrays import Complex, Floats, Indices
from drillid.discrepancy.catalogue import Cause
from drillid.discrepancy.inference.set_fit import SetFit, normal_equations
from drillid.discrepancy.inference.set_model import SHARED, Extension, SetModel

_LEAST_INFORMATION = 1e-30
_ABSORBED = 1e-9
"""Share of a direction's information below which the nuisance figures follow it wholly: the rest is rounding."""


@dataclass(frozen=True, eq=False)
class Projection:
    """Scores and information of directions, past the nuisance figures."""

    score: Floats
    """(K,) derivative of the log-likelihood to each direction at zero; covariance `information` under the base."""
    information: Floats
    """(K, K)"""

    def without(self, places: Indices) -> "Projection":
        """The same without some directions."""
        kept = np.setdiff1d(np.arange(self.score.size), places)
        return Projection(self.score[kept], self.information[np.ix_(kept, kept)])


def candidates(catalogue: Sequence[Cause]) -> list[Extension]:
    """Every linear cause at each of its shapes."""
    return [Extension(cause, shape) for cause in catalogue if cause.is_linear for shape in cause.shapes]


def columns(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], further: Sequence[Extension]) -> Complex:
    """Directions (W, K, rows) of further causes at size zero."""
    return _beside(model, [model.derivative(fit.point, extensions, one) for one in further])


def secants(
    model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], further: Sequence[Extension], share: float = 1.0
) -> Complex:
    """Directions (W, K, rows) in which further causes move the responses from none to a share of their usual sizes."""
    point, before = fit.point, model.residual(fit.point, extensions)

    def direction(one: Extension) -> Complex:
        usual = share * one.cause.size.typical
        grown = replace(point, sizes=np.append(point.sizes, usual))
        return (before - model.residual(grown, (*extensions, one))) / usual

    return _beside(model, [direction(one) for one in further])


def _beside(model: SetModel, directions: Sequence[Complex]) -> Complex:
    """None or more directions (W, rows) beside each other, (W, K, rows)."""
    if not directions:
        return np.zeros((model.evidence.windows, 0, model.rows), dtype=complex)
    return np.stack(directions, axis=1)


def project(
    model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], further: Complex, without: int | None = None
) -> Projection:
    """Project the shared figures, the windows' own figures and the sizes of `extensions` out of directions.

    Parameters
    ----------
    further : (W, K, rows) directions
    without : number of the extension whose size is no nuisance, because the directions stand for it
    """
    normal = normal_equations(model, fit.point, extensions, further)
    matrix, vector, _, _ = normal.eliminated()
    count = SHARED + len(extensions)
    nuisance = np.array([place for place in range(count) if without is None or place != SHARED + without])
    wanted = np.arange(count, matrix.shape[0])
    border = matrix[np.ix_(nuisance, wanted)]
    solved = np.linalg.solve(matrix[np.ix_(nuisance, nuisance)], np.column_stack([border, vector[nuisance]]))
    information = matrix[np.ix_(wanted, wanted)] - border.T @ solved[:, :-1]
    score = vector[wanted] - border.T @ solved[:, -1]
    absorbed = np.diag(information) < _ABSORBED * np.diag(matrix)[wanted]
    score[absorbed] = information[absorbed] = information[:, absorbed] = 0.0
    return Projection(score, (information + information.T) / 2 + _LEAST_INFORMATION * np.eye(score.size))


def smallest_detectable(projection: Projection, threshold: float) -> Floats:
    """Size of each cause at which the ideal test of it alone is passed by half of all sets, (K,).

    Parameters
    ----------
    threshold : standard deviations that the test asks for
    """
    return np.asarray(threshold / np.sqrt(np.diag(projection.information)), dtype=float)


def separation(projection: Projection, sizes: Floats) -> Floats:
    """Expected distance of causes at their sizes in standard deviations, (K, K); the second cause's size is free.

    Row i: how far cause i at its size stays from the best that cause j can do.
    """
    information = projection.information
    diagonal = np.diag(information)
    unlike = np.maximum(diagonal[:, None] - information**2 / diagonal[None, :], 0.0)
    return np.asarray(np.abs(sizes)[:, None] * np.sqrt(unlike), dtype=float)

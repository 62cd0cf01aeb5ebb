"""How well a set of windows can discriminate between causes, with the nuisance parameters projected out.

About the fitted base model every cause moves the whitened responses along a direction of its own. The part that the
nuisance parameters cannot reproduce is its projected information; the cosine between two projected directions measures
how similar two causes are (Pukelsheim 2006, Optimal Design of Experiments, chapter 3). None of this needs the cause to
be present.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drillid.arrays import Complex, Floats, Indices
from drillid.discrepancy.catalogue import Cause
from drillid.discrepancy.inference.coordinates import SHARED, Extension
from drillid.discrepancy.inference.most_mass import bias_of_curvature
from drillid.discrepancy.inference.set_fit import SetFit, normal_equations
from drillid.discrepancy.inference.set_model import SetModel

_LEAST_INFORMATION = 1e-30
_ABSORBED = 1e-9
"""Share of a direction's information below which nuisance parameters reproduce it entirely: the rest is rounding."""


@dataclass(frozen=True, eq=False)
class Projection:
    """Scores and information of directions with the nuisance parameters projected out."""

    score: Floats
    """(K,) derivative of the log-likelihood along each direction at zero; covariance `information` under the base."""
    information: Floats
    """(K, K)"""

    def without(self, indices: Indices) -> "Projection":
        """The same without some directions."""
        kept = np.setdiff1d(np.arange(self.score.size), indices)
        return Projection(self.score[kept], self.information[np.ix_(kept, kept)])


def candidates(catalogue: Sequence[Cause]) -> list[Extension]:
    """Every linear cause at each of its shapes."""
    return [Extension(cause, shape) for cause in catalogue if cause.is_linear for shape in cause.shapes]


def columns(model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], further: Sequence[Extension]) -> Complex:
    """Directions (W, K, rows) of further causes at size zero."""
    return _stacked(model, [model.derivative(fit.point, extensions, extension) for extension in further])


def secants(
    model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], further: Sequence[Extension], share: float = 1.0
) -> Complex:
    """Directions (W, K, rows) of finite steps of further causes, from size zero to a share of their usual sizes."""
    point, before = fit.point, model.residual(fit.point, extensions)

    def direction(extension: Extension) -> Complex:
        step = share * extension.cause.size.typical
        extended = replace(point, sizes=np.append(point.sizes, step))
        return (before - model.residual(extended, (*extensions, extension))) / step

    return _stacked(model, [direction(extension) for extension in further])


def _stacked(model: SetModel, directions: Sequence[Complex]) -> Complex:
    """Directions (W, rows), possibly none, as one array (W, K, rows)."""
    if not directions:
        return np.zeros((model.evidence.windows, 0, model.measured.count), dtype=complex)
    return np.stack(directions, axis=1)


def project(
    model: SetModel, fit: SetFit, extensions: tuple[Extension, ...], further: Complex, without: int | None = None
) -> Projection:
    """Project the shared coordinates, the windows' deviations and the sizes of `extensions` out of directions.

    Parameters
    ----------
    further : (W, K, rows) directions
    without : index of the extension whose size is no nuisance, because the directions stand for it
    """
    bias = bias_of_curvature(model, fit.point, extensions)
    normal = normal_equations(model, fit.point, extensions, further, bias=bias)
    matrix, vector, _, _ = normal.eliminated()
    count = matrix.shape[0] - further.shape[1]
    nuisance = np.array([index for index in range(count) if without is None or index != SHARED + without])
    wanted = np.arange(count, matrix.shape[0])
    border = matrix[np.ix_(nuisance, wanted)]
    solved = np.linalg.solve(matrix[np.ix_(nuisance, nuisance)], np.column_stack([border, vector[nuisance]]))
    information = matrix[np.ix_(wanted, wanted)] - border.T @ solved[:, :-1]
    score = vector[wanted] - border.T @ solved[:, -1]
    absorbed = np.diag(information) < _ABSORBED * np.diag(matrix)[wanted]
    score[absorbed] = information[absorbed] = information[:, absorbed] = 0.0
    return Projection(score, (information + information.T) / 2 + _LEAST_INFORMATION * np.eye(score.size))


def smallest_detectable(projection: Projection, threshold: float) -> Floats:
    """Size of each cause at which the ideal test for it alone detects it in half of all sets, (K,).

    Parameters
    ----------
    threshold : of the test, in standard deviations
    """
    return np.asarray(threshold / np.sqrt(np.diag(projection.information)), dtype=float)


def separation(projection: Projection, sizes: Floats) -> Floats:
    """Expected distance between causes in standard deviations, (K, K); the second cause's size is free.

    Row i: distance of cause i at its size from the best fit of cause j to it.
    """
    information = projection.information
    diagonal = np.diag(information)
    unexplained = np.maximum(diagonal[:, None] - information**2 / diagonal[None, :], 0.0)
    return np.asarray(np.abs(sizes)[:, None] * np.sqrt(unexplained), dtype=float)

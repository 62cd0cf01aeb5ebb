"""How often data sheets are so far off that a cause seems present where nothing is wrong.

Errors of data-sheet values have heavy tails, which linear theory about the fitted model ignores: a score test cannot
tell a plainly wrong value from a cause that looks like it. Here errors are drawn from their priors, and each draw is
fitted without and with each cause. Everything but the priors is linear.
"""

from collections.abc import Sequence

import numpy as np

from drillid.arrays import Floats
from drillid.discrepancy.catalogue import Cause
from drillid.discrepancy.inference.coordinates import SHARED, STATED, Extension
from drillid.discrepancy.inference.heavy_tails import HeavyTailedFit, Optima
from drillid.discrepancy.inference.projection import candidates, columns
from drillid.discrepancy.inference.screen import root
from drillid.discrepancy.inference.search import evidence_of_size
from drillid.discrepancy.inference.set_fit import SetFit, normal_equations
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.rules import REJECTED_PULLS, WIDE_PRIOR

_DRAWS = 2000
"""Number of data sheets drawn: a probability of one in a thousand is found to within a factor of two."""


def chance_of_evidence(
    model: SetModel, base: SetFit, catalogue: Sequence[Cause], log_evidence: float, generator: np.random.Generator
) -> float:
    """Probability that data sheets are off by more than REJECTED_PULLS and some cause has at least so much evidence,
    where nothing is wrong.
    """
    chosen = [candidate for candidate in candidates(catalogue) if not candidate.cause.size.fixed]
    wide = [WIDE_PRIOR * candidate.cause.size.typical for candidate in chosen]
    normal = normal_equations(model, base.point, (), columns(model, base, (), chosen))
    information = normal.eliminated()[0] - np.diag(normal.prior)
    everything = HeavyTailedFit(information, model.priors.and_normal(np.array(wide)))
    true, right = _drawn(model, information, generator)
    rig = np.arange(SHARED)
    without = everything.of(rig).optima(right[:, rig], (np.zeros_like(true), true))
    rejected = model.priors.cost(without.at / model.priors.error)[:, list(STATED)].sum(axis=1) > REJECTED_PULLS
    true, right, without = true[rejected], right[rejected], without.where(rejected)
    # as if the evidence at hand were one of the draws
    most = _most_evidence(everything, chosen, right, true, without)
    return float((np.count_nonzero(most >= log_evidence) + 1) / (_DRAWS + 1))


def _most_evidence(
    everything: HeavyTailedFit, chosen: Sequence[Extension], right: Floats, true: Floats, without: Optima
) -> Floats:
    """Log Bayes factors of the likeliest cause in each draw, (N,)."""
    rig, most = np.arange(SHARED), np.full(len(true), -np.inf)
    starts = [np.pad(start, ((0, 0), (0, 1))) for start in (true, without.at)]
    for place, candidate in enumerate(chosen, SHARED):
        own, size = np.append(rig, place), candidate.cause.size
        fitted = everything.of(own).optima(right[:, own], starts)
        fall, volume = without.cost - fitted.cost, fitted.log_volume - without.log_volume
        estimate, precision = fitted.at[:, -1], 1 / np.linalg.inv(fitted.curvature)[:, -1, -1]
        evidence = evidence_of_size(fall, volume, estimate, precision, size)
        most = np.maximum(most, np.where(estimate >= size.low, evidence, -np.inf))
    return most


def _drawn(model: SetModel, information: Floats, generator: np.random.Generator) -> tuple[Floats, Floats]:
    """Errors (N, 14) of the drawn data sheets, and right-hand sides (N, P) of data with noise."""
    true = model.priors.drawn(_DRAWS, generator) * model.priors.error
    noise = generator.standard_normal((_DRAWS, len(information))) @ root(information).T
    return true, true @ information[:SHARED] + noise

"""Two engines that anyone would try first, on the same evidence: the greatest fall of χ² with BIC, and a lasso.

Both take the base model's fit and the first- and second-order directions of all causes that are linear, with the
nuisance parameters projected out. The proof sets their thresholds so that their false alarms are as many as the
engine's.
"""

import numpy as np

from benchmarks.blind.answer import Answer, Claim
from benchmarks.blind.engines import catalogue_of, kept_answer, kept_evidence
from benchmarks.blind.vocabulary import UNKNOWN
from benchmarks.blind.world import AnyCase
from drillid.arrays import Floats
from drillid.discrepancy.inference.base_fit import fit_base
from drillid.discrepancy.inference.projection import candidates, columns, project, secants
from drillid.errors import DrillidError
from drillid.fleet.provenance import source_hash

_CODE = source_hash("benchmarks.blind.baselines")
_PENALTIES, _LEAST_PENALTY = 25, 0.02
"""Number of penalties of the lasso's path, and the smallest relative to that at which the first cause enters."""
_SWEEPS, _SETTLED = 200, 1e-6


def greatest_reduction(case: AnyCase) -> Answer:
    """The cause that lowers χ² most; its score is that fall less BIC's penalty of one parameter."""
    return kept_answer(case, f"greatest {_CODE}", _greatest)


def lasso(case: AnyCase) -> Answer:
    """The causes that a lasso keeps at the penalty with the best BIC; its score is the fall of BIC."""
    return kept_answer(case, f"lasso {_CODE}", _lasso)


def _greatest(case: AnyCase) -> Answer:
    try:
        names, score, information, rows = _directions(case)
    except DrillidError as error:
        return Answer((), failure=str(error), score=-np.inf)
    fall = score**2 / np.maximum(np.diag(information), 1e-30)
    best = int(np.argmax(fall))
    return Answer((Claim(names[best], 0.5, names[best]),), score=float(fall[best] - np.log(rows)))


def _lasso(case: AnyCase) -> Answer:
    try:
        names, score, information, rows = _directions(case)
    except DrillidError as error:
        return Answer((), failure=str(error), score=-np.inf)
    scale = np.sqrt(np.maximum(np.diag(information), 1e-30))
    unit, gain = information / np.outer(scale, scale), score / scale
    best, kept = -np.inf, np.array([int(np.argmax(np.abs(gain)))])
    size = np.zeros(gain.size)
    for penalty in np.abs(gain).max() * np.geomspace(1.0, _LEAST_PENALTY, _PENALTIES)[1:]:
        size = _coordinates(unit, gain, float(penalty), size)
        active = np.flatnonzero(size)
        # the fall of χ² by least squares over the active directions
        fall = float(gain[active] @ np.linalg.lstsq(unit[np.ix_(active, active)], gain[active], 1e-8)[0])
        value = fall - len({names[each] for each in active}) * np.log(rows)
        if value > best:
            best, kept = value, active
    claims = tuple(Claim(name, 0.5, name) for name in sorted({names[each] for each in kept}))
    return Answer(claims or (Claim(UNKNOWN, 0.5),), score=float(best))


def _coordinates(unit: Floats, gain: Floats, penalty: float, size: Floats) -> Floats:
    """Lasso by cyclic coordinate descent (Friedman, Hastie and Tibshirani 2010), from the last penalty's solution."""
    size = size.copy()
    rest = gain - unit @ size
    for _ in range(_SWEEPS):
        largest = 0.0
        for number in range(size.size):
            free = rest[number] + size[number]
            moved = float(np.sign(free) * max(abs(free) - penalty, 0.0)) - size[number]
            if moved:
                size[number] += moved
                rest -= moved * unit[:, number]
                largest = max(largest, abs(moved))
        if largest < _SETTLED:
            break
    return size


def _directions(case: AnyCase) -> tuple[list[str], Floats, Floats, int]:
    """Names, scores and information of all linear causes' directions, and the number of real residuals."""
    model, base = fit_base(kept_evidence(case))
    chosen = [extension for extension in candidates(catalogue_of(case)) if not extension.cause.size.fixed]
    pieces = [columns(model, base, (), chosen), secants(model, base, (), chosen)]
    found = project(model, base, (), np.concatenate(pieces, axis=1))
    names = [extension.cause.name for extension in chosen]
    return 2 * names, found.score, found.information, 2 * int(np.count_nonzero(model.measured.weight > 0))

"""Verdicts on what wells of a rig, a hole section or a tool have in common, and on each well beside the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import logsumexp

from drillid.arrays import Indices
from drillid.common_causes.hierarchy import CommonCause, common_cause, family_p_value
from drillid.common_causes.pooling import SetStatistics, Wells
from drillid.discrepancy.base_rates import BaseRates
from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.inference.shared_likelihood import shared_candidates
from drillid.discrepancy.rules import CLASS_MASS, SISTERS_SEE
from drillid.discrepancy.verdicts.naming import class_evidence, class_name
from drillid.discrepancy.verdicts.verdict import NONE

SHARES, LONE, WITHDRAWN = "shares it", "this log only", "withdrawn"
UNSEEN, UNSEEING = "the others cannot tell", "cannot tell"
AT_BOUND = "at_bound"


@dataclass(frozen=True)
class OwnVerdict:
    """What a well's own verdict names."""

    members: tuple[str, ...]
    cause: str
    """The most likely member."""
    size: float


@dataclass(frozen=True)
class CommonVerdict:
    """The verdict on a group."""

    shared: str
    """What its wells have in common: rig, section or tool."""
    name: str
    """Name of that."""
    verdict: str
    """none, a cause, or a class as its members joined by |."""
    family: str
    cause: str
    """The most likely member whose size lies within the range compared."""
    probability: float
    evidence_nats: float
    """Log Bayes factor that all wells have it, against none."""
    p_value: float
    """p-value of the likeliest cause of the catalogue at one common size, where no well has any cause."""
    size: float
    size_low: float
    """95 % interval."""
    size_high: float
    unit: str
    wells: int
    """Number of wells whose evidence is combined."""
    heterogeneity_p_value: float
    """p-value of the scatter of the wells' sizes."""
    spread_nats: float
    """Log Bayes factor of sizes of their own against one common size."""
    one_well_nats: float
    """Log Bayes factor that a single well has it, against none."""


@dataclass(frozen=True)
class Standing:
    """One well compared with the others, or why nothing is named for all of them."""

    shared: str
    name: str
    well: str
    """Empty where it is about all wells of the group."""
    cause: str
    standing: str
    deviation: float
    """Its size less the common one, in its standard errors."""
    evidence_nats: float
    """Log Bayes factor that it has the cause alone."""
    reason: str


@dataclass(frozen=True)
class Judged:
    """The verdict on a group, and each well's standing."""

    verdict: CommonVerdict
    standings: tuple[Standing, ...] = field(default=())


def candidates_of(shared: str) -> Indices:
    """Indices of the candidates that wells of a rig, section or tool may share."""
    return np.flatnonzero([each.cause.shared_by == shared for each in shared_candidates()])


def judge(
    shared: str,
    name: str,
    sets: Sequence[SetStatistics],
    own: Mapping[str, Sequence[OwnVerdict]],
    error_rate: float,
    base_rates: BaseRates,
) -> Judged:
    """Judge a group of wells.

    Wells that alone have a cause, more likely than all together, are set apart first: their evidence does not count in
    what the others have in common. By Markov's inequality a group without any cause has one in `error_rate` at most.

    Parameters
    ----------
    shared, name : what the wells have in common
    own : verdicts of the wells
    error_rate : probability that a group without any cause gets a verdict other than none
    """
    wells, lone = list(dict.fromkeys(each.well for each in sets)), dict[str, CommonCause]()
    at, alone = {well: row for row, well in enumerate(wells)}, dict[str, float]()
    while True:
        kept = [each for each in sets if each.well not in lone]
        found, p_value = _judged_causes(shared, kept)
        first = max(found, key=lambda cause: cause.one_well)
        bound = np.log(len(found) / error_rate)
        if len(at) - len(lone) < _FEWEST or first.one_well < max(bound, max(cause.shared for cause in found)):
            break
        outlier = [well for well in wells if well not in lone][int(np.argmax(first.alone))]
        lone[outlier], alone[outlier] = first, float(first.alone.max())
    best = max(found, key=lambda cause: cause.shared)
    members = _members(found) if p_value < error_rate else ()
    named = [cause for cause in found if cause.extension.cause.name in members]
    refused, within = [each for each in named if each.at_bound], [each for each in named if not each.at_bound]
    # a class has the size of its likeliest member within the range compared; without one nothing is named
    members, best = (members, max(within, key=lambda cause: cause.shared)) if within else ((), best)
    verdict = _verdict(shared, name, found, best, members, p_value, len(at) - len(lone), base_rates)
    rows = [
        Standing(
            shared, name, well, cause.extension.cause.name, LONE, float("nan"), alone[well],
            f"no other well of this {shared} has it",
        )
        for well, cause in lone.items()
    ]  # fmt: skip
    rows += [_refused(shared, name, cause) for cause in refused]
    left = [well for well in wells if well not in lone]
    for row, well in enumerate(left):
        if members:
            rows.append(_sharing(shared, name, well, best, row))
        for stated in own.get(well, ()):
            if not set(stated.members) & set(members):
                rows += _beside_sisters(shared, name, well, stated, found, row)
    return Judged(verdict, tuple(rows))


_FEWEST = 3
"""Fewest wells among which one can be told from the others."""


def _judged_causes(shared: str, sets: Sequence[SetStatistics]) -> tuple[list[CommonCause], float]:
    """Every candidate over the wells, and the p-value of the likeliest."""
    every, wells, numbers = shared_candidates(), Wells(sets), candidates_of(shared)
    found = [common_cause(wells, int(number), every[number]) for number in numbers]
    return found, family_p_value(max(cause.gain for cause in found), wells.correlation(numbers))


def _by_cause(found: Sequence[CommonCause]) -> dict[str, float]:
    """Log evidence of each cause that all wells have it, averaged over its shapes."""
    evidence: dict[str, list[float]] = {}
    for cause in found:
        evidence.setdefault(cause.extension.cause.name, []).append(cause.shared)
    return {name: float(logsumexp(values) - np.log(len(values))) for name, values in evidence.items()}


def _members(found: Sequence[CommonCause]) -> tuple[str, ...]:
    """The likeliest causes that together have most of the posterior mass."""
    evidence = _by_cause(found)
    names = sorted(evidence, key=lambda name: -evidence[name])
    mass = np.exp(np.array([evidence[name] for name in names]) - logsumexp(list(evidence.values())))
    return tuple(names[: int(np.searchsorted(np.cumsum(mass), CLASS_MASS)) + 1])


def _verdict(
    shared: str,
    name: str,
    found: Sequence[CommonCause],
    best: CommonCause,
    members: tuple[str, ...],
    p_value: float,
    wells: int,
    base_rates: BaseRates,
) -> CommonVerdict:
    """The verdict with the size of the likeliest cause; that of none states its evidence and no size."""
    evidence, of_group = _by_cause(found), base_rates.among([each.extension.cause.name for each in found])
    cause = best.extension.cause
    if members:
        of_class = class_evidence({member: evidence[member] for member in members}, base_rates)
        probability, sizes = of_group.probability(members, of_class), (best.size, best.size_low, best.size_high)
    else:
        of_class = class_evidence(evidence, base_rates)
        probability, sizes = 1 - of_group.probability(evidence, of_class), (float("nan"),) * 3
    return CommonVerdict(
        shared,
        name,
        class_name(members) if members else NONE,
        cause.family if members else "",
        cause.name if members else "",
        probability,
        of_class,
        p_value,
        *sizes,
        cause.size.unit if members else "",
        wells,
        best.heterogeneity,
        best.spread - best.common,
        best.one_well,
    )


def _refused(shared: str, name: str, cause: CommonCause) -> Standing:
    """A cause that the likelihoods favour at the largest size that they are stored for."""
    size, unit = f"{cause.size:.2g}", cause.extension.cause.size.unit
    reason = f"the likeliest size, {size}{'' if unit == '1' else ' ' + unit}, is the largest that is compared"
    return Standing(shared, name, "", cause.extension.cause.name, AT_BOUND, float("nan"), cause.shared, reason)


def _sharing(shared: str, name: str, well: str, cause: CommonCause, row: int) -> Standing:
    deviation = float(cause.deviations[row])
    size = abs(cause.size) * float(np.sqrt(cause.precision[row]))
    standing, reason = SHARES, f"the common size is {size:.1f} of its own standard errors"
    if not size > 0:
        standing, reason = UNSEEING, "its data do not show a cause of this size"
    return Standing(
        shared, name, well, cause.extension.cause.name, standing, deviation, float(cause.alone[row]), reason
    )  # fmt: skip


def _beside_sisters(
    shared: str, name: str, well: str, stated: OwnVerdict, found: Sequence[CommonCause], row: int
) -> list[Standing]:
    """What becomes of a well's own verdict that the other wells do not share."""
    own = [cause for cause in found if cause.extension.cause.name in stated.members]
    if not own:
        return []
    cause = max(own, key=lambda each: float(each.alone[row]))
    # of a class one member has the size that is stated
    sized = next((each for each in own if each.extension.cause.name == stated.cause), None)
    sight = abs(stated.size) * float(np.sqrt(np.delete(sized.precision, row).sum())) if sized else float("nan")
    evidence = float(cause.alone[row])
    if np.isnan(sight):
        standing, reason = UNSEEN, "the data of the others cannot be compared, as its size is not known"
    elif sight < SISTERS_SEE:
        standing, reason = UNSEEN, f"in the data of all others such a size is {sight:.1f} standard errors"
    elif evidence > 0:
        standing = LONE
        reason = (
            f"its {CATALOGUE[stated.cause].family} alone: in the data of the others it is {sight:.1f} standard errors"
        )
    else:
        standing = WITHDRAWN
        reason = f"the data of the others, in which it is {sight:.1f} standard errors, leave no evidence for it"
    return [Standing(shared, name, well, stated.cause, standing, float(cause.deviations[row]), evidence, reason)]

"""Verdicts on what wells of a rig, a hole section or a tool have in common, and on each well beside the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from operator import attrgetter

import numpy as np
from scipy.special import logsumexp, ndtr

from drillid.arrays import Indices
from drillid.common_causes.hierarchy import CommonCause, common_cause, family_p_value, standard_errors_off
from drillid.common_causes.pooling import SetStatistics, Wells
from drillid.discrepancy.base_rates import BaseRates
from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.inference.shared_likelihood import shared_candidates
from drillid.discrepancy.rules import CLASS_MASS, SISTERS_SEE
from drillid.discrepancy.verdicts.naming import class_evidence, class_name
from drillid.discrepancy.verdicts.verdict import NONE

SHARES, OTHER_SIZE, ABSENT = "shares it", "has it at another size", "does not have it"
LONE, WITHDRAWN = "this log only", "withdrawn"
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
    """Posterior of the verdict; one well that has a cause alone counts as another answer."""
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
    sharing: int
    """Number of those whose own data do not deny the cause; 0 where nothing is named."""
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
    group = Wells(sets)
    left, lone, alone = group.names, dict[str, CommonCause](), dict[str, float]()
    while True:
        found, p_value = _judged_causes(shared, group)
        first, best = (max(found, key=attrgetter(answer)) for answer in ("one_well", "shared"))
        if first.one_well < max(np.log(len(found) / error_rate), best.shared):
            break
        outlier = left[int(np.argmax(first.alone))]
        lone[outlier], alone[outlier] = first, float(first.alone.max())
        left = tuple(well for well in left if well != outlier)
        if len(left) == 1:
            break
        group = group.of(left)
    is_common = p_value < error_rate and first.one_well < best.shared
    members = _members(found) if is_common else ()
    named = [cause for cause in found if cause.extension.cause.name in members]
    refused, within = [each for each in named if each.at_bound], [each for each in named if not each.at_bound]
    # a class has the size of its likeliest member within the range compared; without one nothing is named
    members, best = (members, max(within, key=lambda cause: cause.shared)) if within else ((), best)
    named_wells = left if members else ()
    sharing = {well: _sharing(shared, name, well, best, group, error_rate / len(left)) for well in named_wells}
    shown = sum(each.standing != ABSENT for each in sharing.values())
    verdict = _verdict(shared, name, found, best, members, p_value, (len(left), shown), base_rates)
    rows = [
        Standing(
            shared, name, well, cause.extension.cause.name, LONE, float("nan"), alone[well],
            f"no other well of this {shared} has it",
        )
        for well, cause in lone.items()
    ]  # fmt: skip
    rows += [_refused(shared, name, cause) for cause in refused]
    for well in left:
        rows += [sharing[well]] if well in sharing else []
        for stated in own.get(well, ()):
            if not set(stated.members) & set(members):
                rows += _beside_sisters(shared, name, well, stated, found, group)
    return Judged(verdict, tuple(rows))


def _judged_causes(shared: str, group: Wells) -> tuple[list[CommonCause], float]:
    """Every candidate over the wells, and the p-value of the likeliest."""
    every, numbers = shared_candidates(), candidates_of(shared)
    found = [common_cause(group, int(number), every[number]) for number in numbers]
    return found, family_p_value(max(cause.gain for cause in found), group.correlation(numbers))


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
    wells: tuple[int, int],
    base_rates: BaseRates,
) -> CommonVerdict:
    """The verdict with the size of the likeliest cause; that of none states its evidence and no size.

    Parameters
    ----------
    wells : how many are combined, and how many of them share the cause
    """
    evidence, of_group = _by_cause(found), base_rates.among([each.extension.cause.name for each in found])
    cause, of_one_well = best.extension.cause, max(0.0, *(each.one_well for each in found))
    if members:
        of_class = class_evidence({member: evidence[member] for member in members}, base_rates)
        probability = of_group.probability(members, of_class - of_one_well)
        sizes = best.size, best.size_low, best.size_high
    else:
        of_class = class_evidence(evidence, base_rates)
        probability, sizes = 1 - of_group.probability(evidence, of_class - of_one_well), (float("nan"),) * 3
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
        *wells,
        best.heterogeneity,
        best.spread - best.common,
        best.one_well,
    )


def _refused(shared: str, name: str, cause: CommonCause) -> Standing:
    """A cause that the likelihoods favour at the largest size that they are stored for."""
    size, unit = f"{cause.size:.2g}", cause.extension.cause.size.unit
    reason = f"the likeliest size, {size}{'' if unit == '1' else ' ' + unit}, is the largest that is compared"
    return Standing(shared, name, "", cause.extension.cause.name, AT_BOUND, float("nan"), cause.shared, reason)


def _sharing(shared: str, name: str, well: str, cause: CommonCause, group: Wells, error_rate: float) -> Standing:
    """How a well stands to a cause that is named for all.

    Parameters
    ----------
    error_rate : probability that a well of the common size is told to be of another
    """
    row, own = group.names.index(well), group.of([well])
    deviation, alone, extension = float(cause.deviations[row]), float(cause.alone[row]), cause.extension
    without, at_common = (standard_errors_off(own, cause.number, extension, size) for size in (0.0, cause.size))
    standing, reason = SHARES, f"its own data lie {without:.1f} standard errors off without it, {at_common:.1f} with it"
    if max(without, at_common) < _SEES:
        standing, reason = UNSEEING, "its data do not show a cause of this size"
    elif 2 * ndtr(-abs(deviation)) < error_rate:
        standing = OTHER_SIZE if alone > 0 else ABSENT
    return Standing(shared, name, well, extension.cause.name, standing, deviation, alone, reason)


_SEES = 0.1
"""Standard errors below which the data of a well tell nothing of a size."""


def _beside_sisters(
    shared: str, name: str, well: str, stated: OwnVerdict, found: Sequence[CommonCause], group: Wells
) -> list[Standing]:
    """What becomes of a well's own verdict that the other wells do not share."""
    own = [cause for cause in found if cause.extension.cause.name in stated.members]
    if not own:
        return []
    row = group.names.index(well)
    cause = max(own, key=lambda each: float(each.alone[row]))
    # of a class one member has the size that is stated
    sized = next((each for each in own if each.extension.cause.name == stated.cause), None)
    sight = float("nan")
    if sized and np.isfinite(stated.size):
        others = group.of(set(group.names) - {well})
        sight = standard_errors_off(others, sized.number, sized.extension, stated.size)
    evidence = float(cause.alone[row])
    if np.isnan(sight):
        standing, reason = UNSEEN, "the data of the others cannot be compared, as its size is not known"
    elif sight < SISTERS_SEE:
        standing, reason = (
            UNSEEN,
            f"for the data of all others such a size is {sight:.1f} standard errors off, too few to deny it",
        )
    elif evidence > 0:
        standing = LONE
        family = CATALOGUE[stated.cause].family
        reason = f"its {family} alone: for the data of the others it is {sight:.1f} standard errors off"
    else:
        standing = WITHDRAWN
        reason = f"the data of the others, for which it is {sight:.1f} standard errors off, leave no evidence for it"
    return [Standing(shared, name, well, stated.cause, standing, float(cause.deviations[row]), evidence, reason)]

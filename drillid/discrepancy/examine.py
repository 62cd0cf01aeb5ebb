"""The engine: from a set of windows to verdicts."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import expit, logsumexp

from drillid.discrepancy.calibration import calibrated
from drillid.discrepancy.causes import CATALOGUE, Cause
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.gain import Gain, held_out_gain
from drillid.discrepancy.naming import Posterior, class_name, posterior, separator
from drillid.discrepancy.pooled import PooledSign, pool, sign_gain
from drillid.discrepancy.refine import Refined, refine
from drillid.discrepancy.screen import Screen, screen
from drillid.discrepancy.set_fit import SetFit, fit_set, with_own_deviation
from drillid.discrepancy.set_model import Extension, SetModel
from drillid.discrepancy.track import stretch
from drillid.discrepancy.verdict import NONE, UNKNOWN, Verdict

_LINEAR_SHARE = 0.6
"""Of the error rate, what is given to the linear responses; the rest is shared among the signs."""
_CLOSURE_RATE = 0.01
"""Chance below which an extended model has not passed the tests that the base model failed."""
_FIRSTS = 3
"""Causes with which a second one is tried."""
_FIRST_WITHIN = 12.0
_PAIR_PRICE = np.log(250.0)
"""Log odds against a certain second cause beside a first: one set in nine has two, and any of some thirty may be it."""
_HOPELESS_PULLS, _HOPELESS_CHI2 = 50.0, 2.0
"""Pulls of the papers, in units of log-likelihood, and χ² per residual beyond any chance."""
_WITHOUT_GAIN = 10.0
"""Evidence, in units of log-likelihood, of which a set without a name keeps the verdict that something is wrong."""
_STUCK, _ROUNDED = "stuck_slip_regimes", "quantisation"
_SHADOW = 0.1
"""Evidence for a second sign, per that of the plainest, below which it is not told."""
_LEFT_SHARE, _LEFT = 0.02, 4.0
"""Of the evidence for a cause, what may be left unexplained beside it before its name is withdrawn; and in units of
log-likelihood at least."""


@dataclass(frozen=True, eq=False)
class Examination:
    """Verdicts of a set with what they are made of."""

    verdicts: tuple[Verdict, ...]
    model: SetModel
    base: SetFit
    extended: SetFit
    extensions: tuple[Extension, ...]
    """Causes that stay in the model."""
    before: Screen
    after: Screen
    """The screen of the extended model; that of the base model where nothing was named."""
    posterior: Posterior | None
    signs: tuple[PooledSign, ...]


def examine(
    evidence: Evidence, *, catalogue: Sequence[Cause] | None = None, error_rate: float = 0.05, seed: int = 0
) -> Examination:
    """Show, name, extend and measure.

    Parameters
    ----------
    evidence : a set of windows
    catalogue : causes that may be named; all where not given
    error_rate : chance that a set in which nothing is wrong gets another verdict than none
    seed : of the draws that give chances
    """
    causes = list(CATALOGUE.values()) if catalogue is None else list(catalogue)
    model = SetModel(evidence)
    base = min((fit_set(model, start) for start in (model.start(), model.expected())), key=lambda one: one.cost)
    model, base = with_own_deviation(model, base)
    generator = np.random.default_rng(seed)
    before = screen(model, base, (), causes, generator)
    names = {cause.name for cause in causes}
    signs = tuple(one for one in pool(evidence.signs) if one.cause in names)
    examination = Examination((), model, base, base, (), before, before, None, signs)
    if before.chance < error_rate * _LINEAR_SHARE or _is_hopeless(model, base):
        examination = _explained(examination, causes, generator)
    found = [one for one in signs if one.chance < error_rate * (1 - _LINEAR_SHARE) / len(signs)]
    result = _with_signs(examination, found, error_rate)
    return replace(result, verdicts=tuple(calibrated(one) for one in result.verdicts))


def _explained(examination: Examination, causes: list[Cause], generator: np.random.Generator) -> Examination:
    """Name what the linear responses show: one cause, two, or unknown."""
    model, base, before = examination.model, examination.base, examination.before
    refined = refine(model, base, (), before, causes, every=True, hopeless=_is_hopeless(model, base))
    if not refined:
        return _unknown(examination, before.unknown_evidence)
    first = posterior(_with_own_signs(refined, examination.signs), before.unknown_evidence)
    best = first.best
    after = screen(model, best.fit, (best.extension,), causes, generator)
    left = _evidence_left(after)
    chosen: list[tuple[Posterior, Refined]] = [(first, best)]
    if after.chance < _CLOSURE_RATE:
        other = _other(examination, first, causes, generator)
        if other is not None:
            chosen, after, left = other
    total = sum(one.log_evidence for _, one in chosen) - _PAIR_PRICE * (len(chosen) - 1)
    if before.unknown_evidence > total or (after.chance < _CLOSURE_RATE and left > max(_LEFT, _LEFT_SHARE * total)):
        return _unknown(examination, before.unknown_evidence)
    extensions, extended = _bounded_in_depth(model, tuple(one.extension for _, one in chosen), chosen[-1][1].fit)
    result = replace(examination, extended=extended, extensions=extensions, after=after, posterior=first)
    verdicts = tuple(_linear_verdict(result, place, *one) for place, one in enumerate(chosen))
    kept = tuple(one for one in verdicts if one.gain_low > 0)
    if kept:
        return replace(result, verdicts=kept)
    if total < _WITHOUT_GAIN and all(one.gain <= 0 for one in verdicts):
        return examination
    return _unknown(examination, before.unknown_evidence, verdicts)


def _is_hopeless(model: SetModel, base: SetFit) -> bool:
    """Whether the base model is so far off that nothing linear about it can be trusted."""
    rows = 2 * int(np.count_nonzero(model.weight))
    return base.pulls > _HOPELESS_PULLS or base.chi2 > _HOPELESS_CHI2 * rows


def _with_own_signs(refined: list[Refined], signs: tuple[PooledSign, ...]) -> list[Refined]:
    """Causes that also have a sign of their own carry its evidence as well, for or against."""
    own = {one.cause: one for one in signs}
    return [
        replace(one, log_evidence=one.log_evidence + own[one.name].evidence_for(float(one.fit.point.sizes[-1])))
        if one.name in own
        else one
        for one in refined
    ]


def _bounded_in_depth(
    model: SetModel, extensions: tuple[Extension, ...], fit: SetFit
) -> tuple[tuple[Extension, ...], SetFit]:
    """The extensions with the windows in which each is present, where it begins or ends within the set."""
    for place in range(len(extensions)):
        rows = stretch(model, fit, extensions, place, _CLOSURE_RATE)
        if rows is not None:
            bounded = replace(extensions[place], windows=rows)
            extensions = (*extensions[:place], bounded, *extensions[place + 1 :])
            fit = fit_set(model, fit.point, extensions)
    return extensions, fit


def _evidence_left(after: Screen) -> float:
    """Log Bayes factor of all that may still be wrong, averaged over causes."""
    names = {one.cause.name for one in after.candidates}
    values = [*(after.of(name) for name in names), after.unknown_evidence]
    return max(float(logsumexp(values) - np.log(len(values))), 0.0)


def _other(
    examination: Examination, first: Posterior, causes: list[Cause], generator: np.random.Generator
) -> tuple[list[tuple[Posterior, Refined]], Screen, float] | None:
    """What explains more where the likeliest cause leaves too much: a likely rival that does not, or two causes."""
    model = examination.model
    best: tuple[float, list[tuple[Posterior, Refined]], Screen, float] | None = None
    firsts = [one for one in first.refined[:_FIRSTS] if one.log_evidence > first.best.log_evidence - _FIRST_WITHIN]
    for one in firsts:
        seen = screen(model, one.fit, (one.extension,), causes, generator)
        own = replace_best(first, one)
        if seen.chance >= _CLOSURE_RATE:
            option = (one.log_evidence, [(own, one)], seen, _evidence_left(seen))
        else:
            seconds = refine(model, one.fit, (one.extension,), seen, causes)
            if not seconds or seconds[0].log_evidence < _PAIR_PRICE:
                continue
            second = posterior(seconds, seen.unknown_evidence)
            after = screen(model, second.best.fit, (one.extension, second.best.extension), causes, generator)
            total = one.log_evidence + second.best.log_evidence - _PAIR_PRICE
            option = (total, [(own, one), (second, second.best)], after, _evidence_left(after))
        if best is None or option[0] > best[0]:
            best = option
    return None if best is None else best[1:]


def replace_best(found: Posterior, chosen: Refined) -> Posterior:
    """The posterior with another cause first, as one beside which a second was found."""
    rest = tuple(one for one in found.refined if one is not chosen)
    share = dict(found.share)
    share[found.best.name], share[chosen.name] = share[chosen.name], share[found.best.name]
    return Posterior((chosen, *rest), share)


def _linear_verdict(result: Examination, place: int, found: Posterior, one: Refined) -> Verdict:
    evidence = result.model.evidence
    size, error = float(result.extended.point.sizes[place]), float(result.extended.size_errors[place])
    limits, cause, rows = one.extension.cause.size, one.extension.cause, result.extensions[place].windows
    depth = evidence.conditions.hole_depth if rows is None else evidence.conditions.hole_depth[list(rows)]
    without = tuple(other for number, other in enumerate(result.extensions) if number != place)
    gain = _gain(result, place, without)
    surely = _surely(one.log_evidence)
    location = one.extension.shape * float(np.mean(result.model.length)) if cause.is_place else float("nan")
    return Verdict(
        verdict=class_name(found.members),
        family=cause.family,
        probability=found.mass * surely,
        from_m=float(depth.min()),
        to_m=float(depth.max()),
        cause=cause.name,
        size=size,
        size_low=max(size - 1.96 * error, limits.low),
        size_high=min(size + 1.96 * error, limits.high),
        unit=limits.unit,
        location_m=location,
        gain=gain.value,
        gain_low=gain.low,
        gain_high=gain.high,
        held_out_windows=gain.windows,
        what_would_separate=separator(found.members),
        evidence=f"linear responses, log Bayes factor {one.log_evidence:.1f}",
    )


def _gain(result: Examination, place: int, without: tuple[Extension, ...]) -> Gain:
    """What one extension adds to the others on held-out data."""
    point = result.extended.point
    lesser = replace(point, sizes=np.delete(point.sizes, place))
    start = result.base.point if not without else lesser
    return held_out_gain(result.model, (start, without), (point, result.extensions))


def _unknown(examination: Examination, log_evidence: float, unproved: tuple[Verdict, ...] = ()) -> Examination:
    """Something is wrong, and nothing in the catalogue explains it in a way that held-out data bear out."""
    port = max(examination.before.unknown, key=lambda name: examination.before.unknown[name])
    conditions = examination.model.evidence.conditions
    verdict = Verdict(
        verdict=UNKNOWN,
        family=port,
        probability=_surely(log_evidence),
        from_m=float(conditions.hole_depth.min()),
        to_m=float(conditions.hole_depth.max()),
        evidence=f"linear responses, chance {examination.before.chance:.2g} where nothing is wrong{_doubt(unproved)}",
        what_would_separate="the unknown disturbance acts as one " + _AT[port],
    )
    return replace(examination, verdicts=(verdict,))


def _doubt(unproved: tuple[Verdict, ...]) -> str:
    """Names that were in sight, in words."""
    names = ", ".join(one.verdict for one in unproved)
    return f"; {names} would fit, without a sure gain on held-out data" if names else ""


_AT = {
    "record": "in drive, sensors or recorder",
    "top": "at the top of the string",
    "upper string": "in the upper half of the string",
    "lower string": "in the lower half of the string",
    "bit": "at the bottom-hole assembly",
}


def _with_signs(examination: Examination, found: list[PooledSign], error_rate: float) -> Examination:
    """Verdicts from signs beside, or in place of, those from the linear responses."""
    linear = examination.verdicts
    told = {name for one in linear for name in one.members}
    chosen = [one for one in found if one.cause not in told and _may_be(one)]
    if any(one.cause == _STUCK for one in chosen):
        # a bit that sticks leaves every other sign of the rig as well
        chosen = [one for one in chosen if one.cause == _STUCK or CATALOGUE[one.cause].family == "sensor"]
    chosen = _plainest(chosen)
    regimes = [one for one in chosen if CATALOGUE[one.cause].regime]
    if linear and regimes:
        # a rig that changes or saturates within a window bends the linear responses too
        nothing_named = all(one.verdict == UNKNOWN for one in linear)
        if nothing_named or sum(one.log_evidence for one in regimes) > _evidence_left(examination.before):
            examination, linear = replace(examination, extended=examination.base, extensions=()), ()
    if linear:
        chosen = [one for one in chosen if one.chance < error_rate * _CLOSURE_RATE / len(examination.signs)]
    # beside a cause that is plain a faint sign is more likely its shadow than a second cause
    plain = max((one.log_evidence for one in chosen), default=0.0)
    chosen = [one for one in chosen if one.log_evidence >= _SHADOW * plain]
    shown = [_sign_verdict(examination, one, found) for one in chosen]
    named = [one for one in shown if one.gain_low > 0]
    if any(_bends(one.cause) for one in named) and all(one.verdict == UNKNOWN for one in linear):
        linear = ()
    verdicts = (*linear, *named)
    doubtful = [
        _nameless(one)
        for one, sign in zip(shown, chosen, strict=True)
        if one.gain > 0 or sign.log_evidence > _WITHOUT_GAIN
    ]
    return replace(examination, verdicts=verdicts or tuple(doubtful[:1]) or (_none(examination),))


def _bends(cause: str) -> bool:
    """Whether a cause that is told by its sign may be what linear responses show as unknown."""
    return CATALOGUE[cause].is_linear or cause == _ROUNDED


def _may_be(one: PooledSign) -> bool:
    """Whether a sign's size is one that it may have: a bit whose speed swings by less than its mean does not stand."""
    return one.cause != _STUCK or one.size + 1.96 * one.size_error >= 1.0


def _plainest(signs: list[PooledSign]) -> list[PooledSign]:
    """Of signs that look alike the plainest, most certain first."""
    chosen: list[PooledSign] = []
    for one in sorted(signs, key=lambda sign: -sign.log_evidence):
        if not any(_alike(one.cause, other.cause) for other in chosen):
            chosen.append(one)
    return chosen


def _nameless(one: Verdict) -> Verdict:
    """What is left of a name whose gain is not sure."""
    said = f"{one.evidence}{_doubt((one,))}"
    return Verdict(UNKNOWN, one.family, one.probability, one.from_m, one.to_m, evidence=said)


def _alike(one: str, other: str) -> bool:
    return other in CATALOGUE[one].looks_like or one in CATALOGUE[other].looks_like


def _sign_verdict(examination: Examination, one: PooledSign, found: list[PooledSign]) -> Verdict:
    cause, evidence = CATALOGUE[one.cause], examination.model.evidence
    rivals = (
        [one] if one.cause == _STUCK else [other for other in found if other is one or _alike(one.cause, other.cause)]
    )
    logs = np.array([other.log_evidence for other in rivals])
    shares = np.exp(logs - logsumexp(logs))
    members = [other.cause for other, share in zip(rivals, shares, strict=True) if share > 1 - 0.9]
    gain = sign_gain([sign for sign in evidence.signs if sign.cause == one.cause])
    return Verdict(
        verdict=class_name(members),
        family=cause.family,
        probability=_surely(one.log_evidence) * float(sum(share for share in shares if share > 1 - 0.9)),
        from_m=float(evidence.conditions.hole_depth.min()),
        to_m=float(evidence.conditions.hole_depth.max()),
        cause=one.cause,
        size=one.size,
        size_low=one.size - 1.96 * one.size_error,
        size_high=one.size + 1.96 * one.size_error,
        unit=cause.size.unit,
        gain=gain.value,
        gain_low=gain.low,
        gain_high=gain.high,
        held_out_windows=gain.windows,
        what_would_separate=separator(members),
        evidence=f"a sign of its own in the record, chance {one.chance:.2g} where it is absent",
    )


def _surely(log_evidence: float) -> float:
    """Posterior that a cause is there, of as many as the catalogue holds and even odds that there is one."""
    return float(expit(log_evidence - np.log(len(CATALOGUE))))


def _none(examination: Examination) -> Verdict:
    conditions, before = examination.model.evidence.conditions, examination.before
    names = {one.cause.name for one in before.candidates}
    logs = [*(before.of(name) for name in names), before.unknown_evidence]
    logs += [one.log_evidence for one in examination.signs]
    # even odds, before the data, that something is wrong
    odds = float(logsumexp(logs) - np.log(len(logs)))
    return Verdict(
        verdict=NONE,
        family="",
        probability=float(expit(-odds)),
        from_m=float(conditions.hole_depth.min()),
        to_m=float(conditions.hole_depth.max()),
        evidence=f"chance {before.chance:.2g} of so much misfit where nothing is wrong",
    )

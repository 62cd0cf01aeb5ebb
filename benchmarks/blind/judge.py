"""Judgement of an answer against the hidden causes of its case; nothing of the engine takes part in it."""

from collections.abc import Collection, Iterable
from dataclasses import asdict, dataclass, replace

import numpy as np

from benchmarks.blind.answer import Answer, Claim
from benchmarks.blind.draw import in_turn
from benchmarks.blind.hidden import Hidden
from benchmarks.blind.ideal.alike import INDISTINGUISHABLE, imitated, likely, same, stands_in
from benchmarks.blind.ideal.ideal import Ideal, threshold
from benchmarks.blind.ideal.of_case import ideal_of
from benchmarks.blind.vocabulary import CAUSES, CLOSURE_P_VALUE, DISTINCT, NONE, UNKNOWN
from benchmarks.blind.world import FOLDER, AnyCase, bit_stands, depths, place, present, world_of
from benchmarks.kept import as_json
from drillid.fleet.provenance import digest, source_hash

_CODE_OF_IDEALS = source_hash("benchmarks.blind.ideal.alike", "benchmarks.blind.ideal.of_case")
"""Modules that compute the ideal test; those of their package that they import are hashed with them."""
_PHYSICS = source_hash("drillid.physics.responses", "drillid.physics.nonlinear", "drillid.excitation.torques")
_REGIME = "stuck_slip_regimes"
_UNSIZED = (_REGIME,)
"""Causes whose size has another definition in the simulators than in the catalogue."""
_TOGETHER = frozenset({"actuator_gain", "controller_gain", "speed_scale"})
"""Each of these is exactly equivalent to the other two together: speed times g, gains over g and torque times g."""
_SURE = 0.9
"""Probability above which a name of a wrong family counts as confident."""


@dataclass(frozen=True)
class Ideals:
    """The ideal test on a case; NaN where it cannot be computed."""

    detectability: float
    """√λ of all hidden causes together."""
    power: float
    """Power of the test that knows the cause."""
    family_power: float
    """Power of the test over all candidates."""
    half_power: float
    """Least power over the hidden causes at half their size: of the test over all candidates, given the other of two
    causes; of the test unaware of the cause where it is removed from the catalogue."""
    candidates: float
    same: tuple[tuple[str, ...], ...]
    """For each hidden cause, those that cannot be distinguished from it."""
    imitated: bool = False
    """Whether other causes explain a cause that is removed from the catalogue."""


@dataclass(frozen=True)
class Judgement:
    """Judgement of an answer; None where a question does not arise."""

    seed: int
    windows: int
    hidden: str
    """Names of hidden causes joined by +; none without any."""
    removed: bool
    in_turn: bool
    """Whether the cause is that of the seed's turn, not a zone of local damping in its place."""
    linear: bool
    detectability: float
    power: float
    family_power: float
    large: bool
    """Whether it is at least twice the size at which the family's ideal test has 50 % power."""
    trace: float
    """√λ of the trace in the records of a cause beyond a threshold; NaN where none is hidden."""
    shows: bool
    """Whether it is large, or has no ideal test and no trace that is known to be too small to detect."""
    named: str
    detected: bool
    right: bool
    """Whether every hidden cause is named as itself or a class of causes that cannot be distinguished from it."""
    contains: bool
    """Whether every hidden cause is a member of a verdict."""
    family_right: bool
    claims: tuple[tuple[str, str, float, bool], ...]
    """For every verdict its kind, its family, its probability and whether it is true."""
    sure_of_wrong_family: bool
    still_there: bool
    """Whether the catalogue has a stand-in for a removed cause: one that cannot be distinguished from it, or two."""
    covered: bool | None
    location_error: float | None
    """Error of the location, as a share of the string's length."""
    gain_positive: bool | None
    second_none: bool | None
    """Whether the extended model passes the screen at its share of the error rate."""
    candidates: float
    """Number of effectively distinct candidates of the ideal test."""
    failure: str
    """Why the engine gave no verdict."""
    seconds: float
    """Processor time of the examination."""
    score: float
    """Evidence of an engine that leaves its threshold to the proof; -inf where it names the rig's nature alone."""


def kept_ideals(case: AnyCase, answers: Iterable[Answer]) -> Ideals:
    """The ideal test of a case as far as some answers ask for it, cached in a file named after a hash of its code, the
    case and the causes that they name.
    """
    named = {member for answer in answers for claim in answer.verdicts for member in claim.members} & {*CAUSES}
    path = FOLDER / "ideals" / f"{digest([_CODE_OF_IDEALS, _PHYSICS, str(case), sorted(named)])}.json"
    return Ideals(**as_json(path, lambda: asdict(ideals(case, named))))


def ideals(case: AnyCase, named: Collection[str] = CAUSES, *, thorough: bool = True) -> Ideals:
    """The ideal test of a case.

    Parameters
    ----------
    named : rivals that are asked for: every one alike, whoever names it; no judgement depends on the others
    thorough : whether each rival is fitted from all its shapes and sizes, beside those that linear theory shows to be
        near
    """
    ideal = ideal_of(case)
    if _REGIME in case.hidden_names and not bit_stands(case):
        # what remains is a torque that falls with speed
        ideal = ideal.taking_as_linear(_REGIME)
    noncentrality, tones = ideal.noncentrality(case.hidden), ideal.tones(case.hidden)
    halves = [
        ideal.noncentrality((replace(hidden, size=hidden.size / 2),), _others(case, hidden)) for hidden in case.hidden
    ]
    powers = [_half_power(ideal, hidden, half) for hidden, half in zip(case.hidden, halves, strict=True)]
    return Ideals(
        float(np.sqrt(noncentrality)),
        ideal.power(noncentrality, family=False, tones=tones),
        ideal.power(noncentrality, family=True, tones=tones),
        float(np.min(powers)) if powers else 0.0,
        ideal.candidates,
        tuple(tuple(sorted(_twins(ideal, hidden, _others(case, hidden), named, thorough))) for hidden in case.hidden),
        case.removed and any(_has_stand_in(ideal, hidden, _others(case, hidden), thorough) for hidden in case.hidden),
    )


def _twins(
    ideal: Ideal, hidden: Hidden, beside: tuple[Hidden, ...], named: Collection[str], thorough: bool
) -> frozenset[str]:
    """Causes that cannot be distinguished from a hidden one, of those that are named."""
    # of a cause that is removed from the catalogue any stand-in counts
    near = same(ideal, hidden, beside, CAUSES if ideal.case.removed else named)
    rest = {*named} - near
    further = likely(ideal, hidden, beside, rest) if thorough and rest else []
    return near | {name for name in further if stands_in(ideal, hidden, name, DISTINCT, beside)}


def _has_stand_in(ideal: Ideal, hidden: Hidden, beside: tuple[Hidden, ...], thorough: bool) -> bool:
    """Whether one rival or two explain what is removed from the catalogue."""
    if imitated(ideal, hidden):
        return True
    further = likely(ideal, hidden, beside) if thorough else []
    return any(stands_in(ideal, hidden, name, INDISTINGUISHABLE, beside) for name in further)


def _half_power(ideal: Ideal, hidden: Hidden, noncentrality: float) -> float:
    tones = ideal.tones((hidden,))
    if hidden.name == "sign_or_unit":
        # has a single size, far above any threshold
        return 1.0
    if ideal.case.removed and not tones:
        return ideal.power_unaware(noncentrality)
    return ideal.power(noncentrality, family=True, tones=tones)


def _others(case: AnyCase, hidden: Hidden) -> tuple[Hidden, ...]:
    return tuple(other for other in case.hidden if other is not hidden)


def judge(
    case: AnyCase, answer: Answer, ideal: Ideals, *, stands: bool = False, trace: float = float("nan")
) -> Judgement:
    """Judge an answer.

    Parameters
    ----------
    stands : whether the bit stands for some of the time, so that stick-slip is a right answer as well, and no linear
        test is valid; where it never does, torque that falls with speed is one for stick-slip
    """
    ideal = replace(ideal, same=tuple(_with_regime(names, stands=stands) for names in ideal.same))
    if stands:
        ideal = Ideals(np.nan, np.nan, np.nan, np.nan, ideal.candidates, ideal.same)
    # a size may have less effect than its half, such as a shift of the modes by a whole spacing
    large = bool(min(ideal.half_power, ideal.family_power) >= 0.5)
    # what is there by the rig's own nature is no alarm and no second cause
    beside = present(case) - case.hidden_names
    verdicts = [
        verdict
        for verdict in answer.verdicts
        if verdict.verdict != NONE and (set(verdict.members) & case.hidden_names or not set(verdict.members) & beside)
    ]
    if stands:
        # what makes it stand is named, and that it stands is no second cause
        others = [verdict for verdict in verdicts if verdict.members != (_REGIME,)]
        verdicts = others if any(_named(alike, others) for alike in ideal.same) else verdicts
    world, right = world_of(case), [_named(alike, verdicts) for alike in ideal.same]
    families = {CAUSES[cause.name].family for cause in case.hidden if cause.name in CAUSES}
    single = case.hidden[0] if len(case.hidden) == 1 and not case.removed else None
    true = next((verdict for verdict in verdicts if single and verdict.cause == single.name), None)
    return Judgement(
        seed=case.seed,
        windows=len(case.segments),
        hidden="+".join(cause.name for cause in case.hidden) or NONE,
        removed=case.removed,
        in_turn=not case.hidden or in_turn(case.seed, world) in case.hidden_names,
        linear=not stands and all(world.effects[cause.name].linear for cause in case.hidden),
        detectability=ideal.detectability,
        power=ideal.power,
        family_power=ideal.family_power,
        large=large,
        trace=trace,
        shows=large or bool(np.isnan(ideal.half_power) and not trace / 2 < threshold(ideal.candidates)),
        named="+".join(verdict.verdict for verdict in verdicts) or NONE,
        detected=bool(verdicts),
        right=_is_right(case, verdicts, right),
        contains=all(any(cause.name in verdict.members for verdict in verdicts) for cause in case.hidden),
        family_right={verdict.family for verdict in verdicts} == families,
        claims=tuple(
            (claim.kind, claim.family, claim.probability, is_true(case, claim, ideal.same)) for claim in answer.verdicts
        ),
        sure_of_wrong_family=any(
            verdict.verdict != UNKNOWN and verdict.family not in families and verdict.probability > _SURE
            for verdict in verdicts
        ),
        still_there=case.removed
        and (ideal.imitated or any(len(alike) > 1 for alike in ideal.same) or case.hidden_names <= _TOGETHER),
        covered=_covered(single, true),
        location_error=_location_error(case, single, true),
        gain_positive=None if true is None else bool(true.predictive_gain_low > 0),
        second_none=_second_none(answer, true),
        candidates=ideal.candidates,
        failure=answer.failure,
        seconds=answer.seconds,
        score=answer.score if verdicts or np.isnan(answer.score) else -np.inf,
    )


def _with_regime(same: tuple[str, ...], *, stands: bool) -> tuple[str, ...]:
    """Causes that cannot be distinguished, with what the bit's regime makes of them."""
    if stands:
        return (*same, _REGIME)
    return (*same, "stribeck_cutting") if _REGIME in same else same


def is_true(case: AnyCase, verdict: Claim, same: tuple[tuple[str, ...], ...]) -> bool:
    """Whether a verdict is true: one of its members is present, or nothing is wrong, or an unknown cause is present."""
    if verdict.verdict == NONE:
        return not case.hidden
    if set(verdict.members) & present(case):
        return True
    if verdict.verdict == UNKNOWN:
        return case.removed
    members = set(verdict.members)
    if case.removed and members | case.hidden_names <= _TOGETHER:
        return True
    return any(cause.name in members or members <= set(alike) for cause, alike in zip(case.hidden, same, strict=True))


def _is_right(case: AnyCase, verdicts: list[Claim], named: list[bool]) -> bool:
    if case.removed:
        return [verdict.verdict for verdict in verdicts] == [UNKNOWN]
    return all(named) and len(verdicts) == len(case.hidden)


def _named(same: tuple[str, ...], verdicts: list[Claim]) -> bool:
    """Whether a verdict names only the cause or causes that cannot be distinguished from it."""
    return any(verdict.members and set(verdict.members) <= set(same) for verdict in verdicts)


def _second_none(answer: Answer, verdict: Claim | None) -> bool | None:
    if verdict is None or np.isnan(answer.second_pass):
        return None
    return bool(answer.second_pass >= CLOSURE_P_VALUE)


def _covered(hidden: Hidden | None, verdict: Claim | None) -> bool | None:
    if hidden is None or verdict is None or hidden.name in _UNSIZED or not np.isfinite(verdict.size_low):
        return None
    return bool(verdict.size_low <= hidden.size <= verdict.size_high)


def _location_error(case: AnyCase, hidden: Hidden | None, verdict: Claim | None) -> float | None:
    if hidden is None or verdict is None or hidden.name != "local_damping_zone" or np.isnan(verdict.location_m):
        return None
    return float(abs(verdict.location_m - place(case, hidden)) / depths(case)[1][0])


def as_row(judgement: Judgement) -> dict[str, object]:
    """A judgement as a row of a table."""
    return asdict(judgement)

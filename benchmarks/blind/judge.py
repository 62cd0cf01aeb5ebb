"""Judgement of an answer against the hidden causes of its case."""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from benchmarks.blind.engines import ERROR_RATE, Answer
from benchmarks.blind.generator.cases import EFFECTS, FOLDER, Case, Hidden
from benchmarks.blind.generator.draw import in_turn
from benchmarks.blind.generator.effects_string import zone_middle
from benchmarks.blind.ideal.alike import INDISTINGUISHABLE, imitated, same, stands_in
from benchmarks.blind.ideal.ideal import Ideal, threshold
from drillid.discrepancy import CATALOGUE, Verdict
from drillid.discrepancy.rules import DISTINCT, RESPONSES_SHARE
from drillid.discrepancy.verdicts.verdict import NONE, UNKNOWN, kind
from drillid.fleet.provenance import digest, source_hash

_OF_IDEALS = (
    *("benchmarks.blind.ideal.alike", "benchmarks.blind.ideal.trace"),
    *("drillid.physics.responses", "drillid.physics.nonlinear", "drillid.excitation.torques"),
)
_CODE_OF_IDEALS = source_hash(*_OF_IDEALS)
"""Modules that compute the ideal test; those that they import are hashed with them."""
_UNSIZED = ("stuck_slip_regimes",)
"""Causes whose size has another definition in the simulator than in the catalogue."""
_TOGETHER = frozenset({"actuator_gain", "controller_gain", "speed_scale"})
"""Each of these is exactly equivalent to the other two together: speed times g, gains over g and torque times g."""


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
    claims: tuple[tuple[str, float, bool], ...]
    """For every verdict its kind, its probability and whether it is true."""
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


def kept_ideals(case: Case, named: frozenset[str] = frozenset()) -> Ideals:
    """The ideal test of a case, cached in a file named after a hash of its code and the case.

    Parameters
    ----------
    named : causes that an answer names, which are tested thoroughly against the hidden ones
    """
    kept = _kept([str(case)], lambda: asdict(ideals(case)))
    alike = tuple(
        (
            *same,
            *(name for name in sorted(named - {*same}) if _kept_stands_in(case, hidden, name, DISTINCT)),
        )
        for same, hidden in zip(kept["same"], case.hidden, strict=True)
    )
    if case.removed and not kept["imitated"]:
        kept["imitated"] = any(
            _kept_stands_in(case, hidden, name, INDISTINGUISHABLE)
            for same, hidden in zip(alike, case.hidden, strict=True)
            for name in sorted(named - {*same})
        )
    return Ideals(**{**kept, "same": alike})


def _kept_stands_in(case: Case, hidden: Hidden, name: str, near: float) -> bool:
    stands: bool = _kept(
        [str(case), str(hidden), name, f"{near:.6f}"],
        lambda: stands_in(Ideal(case), hidden, name, near, _others(case, hidden)),
    )
    return stands


def _kept(key: list[str], make: Callable[[], Any]) -> Any:
    path = FOLDER.parent / "ideals" / f"{digest([_CODE_OF_IDEALS, *key])}.json"
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(make()))
    return json.loads(path.read_text())


def ideals(case: Case) -> Ideals:
    """The ideal test of a case."""
    ideal = Ideal(case)
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
        tuple(tuple(sorted(same(ideal, hidden, _others(case, hidden)))) for hidden in case.hidden),
        case.removed and any(imitated(ideal, hidden) for hidden in case.hidden),
    )


def _half_power(ideal: Ideal, hidden: Hidden, noncentrality: float) -> float:
    tones = ideal.tones((hidden,))
    if hidden.name == "sign_or_unit":
        # has a single size, far above any threshold
        return 1.0
    if ideal.case.removed and not tones:
        return ideal.power_unaware(noncentrality)
    return ideal.power(noncentrality, family=True, tones=tones)


def _others(case: Case, hidden: Hidden) -> tuple[Hidden, ...]:
    return tuple(other for other in case.hidden if other is not hidden)


def judge(case: Case, answer: Answer, ideal: Ideals, *, stands: bool = False, trace: float = float("nan")) -> Judgement:
    """Judge an answer.

    Parameters
    ----------
    stands : whether the bit stands for some of the time, so that stick-slip is a right answer as well, and no linear
        test is valid
    """
    if stands:
        alike = tuple((*names, "stuck_slip_regimes") for names in ideal.same)
        ideal = Ideals(np.nan, np.nan, np.nan, np.nan, ideal.candidates, alike)
    # a size may have less effect than its half, such as a shift of the modes by a whole spacing
    large = bool(min(ideal.half_power, ideal.family_power) >= 0.5)
    verdicts = [verdict for verdict in answer.verdicts if verdict.verdict != NONE]
    right = [_named(alike, verdicts) for alike in ideal.same]
    families = {CATALOGUE[cause.name].family for cause in case.hidden}
    single = case.hidden[0] if len(case.hidden) == 1 and not case.removed else None
    true = next((verdict for verdict in verdicts if single and verdict.cause == single.name), None)
    return Judgement(
        seed=case.seed,
        windows=len(case.segments),
        hidden="+".join(cause.name for cause in case.hidden) or NONE,
        removed=case.removed,
        in_turn=not case.hidden or in_turn(case.seed) in case.hidden_names,
        linear=not stands and all(EFFECTS[cause.name].linear for cause in case.hidden),
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
            (kind(verdict), verdict.probability, is_true(case, verdict, ideal.same)) for verdict in answer.verdicts
        ),
        sure_of_wrong_family=any(
            verdict.verdict != UNKNOWN and verdict.family not in families and verdict.probability > 0.9
            for verdict in verdicts
        ),
        still_there=any(len(alike) > 1 for alike in ideal.same)
        or ideal.imitated
        or (case.removed and case.hidden_names <= _TOGETHER),
        covered=_covered(single, true),
        location_error=_location_error(case, single, true),
        gain_positive=None if true is None else bool(true.predictive_gain_low > 0),
        second_none=_second_none(answer, true),
        candidates=ideal.candidates,
        failure=answer.failure,
    )


def is_true(case: Case, verdict: Verdict, same: tuple[tuple[str, ...], ...]) -> bool:
    """Whether a verdict is true: one of its members is present, or nothing is wrong, or an unknown cause is present."""
    if verdict.verdict == NONE:
        return not case.hidden
    if verdict.verdict == UNKNOWN:
        return case.removed
    members = set(verdict.members)
    if case.removed and members | case.hidden_names <= _TOGETHER:
        return True
    return any(cause.name in members or members <= set(alike) for cause, alike in zip(case.hidden, same, strict=True))


def _is_right(case: Case, verdicts: list[Verdict], named: list[bool]) -> bool:
    if case.removed:
        return [verdict.verdict for verdict in verdicts] == [UNKNOWN]
    return all(named) and len(verdicts) == len(case.hidden)


def _named(same: tuple[str, ...], verdicts: list[Verdict]) -> bool:
    """Whether a verdict names only the cause or causes that cannot be distinguished from it."""
    return any(verdict.members and set(verdict.members) <= set(same) for verdict in verdicts)


def _second_none(answer: Answer, verdict: Verdict | None) -> bool | None:
    if verdict is None or np.isnan(answer.second_pass):
        return None
    return bool(answer.second_pass >= ERROR_RATE * RESPONSES_SHARE)


def _covered(hidden: Hidden | None, verdict: Verdict | None) -> bool | None:
    if hidden is None or verdict is None or hidden.name in _UNSIZED or not np.isfinite(verdict.size_low):
        return None
    return bool(verdict.size_low <= hidden.size <= verdict.size_high)


def _location_error(case: Case, hidden: Hidden | None, verdict: Verdict | None) -> float | None:
    if hidden is None or verdict is None or hidden.name != "local_damping_zone" or np.isnan(verdict.location_m):
        return None
    length = case.segments[0].pipe_length + float(case.equipment.collars.length)
    return abs(verdict.location_m - zone_middle(case.context(hidden))) / length


def as_row(judgement: Judgement) -> dict[str, object]:
    """A judgement as a row of a table."""
    return asdict(judgement)

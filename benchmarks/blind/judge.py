"""One case's answer held against what was hidden."""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from benchmarks.blind.engines import ERROR_RATE, Answer
from benchmarks.blind.generator.cases import EFFECTS, FOLDER, Case, Hidden
from benchmarks.blind.generator.draw import in_turn
from benchmarks.blind.generator.effects_string import zone_middle
from benchmarks.blind.ideal.alike import UNTOLD, imitated, same, stands_in
from benchmarks.blind.ideal.ideal import Ideal, threshold
from drillid.discrepancy import CATALOGUE, Verdict
from drillid.discrepancy.rules import DISTINCT, RESPONSES_SHARE
from drillid.discrepancy.verdicts.verdict import NONE, UNKNOWN, kind
from drillid.fleet.provenance import digest, source_hash

_OF_IDEALS = (
    *("benchmarks.blind.ideal.alike", "benchmarks.blind.ideal.trace"),
    *("drillid.physics.responses", "drillid.physics.nonlinear", "drillid.excitation.torques"),
)
"""Modules that compute what an ideal test would see; what they use counts with them."""
_UNSIZED = ("stuck_slip_regimes",)
"""Causes whose size the simulator is not given in the catalogue's terms."""
_TOGETHER = frozenset({"actuator_gain", "controller_gain", "speed_scale"})
"""Each of these is exactly the other two together: a record times g, the gains over g with the torque times g."""


@dataclass(frozen=True)
class Ideals:
    """The ideal test on a case; NaN where it cannot be computed."""

    detectability: float
    """√λ of all that is hidden."""
    power: float
    """Of the test that knows the cause."""
    family_power: float
    """Of the test over all candidates."""
    half_power: float
    """At half the size, the least over what is hidden: of the test over all candidates, of two causes beside the other;
    of the test that does not know the cause where it is taken out of the catalogue."""
    candidates: float
    same: tuple[tuple[str, ...], ...]
    """Causes that cannot be told from each of those hidden."""
    imitated: bool = False
    """Whether a test that does not know what is taken out of the catalogue cannot tell it from other causes."""


@dataclass(frozen=True)
class Judgement:
    """A case and its answer in figures; None where a question does not arise."""

    seed: int
    windows: int
    hidden: str
    """Names joined by +; none where nothing is hidden."""
    removed: bool
    in_turn: bool
    """Not turned to a zone of local damping for the sake of its place."""
    linear: bool
    detectability: float
    power: float
    family_power: float
    large: bool
    """At least twice the size at which the family's ideal test has 50 % power."""
    trace: float
    """√λ that a cause beyond a threshold leaves in the records; NaN where none is hidden."""
    shows: bool
    """Large, or what is hidden has no ideal test and leaves no trace that is known to be too small to be seen."""
    named: str
    detected: bool
    right: bool
    """Every hidden cause is named as itself or a class of causes the data cannot tell from it."""
    contains: bool
    """Every hidden cause is a member of a verdict."""
    family_right: bool
    claims: tuple[tuple[str, float, bool], ...]
    """Of every verdict, its kind, its probability and whether it is true."""
    sure_of_wrong_family: bool
    still_there: bool
    """Where it is taken out of the catalogue: what cannot be told from it is left in, one cause or two together."""
    covered: bool | None
    location_error: float | None
    """Share of the string's length."""
    gain_positive: bool | None
    second_none: bool | None
    """The extended model passes the screen at its share of the error rate."""
    candidates: float
    """Effectively distinct candidates of the ideal test."""
    failure: str
    """Why the engine gave no verdict."""


def kept_ideals(case: Case, named: frozenset[str] = frozenset()) -> Ideals:
    """The ideal test of a case, kept in a file named after the code that computes it and the case.

    Parameters
    ----------
    named : causes that an answer names, of which it is asked thoroughly whether they can be told from those hidden
    """
    kept = _kept([str(case)], lambda: asdict(ideals(case)))
    alike = tuple(
        (
            *same,
            *(name for name in sorted(named - {*same}) if _kept_stands_in(case, one, name, DISTINCT)),
        )
        for same, one in zip(kept["same"], case.hidden, strict=True)
    )
    if case.removed and not kept["imitated"]:
        kept["imitated"] = any(
            _kept_stands_in(case, one, name, UNTOLD)
            for same, one in zip(alike, case.hidden, strict=True)
            for name in sorted(named - {*same})
        )
    return Ideals(**{**kept, "same": alike})


def _kept_stands_in(case: Case, hidden: Hidden, name: str, near: float) -> bool:
    found: bool = _kept(
        [str(case), str(hidden), name, f"{near:.6f}"],
        lambda: stands_in(Ideal(case), hidden, name, near, _others(case, hidden)),
    )
    return found


@cache
def _code_of_ideals() -> str:
    """Hash of all that computes them, as it was when it was first asked for."""
    return source_hash(*_OF_IDEALS)


def _kept(told: list[str], make: Callable[[], Any]) -> Any:
    path = FOLDER.parent / "ideals" / f"{digest([_code_of_ideals(), *told])}.json"
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(make()))
    return json.loads(path.read_text())


def ideals(case: Case) -> Ideals:
    """The ideal test of a case."""
    ideal = Ideal(case)
    noncentrality, tones = ideal.noncentrality(case.hidden), ideal.tones(case.hidden)
    halves = [ideal.noncentrality((replace(one, size=one.size / 2),), _others(case, one)) for one in case.hidden]
    powers = [_half_power(ideal, one, half) for one, half in zip(case.hidden, halves, strict=True)]
    return Ideals(
        float(np.sqrt(noncentrality)),
        ideal.power(noncentrality, family=False, tones=tones),
        ideal.power(noncentrality, family=True, tones=tones),
        float(np.min(powers)) if powers else 0.0,
        ideal.candidates,
        tuple(tuple(sorted(same(ideal, one, _others(case, one)))) for one in case.hidden),
        case.removed and any(imitated(ideal, one) for one in case.hidden),
    )


def _half_power(ideal: Ideal, hidden: Hidden, noncentrality: float) -> float:
    tones = ideal.tones((hidden,))
    if hidden.name == "sign_or_unit":
        # has one size, and cannot be missed
        return 1.0
    if ideal.case.removed and not tones:
        return ideal.power_unaware(noncentrality)
    return ideal.power(noncentrality, family=True, tones=tones)


def _others(case: Case, hidden: Hidden) -> tuple[Hidden, ...]:
    return tuple(one for one in case.hidden if one is not hidden)


def judge(case: Case, answer: Answer, ideal: Ideals, *, stands: bool = False, trace: float = float("nan")) -> Judgement:
    """An answer's figures.

    Parameters
    ----------
    stands : whether the bit stands for some of the time, so that its regimes are there to be named too, and no linear
        test holds
    """
    if stands:
        alike = tuple((*one, "stuck_slip_regimes") for one in ideal.same)
        ideal = Ideals(np.nan, np.nan, np.nan, np.nan, ideal.candidates, alike)
    # a size may look less than its half, as a shift of the modes by a whole one does
    large = bool(min(ideal.half_power, ideal.family_power) >= 0.5)
    verdicts = [one for one in answer.verdicts if one.verdict != NONE]
    right = [_named(alike, verdicts) for alike in ideal.same]
    families = {CATALOGUE[one.name].family for one in case.hidden}
    single = case.hidden[0] if len(case.hidden) == 1 and not case.removed else None
    true = next((one for one in verdicts if single and one.cause == single.name), None)
    return Judgement(
        seed=case.seed,
        windows=len(case.stretches),
        hidden="+".join(one.name for one in case.hidden) or NONE,
        removed=case.removed,
        in_turn=not case.hidden or in_turn(case.seed) in case.answer,
        linear=not stands and all(EFFECTS[one.name].linear for one in case.hidden),
        detectability=ideal.detectability,
        power=ideal.power,
        family_power=ideal.family_power,
        large=large,
        trace=trace,
        shows=large or bool(np.isnan(ideal.half_power) and not trace / 2 < threshold(ideal.candidates)),
        named="+".join(one.verdict for one in verdicts) or NONE,
        detected=bool(verdicts),
        right=_is_right(case, verdicts, right),
        contains=all(any(one.name in verdict.members for verdict in verdicts) for one in case.hidden),
        family_right={one.family for one in verdicts} == families,
        claims=tuple((kind(one), one.probability, is_true(case, one, ideal.same)) for one in answer.verdicts),
        sure_of_wrong_family=any(
            one.verdict != UNKNOWN and one.family not in families and one.probability > 0.9 for one in verdicts
        ),
        still_there=any(len(alike) > 1 for alike in ideal.same)
        or ideal.imitated
        or (case.removed and case.answer <= _TOGETHER),
        covered=_covered(single, true),
        location_error=_location_error(case, single, true),
        gain_positive=None if true is None else bool(true.predictive_gain_low > 0),
        second_none=_second_none(answer, true),
        candidates=ideal.candidates,
        failure=answer.failure,
    )


def is_true(case: Case, verdict: Verdict, same: tuple[tuple[str, ...], ...]) -> bool:
    """Whether what a verdict says of itself is so: that one of its members is there, or nothing, or something else."""
    if verdict.verdict == NONE:
        return not case.hidden
    if verdict.verdict == UNKNOWN:
        return case.removed
    members = set(verdict.members)
    if case.removed and members | case.answer <= _TOGETHER:
        return True
    return any(one.name in members or members <= set(alike) for one, alike in zip(case.hidden, same, strict=True))


def _is_right(case: Case, verdicts: list[Verdict], named: list[bool]) -> bool:
    if case.removed:
        return [one.verdict for one in verdicts] == [UNKNOWN]
    return all(named) and len(verdicts) == len(case.hidden)


def _named(same: tuple[str, ...], verdicts: list[Verdict]) -> bool:
    """Whether a verdict names nothing but the cause or what cannot be told from it."""
    return any(one.members and set(one.members) <= set(same) for one in verdicts)


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
    length = case.stretches[0].pipe_length + float(case.equipment.collars.length)
    return abs(verdict.location_m - zone_middle(case.context(hidden))) / length


def as_row(judgement: Judgement) -> dict[str, object]:
    """For a table."""
    return asdict(judgement)

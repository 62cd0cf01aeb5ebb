"""The engines that are judged: the discovery engine, and one that answers at random for comparison."""

import time
from collections.abc import Callable
from dataclasses import asdict, replace

import numpy as np

from benchmarks.blind.answer import Answer, Claim
from benchmarks.blind.vocabulary import CAUSES, ERROR_RATE, NONE, UNKNOWN
from benchmarks.blind.world import FOLDER, AnyCase, depths, documents, records_of, records_path, weight
from benchmarks.kept import as_json, pickled
from drillid.config.settings import Settings
from drillid.discrepancy import CATALOGUE, Verdict
from drillid.discrepancy.catalogue import Cause
from drillid.discrepancy.evidence import Evidence, OperatingPoints
from drillid.discrepancy.gather import Series, gather
from drillid.discrepancy.verdicts.engine import examine
from drillid.errors import DrillidError
from drillid.fits.datasheet import DataSheet
from drillid.fleet.provenance import digest, source_hash
from drillid.physics.equipment import Controller

RATE = 50.0
"""Hz, of the logs."""
SETTINGS = Settings()
# computed at import, as an edit during a run does not change the running code
_GATHERING = source_hash("drillid.discrepancy.gather")
_ENGINE = digest([source_hash("drillid.discrepancy.verdicts.engine"), _GATHERING])


def data_sheet(case: AnyCase) -> DataSheet:
    """What the engine is told of the rig."""
    known = documents(case)
    if isinstance(known, DataSheet):
        return known
    stated = {name: value for name, value in vars(known).items() if name not in ("proportional", "integral", "wrong")}
    return DataSheet(Controller(known.proportional, known.integral), **stated)


def evidence_of(case: AnyCase) -> Evidence:
    """Input of the engine: logs of a case, operating points from the logs, and the data sheet."""
    records = records_of(case)
    windows = [Series(*channels) for channels in zip(records.sweep, records.speed, records.command, strict=True)]
    hole, bit = depths(case)
    operating_points = OperatingPoints(
        hole_depth=hole,
        bit_depth=bit,
        speed=records.speed.mean(axis=1),
        torque=records.command.mean(axis=1),
        weight_on_bit=np.full(hole.size, weight(case)),
    )
    return gather(windows, RATE, operating_points, data_sheet(case), SETTINGS)


def kept_evidence(case: AnyCase) -> Evidence:
    """Evidence about a case, cached in a file named after a hash of the code that gathers it."""
    key = [str(documents(case)), case.command_logged, records_path(case).name]
    path = FOLDER / "evidence" / f"{digest([_GATHERING, key, SETTINGS.model_dump()])}.pickle"
    return pickled(path, lambda: evidence_of(case))


def catalogue_of(case: AnyCase) -> list[Cause]:
    """The engine's catalogue, without what is removed from it."""
    return [cause for name, cause in CATALOGUE.items() if not (case.removed and name in case.hidden_names)]


def discovery(case: AnyCase) -> Answer:
    """The engine's answer, cached."""
    return kept_answer(case, _ENGINE, _examined)


def kept_answer(case: AnyCase, code: str, answer: Callable[[AnyCase], Answer]) -> Answer:
    """An answer, cached in a file named after a hash of the code that gives it and the case."""
    key = [str(documents(case)), case.removed, case.command_logged, records_path(case).name]
    path = FOLDER / "answers" / f"{digest([code, *key])}.json"
    kept = as_json(path, lambda: asdict(_timed(answer, case)))
    return Answer(tuple(Claim(**claim) for claim in kept.pop("verdicts")), **kept)


def _timed(answer: Callable[[AnyCase], Answer], case: AnyCase) -> Answer:
    """An answer with the processor time that it took, where it does not tell that itself."""
    begin = time.process_time()
    given = answer(case)
    return replace(given, seconds=time.process_time() - begin) if np.isnan(given.seconds) else given


def _examined(case: AnyCase) -> Answer:
    evidence = kept_evidence(case)
    begin = time.process_time()
    try:
        examination = examine(evidence, catalogue=catalogue_of(case), error_rate=ERROR_RATE, seed=case.seed)
    except DrillidError as error:
        return Answer((), failure=str(error))
    after = examination.after.p_value if examination.extensions else float("nan")
    claims = tuple(_claim(verdict) for verdict in examination.verdicts)
    return Answer(claims, after, seconds=time.process_time() - begin)


def _claim(verdict: Verdict) -> Claim:
    return Claim(
        verdict.verdict,
        verdict.probability,
        verdict.cause,
        verdict.size,
        verdict.size_low,
        verdict.size_high,
        verdict.location_m,
        verdict.predictive_gain_low,
    )


def at_random(case: AnyCase) -> Answer:
    """Answers `none` for half of the cases, and any cause or `unknown` for the others."""
    generator = np.random.default_rng([1, case.seed])
    name = NONE if generator.random() < 0.5 else str(generator.choice([*CAUSES, UNKNOWN]))
    probability = float(generator.random())
    low = float(generator.uniform(-1, 1))
    claim = Claim(name, probability, cause=name, size_low=low, size_high=low + 0.1)
    return Answer((claim,), score=float(generator.random()))

"""What is asked about each case: the discovery engine, and one that answers at random beside it."""

import json
import pickle
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.blind.generator.cases import FOLDER, SETTINGS, Case, evidence_of
from drillid.discrepancy import CATALOGUE, Verdict
from drillid.discrepancy.catalogue import Cause
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.verdicts.engine import examine
from drillid.errors import DrillidError
from drillid.fleet.provenance import digest, source_hash

ERROR_RATE = 0.05
# taken when the modules are loaded, as an edit during a run does not change what runs
_GATHERING = source_hash("drillid.discrepancy.gather")
_ENGINE = digest([source_hash("drillid.discrepancy.verdicts.engine"), _GATHERING])


@dataclass(frozen=True)
class Answer:
    """Verdicts about a case."""

    verdicts: tuple[Verdict, ...]
    second_pass: float
    """Chance of so much misfit in the extended model where it is right; NaN where nothing was extended."""
    failure: str = ""
    """Why the engine gave no verdict; empty where it did."""


def discovery(case: Case) -> Answer:
    """The engine's answer, kept in a file named after its code and the case."""
    told = [str(case.data_sheet), case.removed, case.command_logged, case.path.name]
    path = FOLDER.parent / "answers" / f"{digest([_ENGINE, *told])}.json"
    if path.is_file():
        return _read(path)
    catalogue = [cause for name, cause in CATALOGUE.items() if not (case.removed and name in case.answer)]
    answer = _asked(case, catalogue)
    _write(path, json.dumps(asdict(answer)).encode())
    return answer


def _asked(case: Case, catalogue: list[Cause]) -> Answer:
    try:
        found = examine(kept_evidence(case), catalogue=catalogue, error_rate=ERROR_RATE, seed=case.seed)
    except DrillidError as error:
        return Answer((), float("nan"), str(error))
    return Answer(found.verdicts, found.after.p_value if found.extensions else float("nan"))


def kept_evidence(case: Case) -> Evidence:
    """Evidence about a case, kept in a file named after the code that gathers it."""
    told = [str(case.data_sheet), case.command_logged, case.path.name]
    path = FOLDER.parent / "evidence" / f"{digest([_GATHERING, told, SETTINGS.model_dump()])}.pickle"
    if path.is_file():
        found: Evidence = pickle.loads(path.read_bytes())
        return found
    evidence = evidence_of(case)
    _write(path, pickle.dumps(evidence))
    return evidence


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_suffix(".part")
    unfinished.write_bytes(content)
    unfinished.replace(path)


def _read(path: Path) -> Answer:
    kept: dict[str, Any] = json.loads(path.read_text())
    verdicts = tuple(Verdict(**one) for one in kept.pop("verdicts"))
    return Answer(verdicts, **kept)


def at_random(case: Case) -> Answer:
    """Says `none` of half of the cases, and of the others any cause or `unknown`."""
    generator = np.random.default_rng([1, case.seed])
    depths = [stretch.hole_depth for stretch in case.stretches]
    name = "none" if generator.random() < 0.5 else str(generator.choice([*CATALOGUE, "unknown"]))
    family = CATALOGUE[name].family if name in CATALOGUE else ""
    probability = float(generator.random())
    low = float(generator.uniform(-1, 1))
    verdict = Verdict(
        name, family, probability, min(depths), max(depths), cause=name, size_low=low, size_high=low + 0.1
    )
    return Answer((verdict,), float("nan"))

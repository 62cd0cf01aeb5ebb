"""The engines that are judged: the discovery engine, and one that answers at random for comparison."""

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
# computed at import, as an edit during a run does not change the running code
_GATHERING = source_hash("drillid.discrepancy.gather")
_ENGINE = digest([source_hash("drillid.discrepancy.verdicts.engine"), _GATHERING])


@dataclass(frozen=True)
class Answer:
    """Verdicts about a case."""

    verdicts: tuple[Verdict, ...]
    second_pass: float
    """p-value of the extended model's misfit; NaN where the model was not extended."""
    failure: str = ""
    """Why the engine gave no verdict; empty where it did."""


def discovery(case: Case) -> Answer:
    """The engine's answer, cached in a file named after a hash of its code and the case."""
    key = [str(case.data_sheet), case.removed, case.command_logged, case.path.name]
    path = FOLDER.parent / "answers" / f"{digest([_ENGINE, *key])}.json"
    if path.is_file():
        return _read(path)
    catalogue = [cause for name, cause in CATALOGUE.items() if not (case.removed and name in case.hidden_names)]
    answer = _examined(case, catalogue)
    _write(path, json.dumps(asdict(answer)).encode())
    return answer


def _examined(case: Case, catalogue: list[Cause]) -> Answer:
    try:
        examination = examine(kept_evidence(case), catalogue=catalogue, error_rate=ERROR_RATE, seed=case.seed)
    except DrillidError as error:
        return Answer((), float("nan"), str(error))
    return Answer(examination.verdicts, examination.after.p_value if examination.extensions else float("nan"))


def kept_evidence(case: Case) -> Evidence:
    """Evidence about a case, cached in a file named after a hash of the code that gathers it."""
    key = [str(case.data_sheet), case.command_logged, case.path.name]
    path = FOLDER.parent / "evidence" / f"{digest([_GATHERING, key, SETTINGS.model_dump()])}.pickle"
    if path.is_file():
        cached: Evidence = pickle.loads(path.read_bytes())
        return cached
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
    verdicts = tuple(Verdict(**verdict) for verdict in kept.pop("verdicts"))
    return Answer(verdicts, **kept)


def at_random(case: Case) -> Answer:
    """Answers `none` for half of the cases, and any cause or `unknown` for the others."""
    generator = np.random.default_rng([1, case.seed])
    depths = [segment.hole_depth for segment in case.segments]
    name = "none" if generator.random() < 0.5 else str(generator.choice([*CATALOGUE, "unknown"]))
    family = CATALOGUE[name].family if name in CATALOGUE else ""
    probability = float(generator.random())
    low = float(generator.uniform(-1, 1))
    verdict = Verdict(
        name, family, probability, min(depths), max(depths), cause=name, size_low=low, size_high=low + 0.1
    )
    return Answer((verdict,), float("nan"))

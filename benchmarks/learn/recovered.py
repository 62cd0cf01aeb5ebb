"""What is learnt of hidden effects: offers, what they recover on windows that nobody has seen, and fingerprints.

Two wells of each rig hide the same effect in the same size. Of six windows the first four are for learning and for its
offer; the last two, which take no part in any choice, measure what an offer is worth.
Seeds of the proof begin at FIRST; `python -m benchmarks.learn.recovered RIG EFFECT WELL` does one case of any rig.
"""

import json
from dataclasses import replace
from itertools import combinations
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.kept import write
from benchmarks.learn.cases import Case, evidence_of, well, with_hidden
from benchmarks.learn.effects import HIDEABLE
from benchmarks.learn.measurement import FOLDER, share
from benchmarks.parts import Measurement
from benchmarks.result import Result
from drillid.discrepancy.inference.held_out_gain import gain_on
from drillid.discrepancy.inference.set_fit import fit_base, fit_set
from drillid.discrepancy.inference.set_model import Point
from drillid.discrepancy.learning.fingerprint import SAME, Fingerprint
from drillid.discrepancy.learning.offer import learnt_extension
from drillid.discrepancy.predictive_gain import PredictiveGain
from drillid.fleet.provenance import digest, source_hash

FIRST = 90_000
"""Least seed of the proof; a case's seed is its rig's number times 100 and the well's."""
RIGS = (900, 901)
LEARNING = 4
"""Windows that learning has."""
_WELLS = (0, 1)
_CODE = source_hash("drillid.discrepancy.learning.offer", "benchmarks.learn.cases", "benchmarks.learn.effects")


def case_of(rig: int, name: str, number: int) -> Case:
    """One well; its effect has the size that is told in the first well of the rig."""
    first = with_hidden(well(rig, 0), name)
    return first if number == 0 else replace(well(rig, number), hidden=first.hidden)


def outcome(case: Case) -> dict[str, Any]:
    """What is learnt of a case, kept in a file."""
    path = FOLDER / "outcomes" / f"{digest([_CODE, str(case)])}.json"
    if path.is_file():
        kept: dict[str, Any] = json.loads(path.read_text())
        return kept
    found = _outcome(case)
    write(path, json.dumps(found).encode())
    return found


def _outcome(case: Case) -> dict[str, Any]:
    evidence, (hidden,) = evidence_of(case), case.hidden
    found: dict[str, Any] = {"seed": case.seed, "effect": hidden.name, "size": hidden.size, "shape": hidden.shape}
    learning, base = fit_base(evidence.subset(np.arange(LEARNING)))
    learnt = learnt_extension(learning, base)
    model, whole = fit_base(evidence)
    unseen = np.zeros(evidence.used.shape, dtype=bool)
    unseen[LEARNING:] = True
    start = whole.point
    truths = []
    for extensions in HIDEABLE[hidden.name].extensions(hidden.shape):
        point = Point(start.shared, start.local, np.full(len(extensions), hidden.size))
        truths.append((fit_set(model, point, extensions), extensions))
    true_fit, truth = min(truths, key=lambda pair: pair[0].cost)
    found["true_gain"] = gain_on(model, unseen, (start, ()), (true_fit.point, truth)).value
    if learnt is None:
        return found | {"offered": False, "elements": [], "gain": 0.0, "resembles": "", "fingerprint": None}
    point = Point(start.shared, start.local, learnt.fit.point.sizes)
    gain: PredictiveGain = gain_on(model, unseen, (start, ()), (point, learnt.extensions))
    return found | {
        "offered": learnt.offered,
        "elements": [f"{name} at {place:.2f}" for name, place in learnt.elements],
        "gain": gain.value,
        "resembles": learnt.fingerprint.resembles,
        "fingerprint": learnt.fingerprint.content(),
    }


def measure(console: Console) -> Measurement:
    """All cases of the proof."""
    seeds = [(rig, name, number) for rig in RIGS for name in HIDEABLE for number in _WELLS]
    outcomes = [outcome(case_of(*seed)) for seed in track(seeds, "cases", console=console)]
    console.print(_table(outcomes))
    offered = [each for each in outcomes if each["offered"]]
    recovered = sum(each["gain"] for each in offered) / max(sum(each["true_gain"] for each in offered), 1e-9)
    same, different = _pairs(offered)
    results = [
        *share("offered_share", "extensions offered", len(offered), len(outcomes), least=0.8),
        Result("held_out_recovered", "misfit of unseen windows recovered, of the true model's", recovered, 0.7, np.inf),
        *share("worse_share", "offers worse on unseen windows", _count(offered), len(offered), most=0.02),
        *share("fingerprint_matched", "same effect in two wells told the same", sum(same), len(same), least=0.9),
        *share("fingerprint_confused", "different effects told the same", sum(different), len(different), most=0.05),
    ]
    details = [{name: value for name, value in each.items() if name != "fingerprint"} for each in outcomes]
    return Measurement(results, {"recovered_cases": details})


def _count(offered: list[dict[str, Any]]) -> int:
    return sum(each["gain"] < 0 for each in offered)


def _pairs(offered: list[dict[str, Any]]) -> tuple[list[bool], list[bool]]:
    """Whether pairs of wells are told to have the same, with the same effect and with different ones."""
    same, different = [], []
    for first, second in combinations(offered, 2):
        if first["seed"] // 100 != second["seed"] // 100:
            continue
        likeness = Fingerprint.of(first["fingerprint"]).likeness(Fingerprint.of(second["fingerprint"]))
        (same if first["effect"] == second["effect"] else different).append(likeness >= SAME)
    return same, different


def _table(outcomes: list[dict[str, Any]]) -> Table:
    table = Table("seed", "hidden", "size", "learnt", "offered", "gain", "true model's", "resembles")
    for each in outcomes:
        gains = f"{each['gain']:.1f}", f"{each['true_gain']:.1f}"
        learnt, offered = ", ".join(each["elements"]), "yes" if each["offered"] else "no"
        table.add_row(
            str(each["seed"]), each["effect"], f"{each['size']:.3g}", learnt, offered, *gains, each["resembles"]
        )
    return table


def main(rig: int, name: str, number: Annotated[int, typer.Argument()] = 0) -> None:
    """One case."""
    Console().print(_table([outcome(case_of(rig, name, number))]))


if __name__ == "__main__":
    typer.run(main)

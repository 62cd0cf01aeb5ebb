"""What is learnt of hidden effects: offers, what they recover on windows that nobody has seen, and fingerprints.

Two wells of each rig hide the same effect in the same size, twice the one at which the ideal test begins to see it in
either, or its largest. Shares count the wells in which it is twice as large, but worse offers are counted in all wells.
Of twelve windows learning, its offer and the ideal test have the first four; the others, which take no part in any
choice, measure what an offer is worth. `python -m benchmarks.learn.recovered RIG EFFECT` does the wells of any rig.
"""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import typer
from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.blind.hidden import Hidden
from benchmarks.kept import as_json
from benchmarks.learn.cases import LEARNING, Case, evidence_of, seen, well
from benchmarks.learn.effects import HIDEABLE
from benchmarks.learn.measurement import FOLDER, pairs, share
from benchmarks.parts import Measurement
from benchmarks.result import Result
from drillid.discrepancy.inference.base_fit import fit_base
from drillid.discrepancy.inference.coordinates import Point
from drillid.discrepancy.inference.held_out_gain import gain_on
from drillid.discrepancy.inference.set_fit import fit_set
from drillid.discrepancy.learning.offer import learnt_extension
from drillid.discrepancy.predictive_gain import PredictiveGain
from drillid.fleet.provenance import digest, source_hash

RIGS = (902, 903, 904, 905, 906)
"""Of the proof; a case's seed is its rig's number times 100 and the well's."""
PROCESSES = 2
_WELLS = (0, 1)
_TIMES = 2.0
_CODE = source_hash("drillid.discrepancy.learning.offer", "benchmarks.learn.cases", "benchmarks.learn.effects")


def cases_of(rig: int, name: str) -> list[tuple[Case, bool]]:
    """The wells of a rig with an effect, and whether it is twice as large there as where it begins to be seen."""
    wells = [well(rig, number) for number in _WELLS]
    found = [seen(each, name) for each in wells]
    largest = min(each.largest for each in found)
    size = min(_TIMES * max(each.size for each in found), largest)
    hidden = (Hidden(name, size, found[0].shape),)
    return [
        (replace(each, hidden=hidden), bool(size >= _TIMES * own.size)) for each, own in zip(wells, found, strict=True)
    ]


def outcomes_of(seed: tuple[int, str]) -> list[dict[str, Any]]:
    """What is learnt in the wells of a rig."""
    return [outcome(case) | {"twice": is_twice} for case, is_twice in cases_of(*seed)]


def outcome(case: Case) -> dict[str, Any]:
    """What is learnt of a case, kept in a file."""
    path = FOLDER / "outcomes" / f"{digest([_CODE, str(case)])}.json"
    found: dict[str, Any] = as_json(path, lambda: _outcome(case))
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
    seeds = [(rig, name) for rig in RIGS for name in HIDEABLE]
    with ProcessPoolExecutor(PROCESSES) as pool:
        done = track(pool.map(outcomes_of, seeds), "effects", len(seeds), console=console)
        every = [each for wells in done for each in wells]
    console.print(_table(every))
    outcomes = [each for each in every if each["twice"]]
    offered = [each for each in outcomes if each["offered"]]
    recovered = sum(each["gain"] for each in offered) / max(sum(each["true_gain"] for each in offered), 1e-9)
    same, different = pairs([(each["seed"], each["effect"], each["fingerprint"]) for each in offered])
    gains = [each["gain"] for each in every if each["offered"]]
    worse, offers = sum(gain < 0 for gain in gains), len(gains)
    results = [
        *share("offered_share", "extensions offered", len(offered), len(outcomes), least=0.8),
        Result("held_out_recovered", "misfit of unseen windows recovered, of the true model's", recovered, 0.7, np.inf),
        *share("worse_share", "offers worse on unseen windows", worse, offers, most=0.02),
        *share("fingerprint_matched", "same effect in two wells told the same", sum(same), len(same), least=0.9),
        *share("fingerprint_confused", "different effects told the same", sum(different), len(different), most=0.05),
    ]
    details = [{name: value for name, value in each.items() if name != "fingerprint"} for each in every]
    return Measurement(results, {"recovered_cases": details})


def _table(outcomes: list[dict[str, Any]]) -> Table:
    headings = ("seed", "hidden", "size", "twice", "learnt", "offered", "gain", "true model's")
    table = Table(*headings, title="Gains in nats a window, of windows that nobody has seen")
    for each in outcomes:
        gains = f"{each['gain']:.1f}", f"{each['true_gain']:.1f}"
        is_twice, offered = ("yes" if each[name] else "no" for name in ("twice", "offered"))
        learnt = ", ".join(each["elements"])
        table.add_row(str(each["seed"]), each["effect"], f"{each['size']:.3g}", is_twice, learnt, offered, *gains)
    return table


def main(rig: int, name: str) -> None:
    """The wells of one rig with an effect."""
    Console().print(_table(outcomes_of((rig, name))))


if __name__ == "__main__":
    typer.run(main)

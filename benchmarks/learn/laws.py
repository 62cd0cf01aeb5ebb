"""Laws that are learnt of hidden effects that are not linear: offers, what they recover on windows that nobody has
seen, and fingerprints.

As in `benchmarks.learn.recovered` two wells of each rig hide the same effect in the same size: the least at which √λ of
the ideal test is twice that at which it begins to see something, in either well, or that with the largest; learning has
the first windows of twelve. The ideal test knows the law, and nothing of the rig beyond what it fits. A well in which
nothing is hidden comes with each rig.

`python -m benchmarks.learn.laws RIG EFFECT` does the wells of any rig.
"""

from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.progress import track
from rich.table import Table
from scipy.optimize import minimize_scalar

from benchmarks.blind.engines import evidence_of
from benchmarks.blind.generator.cases import RATE, Records, simulate_case
from benchmarks.blind.hidden import Hidden
from benchmarks.blind.vocabulary import ERROR_RATE
from benchmarks.kept import as_json
from benchmarks.learn.cases import LEARNING, SEEN, Case, well
from benchmarks.learn.law_effects import LAWS, LawEffect
from benchmarks.learn.measurement import FOLDER, pairs, share
from benchmarks.parts import Measurement
from benchmarks.result import Result
from drillid.arrays import Complex, Floats
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.inference.base_fit import fit_base
from drillid.discrepancy.inference.coordinates import Extension, Point
from drillid.discrepancy.inference.held_out_gain import gain_on
from drillid.discrepancy.inference.rows import real_rows
from drillid.discrepancy.inference.set_fit import SetFit, fit_set
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.learning.examined_law import law_window, with_linear_or_law
from drillid.discrepancy.learning.law import added
from drillid.discrepancy.learning.law_window import LawWindow
from drillid.discrepancy.products.extended_model import less_tangent
from drillid.discrepancy.verdicts.engine import examine
from drillid.discrepancy.verdicts.examination import Examination
from drillid.errors import SettingsError
from drillid.fleet.provenance import digest, source_hash
from drillid.physics.dual_numbers import Dual

RIGS = tuple(range(940, 950))
"""Of the proof; a case's seed is its rig's number times 100 and the well's. Others are for development."""
PROCESSES = 2
_WELLS = (0, 1)
_TIMES, _SIZES = 2.0, 25
_STRONG, _QUIET = 3.0, 0.1
"""Amplitude of the sweep and noise of the bit over those of the other proofs: a law shows by the swing that the sweep
makes, which is of 1.5 kN m here; a bit of usual noise hides the drag from every test.
"""
_POINTS = 201
_CODE = source_hash("drillid.discrepancy.learning.examined_law", "benchmarks.learn.cases", "benchmarks.learn.laws")


@dataclass(frozen=True)
class Outcome:
    """What is learnt in a well."""

    seed: int
    effect: str
    """Empty where nothing is hidden."""
    size: float
    twice: bool
    """Whether √λ of the ideal test is twice that at which it begins to see something."""
    verdicts: tuple[str, ...]
    offered: str
    """What it resembles; empty where nothing is offered."""
    gain: float
    """Nats per unseen window, of what is offered."""
    true_gain: float
    """The same of the true law."""
    fingerprint: Any


def slopes_of(model: SetModel, fit: SetFit, window: LawWindow) -> Floats:
    """Whitened changes (14, 2 lines) of a window's harmonics by the base model's quantities, in real rows."""
    s, model_at = window.s, model.quantities(fit.point)[:, window.row : window.row + 1]
    units = model.units[:, window.row : window.row + 1]
    duals = [
        Dual(value, unit[None], np.array([place]), len(model_at))
        for place, (value, unit) in enumerate(zip(model_at, units, strict=True))
    ]
    mobility = model.window_model(duals).mobility(s)
    return real_rows(mobility.full_tangents()[:, 0] * window.sweep / window.error)


def detectability(name: str, plain: list[tuple[LawWindow, Floats]], size: float) -> float:
    """√λ of the test that knows the law and its shape, in all windows, whatever the rig's own parameters are.

    Parameters
    ----------
    plain : windows without the effect, with the directions of their base model
    """
    own, total = LAWS[name], 0.0
    for window, slopes in plain:
        window = own.with_tangent(window, size)
        place, value = _about_mean(own, window, size)
        change = real_rows(own.kind.added(window, place, value) / window.error)
        rest = change - slopes.T @ np.linalg.lstsq(slopes.T, change)[0]
        total += float(rest @ rest)
    return float(np.sqrt(total))


def _about_mean(own: LawEffect, window: LawWindow, size: float) -> tuple[Floats, Floats]:
    """The law over the range of the window's swing, less its tangent at the mean."""
    mean, reach = own.kind.mean(window), float(np.abs(own.kind.swing(window)).max())
    place = np.linspace(mean - reach, mean + reach, _POINTS)
    return place, less_tangent(place, size * own.law(place), mean)


def windows_of(examination: Examination, records: Records, rows: Iterable[int]) -> list[LawWindow]:
    """Windows of a set by its extended model, as learning has them."""
    found = [law_window(examination, row, lambda row: (records.sweep[row], records.speed[row]), RATE) for row in rows]
    return [window for window in found if window is not None]


def _plain(case: Case) -> list[tuple[LawWindow, Floats]]:
    """Windows that learning has, and how their base model changes them."""
    examination = examine(_learning(case), error_rate=ERROR_RATE)
    # nothing is hidden in it, whatever it was named
    plain = replace(examination, extended=examination.base, extensions=())
    windows = windows_of(plain, simulate_case(case), range(LEARNING))
    return [(window, slopes_of(plain.model, plain.base, window)) for window in windows]


def _learning(case: Case) -> Evidence:
    return evidence_of(case).subset(np.arange(LEARNING))


def cases_of(rig: int, name: str) -> list[tuple[Case, bool]]:
    """The wells of a rig with an effect, or one without any, and whether √λ is twice that at which it is seen."""
    if not name:
        return [(_well(rig, _WELLS[-1] + 1), False)]
    wells = [_well(rig, number) for number in _WELLS]
    plain = [_plain(each) for each in wells]
    first = wells[0]
    sizes = np.geomspace(*LAWS[name].effect.range(first.world(0), first.context(Hidden(name, 0.0, 0.0))), _SIZES)
    roots = np.array([min(detectability(name, windows, size) for windows in plain) for size in sizes])
    large = np.flatnonzero(roots >= _TIMES * SEEN)
    size = float(sizes[large[0] if large.size else np.argmax(roots)])
    return [(replace(each, hidden=(Hidden(name, size, 0.0),)), bool(large.size)) for each in wells]


def _well(rig: int, number: int) -> Case:
    """A well of a rig that sweeps as strongly as rigs do, with a quiet bit."""
    case = well(rig, number)
    equipment = replace(case.equipment, sweep_amplitude=_STRONG * case.equipment.sweep_amplitude)
    segments = tuple(replace(segment, bit_noise=_QUIET * segment.bit_noise) for segment in case.segments)
    return replace(case, equipment=equipment, segments=segments)


def outcomes_of(task: tuple[int, str]) -> list[Outcome]:
    """What is learnt in the wells of a rig, kept in files."""
    return [outcome(task[1], *each) for each in cases_of(*task)]


def outcome(name: str, case: Case, twice: bool) -> Outcome:
    """What is learnt in a well."""
    path = FOLDER / "laws" / f"{digest([_CODE, str(case), case.path.name])}.json"
    return Outcome(**as_json(path, lambda: asdict(_outcome(name, case, twice))))


def _outcome(name: str, case: Case, twice: bool) -> Outcome:
    records, evidence = simulate_case(case), evidence_of(case)

    def channels(row: int) -> tuple[Floats, Floats]:
        return records.sweep[row], records.speed[row]

    learning = evidence.subset(np.arange(LEARNING))
    told = with_linear_or_law(examine(learning, error_rate=ERROR_RATE), channels, RATE, ERROR_RATE)
    size = case.hidden[0].size if case.hidden else 0.0
    verdicts = tuple(verdict.verdict for verdict in told.verdicts)
    named = told.extensions if told.law is not None or told.fingerprint is None else ()
    model, base = fit_base(evidence)
    unseen = _of_all_windows(told, model, base, named)
    windows = windows_of(unseen, records, range(LEARNING, evidence.windows))
    try:
        true_gain = _true_gain(LAWS[name], size, windows) if name else 0.0
    except SettingsError:
        # what was named has no simulation in time, such as a very stiff spring
        without = _of_all_windows(told, model, base, ())
        true_gain = _true_gain(LAWS[name], size, windows_of(without, records, range(LEARNING, evidence.windows)))
    if told.fingerprint is None:
        return Outcome(case.seed, name, size, twice, verdicts, "", 0.0, true_gain, None)
    if told.law is not None:
        gain = _gain([(window, added(told.law.kind, window, told.law.spline)) for window in windows])
    else:
        held = np.zeros(evidence.used.shape, dtype=bool)
        held[LEARNING:] = True
        start = base.point
        point = Point(start.shared, start.local, told.extended.point.sizes)
        gain = gain_on(model, held, (start, ()), (point, told.extensions)).value
    fingerprint = told.fingerprint
    return Outcome(
        case.seed, name, size, twice, verdicts, fingerprint.resembles, gain, true_gain, fingerprint.content()
    )


def _of_all_windows(told: Examination, model: SetModel, base: SetFit, named: tuple[Extension, ...]) -> Examination:
    """The model of a set with what was named in its first windows, fitted to all windows."""
    if not named:
        return replace(told, model=model, extended=base, extensions=())
    start = Point(base.point.shared, base.point.local, told.extended.point.sizes, told.extended.point.shapes)
    return replace(told, model=model, extended=fit_set(model, start, named), extensions=named)


def _gain(changes: Sequence[tuple[LawWindow, Complex]]) -> float:
    """Nats per window that changes of the harmonics gain."""
    gains = [
        0.5 * float(np.sum(np.abs(window.residual) ** 2 - np.abs(window.residual - change) ** 2))
        for window, change in changes
    ]
    return sum(gains) / len(gains)


def _true_gain(own: LawEffect, size: float, windows: Sequence[LawWindow]) -> float:
    """Gain of the true law, with the slope at the mean that the windows themselves ask for where laws have one."""

    def loss(slope: float) -> float:
        changes = []
        for window in windows:
            place, value = _about_mean(own, window, size)
            value = value + slope * own.kind.scale(window) * (place - own.kind.mean(window))
            changes.append((window, np.asarray(own.kind.added(window, place, value) / window.error, dtype=complex)))
        return -_gain(changes)

    if not own.kind.has_slope:
        return -loss(0.0)
    return -float(minimize_scalar(loss, (-0.5, 0.0), options={"maxiter": 8}).fun)


def measure(console: Console) -> Measurement:
    """All cases of the proof."""
    tasks = [(rig, name) for rig in RIGS for name in (*LAWS, "")]
    with ProcessPoolExecutor(PROCESSES) as pool:
        done = track(pool.map(outcomes_of, tasks), "laws", len(tasks), console=console)
        every = [each for wells in done for each in wells]
    console.print(_table(every))
    large = [each for each in every if each.twice]
    offered = [each for each in large if each.offered]
    recovered = sum(each.gain for each in offered) / max(sum(each.true_gain for each in offered), 1e-9)
    worse = [each.gain < 0 for each in every if each.offered]
    plain = [bool(each.offered) for each in every if not each.effect]
    same, different = pairs([(each.seed, each.effect, each.fingerprint) for each in offered])
    results = [
        *share("law_offered_share", "laws offered", len(offered), len(large), least=0.8),
        Result("law_recovered", "misfit of unseen windows recovered, of the true law's", recovered, 0.7, np.inf),
        *share("law_worse_share", "offers worse on unseen windows", sum(worse), len(worse), most=0.02),
        *share("law_false_share", "offers where nothing is hidden", sum(plain), len(plain), most=0.05),
        *share("law_matched", "same law in two wells told the same", sum(same), len(same), least=0.9),
        *share("law_confused", "different laws told the same", sum(different), len(different), most=0.05),
    ]
    details = [{name: value for name, value in asdict(each).items() if name != "fingerprint"} for each in every]
    return Measurement(results, {"law_cases": details})


def _table(outcomes: list[Outcome]) -> Table:
    headings = ("seed", "hidden", "size", "twice", "verdicts", "offered", "gain", "true law's")
    table = Table(*headings, title="Gains in nats a window, of windows that nobody has seen")
    for each in outcomes:
        gains = f"{each.gain:.1f}", f"{each.true_gain:.1f}"
        twice = "yes" if each.twice else "no"
        verdicts = ", ".join(each.verdicts)
        table.add_row(str(each.seed), each.effect, f"{each.size:.3g}", twice, verdicts, each.offered, *gains)
    return table


def main(rig: int, name: Annotated[str, typer.Argument()] = "") -> None:
    """The wells of one rig with an effect, or one without."""
    Console(width=200).print(_table(outcomes_of((rig, name))))


if __name__ == "__main__":
    typer.run(main)

"""Fleets with a cause that no single well shows, and without any: power beside the ideal test, false alarms, gain."""

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd
from rich.console import Console
from rich.progress import track

from benchmarks.blind.engines import evidence_of
from benchmarks.blind.generator.cases import Case
from benchmarks.blind.ideal.ideal import threshold
from benchmarks.blind.vocabulary import ERROR_RATE
from benchmarks.kept import pickled
from benchmarks.learn.fleet_cases import Fleet, plain_fleet, power, sized
from benchmarks.learn.measurement import FOLDER, share
from benchmarks.parts import Measurement
from benchmarks.result import Result
from drillid.common_causes.pooling import SetStatistics, Wells, together
from drillid.common_causes.verdicts import Judged, candidates_of, judge
from drillid.discrepancy.base_rates import BaseRates
from drillid.discrepancy.inference.shared_likelihood import SharedLikelihood, shared_candidates, shared_likelihood
from drillid.discrepancy.verdicts.engine import examine
from drillid.discrepancy.verdicts.verdict import NONE
from drillid.fleet.manifest import write_whole
from drillid.fleet.provenance import digest, source_hash
from drillid.statistics import TWO_SIDED

FIRST = 170_000
"""First seed of the proof; lower ones are for development."""
SIZES = (3, 6, 12)
"""Wells of a fleet, in turn; a well takes about a second."""
NULLS = 60
"""Fleets without any cause."""
CAUSES = (
    *("drive_lag", "actuator_gain", "delay_jitter", "controller_gain", "speed_filter", "torque_filter"),
    *("speed_scale", "clock_offset", "recorder_filter"),
)
"""Causes that wells of a rig may share and that linear responses show; each in fleets of all sizes."""
ROUNDS = 2
DISTINCT = 8
"""Of these, those that a response can tell apart: filters on speed and on torque are one."""
ALONE = 2.5
"""√λ that no single well exceeds: the ideal test for one of them finds it in half of all wells at best."""
DETECTABILITY = (2.5, 10.0)
"""Range of √λ over the fleet, log-uniform, as far as no single well shows it."""
GAIN_CAUSE, GAIN_WELLS, GAIN_ROOT = "delay_jitter", (3, 6, 12, 24), 4.0
"""Cause that no data sheet limits, so that only the number of wells does; wells of one fleet, taken in turn; and √λ of
the first of these."""
PROCESSES = 2
_CODE = source_hash(
    "drillid.discrepancy.inference.shared_likelihood",
    "drillid.discrepancy.gather",
    "drillid.discrepancy.verdicts.engine",
)


@dataclass(frozen=True)
class Trial:
    """One fleet and what is said about it."""

    seed: int
    wells: int
    cause: str
    """Empty where there is none."""
    size: float
    ideal: float
    """√λ of the ideal test over the fleet."""
    alone: float
    """The largest of single wells."""
    deviation: float
    """Of twice the log-likelihood ratio at the true size from what the ideal test expects, λ, in standard deviations,
    2√λ; NaN without a cause.
    """
    verdict: str
    likeliest: str
    """The member whose size is stated."""
    p_value: float
    probability: float
    found_size: float
    size_low: float
    size_high: float
    named_alone: int
    """Wells whose own verdict names the cause."""

    @property
    def right(self) -> bool:
        """Whether the cause is in the class that is named."""
        return self.cause in self.verdict.split("|")


def statistics_of(case: Case, well: str) -> tuple[SetStatistics, tuple[str, ...]]:
    """What the fleet keeps of a well, and what its own verdicts name; cached in a file."""
    path = FOLDER / "wells" / f"{digest([_CODE, case.path.name, str(case.data_sheet), case.command_logged])}.pickle"
    kept, named = pickled(path, lambda: _examined(case))
    return SetStatistics(well=well, rig="rig", **vars(kept)), named


def _examined(case: Case) -> tuple[SharedLikelihood, tuple[str, ...]]:
    examination = examine(evidence_of(case), error_rate=ERROR_RATE)
    kept = shared_likelihood(examination.model, examination.extended, examination.extensions, examination.before)
    return kept, tuple(verdict.verdict for verdict in examination.verdicts)


def drawn(seed: int, wells: int, cause: str) -> tuple[Fleet, float, float, float]:
    """A fleet with a cause that no single well shows: its size, and √λ over the fleet and in the best single well."""
    fleet = plain_fleet(seed, wells)
    if not cause:
        return fleet, 0.0, 0.0, 0.0
    generator = np.random.default_rng([1, seed])
    low, high = DETECTABILITY
    wanted = float(low * (high / low) ** generator.random())
    hidden, root = sized(fleet, cause, wanted, ALONE)
    return fleet.with_cause(hidden), hidden.size, root, fleet.ideal.largest_alone(hidden)


def judged(found: Sequence[SetStatistics]) -> Judged:
    """The verdict on a fleet's wells."""
    return judge("rig", "rig", found, {}, ERROR_RATE, BaseRates())


def log_ratio(found: Sequence[SetStatistics], cause: str, size: float) -> float:
    """Log-likelihood ratio of a cause at a size in all wells, against none, at its likeliest shape."""
    every, wells = shared_candidates(), Wells(found)
    shapes = [int(number) for number in candidates_of("rig") if every[number].cause.name == cause]
    sizes = np.array([0.0, size])
    return max(float(np.diff(together(wells, wells.at(number, sizes)))[0]) for number in shapes)


def trial(task: tuple[int, int, str]) -> Trial:
    """One fleet: drawn, simulated, examined and judged."""
    seed, wells, cause = task
    fleet, size, root, alone = drawn(seed, wells, cause)
    found, named = zip(*(statistics_of(case, f"W{number}") for number, case in enumerate(fleet.wells)), strict=True)
    verdict = judged(found).verdict
    deviation = (2 * log_ratio(found, cause, size) - root**2) / (2 * root) if cause else float("nan")
    return Trial(
        seed, wells, cause, size, root, alone, deviation,
        verdict.verdict, verdict.cause, verdict.p_value, verdict.probability,
        verdict.size, verdict.size_low, verdict.size_high,
        sum(any(cause in name.split("|") for name in names) for names in named) if cause else 0,
    )  # fmt: skip


def tasks(first: int, nulls: int, rounds: int) -> list[tuple[int, int, str]]:
    """Seed, wells and cause of every fleet."""
    plain = [(first + number, SIZES[number % len(SIZES)], "") for number in range(nulls)]
    hidden = [
        (first + 5000 + len(SIZES) * (len(CAUSES) * turn + place) + number, wells, cause)
        for turn in range(rounds)
        for place, cause in enumerate(CAUSES)
        for number, wells in enumerate(SIZES)
    ]
    return [*hidden, *plain]


def run(work: list[tuple[int, int, str]], console: Console) -> list[Trial]:
    """All fleets."""
    with ProcessPoolExecutor(PROCESSES) as pool:
        return list(track(pool.map(trial, work), "Fleets", len(work), console=console))


def scores(trials: list[Trial]) -> list[Result]:
    """Power beside the ideal test, false alarms, coverage."""
    hidden = [each for each in trials if each.cause]
    plain = [each for each in trials if not each.cause]
    level = threshold(DISTINCT)
    ideal = float(np.mean([power(each.ideal, level) for each in hidden]))
    right = sum(each.right for each in hidden)
    caught, low, high = share("fleet_named", "fleets whose cause is named, alone or in its class", right, len(hidden))
    ratio = [
        Result(f"fleet_power{end}", f"the same per power of the ideal test{words}", of.value / ideal, least)
        for end, words, of, least in (
            ("", "", caught, 0.9),
            ("_low", ", lower limit", low, -np.inf),
            ("_high", ", upper limit", high, -np.inf),
        )
    ]
    alarms = sum(each.verdict != NONE for each in plain)
    named = [each for each in hidden if each.likeliest == each.cause]
    covered = sum(each.size_low <= each.size <= each.size_high for each in named)
    deviations = np.array([each.deviation for each in hidden])
    deviation, error = float(deviations.mean()), float(deviations.std(ddof=1) / np.sqrt(deviations.size))
    return [
        caught,
        low,
        high,
        *ratio,
        *share("fleet_false_alarm", "fleets without any cause that get one", alarms, len(plain), most=0.05),
        *share("fleet_coverage", "intervals of named sizes that hold the true one", covered, len(named), least=0.9),
        Result("fleet_ideal_power", "mean power of the ideal test over these fleets", ideal),
        Result("fleet_deviation", "log-likelihood ratio at the true size less that expected, in deviations", deviation),
        Result("fleet_deviation_error", "standard error of that", error),
    ]


def gain(seed: int) -> pd.DataFrame:
    """Standard error of a common size, relative to it, by the number of wells: of the engine and of the ideal test."""
    fleet = plain_fleet(seed, GAIN_WELLS[-1])
    hidden, _ = sized(Fleet(seed, fleet.wells[: GAIN_WELLS[0]]), GAIN_CAUSE, GAIN_ROOT, GAIN_ROOT)
    fleet, rows = fleet.with_cause(hidden), []
    found = [statistics_of(case, f"W{number}")[0] for number, case in enumerate(fleet.wells)]
    for wells in GAIN_WELLS:
        verdict = judged(found[:wells]).verdict
        error = (verdict.size_high - verdict.size_low) / (2 * TWO_SIDED) / hidden.size
        ideal = fleet.ideal.noncentrality(hidden, range(wells)) ** -0.5
        rows.append({"wells": wells, "named": verdict.cause == GAIN_CAUSE, "error": error, "ideal_error": ideal})
    return pd.DataFrame(rows)


def gain_scores(errors: pd.DataFrame) -> list[Result]:
    """Power of the number of wells with which standard errors fall; −½ where nothing but noise limits them."""
    known = errors[errors["named"]]
    powers = [
        float(np.polyfit(np.log(known["wells"]), np.log(known[name]), 1)[0]) if len(known) > 1 else np.nan
        for name in ("error", "ideal_error")
    ]
    return [
        Result("fleet_gain", "power of the number of wells with which the error of a size falls", powers[0], most=-0.4),
        Result("fleet_ideal_gain", "the same of the ideal test", powers[1]),
    ]


def measure(console: Console) -> Measurement:
    """The proof's fleets."""
    trials = run(tasks(FIRST, NULLS, ROUNDS), console)
    errors = gain(FIRST + 9000)
    console.print(errors.round(4).to_string(index=False))
    console.print(pd.DataFrame([asdict(each) for each in trials if each.cause]).round(4).to_string())
    rows: list[dict[str, Any]] = [asdict(each) for each in trials]
    write_whole(FOLDER / "fleets.csv", pd.DataFrame(rows).to_csv(index=False))
    return Measurement([*scores(trials), *gain_scores(errors)])

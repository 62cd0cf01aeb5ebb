"""Many sealed cases: drawn, simulated, examined and judged."""

from concurrent.futures import ProcessPoolExecutor
from functools import partial

import pandas as pd
from rich.progress import Progress

from benchmarks.blind.baselines import greatest_reduction, lasso
from benchmarks.blind.draw import draw
from benchmarks.blind.engines import at_random, discovery
from benchmarks.blind.ideal.trace import trace
from benchmarks.blind.judge import as_row, judge, kept_ideals
from benchmarks.blind.world import WORLDS, bit_stands

PROCESSES = 2
ENGINES = {"engine": discovery, "random": at_random, "greatest": greatest_reduction, "lasso": lasso}
"""Whose answers are judged."""
Row = dict[str, object]


def one_case(seed: int, world: str) -> dict[str, Row]:
    """Judgements of every engine about a case."""
    try:
        case = draw(seed, world=WORLDS[world])
        answers = {name: engine(case) for name, engine in ENGINES.items()}
        ideal = kept_ideals(case)
        stands, traced = bit_stands(case), trace(case)
        return {
            name: as_row(judge(case, answer, ideal, stands=stands, trace=traced)) for name, answer in answers.items()
        }
    except Exception as error:
        error.add_note(f"in the sealed case of seed {seed} of the {world} world")
        raise


def run(cases: int, first: int, world: str = "own") -> dict[str, pd.DataFrame]:
    """Tables of judgements about successive seeds, by engine."""
    rows: list[dict[str, Row]] = []
    with ProcessPoolExecutor(PROCESSES) as pool, Progress() as progress:
        task = progress.add_task(f"Sealed cases, {world} world", total=cases)
        for row in pool.map(partial(one_case, world=world), range(first, first + cases)):
            rows.append(row)
            progress.advance(task)
    return {name: pd.DataFrame([row[name] for row in rows]) for name in ENGINES}

"""Many sealed cases: drawn, simulated, examined and judged."""

import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np
import pandas as pd
from rich.progress import Progress

from benchmarks.blind.baselines import greatest_reduction, lasso
from benchmarks.blind.draw import draw
from benchmarks.blind.engines import at_random, discovery
from benchmarks.blind.ideal.trace import trace
from benchmarks.blind.judge import as_row, judge, kept_ideals
from benchmarks.blind.world import FOLDER, WORLDS, bit_stands
from benchmarks.kept import as_json
from drillid.fleet.provenance import digest

PROCESSES = 2
ENGINES = {"engine": discovery, "random": at_random, "greatest": greatest_reduction, "lasso": lasso}
"""Whose answers are judged."""
Row = dict[str, object]


def one_case(seed: int, world: str) -> dict[str, Row]:
    """Judgements of every engine about a case."""
    try:
        case = draw(seed, world=WORLDS[world])
        answers = {name: engine(case) for name, engine in ENGINES.items()}
        ideal = kept_ideals(case, answers.values())
        stands, traced = bit_stands(case), trace(case)
        return {
            name: as_row(judge(case, answer, ideal, stands=stands, trace=traced)) for name, answer in answers.items()
        }
    except Exception as error:
        error.add_note(f"in the sealed case of seed {seed} of the {world} world")
        raise


def kept_case(seed: int, world: str, code: str, deadline: float = np.inf) -> dict[str, Row] | None:
    """The same, cached in a file named after a hash of the code; None where it is not there when time is up.

    Parameters
    ----------
    deadline : s since the epoch
    """
    path = FOLDER / "judgements" / f"{digest([code, world, seed])}.json"
    if time.time() > deadline and not path.is_file():
        return None
    judgements: dict[str, Row] = as_json(path, lambda: one_case(seed, world))
    return judgements


def run(cases: int, first: int, world: str = "own", code: str = "", minutes: float = np.inf) -> dict[str, pd.DataFrame]:
    """Tables of judgements about successive seeds, by engine.

    Parameters
    ----------
    code : hash of all code that the judgements depend on; those of another run of the same are used again
    minutes : after which no case is begun; the tables then end with the last case before the first that is missing
    """
    judged = partial(kept_case, world=world, code=code, deadline=time.time() + 60 * minutes)
    rows: list[dict[str, Row]] = []
    with ProcessPoolExecutor(PROCESSES) as pool, Progress() as progress:
        task = progress.add_task(f"Sealed cases, {world} world", total=cases)
        for row in pool.map(judged, range(first, first + cases)):
            if row is None:
                break
            rows.append(row)
            progress.advance(task)
    return {name: pd.DataFrame([row[name] for row in rows]) for name in ENGINES}

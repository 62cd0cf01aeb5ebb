"""Many sealed cases: drawn, simulated, examined and judged."""

from concurrent.futures import ProcessPoolExecutor

import pandas as pd
from rich.progress import Progress

from benchmarks.blind.engines import at_random, discovery
from benchmarks.blind.generator.cases import bit_stands
from benchmarks.blind.generator.draw import draw
from benchmarks.blind.ideal.trace import trace
from benchmarks.blind.judge import as_row, judge, kept_ideals

PROCESSES = 2
Row = dict[str, object]


def one_case(seed: int) -> tuple[Row, Row]:
    """Judgements of the engine and of the random one about a case."""
    case = draw(seed)
    try:
        answers = [engine(case) for engine in (discovery, at_random)]
        ideal = kept_ideals(case, frozenset(name for verdict in answers[0].verdicts for name in verdict.members))
        stands, traced = bit_stands(case), trace(case)
        judged, guessed = (as_row(judge(case, answer, ideal, stands=stands, trace=traced)) for answer in answers)
    except Exception as error:
        error.add_note(f"in the sealed case of seed {seed}")
        raise
    return judged, guessed


def run(cases: int, first: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Tables of judgements about successive seeds, of the engine and of the random one."""
    rows: list[tuple[Row, Row]] = []
    with ProcessPoolExecutor(PROCESSES) as pool, Progress() as progress:
        task = progress.add_task("Sealed cases", total=cases)
        for row in pool.map(one_case, range(first, first + cases)):
            rows.append(row)
            progress.advance(task)
    judged, guessed = zip(*rows, strict=True)
    return pd.DataFrame(judged), pd.DataFrame(guessed)

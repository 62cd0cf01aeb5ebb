"""One result of a benchmark beside its target."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.table import Table


@dataclass(frozen=True)
class Result:
    """One result with its target.

    key : in the JSON file of the benchmark
    meaning : what it is
    least, most : target, either may be infinite
    """

    key: str
    meaning: str
    value: float
    least: float = -np.inf
    most: float = np.inf

    @property
    def target(self) -> str:
        """The target in words; empty where there is none."""
        if np.isinf(self.least) and np.isinf(self.most):
            return ""
        if np.isinf(self.least):
            return f"at most {self.most:g}"
        if np.isinf(self.most):
            return f"at least {self.least:,g}"
        return f"{self.least:g} to {self.most:g}"

    @property
    def holds(self) -> bool:
        """Whether the target is met."""
        return bool(self.least <= self.value <= self.most)


def result_table(title: str, results: Sequence[Result]) -> Table:
    """Results beside their targets."""
    table = Table(title=title)
    for heading in ("result", "reached", "target", "holds"):
        table.add_column(heading)
    for result in results:
        holds = ("yes" if result.holds else "no") if result.target else ""
        table.add_row(result.meaning, f"{result.value:,.4g}", result.target, holds)
    return table

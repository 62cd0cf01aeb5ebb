"""Rows of `make discoveries`: the columns of the wells' verdicts.csv, for data that are no wells as well."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from drillid.discrepancy.verdicts.verdict import NONE, UNKNOWN

if TYPE_CHECKING:
    import pandas as pd

NAN = float("nan")


@dataclass(frozen=True)
class Discovery:
    """One verdict on some data."""

    data: str
    """What was looked at."""
    verdict: str
    """none, a cause, a class as its members joined by |, or unknown."""
    probability: float
    evidence: str
    family: str = ""
    cause: str = ""
    """Most likely member of the class, whose size is given."""
    from_m: float = NAN
    """Hole depth, m."""
    to_m: float = NAN
    location_m: float = NAN
    """Measured depth along the string."""
    size: tuple[float, float, float] = (NAN, NAN, NAN)
    """With its 95 % interval."""
    unit: str = ""
    gain: tuple[float, float, float] = (NAN, NAN, NAN)
    """On data that were not fitted, with its 90 % interval."""
    gain_unit: str = ""
    held_out: str = ""
    what_would_separate: str = ""

    def row(self) -> dict[str, object]:
        """As a row of the table."""
        named = {} if self.verdict in (NONE, UNKNOWN) else {"class": self.verdict}
        ranges = {
            f"{name}{end}": value
            for name in ("size", "gain")
            for end, value in zip(("", "_low", "_high"), getattr(self, name), strict=True)
        }
        return vars(self) | {"class": ""} | named | ranges


COLUMNS = (
    *("data", "from_m", "to_m", "verdict", "family", "class", "cause", "probability", "location_m"),
    *("size", "size_low", "size_high", "unit", "gain", "gain_low", "gain_high", "gain_unit", "held_out"),
    *("what_would_separate", "evidence"),
)


@dataclass(frozen=True)
class Part:
    """What was found in one source of data, or why nothing was looked at."""

    rows: tuple[Discovery, ...] = ()
    figures: tuple[Path, ...] = ()
    absent: str = field(default="")
    """What is missing and how to get it."""


def table(rows: Sequence[Discovery]) -> "pd.DataFrame":
    """The rows under COLUMNS."""
    import pandas as pd

    return pd.DataFrame([one.row() for one in rows], columns=list(COLUMNS))


def printed(rows: Sequence[Discovery]) -> str:
    """One line a verdict with its evidence below."""
    lines = [f"{'data':24} {'interval, m':>13} {'verdict':40} {'prob.':>6}  {'size':36} gain on held-out data"]
    for one in rows:
        depth = f"{one.from_m:.0f}–{one.to_m:.0f}" if isfinite(one.from_m) else ""
        size, gain = _range(one.size, one.unit), _range(one.gain, one.gain_unit)
        lines.append(f"{one.data:24} {depth:>13} {one.verdict:40} {one.probability:6.3f}  {size:36} {gain}")
        held_out = f"held out: {one.held_out}. " if one.held_out else ""
        separated = f" To separate: {one.what_would_separate}." if one.what_would_separate else ""
        lines.append(f"{'':24} {held_out}{one.evidence}.{separated}")
    return "\n".join(lines)


def _range(bounds: tuple[float, float, float], unit: str) -> str:
    value, low, high = bounds
    if not isfinite(value):
        return ""
    interval = f" ({low:.4g} to {high:.4g})" if isfinite(low) else ""
    return f"{value:.4g}{interval} {unit if unit != '1' else ''}".rstrip()

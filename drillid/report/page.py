"""The fleet's report: one HTML file with everything inside, a summary first."""

from __future__ import annotations

import base64
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

import drillid
from drillid.config.sheets import Listing, read_sheets
from drillid.datasets.store import WellFolders
from drillid.figures.captions import FIGURES, LENGTH_LESS_DEPTH, QUANTITIES
from drillid.report.content import (
    EXPLANATIONS,
    Comparison,
    Drilled,
    Estimate,
    Identified,
    Interval,
    Rise,
    Spread,
    drilled,
    identified,
    joined,
    read_segments,
    without_windows,
)
from drillid.report.verdicts import SetWords, Told, read_told

if TYPE_CHECKING:
    from drillid.config.settings import Settings

TEMPLATES = Path(__file__).parent
_ILLUSTRATED_WELLS = 25
"""Wells up to which the report holds all figures; in larger fleets flagged wells show their parameters alone."""
_LEAST_RATIO, _WHOLE_RATIO = 1.05, 3.0
"""Ratios below which a rise is not told as a ratio, and from which it is told as a whole number."""
_WITHOUT_EFFECT = {"fleet", "wells", "logs", "rigs", "results"}
"""Settings that do not change what the report says."""
_VERDICTS = {
    "agrees": ("agrees with the rig's data sheets", "agree with the rig's data sheets"),
    "doubtful": (
        "lies 2 to 3 standard deviations off the data sheets",
        "lie 2 to 3 standard deviations off the data sheets",
    ),
    "disagrees": ("disagrees with the data sheets", "disagree with the data sheets"),
    "the data do not tell": ("cannot be told from these data", "cannot be told from these data"),
}
"""Verdicts on one and on several parameters."""


@dataclass(frozen=True)
class Picture:
    """A figure inside the report."""

    name: str
    title: str
    caption: str
    source: str
    width: int
    height: int


@dataclass(frozen=True)
class WellReport:
    """Everything that the report says about one well."""

    name: str
    description: str
    drilled: Drilled
    found: Identified | None
    """None where the well has no results."""
    unused: pd.DataFrame
    problems: pd.DataFrame
    pictures: tuple[Picture, ...]
    verdicts: tuple[Told, ...] = ()
    sets: tuple[SetWords, ...] = ()

    @property
    def status(self) -> str:
        """One of 'failed', 'flagged', 'clear'."""
        if self.found is None:
            return "failed"
        return "flagged" if self.found.intervals or self.named else "clear"

    @property
    def named(self) -> list[Told]:
        """Verdicts that something is wrong."""
        return [each for each in self.verdicts if each.named]

    @property
    def off_data_sheet(self) -> list[Comparison]:
        """Parameters that do not agree with the rig's data sheets."""
        return [each for each in self.found.comparisons if each.off] if self.found else []

    @property
    def refused(self) -> int:
        """Windows without an accepted fit."""
        return self.found.windows - self.found.accepted if self.found else 0


def write_report(settings: Settings, results: Path, wells: Sequence[str]) -> None:
    """Write `<results>/report.html` from the datasets, tables and figures of the wells.

    Raises
    ------
    SettingsError
        If the sheets or the rig description of a well with results cannot be read.
    """
    listings = read_sheets(settings)
    problems = pd.read_csv(Path(results) / "problems.csv", dtype=str, keep_default_na=False)
    reports = [
        well_report(
            WellFolders(Path(results), well), listings[well], problems, illustrated=len(wells) <= _ILLUSTRATED_WELLS
        )
        for well in wells
    ]
    (Path(results) / "report.html").write_text(render(settings, reports), encoding="utf-8")


def well_report(folders: WellFolders, listing: Listing, problems: pd.DataFrame, *, illustrated: bool) -> WellReport:
    """Gather a well; with `illustrated` all its figures, else parameters and verdicts where something stands out."""
    segments = read_segments(folders)
    found = identified(folders, listing.load().rig) if _has_results(folders) else None
    verdicts, sets = read_told(folders) if found else ((), ())
    stands_out = bool(found and found.intervals) or any(each.named for each in verdicts)
    chosen = list(FIGURES) if illustrated else ["parameters", "verdicts"] * stands_out
    return WellReport(
        listing.name,
        listing.description,
        drilled(segments),
        found,
        without_windows(segments),
        problems[problems["well"] == listing.name],
        tuple(pictures(folders.stage("figures"), chosen)),
        verdicts,
        sets,
    )


def _has_results(folders: WellFolders) -> bool:
    return folders.has("depth", "depth") and bool(folders.read("depth", "depth").sizes["depth"])


def pictures(folder: Path, names: Sequence[str]) -> list[Picture]:
    """The named figures that are there."""
    found = []
    for name in names:
        path = folder / f"{name}.png"
        if path.exists():
            content = path.read_bytes()
            width, height = struct.unpack(">II", content[16:24])
            source = f"data:image/png;base64,{base64.b64encode(content).decode()}"
            found.append(Picture(name, FIGURES[name].title, FIGURES[name].caption, source, width, height))
    return found


def render(settings: Settings, reports: Sequence[WellReport]) -> str:
    """The page as text; it depends on its arguments alone."""
    import yaml
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "rise": rise_text,
        "spread": spread_text,
        "estimate": estimate_text,
        "number": number,
        "share": share,
        "explanation": explanation,
        "data_sheet": data_sheet_text,
        "verdict": data_sheet_verdict,
        "joined": joined,
        "depths": depths,
    }
    used = settings.model_dump(mode="json", exclude=_WITHOUT_EFFECT, exclude_none=True)
    newest = max((report.drilled.newest for report in reports if report.drilled.newest is not None), default=None)
    return environment.get_template("report.html.j2").render(
        title=settings.report.title,
        wells=reports,
        totals=_totals(reports),
        quantities=QUANTITIES,
        length_label=LENGTH_LESS_DEPTH,
        illustrated=len(reports) <= _ILLUSTRATED_WELLS,
        version=drillid.__version__,
        settings=yaml.safe_dump(used, sort_keys=False, allow_unicode=True),
        newest="" if newest is None else f"{newest:%Y-%m-%d %H:%M} UTC",
    )


def _totals(reports: Sequence[WellReport]) -> dict[str, Any]:
    found = [report.found for report in reports if report.found]
    return {
        "metres": float(np.nansum([report.drilled.to_m - report.drilled.from_m for report in reports])),
        "drilling": sum(report.drilled.hours for report in reports),
        "identified": sum(each.hours for each in found),
        "windows": sum(each.windows for each in found),
        "accepted": sum(each.accepted for each in found),
        "intervals": sum(len(each.intervals) for each in found),
        "verdicts": sum(len(report.named) for report in reports),
        "failed": sum(report.status == "failed" for report in reports),
        "problems": sum(len(report.problems) for report in reports),
    }


def number(value: float, decimals: int = 0) -> str:
    """A number for readers, thousands parted from ten thousand on; a dash for none."""
    if not np.isfinite(value):
        return "–"
    parted = "," if abs(value) >= 1e4 else ""
    return f"{value:z{parted}.{decimals}f}".replace(",", "\u202f").replace("-", "−")


def share(part: float, whole: float) -> str:
    """A share in percent; never rounded to all or nothing when it is not."""
    if not whole:
        return "–"
    percent = 100 * part / whole
    return "> 99 %" if 99.5 <= percent < 100 else "< 1 %" if 0 < percent < 0.5 else f"{percent:.0f} %"


def depths(place: Interval | Drilled) -> str:
    """From and to in metres, a dash for nothing."""
    if not np.isfinite(place.from_m):
        return "–"
    return f"{number(place.from_m)}–{number(place.to_m)} m"


def estimate_text(estimate: Estimate, parameter: str) -> str:
    """Value ± standard error in the parameter's unit, to two digits of the error."""
    quantity = QUANTITIES[parameter]
    value, error = estimate.value * quantity.factor, estimate.error * quantity.factor
    decimals = max(0, 1 - int(np.floor(np.log10(error)))) if error > 0 else quantity.decimals
    return f"{number(value, decimals)} ± {number(error, decimals)} {quantity.unit}"


def spread_text(spread: Spread, parameter: str) -> str:
    """Median and middle two thirds in the parameter's unit; a dash without windows of use."""
    if not np.isfinite(spread.median):
        return "–"
    quantity = QUANTITIES[parameter]
    low, middle, high = (
        number(value * quantity.factor, quantity.decimals) for value in (spread.low, spread.median, spread.high)
    )
    return f"{middle} ({low} to {high})"


def rise_text(rise: Rise, *, brief: bool = False) -> str:
    """What rose, to how much, from how much, and, unless brief, how surely."""
    quantity = QUANTITIES[rise.parameter]
    there, usual = (number(estimate.value * quantity.factor) for estimate in (rise.there, rise.usual))
    ratio = rise.least_ratio
    times = f", at least {number(ratio, int(ratio < _WHOLE_RATIO))} times as much" if ratio > _LEAST_RATIO else ""
    level = f"where {usual} is usual" if np.isfinite(rise.usual.value) else "without any usual level"
    surely = "" if brief else f" ({rise.pull:.1f} standard deviations in the clearest window)"
    return f"{quantity.name} {there} {quantity.unit} {level}{times}{surely}"


def explanation(interval: Interval) -> str:
    """What could explain the interval; empty where nothing in particular rose."""
    return EXPLANATIONS.get(frozenset(rise.parameter for rise in interval.rises), "")


def data_sheet_text(comparisons: Sequence[Comparison]) -> str:
    """Agreement of top drive and pipe with the rig's data sheets in one sentence."""
    if not comparisons:
        return "The rig's data sheets give nothing to compare with."
    groups: dict[str, list[str]] = {}
    for each in comparisons:
        text = QUANTITIES[each.parameter].name.lower()
        if each.off and each.found is not None:
            found, stated = (estimate_text(one, each.parameter) for one in (each.found, each.data_sheet))
            text += f" ({found} against {stated})"
        groups.setdefault(each.verdict, []).append(text)
    sentence = "; ".join(f"{_listed(names)} {_VERDICTS[verdict][len(names) > 1]}" for verdict, names in groups.items())
    return f"{sentence[0].upper()}{sentence[1:]}."


def data_sheet_verdict(comparisons: Sequence[Comparison]) -> str:
    """The same for a cell of a table."""
    off = [f"{QUANTITIES[each.parameter].name.lower()} {each.verdict}" for each in comparisons if each.off]
    if off:
        return ", ".join(off)
    if any(each.found for each in comparisons):
        return "agrees"
    return "the data do not tell" if comparisons else "not given"


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"

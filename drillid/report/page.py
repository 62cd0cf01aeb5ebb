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
from drillid.datasets.tables import read_table
from drillid.figures.captions import DISPLAYED_PARAMETERS, FIGURES, LENGTH_LESS_DEPTH
from drillid.report.content import (
    EXPLANATIONS,
    Comparison,
    Drilled,
    Estimate,
    FlaggedInterval,
    Identified,
    ParameterSpread,
    Rise,
    drilled,
    identified,
    joined,
    read_segments,
    without_windows,
)
from drillid.report.verdicts import SetText, VerdictText, read_verdict_texts

if TYPE_CHECKING:
    from drillid.config.settings import Settings

TEMPLATES = Path(__file__).parent
_ILLUSTRATED_WELLS = 25
"""Largest number of wells with all figures in the report; in larger fleets flagged wells show fewer."""
_LEAST_RATIO, _WHOLE_RATIO = 1.05, 3.0
"""Ratios below which a rise has no ratio in the text, and from which it is a whole number."""
_WITHOUT_EFFECT = {"fleet", "wells", "logs", "rigs", "results"}
"""Settings without effect on the report."""
_VERDICTS = {
    "agrees": ("agrees with the rig's data sheets", "agree with the rig's data sheets"),
    "doubtful": (
        "lies 2 to 3 standard deviations off the data sheets",
        "lie 2 to 3 standard deviations off the data sheets",
    ),
    "disagrees": ("disagrees with the data sheets", "disagree with the data sheets"),
    "not determined by the data": ("is not determined by these data", "are not determined by these data"),
}
"""Sentences on one and on several parameters, by verdict."""


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
    """Everything in the report about one well."""

    name: str
    folder: str
    description: str
    drilled: Drilled
    identified: Identified | None
    """None where the well has no results."""
    unused: pd.DataFrame
    problems: pd.DataFrame
    pictures: tuple[Picture, ...]
    verdicts: tuple[VerdictText, ...] = ()
    sets: tuple[SetText, ...] = ()

    @property
    def status(self) -> str:
        """One of 'failed', 'flagged', 'clear'."""
        if self.identified is None:
            return "failed"
        return "flagged" if self.identified.intervals or self.named else "clear"

    @property
    def named(self) -> list[VerdictText]:
        """Verdicts that something is wrong."""
        return [verdict for verdict in self.verdicts if verdict.named]

    @property
    def data_sheet_deviations(self) -> list[Comparison]:
        """Parameters that deviate from the rig's data sheets."""
        return (
            [comparison for comparison in self.identified.comparisons if comparison.deviates] if self.identified else []
        )

    @property
    def rejected(self) -> int:
        """Windows without an accepted fit."""
        return self.identified.windows - self.identified.accepted if self.identified else 0


def write_report(settings: Settings, results: Path, wells: Sequence[str]) -> None:
    """Write `<results>/report.html` from the datasets, tables and figures of the wells.

    Raises
    ------
    SettingsError
        If the sheets or the rig description of a well with results cannot be read.
    """
    listings = read_sheets(settings)
    problems = read_table(Path(results) / "problems.csv", dtype=str, keep_default_na=False)
    reports = [
        well_report(
            WellFolders(Path(results), well), listings[well], problems, illustrated=len(wells) <= _ILLUSTRATED_WELLS
        )
        for well in wells
    ]
    (Path(results) / "report.html").write_text(render(settings, reports), encoding="utf-8")


def well_report(folders: WellFolders, listing: Listing, problems: pd.DataFrame, *, illustrated: bool) -> WellReport:
    """Read a well; with `illustrated` all its figures, else parameters and verdicts where something stands out."""
    segments = read_segments(folders)
    results = identified(folders, listing.load().rig) if _has_results(folders) else None
    verdicts, sets = read_verdict_texts(folders) if results else ((), ())
    stands_out = bool(results and results.intervals) or any(verdict.named for verdict in verdicts)
    chosen = list(FIGURES) if illustrated else ["parameters", "verdicts"] * stands_out
    return WellReport(
        listing.name,
        listing.folder,
        listing.description,
        drilled(segments),
        results,
        without_windows(segments),
        problems[problems["well"].isin([listing.name, listing.folder])],
        tuple(pictures(folders.stage("figures"), chosen)),
        verdicts,
        sets,
    )


def _has_results(folders: WellFolders) -> bool:
    return folders.has("depth", "depth") and bool(folders.read("depth", "depth").sizes["depth"])


def pictures(folder: Path, names: Sequence[str]) -> list[Picture]:
    """The named figures that exist."""
    existing = []
    for name in names:
        path = folder / f"{name}.png"
        if path.exists():
            content = path.read_bytes()
            width, height = struct.unpack(">II", content[16:24])
            source = f"data:image/png;base64,{base64.b64encode(content).decode()}"
            existing.append(Picture(name, FIGURES[name].title, FIGURES[name].caption, source, width, height))
    return existing


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
        quantities=DISPLAYED_PARAMETERS,
        length_label=LENGTH_LESS_DEPTH,
        illustrated=len(reports) <= _ILLUSTRATED_WELLS,
        version=drillid.__version__,
        settings=yaml.safe_dump(used, sort_keys=False, allow_unicode=True),
        newest="" if newest is None else f"{newest:%Y-%m-%d %H:%M} UTC",
    )


def _totals(reports: Sequence[WellReport]) -> dict[str, Any]:
    results = [report.identified for report in reports if report.identified]
    return {
        "metres": float(np.nansum([report.drilled.to_m - report.drilled.from_m for report in reports])),
        "drilling": sum(report.drilled.hours for report in reports),
        "identified": sum(well.hours for well in results),
        "windows": sum(well.windows for well in results),
        "accepted": sum(well.accepted for well in results),
        "intervals": sum(len(well.intervals) for well in results),
        "verdicts": sum(len(report.named) for report in reports),
        "failed": sum(report.status == "failed" for report in reports),
        "problems": sum(len(report.problems) for report in reports),
    }


def number(value: float, decimals: int = 0) -> str:
    """A number for readers, with separated thousands from ten thousand on; a dash for NaN."""
    if not np.isfinite(value):
        return "–"
    separator = "," if abs(value) >= 1e4 else ""
    return f"{value:z{separator}.{decimals}f}".replace(",", "\u202f").replace("-", "−")


def share(part: float, whole: float) -> str:
    """A share in percent; never rounded to 0 or 100 % unless exact."""
    if not whole:
        return "–"
    percent = 100 * part / whole
    return "> 99 %" if 99.5 <= percent < 100 else "< 1 %" if 0 < percent < 0.5 else f"{percent:.0f} %"


def depths(place: FlaggedInterval | Drilled) -> str:
    """From and to in metres, a dash for NaN."""
    if not np.isfinite(place.from_m):
        return "–"
    return f"{number(place.from_m)}–{number(place.to_m)} m"


def estimate_text(estimate: Estimate, parameter: str) -> str:
    """Value ± standard error in the parameter's unit, to two digits of the error."""
    quantity = DISPLAYED_PARAMETERS[parameter]
    value, error = estimate.value * quantity.factor, estimate.error * quantity.factor
    decimals = max(0, 1 - int(np.floor(np.log10(error)))) if error > 0 else quantity.decimals
    return f"{number(value, decimals)} ± {number(error, decimals)} {quantity.unit}"


def spread_text(spread: ParameterSpread, parameter: str) -> str:
    """Median and middle two thirds in the parameter's unit; a dash without windows."""
    if not np.isfinite(spread.median):
        return "–"
    quantity = DISPLAYED_PARAMETERS[parameter]
    low, middle, high = (
        number(value * quantity.factor, quantity.decimals) for value in (spread.low, spread.median, spread.high)
    )
    return f"{middle} ({low} to {high})"


def rise_text(rise: Rise, *, brief: bool = False) -> str:
    """The parameter that rose, its value, the usual one, the ratio and, unless brief, the pull."""
    quantity = DISPLAYED_PARAMETERS[rise.parameter]
    there, usual = (number(estimate.value * quantity.factor) for estimate in (rise.there, rise.usual))
    ratio = rise.least_ratio
    times = f", at least {number(ratio, int(ratio < _WHOLE_RATIO))} times as much" if ratio > _LEAST_RATIO else ""
    level = f"where {usual} is usual" if np.isfinite(rise.usual.value) else "without any usual level"
    pull = "" if brief else f" ({rise.pull:.1f} standard deviations in the clearest window)"
    return f"{quantity.name} {there} {quantity.unit} {level}{times}{pull}"


def explanation(interval: FlaggedInterval) -> str:
    """Possible explanation of the interval; empty where no parameter rose clearly."""
    return EXPLANATIONS.get(frozenset(rise.parameter for rise in interval.rises), "")


def data_sheet_text(comparisons: Sequence[Comparison]) -> str:
    """Agreement of top drive and pipe with the rig's data sheets in one sentence."""
    if not comparisons:
        return "The rig's data sheets give nothing to compare with."
    groups: dict[str, list[str]] = {}
    for comparison in comparisons:
        text = DISPLAYED_PARAMETERS[comparison.parameter].name.lower()
        if comparison.deviates and comparison.measured is not None:
            measured = estimate_text(comparison.measured, comparison.parameter)
            text += f" ({measured} against {estimate_text(comparison.data_sheet, comparison.parameter)})"
        groups.setdefault(comparison.verdict, []).append(text)
    sentence = "; ".join(f"{_listed(names)} {_VERDICTS[verdict][len(names) > 1]}" for verdict, names in groups.items())
    return f"{sentence[0].upper()}{sentence[1:]}."


def data_sheet_verdict(comparisons: Sequence[Comparison]) -> str:
    """The same for a cell of a table."""
    deviations = [
        f"{DISPLAYED_PARAMETERS[comparison.parameter].name.lower()} {comparison.verdict}"
        for comparison in comparisons
        if comparison.deviates
    ]
    if deviations:
        return ", ".join(deviations)
    if any(comparison.measured for comparison in comparisons):
        return "agrees"
    return "not determined by the data" if comparisons else "not given"


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"

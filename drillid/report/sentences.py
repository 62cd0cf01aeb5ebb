"""Sentences on what was identified: agreement with data sheets, fits that are not accepted, problems."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from drillid.figures.captions import DISPLAYED_PARAMETERS
from drillid.report.content import Comparison, Estimate, ParameterSpread
from drillid.report.quantities import MISSING, QUANTITIES, both, number

if TYPE_CHECKING:
    from drillid.report.well_report import WellReport

_VERDICTS = {
    "agrees": ("agrees with the rig's data sheets", "agree with the rig's data sheets"),
    "doubtful": (
        "is 2 to 3 standard deviations from the data sheets",
        "are 2 to 3 standard deviations from the data sheets",
    ),
    "disagrees": ("disagrees with the data sheets", "disagree with the data sheets"),
    "not determined by the data": ("is not determined by these data", "are not determined by these data"),
}
"""Sentences on one and on several parameters, by verdict."""
PARAMETER_QUANTITIES = {
    "kappa": "wall damping",
    "delta": "internal damping",
    "length": "depth",
    "polar_moment": "polar moment",
    "damping_bha": "damping",
    "inertia_td": "inertia",
    "inertia_bha": "inertia",
}
"""Quantities of parameters that have an oilfield unit."""


def deviations_text(comparisons: Sequence[Comparison]) -> Markup:
    """Agreement of top drive and pipe with the rig's data sheets in one sentence."""
    if not comparisons:
        return Markup("The rig's data sheets give nothing to compare with.")
    groups: dict[str, list[Markup]] = {}
    for comparison in comparisons:
        text = Markup(DISPLAYED_PARAMETERS[comparison.parameter].name.lower())
        if comparison.deviates and comparison.measured is not None:
            values = (comparison.measured, comparison.data_sheet)
            text += Markup(" ({} against {})").format(*(estimate_text(each, comparison.parameter) for each in values))
        groups.setdefault(comparison.verdict, []).append(text)
    sentence = Markup("; ").join(
        Markup("{} {}").format(_listed(names), _VERDICTS[verdict][len(names) > 1]) for verdict, names in groups.items()
    )
    return sentence[:1].upper() + sentence[1:] + Markup(".")


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


def rejections_text(well: WellReport) -> str:
    """How many fits are not accepted, and why."""
    results = well.identified
    if results is None or not well.rejected:
        return ""
    reasons = "; ".join(f"{windows} because {reason}" for reason, windows in results.rejections.most_common())
    return f"{well.rejected} of {results.windows} fits {'is' if well.rejected == 1 else 'are'} not accepted: {reasons}."


def problem_sentence(row: Mapping[Any, Any]) -> Markup:
    """One row of the problems in a sentence."""
    remedy = str(row["remedy"])
    end = "" if remedy[-1:] in ".?!" else "."
    return Markup("{}: {}: {}. {}{}").format(str(row["stage"]).capitalize(), row["where"], row["what"], remedy, end)


def estimate_text(estimate: Estimate, parameter: str) -> Markup:
    """Value ± standard error in the parameter's unit, to two digits of the error."""
    return both(*(_estimate(estimate, *scale) for scale in scales(parameter)))


def _estimate(estimate: Estimate, factor: float, usual_decimals: int, unit: str) -> str:
    value, error = estimate.value / factor, estimate.error / factor
    decimals = _decimals(error, usual_decimals)
    return f"{number(value, decimals)} ± {number(error, decimals)} {unit}"


def _decimals(error: float, usual: int) -> int:
    """Decimal places of two digits of an error; the usual ones where it is zero or unknown."""
    return max(0, 1 - int(np.floor(np.log10(error)))) if 0 < error < np.inf else usual


def spread_text(spread: ParameterSpread, parameter: str) -> Markup:
    """Usual value and middle two thirds of the windows; a dash without windows."""
    if not np.isfinite(spread.usual):
        return Markup(MISSING)
    return both(*(_spread(spread, *scale) for scale in scales(parameter)))


def error_text(error: float, parameter: str) -> Markup:
    """A standard error in the parameter's unit, to two digits."""
    scaled = [(error / factor, usual) for factor, usual, _ in scales(parameter)]
    return both(*(number(each, _decimals(each, usual)) for each, usual in scaled))


def unit_text(parameter: str) -> Markup:
    """The parameter's unit."""
    return both(*(unit for _, _, unit in scales(parameter)))


def _spread(spread: ParameterSpread, factor: float, decimals: int, unit: str) -> str:
    usual, low, high = (number(value / factor, decimals) for value in (spread.usual, spread.low, spread.high))
    return f"{usual} ({low} to {high})"


def scales(parameter: str) -> list[tuple[float, int, str]]:
    """SI value, decimals and name of the parameter's metric and oilfield unit."""
    shown, quantity = DISPLAYED_PARAMETERS[parameter], QUANTITIES.get(PARAMETER_QUANTITIES.get(parameter, ""))
    usual = (1 / shown.factor, shown.decimals, shown.unit)
    if quantity is None:
        return [usual, usual]
    oilfield = quantity.oilfield
    return [usual, (oilfield.factor(quantity.si_unit), oilfield.decimals, oilfield.shown)]


def _listed(names: Sequence[Markup]) -> Markup:
    return names[0] if len(names) == 1 else Markup(", ").join(names[:-1]) + Markup(" and ") + names[-1]

"""What needs attention in a well, the most urgent first."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape

from drillid.figures.captions import DISPLAYED_PARAMETERS
from drillid.report.content import EXPLANATIONS, FlaggedInterval, Rise
from drillid.report.quantities import QUANTITIES, number
from drillid.report.sentences import PARAMETER_QUANTITIES, deviations_text, problem_sentence, rejections_text
from drillid.report.verdicts import Prediction, VerdictText
from drillid.report.well_report import StickSlip, WellReport

ACT, LOOK, NOTE = 1, 2, 3
URGENCY = {ACT: "act", LOOK: "look", NOTE: "note"}
"""Levels of urgency, in words."""
_LIKELY = 0.8
_LEAST_RATIO, _WHOLE_RATIO = 1.1, 3.0
"""Ratios below which a rise has no ratio in the text, and from which it is a whole number."""
_FAMILIES = {
    "drive": "Top drive",
    "control": "Top drive",
    "top": "Top drive",
    "sensor": "Sensors and data",
    "string": "String",
    "bit": "Bit and assembly",
    "time": "Change while drilling",
}
KINDS = (
    *("No result", "Wash-out", "Top drive", "Bit and assembly", "String", "Change while drilling"),
    *("Stick-slip", "Sensors and data", "Unknown", "Data sheet"),
)
"""Kinds of items, by which the page filters them."""


@dataclass(frozen=True)
class Item:
    """Something that needs attention."""

    level: int
    kind: str
    lead: Markup
    more: Markup
    from_m: float
    to_m: float
    strength: float
    """By which items of a level are ranked; larger is more urgent."""
    anchor: str
    """Of its place in the page of the well."""

    @property
    def depths(self) -> Markup:
        """From and to; empty where it holds for the whole well."""
        return QUANTITIES["depth"].text(self.from_m, self.to_m) if np.isfinite(self.from_m) else Markup("")


def items(well: WellReport) -> list[Item]:
    """All items of a well in order of urgency."""
    found = [
        *_failure(well),
        *(_of_verdict(well, verdict) for verdict in well.wrong),
        *(_of_interval(interval) for interval in well.unnamed_intervals),
        *_stick_slip(well),
        *_rejections(well),
        *_data_sheet(well),
        *_data(well),
    ]
    return sorted(found, key=lambda item: (item.level, -item.strength))


def _failure(well: WellReport) -> list[Item]:
    if well.identified is not None:
        return []
    reasons = [problem_sentence(row) for row in well.problems.tail(1).to_dict("records")]
    lead = Markup("No result. ") + (reasons[0] if reasons else Markup("Nothing was written for this well."))
    return [Item(ACT, "No result", lead, Markup(""), np.nan, np.nan, 2.0, "problems")]


def _of_verdict(well: WellReport, verdict: VerdictText) -> Item:
    interval = well.interval_of(verdict)
    kind = "Unknown" if verdict.kind == "unknown" else _FAMILIES.get(verdict.family, "Unknown")
    lead = verdict.lead
    more = Markup("{} {}").format(verdict.size, verdict.gain) if verdict.kind == "named" else escape(verdict.doubt)
    if interval is not None:
        kind, lead = _interval_kind(interval), interval_lead(interval)
        more = Markup("{} {}").format(interval_text(interval), interval_gain(interval))
    level = ACT if verdict.kind == "named" and verdict.probability >= _LIKELY else LOOK
    return Item(level, kind, lead, more, verdict.from_m, verdict.to_m, verdict.probability, "verdicts")


def _of_interval(interval: FlaggedInterval) -> Item:
    strength = max((rise.pull for rise in interval.rises), default=0.0) / 100
    lead, more = interval_lead(interval), interval_text(interval)
    kind = _interval_kind(interval)
    return Item(LOOK, kind, lead, more, interval.from_m, interval.to_m, strength, "verdicts")


def _interval_kind(interval: FlaggedInterval) -> str:
    """A washed-out hole raises the damping; an inertia that rises alone does not tell of one."""
    return "Wash-out" if any(rise.parameter == "damping_bha" for rise in interval.rises) else "Bit and assembly"


def interval_lead(interval: FlaggedInterval) -> Markup:
    """What a driller would say of a flagged interval."""
    rose = frozenset(rise.parameter for rise in interval.rises)
    what = {
        frozenset(): "Damping or inertia of the assembly is higher here than its scatter explains",
        frozenset({"damping_bha"}): "Something drags on the assembly here",
        frozenset({"inertia_bha"}): "More mass than usual rotates with the assembly here",
    }.get(rose, "Something drags on the assembly here, and more mass rotates with it")
    action = "check the tally" if rose == {"inertia_bha"} else "check caliper, cuttings and downhole vibration"
    likely = ", as in a washed-out hole" if "damping_bha" in rose else ""
    return Markup("{}{}: {}.").format(what, likely, action)


def interval_text(interval: FlaggedInterval) -> Markup:
    """The parameters that rose, with their usual levels."""
    return Markup("; ").join(rise_text(rise) for rise in interval.rises) + Markup("." if interval.rises else "")


def interval_gain(interval: FlaggedInterval) -> Markup:
    """What knowing of the interval gains; empty where that is not known."""
    return Prediction(*interval.prediction, change=np.nan).text if interval.prediction else Markup("")


def interval_explanation(interval: FlaggedInterval) -> str:
    """Possible explanation of the interval; empty where no parameter rose clearly."""
    return EXPLANATIONS.get(frozenset(rise.parameter for rise in interval.rises), "")


def rise_text(rise: Rise) -> Markup:
    """The parameter that rose, its value, the usual one and the ratio."""
    name, quantity = DISPLAYED_PARAMETERS[rise.parameter].name, QUANTITIES[PARAMETER_QUANTITIES[rise.parameter]]
    ratio = rise.least_ratio
    times = f", at least {_rounded_down(ratio)} times as much" if ratio >= _LEAST_RATIO else ""
    usual = (
        Markup("where {} is usual").format(quantity.text(rise.usual.value))
        if np.isfinite(rise.usual.value)
        else Markup("without any usual level")
    )
    clear = f" ({rise.pull:.1f} standard deviations in the clearest window)"
    return Markup("{} {} {}{}{}").format(name, quantity.text(rise.there.value), usual, times, clear)


def _rounded_down(ratio: float) -> str:
    """A lower limit, which rounding must not raise."""
    return number(math.floor(ratio)) if ratio >= _WHOLE_RATIO else number(math.floor(10 * ratio) / 10, 1)


def _stick_slip(well: WellReport) -> list[Item]:
    risk = well.stick_slip
    if risk is None:
        return []
    rotation = QUANTITIES["rotation"]
    remedy = "set the speed control as advised" if well.control else "have the speed control tuned"
    share = risk.windows / max(risk.judged, 1)
    limit = "is below its limit" if risk.windows == 1 else "are below their limit"
    below = f"{risk.windows} of {risk.judged} windows {limit}."
    if risk.unstable:
        lead, more = _at_every_speed(risk, remedy)
        return [Item(LOOK, "Stick-slip", lead, more + below, risk.from_m, risk.to_m, share, "control")]
    lead = Markup("Risk of stick-slip: raise the speed, reduce the weight on bit or {}.").format(remedy)
    speeds = (risk.speed, risk.lowest)
    # as many decimal places as tell the two apart
    places = next((more for more in range(3) if len({rotation.text(each, more=more) for each in speeds}) > 1), 3)
    speed, lowest = (rotation.text(each, more=places) for each in speeds)
    more = Markup("{} where a bit with the stated torque needs {}; {}").format(speed, lowest, below)
    return [Item(LOOK, "Stick-slip", lead, more, risk.from_m, risk.to_m, share, "control")]


def _at_every_speed(risk: StickSlip, remedy: str) -> tuple[Markup, Markup]:
    """Lead of windows in which no speed is stable, and why that is so."""
    where = "" if risk.unstable == risk.windows else f", in {risk.unstable} of {risk.windows} windows"
    remedies = remedy if risk.fed_by else f"reduce the weight on bit or {remedy}"
    lead = Markup("Risk of stick-slip{} at every speed: {}.").format(where, remedies)
    if risk.fed_by:
        bit = "it" if risk.fed_by == ("bit",) else "the bit"
        feeds = Markup("The {} feeds vibration by itself, whatever the weight on {}; ")
        return lead, feeds.format(" or the ".join(risk.fed_by), bit)
    return lead, Markup("With a bit of the stated torque no speed is stable there; ")


def _rejections(well: WellReport) -> list[Item]:
    if not well.many_rejected or well.identified is None:
        return []
    share = well.rejected / well.identified.windows
    named = [verdict.title for verdict in well.wrong if verdict.kind == "named" and verdict.probability >= _LIKELY]
    if named:
        lead = Markup("Many fits without the {} are not accepted: rely on the extended model.").format(named[0])
        level = NOTE
    else:
        level, lead = LOOK, Markup("Many fits are not accepted: check the reasons before relying on this well.")
    return [Item(level, "Sensors and data", lead, escape(rejections_text(well)), np.nan, np.nan, share, "parameters")]


def _data_sheet(well: WellReport) -> list[Item]:
    if not well.deviations:
        return []
    level = LOOK if any(each.verdict == "disagrees" for each in well.deviations) else NOTE
    largest = max(abs(each.pull) for each in well.deviations)
    lead = Markup("The data do not agree with the rig's data sheets: check the sheets against the rig.")
    more = deviations_text(well.deviations)
    return [Item(level, "Data sheet", lead, more, np.nan, np.nan, largest / 100, "sheets")]


def _data(well: WellReport) -> list[Item]:
    rows = well.problems[well.problems["stage"] == "records"] if well.identified else well.problems.iloc[:0]
    if not len(rows):
        return []
    first, count = rows.iloc[0], len(rows)
    lead = Markup("{} in the logs, repaired or left out: {}.").format(
        "A problem" if count == 1 else f"{count} problems", "check it" if count == 1 else "check them"
    )
    more = Markup("{}{}: {}.").format("" if count == 1 else "The first: ", first["where"], first["what"])
    return [Item(NOTE, "Sensors and data", lead, more, np.nan, np.nan, count / 1e4, "problems")]

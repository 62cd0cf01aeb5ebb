"""Rows and figure of the field well's start of rotation."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from scipy.special import expit

from benchmarks.discoveries.field import SERIES, Misses, gain, intervals, log_odds, misses
from benchmarks.discoveries.rows import Discovery, Part
from benchmarks.field.log import FieldLog, read_field_log
from benchmarks.field.start_up import DATA, DEPTH, FITTED_S, LADDER
from drillid.discrepancy import CATALOGUE
from drillid.discrepancy.verdicts.verdict import UNKNOWN
from drillid.simulation.start_up import WellFriction

VISCOUS, SLIDING, BREAKAWAY, CONTACT, REST = LADDER
SOLID = "+ assembly's own friction"
SOLID_STEEL = WellFriction(0.1866, 1.0376, 0.9458, 1.5843, threshold=3.2386, kappa=3866.4)
"""Fitted as CONTACT, by `benchmarks.field.start_up.fit`, with the assembly's inertia held at that of solid steel."""
STIFFER = "+ own friction, stiffer pipe"
STIFFER_PIPE = WellFriction(0.06715, 1.3929, 2.8276, 1.7594, threshold=7.8071, kappa=10180.0)
STIFFNESS = 71.05 / 61
"""Fitted as SOLID_STEEL, with the pipe's shear modulus as a further figure, in the place of the assembly's inertia."""
_OWN_FRICTION = LADDER[CONTACT][1][:-1]
MODELS: Mapping[str, tuple[WellFriction, tuple[str, ...], float]] = {
    **{name: (*LADDER[name], 1.0) for name in (VISCOUS, SLIDING, BREAKAWAY)},
    SOLID: (SOLID_STEEL, _OWN_FRICTION, 1.0),
    STIFFER: (STIFFER_PIPE, (*_OWN_FRICTION, "pipe's stiffness"), STIFFNESS),
    **{name: (*LADDER[name], 1.0) for name in (CONTACT, REST)},
}
"""Friction, names of the fitted parameters, shear modulus of the pipe per described one."""
AXIAL_S = 50.0
"""The string begins to move along the hole, which no model here does."""


@dataclass(frozen=True)
class Question:
    """Two models that differ in one part, and what the part is called."""

    label: str
    before: str
    after: str
    verdict: str
    parameters: Mapping[str, str]
    """The part's own parameters and what they are called; the size is the first."""
    words: str
    what_would_separate: str
    instead: str = ""
    """Another model with as many parameters, which the part is held against too."""


QUESTIONS = (
    Question(
        "field, friction on the wall",
        VISCOUS,
        CONTACT,
        "coulomb_contact",
        {
            "sliding": "coefficient of sliding friction of the pipe",
            "assembly_sliding": "assembly's per pipe's",
            "breakaway": "static per sliding",
            "threshold": "speed over which it falls, rad/s",
        },
        "the bit sticks and slips, which viscous drag cannot make at any inertia: its torque has the mean and no cycle",
        "",
    ),
    Question(
        "field, assembly's inertia",
        SOLID,
        CONTACT,
        UNKNOWN,
        {"assembly_inertia": "inertia of the assembly per that of solid steel"},
        "with the inertia of solid steel the best fit that the search finds makes no cycle, as it would be too slow:"
        " friction shows its gain only beside a lighter assembly, and no cause of the catalogue makes it lighter",
        "the assembly's weight and tally, or a sweep off bottom: the string's modes tell stiffness from inertia",
        STIFFER,
    ),
    Question(
        "field, friction of rest",
        CONTACT,
        REST,
        UNKNOWN,
        {
            "rest": "share by which a rested pipe is held more",
            "assembly_rest": "a rested assembly",
            "rest_angle": "slip that takes it away, rad",
        },
        "a share of friction that rest leaves and slip takes away; the catalogue has no such cause",
        "starts of rotation after short and long rests, and the second depth of this well",
    ),
)


def simulated(log: FieldLog) -> dict[str, Misses]:
    """Every model's misses."""
    return {name: misses(friction, fitted, log, stiffness) for name, (friction, fitted, stiffness) in MODELS.items()}


def field_rows(found: Mapping[str, Misses], log: FieldLog) -> tuple[Discovery, ...]:
    """A row for each question and series."""
    sizes = {name: intervals(found[name], log) for name in (CONTACT, REST)}
    return tuple(_row(one, found, series, sizes[one.after]) for one in QUESTIONS for series in SERIES)


def _row(
    question: Question, found: Mapping[str, Misses], series: str, sizes: Mapping[str, tuple[float, float, float]]
) -> Discovery:
    before, after = found[question.before], found[question.after]
    odds, unit = log_odds(before, after), SERIES[series][1]
    gained = gain(before, after, series)
    named = question.verdict != UNKNOWN
    parameters = ", ".join(
        "{} {:.3g} ({:.3g} to {:.3g})".format(words, *sizes[name]) for name, words in question.parameters.items()
    )
    spans = ", ".join(
        f"{first:.0f}–{last:.0f} s {before.rms(series, first, last):.2f} → {after.rms(series, first, last):.2f}"
        for first, last in ((0.0, FITTED_S), (FITTED_S, AXIAL_S), (FITTED_S, 60.0))
    )
    if question.instead:
        rival = found[question.instead]
        spans += (
            f"; a stiffer pipe (wave_speed) in its place leaves {rival.rms(series, 0.0, FITTED_S):.2f} and"
            f" {rival.rms(series, FITTED_S, 60.0):.2f}, log Bayes factor {log_odds(rival, after):.1f} for the inertia"
        )
    doubt = "" if gained[1] > 0 else "; the gain on held-out time is not sure to be one"
    return Discovery(
        f"{question.label}: {series}",
        question.verdict,
        float(expit(odds)),
        f"{question.words}; {parameters}; {series} in {unit}: {spans}; "
        f"log Bayes factor {odds:.1f} on both series{doubt}",
        family=CATALOGUE[question.verdict].family if named else "string",
        cause=question.verdict if named else "",
        from_m=DEPTH,
        to_m=DEPTH,
        size=sizes[next(iter(question.parameters))],
        unit="1",
        gain=gained,
        gain_unit=unit,
        held_out="45–60 s (axial motion from 50 s on), friction at 98.5, 100 and 101.5 %",
        what_would_separate=question.what_would_separate,
    )


def parts(found: Mapping[str, Misses]) -> pd.DataFrame:
    """Rms misses of every model over the fitted and the held-out time."""
    spans = {"0–45 s": (0.0, FITTED_S), "45–50 s": (FITTED_S, AXIAL_S), "45–60 s": (FITTED_S, 60.0)}
    rows = {
        name: {
            f"{series}, {unit}, {span}": one.rms(series, *ends)
            for series, (_, unit) in SERIES.items()
            for span, ends in spans.items()
        }
        for name, one in found.items()
    }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("model")


def discover(folder: Path) -> Part:
    """Rows, table of parts and figure of the field well."""
    if not DATA.is_file():
        return Part(absent=f"the field log is not at {DATA}")
    from benchmarks.discoveries.figures import draw_field

    log = read_field_log(DATA)
    found = simulated(log)
    parts(found).round(3).to_csv(folder / "field_parts.csv")
    path = folder / "field.png"
    draw_field(log, found, path)
    return Part(field_rows(found, log), (path,))

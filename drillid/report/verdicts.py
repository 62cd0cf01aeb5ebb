"""Verdicts for readers: what a driller would say, then size, doubt and gain, then the evidence."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup, escape

from drillid.discrepancy import EVIDENCE
from drillid.discrepancy.catalogue import CATALOGUE, SYMPTOMS, words_of
from drillid.discrepancy.catalogue.time import risen
from drillid.discrepancy.rules import EVEN_ODDS
from drillid.discrepancy.sets import read_verdicts
from drillid.discrepancy.verdicts.verdict import LEARNT, NONE, UNKNOWN, UNPROVED
from drillid.figures.captions import share
from drillid.report.quantities import QUANTITIES, digits, number, size_text
from drillid.units import RPM

if TYPE_CHECKING:
    import xarray as xr

    from drillid.arrays import Floats
    from drillid.datasets.store import WellFolders
    from drillid.discrepancy.catalogue import Cause
    from drillid.discrepancy.catalogue.symptoms import Symptom

_UNKNOWN_ACTION = "Rely less on the model at these depths, and have the part of the rig named here inspected."
_CLEAR, _LIKELY = 0.95, 0.8
_FALLS = 0.98
"""Ratio of prediction errors below which one is told to fall, or to rise from the other."""
_SIGNED = (
    *(("more", "less"), ("higher", "lower"), ("high", "low"), ("longer", "shorter"), ("later", "earlier")),
    ("up", "down"),
)
"""Words of headlines for positive sizes, and those for negative ones."""
_SEEN_FIRST = ("drive_lag", "clock_offset", "speed_scale", "actuator_gain", "local_damping_zone", "motor_compliance")
"""Causes of which a clear verdict tells how small they would have been seen."""


@dataclass(frozen=True)
class Visible:
    """The smallest size of a cause that the data of a set show, and its usual size, in words."""

    cause: str
    size: float
    """The smallest, SI."""
    smallest: Markup
    usual: Markup
    below_usual: bool


@dataclass(frozen=True)
class Prediction:
    """Prediction of the top drive's speed in a held-out window, rpm rms."""

    base: float
    """Error without the cause."""
    extended: float
    """Error with it."""
    noise: float
    """Part of both that is noise of the measurement."""
    change: float
    """Of the prediction by the cause; NaN where that is not known."""

    @property
    def text(self) -> Markup:
        """What knowing of the cause gains."""
        least = min(value for value in (self.base, self.extended, self.noise, self.change) if value == value)
        decimals = max(2, 1 - math.floor(math.log10(max(least, 1e-9))))
        base, extended, noise, change = (
            number(value, decimals) for value in (self.base, self.extended, self.noise, self.change)
        )
        moved = (
            f"It changes the predicted speed of the top drive by {change} rpm. " if self.change == self.change else ""
        )
        known = f"; the noise is {noise} rpm" if self.noise == self.noise else ""
        is_hidden = self.extended >= _FALLS * self.base and self.noise > self.base / 2
        verb = "falls" if self.extended < self.base else "rises"
        error = f"stays at {base}" if base == extended else f"{verb} from {base} to {extended}"
        return Markup("{}In a held-out window the error of the predicted speed {} rpm{}{}.").format(
            moved, error, known, ", which hides the cause there" if is_hidden else ""
        )


@dataclass(frozen=True)
class SetText:
    """Text on a whole set of windows."""

    from_m: float
    to_m: float
    advice: str
    missing: str
    """Interpretation of the missing immittance where the cause is unknown; else empty."""
    prediction: Prediction | None
    """Of the speed in a held-out window; None where the model is not extended."""
    visible: tuple[Visible, ...]
    """Of every cause that the linear responses show."""


@dataclass(frozen=True)
class VerdictText:
    """One verdict for readers."""

    kind: str
    """One of 'named', 'unknown', 'none', 'unproved'."""
    title: str
    """The cause, or the class, in a few words."""
    from_m: float
    to_m: float
    lead: Markup
    """What a driller would say, with what to do."""
    size: Markup
    doubt: str
    """Probability."""
    gain: Markup
    evidence: Markup
    action: str
    probability: float
    family: str
    decisive: str = ""
    """What would decide it; empty where nothing is known to."""
    learnt: str = ""
    """What was learnt of it; empty where nothing was."""

    @property
    def wrong(self) -> bool:
        """Whether something is wrong."""
        return self.kind in ("named", "unknown")

    @property
    def depths(self) -> Markup:
        """From and to."""
        return QUANTITIES["depth"].text(self.from_m, self.to_m)


def read_verdict_texts(folders: WellFolders) -> tuple[tuple[VerdictText, ...], tuple[SetText, ...]]:
    """Texts of the verdicts and of the sets of windows of a well."""
    sets = folders.read("discrepancy", "examination").drop_dims(["window", "frequency"]).load()
    texts = tuple(_set_text(sets.isel(set=number)) for number in range(sets.sizes["set"]))
    rows = read_verdicts(folders).to_dict("records")
    return verdict_texts(rows, texts), texts


def verdict_texts(rows: Sequence[Mapping[Any, Any]], sets: Sequence[SetText]) -> tuple[VerdictText, ...]:
    """Texts for the rows of verdicts.csv; sets one after another in which nothing is wrong have one."""
    texts: list[VerdictText] = []
    for clear, group in groupby(rows, lambda row: _kind(row) == "none"):
        found = list(group)
        texts += [_all_clear(found, sets)] if clear and len(found) > 1 else [verdict_text(row, sets) for row in found]
    return tuple(texts)


def _all_clear(rows: Sequence[Mapping[Any, Any]], sets: Sequence[SetText]) -> VerdictText:
    """Text for several sets in which nothing is wrong, with the ranges of what they say and the least probability."""
    texts = [verdict_text(row, sets) for row in rows]
    least, most = (percent(end(text.probability for text in texts)) for end in (min, max))
    both_ends = least if least == most else f"{least.removesuffix(' %')} to {most}"
    ends = min(text.from_m for text in texts), max(text.to_m for text in texts)
    own = [each for each in sets if ends[0] <= each.from_m and each.to_m <= ends[1]]
    doubt = f"The probability that nothing is wrong is {both_ends} in each of {len(rows)} sets of windows."
    lead, probability = _none(rows[0], own), min(text.probability for text in texts)
    first = replace(texts[0], from_m=ends[0], to_m=ends[1], evidence=Markup(""))
    return replace(first, lead=lead, doubt=doubt, probability=probability)


def verdict_text(row: Mapping[Any, Any], sets: Sequence[SetText] = ()) -> VerdictText:
    """Text for one row of verdicts.csv.

    Parameters
    ----------
    sets : of the well; the one that holds the verdict tells its gain in rpm, or how small a cause would be seen
    """
    own = next((each for each in sets if each.from_m <= row["from_m"] and row["to_m"] <= each.to_m), None)
    kind = _kind(row)
    return VerdictText(
        kind=kind,
        title={"none": "nothing wrong", "unproved": "nothing proved"}.get(kind, _title(row)),
        from_m=float(row["from_m"]),
        to_m=float(row["to_m"]),
        lead=_none(row, [own] if own else []) if kind in ("none", "unproved") else _lead(row),
        size=_size(row),
        doubt=_doubt(row, kind),
        gain=_gain(row, own),
        evidence=_evidence(row),
        action="" if kind in ("none", "unproved") else _action(row),
        probability=float(row["probability"]),
        family=str(row["family"]),
        decisive=_decisive(row, kind),
        learnt=_learnt(row),
    )


def _decisive(row: Mapping[Any, Any], kind: str) -> str:
    """Of something unknown, only a symptom's verdict tells what would decide it; the others tell where it shows."""
    if kind in ("none", "unproved") or (kind == "unknown" and _symptom(row) is None):
        return ""
    return str(row["what_would_separate"])


def _symptom(row: Mapping[Any, Any]) -> Symptom | None:
    """The symptom that a verdict is on; None where it is on none."""
    return next((each for each in SYMPTOMS.values() if str(row["evidence"]).startswith(each.meaning)), None)


def _kind(row: Mapping[Any, Any]) -> str:
    if row["verdict"] == NONE:
        return "none" if float(row["probability"]) >= EVEN_ODDS else "unproved"
    return "unknown" if row["verdict"] == UNKNOWN else "named"


def _title(row: Mapping[Any, Any]) -> str:
    names = risen(str(row["evidence"]))
    if names:
        return "rise of " + " and ".join(names)
    return words_of(str(row["verdict"]))


def _set_text(examined: xr.Dataset) -> SetText:
    return SetText(
        float(examined["from_m"]),
        float(examined["to_m"]),
        str(examined["advice"].item()),
        str(examined["missing_reading"].item()),
        _prediction(examined),
        tuple(_visible(examined)),
    )


def _prediction(examined: xr.Dataset) -> Prediction | None:
    speed, by_base, by_extended = (examined[f"period_{name}"].values / RPM for name in ("speed", "base", "extended"))
    base, extended, change = (_rms(each) for each in (speed - by_base, speed - by_extended, by_base - by_extended))
    if not np.isfinite(base) or change == 0:
        return None
    return Prediction(base, extended, float(examined["period_error"]) / RPM, change)


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _visible(examined: xr.Dataset) -> list[Visible]:
    """Causes by how far below their usual size they are seen."""
    names = [str(name) for name in examined["cause"].values]
    rows = zip(names, examined["smallest_detectable"].values, examined["typical_size"].values, strict=True)
    seen = [row for row in rows if row[0] in CATALOGUE and np.isfinite(row[1]) and not CATALOGUE[row[0]].size.fixed]
    return [
        Visible(
            name,
            float(smallest),
            size_text(smallest, CATALOGUE[name].size.unit, 2),
            size_text(usual, CATALOGUE[name].size.unit),
            bool(smallest <= usual),
        )
        for name, smallest, usual in sorted(seen, key=lambda row: row[1] / row[2])
    ]


def _with_article(cause: str) -> str:
    words = words_of(cause)
    return f"an {words}" if words[0] in "aeiou" else f"a {words}"


def _none(row: Mapping[Any, Any], own: Sequence[SetText]) -> Markup:
    """What a clear verdict says: also how small a cause would have been seen in its sets."""
    visible = {name: [each for one in own for each in one.visible if each.cause == name] for name in _SEEN_FIRST}
    seen = [found for found in visible.values() if len(found) == len(own) and all(each.below_usual for each in found)]
    clauses = [
        Markup("{} of {}").format(_with_article(found[0].cause), _range_text(found)) for found in seen[:3] if found
    ]
    would = Markup("")
    if clauses:
        would = Markup(" {} would have been detected.").format(_joined(clauses, "or"))
        would = would[:1] + would[1:2].upper() + would[2:]
    if _kind(row) == "none":
        return Markup("Nothing is wrong with the simulation here.") + would
    return Markup("Nothing is proved, although noise alone seldom gives such evidence.") + would


def _range_text(found: Sequence[Visible]) -> Markup:
    """The smallest size that was seen, or between which ends it was."""
    least, most = (end(found, key=lambda each: each.size).smallest for end in (min, max))
    return least if least == most else Markup("{} to {}").format(least, most)


def _joined(clauses: Sequence[Markup], word: str) -> Markup:
    if len(clauses) == 1:
        return clauses[0]
    return Markup(", ").join(clauses[:-1]) + Markup(" {} ").format(word) + clauses[-1]


def _lead(row: Mapping[Any, Any]) -> Markup:
    if row["verdict"] == UNKNOWN:
        symptom = _symptom(row)
        place = symptom.meaning if symptom else row["what_would_separate"] or f"in the part called {row['family']}"
        status = "that no known cause explains" if UNPROVED not in row["evidence"] else "whose cause is not proved yet"
        verb = "is" if float(row["probability"]) >= EVEN_ODDS else "may be"
        return Markup("Something {} wrong {}: {}.").format(verb, status, place)
    leads = [headline(row, name) for name in str(row["class"]).split("|")]
    if len(leads) == 1:
        return leads[0][:1].upper() + leads[0][1:] + Markup(".")
    return Markup("One of these, which the data cannot tell apart: {}.").format(Markup("; or ").join(leads))


def headline(row: Mapping[Any, Any], name: str) -> Markup:
    """What a driller would say of a cause that a verdict names, with the verdict's size where that is the cause's."""
    cause = CATALOGUE[name]
    sized = name == row["cause"] and _is_sized(row)
    of_size = ("size", *(positive for positive, _ in _SIGNED))
    if not cause.headline or (not sized and any(f"{{{word}}}" in cause.headline for word in of_size)):
        return escape(cause.described(str(row["evidence"])))
    negative = sized and row["size"] < 0
    place = Markup(" at {}").format(QUANTITIES["depth"].text(row["location_m"])) if _has_place(row) else Markup("")
    words = {positive: opposite if negative else positive for positive, opposite in _SIGNED}
    size = size_text(row["size"], cause.size.unit) if sized else Markup("")
    return Markup(cause.headline).format(size=size, place=place, **words)


def _is_sized(row: Mapping[Any, Any]) -> bool:
    """Whether the size is known and of what the verdict is on: that of an interval is of its damping, whatever rose."""
    names = risen(str(row["evidence"]))
    return bool(np.isfinite(row["size"])) and (not names or EVIDENCE["damping_pull"] in names)


def _has_place(row: Mapping[Any, Any]) -> bool:
    return bool(np.isfinite(row["location_m"]))


def _action(row: Mapping[Any, Any]) -> str:
    return CATALOGUE[row["cause"]].action if row["cause"] in CATALOGUE else _UNKNOWN_ACTION


def _size(row: Mapping[Any, Any]) -> Markup:
    """Name, size, interval and place of the most likely cause."""
    if row["cause"] not in CATALOGUE:
        return Markup("")
    cause = CATALOGUE[row["cause"]]
    parts = []
    if _is_sized(row) and not cause.size.fixed:
        subject = size_name(cause)
        if "|" in row["verdict"]:
            subject += f", if it is {words_of(row['cause'])}"
        ends = Markup("")
        if np.isfinite(row["size_low"]) and np.isfinite(row["size_high"]):
            low, high = (signed_size(row[end], cause.size.unit) for end in ("size_low", "size_high"))
            ends = Markup(" (95 % interval {} to {})").format(low, high)
        parts.append(Markup("{}: {}{}.").format(capitalised(subject), signed_size(row["size"], cause.size.unit), ends))
    members = [CATALOGUE[name] for name in str(row["class"]).split("|") if name in CATALOGUE]
    if _has_place(row):
        place = QUANTITIES["depth"].text(row["location_m"])
        parts.append(Markup("It is located {} along the string.").format(place))
    elif members and all(member.is_place for member in members):
        parts.append(Markup("The data do not determine its location along the string."))
    return Markup(" ").join(parts)


def size_name(cause: Cause) -> str:
    """What the size of a cause is as it is told: not the square, where `size_text` takes the root."""
    return cause.size.name.removesuffix(", squared")


def signed_size(value: float, unit: str) -> Markup:
    """The size of a cause with its sign, in units that one feels."""
    return Markup("\u2212") * (value < 0) + size_text(value, unit)


def capitalised(text: str) -> str:
    """The text as a sentence begins."""
    return text[:1].upper() + text[1:]


def _doubt(row: Mapping[Any, Any], kind: str) -> str:
    chance = percent(row["probability"])
    if kind in ("none", "unproved"):
        return f"The probability that nothing is wrong is {chance}."
    if kind == "unknown":
        return (
            f"The probability that no known cause is behind it is {chance}. This gives a place but no cause: more "
            "windows, or the measurement that is advised, may identify it."
        )
    word = "Clear" if row["probability"] >= _CLEAR else "Likely" if row["probability"] >= _LIKELY else "Doubtful"
    return f"{word}: the probability is {chance}."


def percent(probability: float) -> str:
    """A probability for readers; near zero or one, the limit that it is beyond."""
    return share(probability, 1.0).replace(">", "above").replace("<", "below")


def _gain(row: Mapping[Any, Any], own: SetText | None) -> Markup:
    """Error of the predicted speed in rpm where the model is extended, beside the log-likelihood."""
    gain, low, high = (row[f"predictive_gain{end}"] for end in ("", "_low", "_high"))
    if not np.isfinite(gain):
        return Markup("")
    felt = Markup("")
    # a rise between windows is not among what the set's model is extended by
    if own is not None and own.prediction is not None and not risen(str(row["evidence"])):
        felt = own.prediction.text + " "
    windows = int(row["held_out_windows"])
    data = f"{windows} window{'s' if windows > 1 else ''}" if windows else "data"
    ends = f" (90 % interval {digits(low)} to {digits(high)})" if np.isfinite(low) and np.isfinite(high) else ""
    return felt + Markup("Log-likelihood gained on {} it was not fitted to: {}{} per window.").format(
        data, digits(gain), ends
    )


def _learnt(row: Mapping[Any, Any]) -> str:
    """What the evidence says that was learnt, as a sentence."""
    words = words_of(str(row["evidence"])).partition(LEARNT)[2]
    return f"{capitalised(words)}." if words else ""


def _evidence(row: Mapping[Any, Any]) -> Markup:
    """What the engine saw, and the evidence apart from how common causes are."""
    words = words_of(str(row["evidence"])).partition(LEARNT)[0]
    parts = [Markup("{}.").format(capitalised(words))] if words else []
    nats = float(row.get("evidence_nats", np.nan))
    if np.isfinite(nats):
        favoured = "in favour of" if nats >= 0 else "against"
        parts.append(
            Markup(
                "Log Bayes factor {} {} this verdict, before the base rates of causes are taken into account."
            ).format(digits(abs(nats)), favoured)
        )
    return Markup(" ").join(parts)

"""Verdicts in plain words: cause, size, probability, predictive gain, and the action to take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from drillid.discrepancy import CATALOGUE
from drillid.discrepancy.rules import EVEN_ODDS
from drillid.discrepancy.sets import read_verdicts
from drillid.discrepancy.verdicts.verdict import UNPROVED

if TYPE_CHECKING:
    import xarray as xr

    from drillid.datasets.store import WellFolders

_UNKNOWN_ACTION = "Rely less on the model of these depths, and have the part of the rig that is named here inspected."
_CLEAR, _LIKELY = 0.95, 0.8
_NEARLY_ONE = 0.99


@dataclass(frozen=True)
class VerdictText:
    """One verdict for readers."""

    heading: str
    sentences: tuple[str, ...]
    """Cause, size, place, probability and predictive gain."""
    action: str
    """Action to take; empty where nothing is wrong."""
    doubt: str
    """What limits the verdict, or would decide it."""
    named: bool
    """Whether something is wrong."""


@dataclass(frozen=True)
class SetText:
    """Text on a whole set of windows."""

    from_m: float
    to_m: float
    advice: str
    missing: str
    """Interpretation of the missing immittance where the cause is unknown; else empty."""
    prediction: str
    """Errors of the predicted speed of a held-out window; empty where the model is not extended."""


def verdict_text(row: Mapping[Any, Any]) -> VerdictText:
    """Text for one row of verdicts.csv."""
    depths = f"{row['from_m']:.0f}–{row['to_m']:.0f} m"
    if row["verdict"] == "none":
        return _none(row, depths)
    return VerdictText(
        heading=f"{depths}: {_title(row)}",
        sentences=tuple(
            filter(None, (_cause(row), _size(row), _location(row), _probability(row), _predictive_gain(row)))
        ),
        action=CATALOGUE[row["cause"]].action if row["cause"] in CATALOGUE else _UNKNOWN_ACTION,
        doubt=_doubt(row),
        named=True,
    )


def read_verdict_texts(folders: WellFolders) -> tuple[tuple[VerdictText, ...], tuple[SetText, ...]]:
    """Texts of the verdicts and of the sets of windows of a well."""
    rows = read_verdicts(folders).to_dict("records")
    sets = folders.read("discrepancy", "examination").drop_dims(["window", "frequency"]).load()
    texts = tuple(
        SetText(
            float(examined["from_m"]),
            float(examined["to_m"]),
            str(examined["advice"].item()),
            _missing(examined),
            _prediction(examined),
        )
        for examined in (sets.isel(set=number) for number in range(sets.sizes["set"]))
    )
    return tuple(verdict_text(row) for row in rows), texts


def _missing(examined: xr.Dataset) -> str:
    return str(examined["missing_reading"].item())


def _prediction(examined: xr.Dataset) -> str:
    """Errors of the predicted speed in a held-out window, base against extended, beside the noise."""
    base, extended = (
        1e3 * float(np.sqrt(np.mean((examined["period_speed"] - examined[name]) ** 2)))
        for name in ("period_base", "period_extended")
    )
    if not np.isfinite(base) or base == extended:
        return ""
    noise = 1e3 * float(examined["period_error"])
    return (
        f"In a held-out window the speed response to the sweep is predicted with an error of {base:.1f} mrad/s rms "
        f"without and {extended:.1f} mrad/s with the named cause; the noise is {noise:.1f} mrad/s"
    )


def _title(row: Mapping[Any, Any]) -> str:
    return str(row["verdict"]).replace("|", " or ").replace("_", " ")


def _none(row: Mapping[Any, Any], depths: str) -> VerdictText:
    """Text for a verdict of none, and for one that is more likely wrong than right."""
    probability = float(row["probability"])
    if probability >= EVEN_ODDS:
        sentence = f"No fault of the simulation is found (probability {_percent(probability)})."
        return VerdictText(f"{depths}: nothing wrong", (sentence,), "", "", named=False)
    sentence = (
        "No cause is proved, but the evidence is seldom due to noise alone: the probability that the simulation is "
        f"right is {_percent(probability)}."
    )
    return VerdictText(f"{depths}: nothing proved", (sentence,), "", "", named=False)


def _cause(row: Mapping[Any, Any]) -> str:
    """The cause in plain words, or the members of the class of indistinguishable causes."""
    if row["verdict"] == "unknown":
        place = row["what_would_separate"] or f"in the part called {row['family']}"
        status = (
            "that no known cause explains" if UNPROVED not in row["evidence"] else "of which no cause is proved yet"
        )
        verb = "is" if float(row["probability"]) >= EVEN_ODDS else "may be"
        return f"Something {verb} wrong {status}: {place}."
    members: Sequence[str] = str(row["class"]).split("|")
    words = [CATALOGUE[name].described(str(row["evidence"])) for name in members]
    if len(words) == 1:
        return f"{words[0][0].upper()}{words[0][1:]}."
    return f"One of these: {'; or '.join(words)}. The data do not distinguish them."


def _size(row: Mapping[Any, Any]) -> str:
    if not np.isfinite(row["size"]) or not row["cause"]:
        return ""
    size = CATALOGUE[row["cause"]].size
    unit = "" if row["unit"] == "1" else f" {row['unit']}"
    ends = ""
    if np.isfinite(row["size_low"]) and np.isfinite(row["size_high"]):
        ends = f" (95 % interval {_number(row['size_low'])} to {_number(row['size_high'])}{unit})"
    subject = size.name if "|" not in row["verdict"] else f"{size.name}, if it is {row['cause'].replace('_', ' ')}"
    return f"{subject[0].upper()}{subject[1:]}: {_number(row['size'])}{unit}{ends}."


def _location(row: Mapping[Any, Any]) -> str:
    if np.isfinite(row["location_m"]):
        return f"It is located {row['location_m']:.0f} m along the string."
    members = [CATALOGUE[name] for name in str(row["class"]).split("|") if name in CATALOGUE]
    no_place = not members or not all(cause.is_place for cause in members)
    return "" if no_place else "The data do not determine its location along the string."


def _probability(row: Mapping[Any, Any]) -> str:
    if row["verdict"] == "unknown":
        evidence = f"{row['evidence'][:1].upper()}{row['evidence'][1:].replace('_', ' ')}. " if row["evidence"] else ""
        return f"{evidence}That no known cause is behind it has a probability of {_percent(row['probability'])}."
    word = "Clear" if row["probability"] >= _CLEAR else "Likely" if row["probability"] >= _LIKELY else "Doubtful"
    return f"{word}: the probability is {_percent(row['probability'])}."


def _predictive_gain(row: Mapping[Any, Any]) -> str:
    gain, low, high = (row[f"predictive_gain{end}"] for end in ("", "_low", "_high"))
    if not np.isfinite(gain):
        return ""
    ends = ""
    if np.isfinite(low) and np.isfinite(high):
        ends = f" (90 % interval {_number(low)} to {_number(high)})"
    windows = int(row["held_out_windows"])
    data = f"{windows} windows that it was not fitted to" if windows else "data that it was not fitted to"
    return f"Predictive gain on {data}: {_number(gain)}{ends} units of log-likelihood per window."


def _doubt(row: Mapping[Any, Any]) -> str:
    if row["verdict"] == "unknown":
        return "This gives a place and no cause: more windows, or the measurement advised below, may decide it."
    return f"What would decide it: {row['what_would_separate']}." if row["what_would_separate"] else ""


def _percent(probability: float) -> str:
    return "above 99 %" if probability > _NEARLY_ONE else f"{100 * probability:.0f} %"


def _number(value: float) -> str:
    """Three digits, and no more than a whole number needs."""
    if abs(value) >= 100:
        return f"{value:,.0f}".replace(",", "\u202f").replace("-", "−")
    return f"{value:.3g}".replace("-", "−")

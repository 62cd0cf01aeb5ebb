"""Verdicts in plain words: what is wrong, how large, how surely, what it is worth, and what to do about it."""

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

_UNKNOWN_ACTION = "Trust the model of these depths less, and have the part of the rig that is named here looked at."
_CLEAR, _LIKELY = 0.95, 0.8
_NEARLY_ONE = 0.99


@dataclass(frozen=True)
class Told:
    """One verdict for readers."""

    heading: str
    sentences: tuple[str, ...]
    """What it is, how large, how surely and what it is worth."""
    action: str
    """What to do; empty where nothing is wrong."""
    doubt: str
    """What speaks against it or would settle it."""
    named: bool
    """Something is wrong."""


@dataclass(frozen=True)
class SetWords:
    """What is told of a whole set of windows."""

    from_m: float
    to_m: float
    advice: str
    missing: str
    """Reading of what is missing where the cause is unknown; else empty."""
    prediction: str
    """How well the speed of a held-out window is predicted; empty where nothing extends the model."""


def told(row: Mapping[Any, Any]) -> Told:
    """Words for one row of verdicts.csv."""
    depths = f"{row['from_m']:.0f}–{row['to_m']:.0f} m"
    if row["verdict"] == "none":
        return _nothing(row, depths)
    return Told(
        heading=f"{depths}: {_title(row)}",
        sentences=tuple(filter(None, (_what(row), _size(row), _where(row), _surely(row), _predictive_gain(row)))),
        action=CATALOGUE[row["cause"]].action if row["cause"] in CATALOGUE else _UNKNOWN_ACTION,
        doubt=_doubt(row),
        named=True,
    )


def read_told(folders: WellFolders) -> tuple[tuple[Told, ...], tuple[SetWords, ...]]:
    """The verdicts of a well in words, and what is told of its sets."""
    rows = read_verdicts(folders.stage("discrepancy") / "verdicts.csv").to_dict("records")
    sets = folders.read("discrepancy", "examination").drop_dims(["window", "frequency"]).load()
    words = tuple(
        SetWords(float(one["from_m"]), float(one["to_m"]), str(one["advice"].item()), _missing(one), _prediction(one))
        for one in (sets.isel(set=number) for number in range(sets.sizes["set"]))
    )
    return tuple(told(row) for row in rows), words


def _missing(one: xr.Dataset) -> str:
    return str(one["missing_reading"].item())


def _prediction(one: xr.Dataset) -> str:
    """Errors of the predicted speed in a held-out window, base against extended, beside the noise."""
    base, extended = (
        1e3 * float(np.sqrt(np.mean((one["period_speed"] - one[name]) ** 2)))
        for name in ("period_base", "period_extended")
    )
    if not np.isfinite(base) or base == extended:
        return ""
    noise = 1e3 * float(one["period_error"])
    return (
        f"In a window that the models have not seen, the speed that the sweep drives is predicted to {base:.1f} mrad/s "
        f"without and {extended:.1f} mrad/s with the named cause, where noise is {noise:.1f} mrad/s"
    )


def _title(row: Mapping[Any, Any]) -> str:
    return str(row["verdict"]).replace("|", " or ").replace("_", " ")


def _nothing(row: Mapping[Any, Any], depths: str) -> Told:
    """Words for a verdict of none, and for one that is likelier wrong than right."""
    probability = float(row["probability"])
    if probability >= EVEN_ODDS:
        sentence = f"Nothing is found that the simulation gets wrong (probability {_percent(probability)})."
        return Told(f"{depths}: nothing wrong", (sentence,), "", "", named=False)
    sentence = (
        "Nothing is proved, but a trace is there that chance seldom leaves: the probability that the simulation gets "
        f"nothing wrong is {_percent(probability)}."
    )
    return Told(f"{depths}: nothing proved", (sentence,), "", "", named=False)


def _what(row: Mapping[Any, Any]) -> str:
    """The cause in plain words, or the members of the class."""
    if row["verdict"] == "unknown":
        place = row["what_would_separate"] or f"in the part called {row['family']}"
        open_to = (
            "that no known cause explains" if UNPROVED not in row["evidence"] else "of which no cause is proved yet"
        )
        surely = "is" if float(row["probability"]) >= EVEN_ODDS else "may be"
        return f"Something {surely} wrong {open_to}: {place}."
    members: Sequence[str] = str(row["class"]).split("|")
    words = [CATALOGUE[name].described(str(row["evidence"])) for name in members]
    if len(words) == 1:
        return f"{words[0][0].upper()}{words[0][1:]}."
    return f"One of these: {'; or '.join(words)}. The data cannot tell which."


def _size(row: Mapping[Any, Any]) -> str:
    if not np.isfinite(row["size"]) or not row["cause"]:
        return ""
    size = CATALOGUE[row["cause"]].size
    unit = "" if row["unit"] == "1" else f" {row['unit']}"
    ends = ""
    if np.isfinite(row["size_low"]) and np.isfinite(row["size_high"]):
        ends = f" (95 % interval {_figure(row['size_low'])} to {_figure(row['size_high'])}{unit})"
    subject = size.name if "|" not in row["verdict"] else f"{size.name}, if it is {row['cause'].replace('_', ' ')}"
    return f"{subject[0].upper()}{subject[1:]}: {_figure(row['size'])}{unit}{ends}."


def _where(row: Mapping[Any, Any]) -> str:
    if np.isfinite(row["location_m"]):
        return f"It sits {row['location_m']:.0f} m along the string."
    members = [CATALOGUE[name] for name in str(row["class"]).split("|") if name in CATALOGUE]
    placeless = not members or not all(cause.is_place for cause in members)
    return "" if placeless else "Where along the string it sits, the data do not tell."


def _surely(row: Mapping[Any, Any]) -> str:
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
        ends = f" (90 % interval {_figure(low)} to {_figure(high)})"
    windows = int(row["held_out_windows"])
    data = f"{windows} windows that it was not fitted to" if windows else "data that it was not fitted to"
    return f"Predictive gain on {data}: {_figure(gain)}{ends} units of log-likelihood per window."


def _doubt(row: Mapping[Any, Any]) -> str:
    if row["verdict"] == "unknown":
        return "This names a place and no cause: more windows, or the measurement advised below, may settle it."
    return f"What would settle it: {row['what_would_separate']}." if row["what_would_separate"] else ""


def _percent(probability: float) -> str:
    return "above 99 %" if probability > _NEARLY_ONE else f"{100 * probability:.0f} %"


def _figure(value: float) -> str:
    """Three digits, and no more than a whole number needs."""
    if abs(value) >= 100:
        return f"{value:,.0f}".replace(",", "\u202f").replace("-", "−")
    return f"{value:.3g}".replace("-", "−")

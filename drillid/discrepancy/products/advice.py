"""Which one further measurement would help a set of windows most, by the information that it would bring.

Every measurement is a change of evidence or data sheet about the fitted model. What causes can be told apart, and how
small each may be, follows from the projected information before anything is measured (Pukelsheim 2006, Optimal
Design of Experiments, chapter 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from drillid.arrays import Floats
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.inference.projection import columns, project, separation, smallest_detectable
from drillid.discrepancy.inference.set_model import Extension, Linearised, Point, SetModel, weighted
from drillid.discrepancy.rules import DETECTABLE
from drillid.fits.datasheet import DataSheet
from drillid.physics.dual_numbers import primal
from drillid.physics.responses import string_admittance

if TYPE_CHECKING:
    from drillid.discrepancy.catalogue import WindowModel
    from drillid.discrepancy.inference.screen import Screen
    from drillid.discrepancy.inference.set_fit import SetFit
    from drillid.discrepancy.verdicts.examination import Examination


_TIGHTER = 5.0
_FASTER = 1.3
_USUAL = {"delay_error": 0.005, "inertia_td_error": 0.05, "polar_moment_error": 0.05, "length_relative": 0.02}
"""What data sheets give where they give anything: s, then shares of the value."""
_DATA_SHEET = {
    "delay_error": "the drive's delay",
    "inertia_td_error": "the top drive's inertia",
    "polar_moment_error": "the pipe's size",
    "length_relative": "the string's length as waves see it",
}


@dataclass(frozen=True)
class Advice:
    """What one further measurement would bring."""

    measurement: str
    """In words."""
    separation: float
    """Distance in standard deviations between the two members of the class that are most alike; NaN without class."""
    smallest: float
    """Geometric mean over causes of the smallest detectable size, per that of today."""


@dataclass(frozen=True, eq=False)
class _Told:
    separation: Floats
    smallest: Floats


class _WithStringTorque(SetModel):
    """The string's torque measured too: its response to the speed, as exact as the mobility is."""

    def _whitened(self, window_model: WindowModel, count: int) -> Linearised:
        seen = super()._whitened(window_model, count)
        response = string_admittance(window_model.system, self.s) / window_model.recording.transfer(self.s)
        value = primal(response)
        relative = np.where(self.weight > 0, self.weight * np.abs(self.evidence.mobility), 0.0)
        weight = np.nan_to_num(relative) / np.abs(value)
        # what would be measured is not known; only how sharply it would tell
        residual, slopes = weighted(response, np.broadcast_to(value, weight.shape), weight, count)
        joined = [np.concatenate(pair, axis=-1) for pair in ((seen.residual, residual), (seen.jacobian, slopes))]
        return Linearised(*joined)


def identified_figures(found: Examination) -> SetFit:
    """The base model at the figures of the extended one: a cause left out would have bent those of the base fit."""
    point = found.extended.point
    return replace(found.base, point=Point(point.shared, point.local, np.empty(0)))


def best_shapes(screened: Screen) -> list[int]:
    """Places of the candidates: each cause at the shape with the best evidence."""
    best: dict[str, int] = {}
    for place, one in enumerate(screened.candidates):
        name = one.cause.name
        if name not in best or screened.log_evidence[place] > screened.log_evidence[best[name]]:
            best[name] = place
    return list(best.values())


def advise(found: Examination, members: Sequence[str]) -> list[Advice]:
    """Measurements that can be had, the one that would help most first.

    The criterion: for a class, the distance of its two most similar members at their usual sizes; otherwise the
    geometric mean of the smallest detectable sizes of all linear causes.

    Parameters
    ----------
    members : causes of the verdict
    """
    chosen = [found.before.candidates[place] for place in best_shapes(found.before)]
    today = _told(found.model, found, chosen)
    pair = [place for place, one in enumerate(chosen) if one.cause.name in members]
    advice = []
    for words, model in _measurements(found.model, identified_figures(found).point):
        told = _told(model, found, chosen)
        ratio = float(np.exp(np.mean(np.log(told.smallest / today.smallest))))
        advice.append(Advice(words, _nearest(told.separation, pair), ratio))
    if len(pair) > 1:
        return sorted(advice, key=lambda one: -one.separation)
    return sorted(advice, key=lambda one: one.smallest)


def today_separation(found: Examination, members: Sequence[str]) -> float:
    """Distance of the two most similar members of a class as things are."""
    chosen = [found.before.candidates[place] for place in best_shapes(found.before)]
    pair = [place for place, one in enumerate(chosen) if one.cause.name in members]
    return _nearest(_told(found.model, found, chosen).separation, pair)


def advice_text(found: Examination, members: Sequence[str]) -> str:
    """The best advice and the next best in a sentence."""
    best, second = advise(found, members)[:2]
    if np.isfinite(best.separation):
        now = today_separation(found, members)
        return (
            f"{_capital(best.measurement)} would help most: the two most similar causes of the class would then stand "
            f"{best.separation:.1f} standard deviations apart at their usual sizes, {now:.1f} today. Next comes "
            f"{second.measurement}, with {second.separation:.1f}"
        )
    return (
        f"{_capital(best.measurement)} would help most: causes could then be seen on average at "
        f"{100 * best.smallest:.0f} % of the size that can be seen today. Next comes {second.measurement}, with "
        f"{100 * second.smallest:.0f} %"
    )


def _capital(words: str) -> str:
    return words[0].upper() + words[1:]


def _nearest(distance: Floats, pair: Sequence[int]) -> float:
    return min((float(distance[i, j]) for i in pair for j in pair if i != j), default=float("nan"))


def _told(model: SetModel, found: Examination, chosen: Sequence[Extension]) -> _Told:
    """What a model with these data would tell at the identified figures."""
    identified = identified_figures(found)
    local = np.resize(identified.point.local, (model.evidence.windows, identified.point.local.shape[1]))
    fit = replace(identified, point=replace(identified.point, local=local))
    projection = project(model, fit, (), columns(model, fit, (), chosen))
    typical = np.array([one.cause.size.typical for one in chosen])
    return _Told(separation(projection, typical), smallest_detectable(projection, DETECTABLE))


def _measurements(model: SetModel, point: Point) -> list[tuple[str, SetModel]]:
    """Every measurement in words, with the model of a set that has it."""
    evidence = model.evidence
    found = [
        (words, model.with_evidence(replace(evidence, data_sheet=sheet))) for words, sheet in _better_sheets(evidence)
    ]
    if evidence.control is None:
        control = model.window_model_at(point).control(model.s)
        logged = np.broadcast_to(np.asarray(control, dtype=complex), evidence.mobility.shape)
        with_command = replace(evidence, control=logged, control_variance=np.zeros(logged.shape))
        found.append(("the torque command in the log", model.with_evidence(with_command)))
    found.append(("a measured torque of the string", _WithStringTorque(evidence, model.deviation)))
    found.append(("as many windows again", model.with_evidence(_joined(evidence, 1.0))))
    found.append(("as many windows again at a 30 % higher speed", model.with_evidence(_joined(evidence, _FASTER))))
    return found


def _better_sheets(evidence: Evidence) -> list[tuple[str, DataSheet]]:
    sheet = evidence.data_sheet
    scale = {"inertia_td_error": sheet.inertia_td, "polar_moment_error": sheet.polar_moment}
    better_sheets = []
    for name, words in _DATA_SHEET.items():
        error = float(getattr(sheet, name))
        given = np.isfinite(error)
        better: dict[str, Any] = {name: error / _TIGHTER if given else _USUAL[name] * scale.get(name, 1.0)}
        exact = " that is five times as exact" if given else ""
        better_sheets.append((f"a figure of {words}{exact}", replace(sheet, **better)))
    return better_sheets


def _joined(evidence: Evidence, faster: float) -> Evidence:
    """The windows twice, the second time at another speed."""
    rows = np.concatenate([np.arange(evidence.windows)] * 2)
    twice = evidence.subset(rows)
    factor = np.where(np.arange(rows.size) < evidence.windows, 1.0, faster)
    operating_points = replace(twice.operating_points, speed=twice.operating_points.speed * factor)
    return replace(twice, operating_points=operating_points, detections=())

"""Which further measurement would help a set of windows most, by the information that it would add.

Every measurement is a change of evidence or data sheet about the fitted model. How well causes can be separated, and
how small a cause can be detected, follows from the projected information before anything is measured (Pukelsheim 2006,
Optimal Design of Experiments, chapter 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from drillid.arrays import Floats
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.inference.coordinates import Extension, Point
from drillid.discrepancy.inference.measured_rows import MeasuredRows
from drillid.discrepancy.inference.projection import columns, project, separation, smallest_detectable
from drillid.discrepancy.inference.rows import Linearised, weighted
from drillid.discrepancy.inference.set_model import SetModel
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
"""Ratio of a stated tolerance to that of a better data sheet."""
_FASTER = 1.3
"""Ratio of the speed of further windows to that of the present ones."""
_USUAL = {"delay_error": 0.005, "inertia_td_error": 0.05, "polar_moment_error": 0.05, "length_relative": 0.02}
"""Usual tolerances of data sheets that state a value: s, then shares of the value."""
_DATA_SHEET = {
    "delay_error": "the drive's delay",
    "inertia_td_error": "the top drive's inertia",
    "polar_moment_error": "the pipe's size",
    "length_relative": "the string's length as waves see it",
}


@dataclass(frozen=True)
class Advice:
    """Benefit of one further measurement."""

    measurement: str
    """In words."""
    separation: float
    """Distance in standard deviations between the two most similar members of the class; NaN without a class."""
    smallest: float
    """Geometric mean over causes of the smallest detectable size, relative to the present one."""


@dataclass(frozen=True, eq=False)
class _Resolution:
    """Distances between causes, and the smallest detectable size of each."""

    separation: Floats
    smallest: Floats


class _WithStringTorque(MeasuredRows):
    """Rows with a measured string torque as well: its response to speed, with the relative error of the mobility."""

    def linearised(self, window_model: WindowModel, coordinates: int) -> Linearised:
        """Rows of the string torque are the last ones."""
        recorded = super().linearised(window_model, coordinates)
        response = string_admittance(window_model.system, self.s) / window_model.recording.transfer(self.s)
        value = primal(response)
        relative = np.where(self.weight > 0, self.weight * np.abs(self.evidence.mobility), 0.0)
        weight = np.nan_to_num(relative) / np.abs(value)
        # the measured values are not known, only their weight
        residual, slopes = weighted(response, np.broadcast_to(value, weight.shape), weight, coordinates)
        joined = [
            np.concatenate(pair, axis=-1) for pair in ((recorded.residual, residual), (recorded.jacobian, slopes))
        ]
        return Linearised(*joined)


def identified_fit(examination: Examination) -> SetFit:
    """The base model at the coordinates of the extended one, since a cause left out biases those of the base fit."""
    point = examination.extended.point
    return replace(examination.base, point=Point(point.shared, point.local, np.empty(0)))


def best_shapes(screened: Screen) -> list[int]:
    """Indices of the candidates with the best shape of each cause, by the evidence."""
    best: dict[str, int] = {}
    for index, candidate in enumerate(screened.candidates):
        name = candidate.cause.name
        if name not in best or screened.log_evidence[index] > screened.log_evidence[best[name]]:
            best[name] = index
    return list(best.values())


def advise(examination: Examination, members: Sequence[str]) -> list[Advice]:
    """Measurements that could be made, the most useful first.

    The criterion: for a class, the distance of its two most similar members at their usual sizes; otherwise the
    geometric mean of the smallest detectable sizes of all linear causes.

    Parameters
    ----------
    members : causes of the verdict
    """
    chosen = [examination.before.candidates[index] for index in best_shapes(examination.before)]
    present = _resolution(examination.model, examination, chosen)
    indices = _indices(chosen, members)
    advice = []
    for words, model in _measurements(examination.model, identified_fit(examination).point):
        resolution = _resolution(model, examination, chosen)
        ratio = float(np.exp(np.mean(np.log(resolution.smallest / present.smallest))))
        advice.append(Advice(words, _smallest_distance(resolution.separation, indices), ratio))
    if len(indices) > 1:
        return sorted(advice, key=lambda measurement: -measurement.separation)
    return sorted(advice, key=lambda measurement: measurement.smallest)


def present_separation(examination: Examination, members: Sequence[str]) -> float:
    """Distance between the two most similar members of a class with the present measurements."""
    chosen = [examination.before.candidates[index] for index in best_shapes(examination.before)]
    resolution = _resolution(examination.model, examination, chosen)
    return _smallest_distance(resolution.separation, _indices(chosen, members))


def advice_text(examination: Examination, members: Sequence[str]) -> str:
    """The two most useful measurements in a sentence."""
    best, second = advise(examination, members)[:2]
    if np.isfinite(best.separation):
        present = present_separation(examination, members)
        return (
            f"{_capitalised(best.measurement)} would help most: the two most similar causes of the class would then be "
            f"{best.separation:.1f} standard deviations apart at their usual sizes, {present:.1f} at present. The next "
            f"best is {second.measurement}, with {second.separation:.1f}"
        )
    return (
        f"{_capitalised(best.measurement)} would help most: causes could then be detected on average at "
        f"{100 * best.smallest:.0f} % of the size that is detectable at present. The next best is "
        f"{second.measurement}, with {100 * second.smallest:.0f} %"
    )


def _capitalised(words: str) -> str:
    return words[0].upper() + words[1:]


def _indices(chosen: Sequence[Extension], members: Sequence[str]) -> list[int]:
    """Indices of the members of a class."""
    return [index for index, candidate in enumerate(chosen) if candidate.cause.name in members]


def _smallest_distance(distance: Floats, indices: Sequence[int]) -> float:
    return min((float(distance[i, j]) for i in indices for j in indices if i != j), default=float("nan"))


def _resolution(model: SetModel, examination: Examination, chosen: Sequence[Extension]) -> _Resolution:
    """Resolution of causes by a model with its data, at the identified coordinates."""
    identified = identified_fit(examination)
    local = np.resize(identified.point.local, (model.evidence.windows, identified.point.local.shape[1]))
    fit = replace(identified, point=replace(identified.point, local=local))
    projection = project(model, fit, (), columns(model, fit, (), chosen))
    typical = np.array([candidate.cause.size.typical for candidate in chosen])
    return _Resolution(separation(projection, typical), smallest_detectable(projection, DETECTABLE))


def _measurements(model: SetModel, point: Point) -> list[tuple[str, SetModel]]:
    """Every measurement in words, with the model of the set as if that measurement had been made."""
    evidence = model.evidence
    measurements = [
        (words, model.with_evidence(replace(evidence, data_sheet=sheet))) for words, sheet in _better_sheets(evidence)
    ]
    if evidence.control is None:
        control = model.window_model_at(point).control(model.s)
        logged = np.broadcast_to(np.asarray(control, dtype=complex), evidence.mobility.shape)
        with_command = replace(evidence, control=logged, control_variance=np.zeros(logged.shape))
        measurements.append(("the torque command in the log", model.with_evidence(with_command)))
    measurements.append(("a measured torque of the string", model.beside(_WithStringTorque(evidence))))
    measurements.append(("as many windows again", model.with_evidence(_joined(evidence, 1.0))))
    measurements.append(
        ("as many windows again at a 30 % higher speed", model.with_evidence(_joined(evidence, _FASTER)))
    )
    return measurements


def _better_sheets(evidence: Evidence) -> list[tuple[str, DataSheet]]:
    sheet = evidence.data_sheet
    scale = {"inertia_td_error": sheet.inertia_td, "polar_moment_error": sheet.polar_moment}
    better_sheets: list[tuple[str, DataSheet]] = []
    for name, words in _DATA_SHEET.items():
        error = float(getattr(sheet, name))
        stated = np.isfinite(error)
        better: dict[str, Any] = {name: error / _TIGHTER if stated else _USUAL[name] * scale.get(name, 1.0)}
        measurement = f"a data-sheet value of {words}" + (" with a fifth of the tolerance" if stated else "")
        better_sheets.append((measurement, replace(sheet, **better)))
    return better_sheets


def _joined(evidence: Evidence, faster: float) -> Evidence:
    """The windows twice, the second time at a higher speed."""
    rows = np.concatenate([np.arange(evidence.windows)] * 2)
    twice = evidence.subset(rows)
    factor = np.where(np.arange(rows.size) < evidence.windows, 1.0, faster)
    operating_points = replace(twice.operating_points, speed=twice.operating_points.speed * factor)
    return replace(twice, operating_points=operating_points, detections=())

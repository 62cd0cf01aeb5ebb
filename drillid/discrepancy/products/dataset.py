"""The examination dataset: evidence, matrices, extended models and predictions of every set of a well."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from drillid.arrays import Complex
from drillid.datasets.examined import EXAMINATIONS
from drillid.datasets.measured import WINDOW_COORDINATES
from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.inference import unknown
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.inference.projection import columns, project, separation, smallest_detectable
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.shared_likelihood import candidate_labels, shared_candidates, shared_likelihood
from drillid.discrepancy.learning.examined import learnt_words
from drillid.discrepancy.learning.law_kinds import BitLaw, ControlLaw, CouplingLaw
from drillid.discrepancy.learning.law_spline import POINTS
from drillid.discrepancy.products.advice import advice_text, best_shapes, identified_fit
from drillid.discrepancy.products.extended_model import COORDINATES, extension_variables, parameters
from drillid.discrepancy.products.immittance import missing_immittance
from drillid.discrepancy.products.prediction import (
    PHASES,
    added_by_law,
    at_phases,
    driven,
    held_out_predictions,
    mean_period,
)
from drillid.discrepancy.products.reflectogram import reflectogram
from drillid.discrepancy.rules import DETECTABLE
from drillid.discrepancy.sets import ExaminedSet, WellData
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.verdict import LEARNT, UNKNOWN
from drillid.physics.parameters import PARAMETERS
from drillid.windows.channels import sample_rate, window_channels

Columns = dict[str, tuple[tuple[str, ...], Any]]


def examination_dataset(
    sets: Sequence[ExaminedSet], data: WellData, error_rate: float, common_causes: bool = False
) -> xr.Dataset:
    """All that is stored of the examinations of a well; an empty dataset where the well has no set.

    Parameters
    ----------
    error_rate : probability that noise alone passes the level of a reflectogram anywhere
    common_causes : whether to store the sets' statistics of causes that they may share with other wells
    """
    if not sets:
        return EXAMINATIONS.empty()
    windows = data.windows.sizes["window"]
    candidates = shared_candidates() if common_causes else []
    variables = [
        _set_variables(examined, data, error_rate) | _shared(examined.examination, candidates) for examined in sets
    ]
    stacked = {
        name: (("set", *dims), np.array([of_set[name][1] for of_set in variables]))
        for name, (dims, _) in variables[0].items()
    }
    dataset = xr.Dataset(stacked | _window_variables(sets, data) | extension_variables(sets, windows))
    return dataset.assign_coords(
        {name: data.mobility[name] for name in (*WINDOW_COORDINATES, "frequency")}
        | {
            "set": np.arange(len(sets)),
            "key": ("set", [""] * len(sets)),
            "cause": list(CATALOGUE),
            "cause_": list(CATALOGUE),
            "port": list(unknown.CHANNELS),
            "candidate": candidate_labels(candidates),
        }
        | {"parameter": list(PARAMETERS), "coordinate": list(COORDINATES)}
    )


def _window_variables(sets: Sequence[ExaminedSet], data: WellData) -> Columns:
    """Whitened residuals of base and extended model, the eight parameters of the latter, and each window's set."""
    shape = (data.windows.sizes["window"], data.mobility.sizes["frequency"])
    number = np.full(shape[0], -1)
    before, after = np.full((2, *shape), complex(np.nan, np.nan))
    values = np.full((shape[0], len(PARAMETERS)), np.nan)
    for index, examined in enumerate(sets):
        examination = examined.examination
        number[examined.rows] = index
        before[examined.rows] = _residual(examination, examination.base, ())
        after[examined.rows] = _residual(examination, examination.extended, examination.extensions)
        values[examined.rows] = parameters(examination.model, examination.extended.point)
    residual_dims = ("window", "frequency")
    return {
        "window_set": (("window",), number),
        "residual_before": (residual_dims, before),
        "residual_after": (residual_dims, after),
        "extended_value": (("window", "parameter"), values),
    }


def _residual(examination: Examination, fit: SetFit, extensions: tuple[Extension, ...]) -> Complex:
    """Whitened residuals of the mobilities, NaN where they are not used, (W, F)."""
    model = examination.model
    residual = model.residual(fit.point, extensions)[:, : model.s.size]
    return np.where(model.measured.weight > 0, residual, complex(np.nan, np.nan))


def _set_variables(examined: ExaminedSet, data: WellData, error_rate: float) -> Columns:
    """Variables of one set, without the dimension `set`."""
    examination = examined.examination
    model, extensions = examination.model, examination.extensions
    depth = model.evidence.operating_points.hole_depth
    # the first of the classes whose members are to be told apart
    members = next((verdict.members for verdict in examination.verdicts if len(verdict.members) > 1), ())
    before = reflectogram(model, examination.base, (), error_rate)
    after = reflectogram(model, examination.extended, extensions, error_rate) if extensions else before
    return {
        "verdict": ((), " + ".join(verdict.verdict for verdict in examination.verdicts)),
        "advice": ((), advice_text(examination, members)),
        "fingerprint": ((), json.dumps(examination.fingerprint.content()) if examination.fingerprint else ""),
        "from_m": ((), depth.min()),
        "to_m": ((), depth.max()),
        "p_value_before": ((), examination.before.p_value),
        "p_value_after": ((), examination.after.p_value),
        "distance": (("place",), before.distance),
        "reflection_before": (("place",), before.reflection),
        "reflection_after": (("place",), after.reflection),
        "reflection_level": (("place",), after.level),
        **_evidence(examination),
        **_separation(examination),
        **_missing(examination),
        **_held_out(examined, data),
        **_law(examination),
    }


def _evidence(examination: Examination) -> Columns:
    """Evidence for every cause, by its non-linear fit where there is one, and for something unknown at the ports."""
    by_cause = examination.before.by_cause
    if examination.posterior is not None:
        by_cause |= {cause.name: cause.log_evidence for cause in examination.posterior.fitted_causes}
    detections = {detection.cause: detection for detection in examination.detections}
    return {
        "log_evidence": (("cause",), [by_cause.get(name, np.nan) for name in CATALOGUE]),
        "detection_log_evidence": (
            ("cause",),
            [detections[name].log_evidence if name in detections else np.nan for name in CATALOGUE],
        ),
        "detection_p_value": (
            ("cause",),
            [detections[name].p_value if name in detections else np.nan for name in CATALOGUE],
        ),
        "unknown_evidence": (("port",), [examination.before.unknown[port] for port in unknown.CHANNELS]),
    }


def _separation(examination: Examination) -> Columns:
    """Smallest detectable sizes and distances of the linear causes at the identified fit and their best shapes."""
    chosen = [examination.before.candidates[index] for index in best_shapes(examination.before)]
    causes = [candidate.cause for candidate in chosen]
    names = list(CATALOGUE)
    rows = [names.index(cause.name) for cause in causes]
    fit = identified_fit(examination)
    projection = project(examination.model, fit, (), columns(examination.model, fit, (), chosen))
    smallest, typical = np.full((2, len(names)), np.nan)
    distance = np.full((len(names), len(names)), np.nan)
    typical[rows] = [cause.size.typical for cause in causes]
    smallest[rows] = smallest_detectable(projection, DETECTABLE)
    distance[np.ix_(rows, rows)] = separation(projection, typical[rows])
    return {
        "smallest_detectable": (("cause",), smallest),
        "typical_size": (("cause",), typical),
        "separation": (("cause", "cause_"), distance),
    }


def _shared(examination: Examination, candidates: Sequence[Extension]) -> Columns:
    """The set's statistics of causes that it may share with other wells."""
    kept = shared_likelihood(
        examination.model, examination.extended, examination.extensions, examination.before, candidates
    )
    at_sizes = ("part", "candidate", "held")
    dims = {"prior_error": ("rig_coordinate",), "sizes": ("candidate", "held"), "value": at_sizes}
    dims |= {"coordinates": ("candidate", "held", "rig_coordinate")}
    dims |= {"score": (*at_sizes, "rig_coordinate")}
    dims |= {"information": (*at_sizes, "rig_coordinate", "rig_coordinate_")}
    dims |= {"directions": ("part", "direction", "direction_")}
    return {f"shared_{name}": (dims.get(name, ()), value) for name, value in vars(kept).items()}


def _missing(examination: Examination) -> Columns:
    """The missing immittance where the verdict is unknown."""
    size = examination.model.s.size
    values, rational = np.full((2, size), complex(np.nan, np.nan))
    deviation, reading = np.full(size, np.nan), ""
    families = [verdict.family for verdict in examination.verdicts if verdict.verdict == UNKNOWN]
    ports = [family for family in families if family in unknown.PORTS]
    if ports:
        missing = missing_immittance(examination.model, examination.base, ports[0])
        values, rational, deviation = missing.values, missing.rational, missing.deviation
        active = (
            "" if missing.passive else " (it supplies energy in part of the band: the model is damped too much there)"
        )
        learnt = f"{LEARNT}{learnt_words(examination)}" if examination.extensions else ""
        reading = f"at the port {ports[0]}: {missing.reading}{active}{learnt}"
    return {
        "missing_immittance": (("frequency",), values),
        "missing_rational": (("frequency",), rational),
        "missing_deviation": (("frequency",), deviation),
        "missing_reading": ((), reading),
    }


def _law(examination: Examination) -> Columns:
    """The learnt law of bit, coupling or control; NaN without one."""
    law = examination.law
    columns: Columns = {
        name: (("law_point",), np.full(POINTS, np.nan))
        for kind in (BitLaw, CouplingLaw, ControlLaw)
        for name in kind.variables
    }
    memory = place = np.nan
    if law is not None:
        columns |= {name: (("law_point",), row) for name, row in zip(law.kind.variables, law.drawn(), strict=True)}
        memory = law.kind.memory if isinstance(law.kind, BitLaw) else np.nan
        place = np.nan if law.kind.place is None else law.kind.place
    return columns | {"law_memory": ((), memory), "coupling_place": ((), place)}


def _held_out(examined: ExaminedSet, data: WellData) -> Columns:
    """The held-out window's predictions over frequency, and over a period of its sweep where that repeats."""
    examination, model = examined.examination, examined.examination.model
    held_out = examination.law.held_out if examination.law is not None else None
    row, base, extended = held_out_predictions(examination, held_out)
    window = int(examined.rows[row])
    frequency = model.evidence.frequency
    time, speed, by_base, by_extended = np.full((4, PHASES), np.nan)
    error, period = np.nan, float(data.spectra["sweep_period"][window])
    channels = window_channels(data.records, data.windows, window, ("torque_sweep", "speed"))
    if period > 0 and np.isfinite(channels).all():
        rate, used = sample_rate(data.records), model.measured.weight[row] > 0
        band = float(frequency[used].min()), float(frequency[used].max())
        sweep, _ = mean_period(channels[0], rate, period, band)
        speed, error = mean_period(channels[1], rate, period, band)
        by_base, by_extended = (driven(prediction.mobility, sweep, period, band) for prediction in (base, extended))
        if examination.law is not None:
            own = channels[0], channels[1]
            by_extended = by_extended + added_by_law(examination, row, own, rate, band, sweep.size)
        time = np.arange(PHASES) * period / PHASES
        speed, by_base, by_extended = (at_phases(series) for series in (speed, by_base, by_extended))
    return {
        "held_out_window": ((), int(data.windows["window"][window])),
        "held_out_base": (("frequency",), base.mobility(frequency)),
        "held_out_extended": (("frequency",), extended.mobility(frequency)),
        "period_time": (("phase",), time),
        "period_speed": (("phase",), speed),
        "period_base": (("phase",), by_base),
        "period_extended": (("phase",), by_extended),
        "period_error": ((), error),
    }

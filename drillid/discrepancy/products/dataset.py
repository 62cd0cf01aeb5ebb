"""The examination dataset: evidence, matrices, extended models and predictions of every set of a well."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from drillid.arrays import Complex
from drillid.datasets.examined import EXAMINATIONS
from drillid.datasets.measured import WINDOW_COORDINATES
from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.inference import unknown
from drillid.discrepancy.inference.projection import columns, project, separation, smallest_detectable
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.set_model import Extension
from drillid.discrepancy.products.advice import advice_text, best_shapes, identified_figures
from drillid.discrepancy.products.extended_model import FIGURES, extension_variables, parameters
from drillid.discrepancy.products.immittance import missing_immittance
from drillid.discrepancy.products.prediction import PHASES, driven, held_out_predictions, in_band, mean_period
from drillid.discrepancy.products.reflectogram import reflectogram
from drillid.discrepancy.rules import DETECTABLE
from drillid.discrepancy.sets import ExaminedSet, WellData
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.verdict import UNKNOWN
from drillid.physics.parameters import PARAMETERS
from drillid.windows.channels import sample_rate, window_channels

Columns = dict[str, tuple[tuple[str, ...], Any]]


def examination_dataset(sets: Sequence[ExaminedSet], data: WellData, error_rate: float) -> xr.Dataset:
    """Everything that is kept of the examinations of a well; without a set, the dataset without a row.

    Parameters
    ----------
    error_rate : at which an echo of the reflectogram stands out
    """
    if not sets:
        return EXAMINATIONS.empty()
    windows = data.windows.sizes["window"]
    each = [_of_set(one, data, error_rate) for one in sets]
    stacked = {name: (("set", *dims), np.array([one[name][1] for one in each])) for name, (dims, _) in each[0].items()}
    dataset = xr.Dataset(stacked | _of_windows(sets, data) | extension_variables(sets, windows))
    return dataset.assign_coords(
        {name: data.mobility[name] for name in (*WINDOW_COORDINATES, "frequency")}
        | {
            "set": np.arange(len(sets)),
            "cause": list(CATALOGUE),
            "cause_": list(CATALOGUE),
            "port": list(unknown.CHANNELS),
        }
        | {"parameter": list(PARAMETERS), "coordinate": list(FIGURES)}
    )


def _of_windows(sets: Sequence[ExaminedSet], data: WellData) -> Columns:
    """Whitened residuals before and after, the eight parameters of the sets' models, and each window's set."""
    shape = (data.windows.sizes["window"], data.mobility.sizes["frequency"])
    number = np.full(shape[0], -1)
    before, after = np.full((2, *shape), complex(np.nan, np.nan))
    values = np.full((shape[0], len(PARAMETERS)), np.nan)
    for place, one in enumerate(sets):
        found = one.examination
        number[one.rows] = place
        before[one.rows] = _residual(found, found.base, ())
        after[one.rows] = _residual(found, found.extended, found.extensions)
        values[one.rows] = parameters(found.model, found.extended.point)
    residual_dims = ("window", "frequency")
    return {
        "window_set": (("window",), number),
        "residual_before": (residual_dims, before),
        "residual_after": (residual_dims, after),
        "extended_value": (("window", "parameter"), values),
    }


def _residual(found: Examination, fit: SetFit, extensions: tuple[Extension, ...]) -> Complex:
    """Whitened residuals of the mobilities, NaN where they are not used, (W, F)."""
    model = found.model
    residual = model.residual(fit.point, extensions)[:, : model.s.size]
    return np.where(model.weight > 0, residual, complex(np.nan, np.nan))


def _of_set(one: ExaminedSet, data: WellData, error_rate: float) -> Columns:
    """Variables of one set, without the dimension `set`."""
    found = one.examination
    depth = found.model.evidence.operating_points.hole_depth
    members = [name for verdict in found.verdicts for name in verdict.members]
    before = reflectogram(found.model, found.base, (), error_rate)
    after = reflectogram(found.model, found.extended, found.extensions, error_rate) if found.extensions else before
    return {
        "verdict": ((), " + ".join(verdict.verdict for verdict in found.verdicts)),
        "advice": ((), advice_text(found, members)),
        "from_m": ((), depth.min()),
        "to_m": ((), depth.max()),
        "p_value_before": ((), found.before.p_value),
        "p_value_after": ((), found.after.p_value),
        "distance": (("place",), before.distance),
        "reflection_before": (("place",), before.reflection),
        "reflection_after": (("place",), after.reflection),
        "reflection_level": (("place",), after.level),
        **_evidence(found),
        **_matrix(found),
        **_missing(found),
        **_held_out(one, data),
    }


def _evidence(found: Examination) -> Columns:
    """Evidence of every cause, by the best fit where there is one, and of the ports."""
    linear = found.before.by_cause
    if found.posterior is not None:
        linear |= {one.name: one.log_evidence for one in found.posterior.refined}
    detections = {one.cause: one for one in found.detections}
    return {
        "log_evidence": (("cause",), [linear.get(name, np.nan) for name in CATALOGUE]),
        "detection_log_evidence": (
            ("cause",),
            [detections[name].log_evidence if name in detections else np.nan for name in CATALOGUE],
        ),
        "detection_p_value": (
            ("cause",),
            [detections[name].p_value if name in detections else np.nan for name in CATALOGUE],
        ),
        "unknown_evidence": (("port",), [found.before.unknown[port] for port in unknown.CHANNELS]),
    }


def _matrix(found: Examination) -> Columns:
    """Smallest detectable sizes and distances of the linear causes at the identified figures and their best shapes."""
    chosen = [found.before.candidates[place] for place in best_shapes(found.before)]
    causes = [one.cause for one in chosen]
    names = list(CATALOGUE)
    rows = [names.index(cause.name) for cause in causes]
    fit = identified_figures(found)
    projection = project(found.model, fit, (), columns(found.model, fit, (), chosen))
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


def _missing(found: Examination) -> Columns:
    """The missing immittance where the verdict is unknown."""
    size = found.model.s.size
    values, rational = np.full((2, size), complex(np.nan, np.nan))
    deviation, reading = np.full(size, np.nan), ""
    ports = [one.family for one in found.verdicts if one.verdict == UNKNOWN and one.family in unknown.PORTS]
    if ports:
        missing = missing_immittance(found.model, found.base, ports[0])
        values, rational, deviation = missing.values, missing.rational, missing.deviation
        kind = "" if missing.passive else " (it gives energy somewhere: the model holds too much damping there)"
        reading = f"at the port {ports[0]}: {missing.reading}{kind}"
    return {
        "missing_immittance": (("frequency",), values),
        "missing_rational": (("frequency",), rational),
        "missing_deviation": (("frequency",), deviation),
        "missing_reading": ((), reading),
    }


def _held_out(one: ExaminedSet, data: WellData) -> Columns:
    """The held-out window's predictions over frequency, and over a period of its sweep where that repeats."""
    row, base, extended = held_out_predictions(one.examination)
    window = int(one.rows[row])
    frequency = one.examination.model.evidence.frequency
    time, speed, by_base, by_extended = np.full((4, PHASES), np.nan)
    error, period = np.nan, float(data.spectra["sweep_period"][window])
    channels = window_channels(data.records, data.windows, window, ("torque_sweep", "speed"))
    if period > 0 and np.isfinite(channels).all():
        rate, used = sample_rate(data.records), one.examination.model.weight[row] > 0
        band = float(frequency[used].min()), float(frequency[used].max())
        sweep, _ = mean_period(channels[0], rate, period)
        speed, error = mean_period(channels[1], rate, period)
        time, speed = np.arange(PHASES) * period / PHASES, in_band(speed, period, band)
        by_base, by_extended = (driven(each, sweep, period, band) for each in (base, extended))
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

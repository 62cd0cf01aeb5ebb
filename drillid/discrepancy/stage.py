"""Residual tests of the fitted models, and the engine's verdicts and extended models."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from drillid.arrays import Booleans, Complex, Floats, Integers
from drillid.datasets.codes import Gate
from drillid.datasets.measured import WINDOW_COORDINATES
from drillid.datasets.reuse import Memo, completed, row_keys
from drillid.datasets.store import Problem, WellFolders, windows_place
from drillid.discrepancy.base_rates import stated_base_rates
from drillid.discrepancy.products.interval_prediction import PREDICTION_COLUMNS, interval_prediction
from drillid.discrepancy.products.kept_sets import examine_well, joined
from drillid.discrepancy.rules import CHANGES_SHARE
from drillid.discrepancy.sets import WellData, all_verdicts, verdict_table, window_verdicts
from drillid.discrepancy.verdicts.intervals import (
    bridged,
    change_verdict,
    flag,
    interval_numbers,
    intervals,
    run_pulls,
    runs,
)
from drillid.discrepancy.verdicts.verdict import NONE, Verdict
from drillid.fits.datasheet import data_sheet, stored_controllers
from drillid.fits.window_fit import Measured, measured_rows
from drillid.physics.eight_parameters import KnownEquipment, drilling_system
from drillid.physics.responses import command_mobility, laplace
from drillid.statistics import to_normal

if TYPE_CHECKING:
    from drillid.config.listing import Well
    from drillid.config.settings import Settings


_REMEDY = "The noise or the model is not as assumed there; treat its stated errors with caution"
RESIDUAL_TESTS = {
    "normality_p_value": "are not Gaussian",
    "whiteness_p_value": "depend on their neighbours in frequency",
}
"""Tests of the whitened residuals that share the error rate, and what a failure says of these."""
_LAGS = 5
"""Largest lag, in frequencies, over which residuals are tested for correlation."""


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Residual tests, anomaly track, verdicts and extended models of a well."""
    data = WellData(
        well.rig,
        folders.read("records", "records"),
        folders.read("windows", "windows").load(),
        folders.read("spectra", "spectra").drop_dims(["spectrogram_time", "spectrogram_frequency"]).load(),
        folders.read("mobility", "mobility").load(),
        folders.read("fits", "fits").load(),
    )
    error_rate, run = settings.discrepancy.error_rate, runs(well.rig, data.windows["bit_depth"].values)
    parameters = {name: _estimate(data.fits, name) for name in ("damping_bha", "inertia_bha")}
    pulls = {
        track: run_pulls(*parameters[name], run)
        for track, name in (("damping_pull", "damping_bha"), ("inertia_pull", "inertia_bha"))
    }
    p_values = [p_value for _, p_value in pulls.values()]
    keys = row_keys(folders.basis, data.fits["key"].values.tolist())
    dataset = completed(
        folders.earlier("discrepancy", "discrepancy"),
        keys,
        "window",
        lambda rows: _residual_tests(data.at(np.array(rows))),
    )
    flagged = bridged(flag(p_values, error_rate * CHANGES_SHARE), run, list(parameters.values()))
    dataset = dataset.assign(
        {name: ("window", pull) for name, (pull, _) in pulls.items()} | {"flagged": ("window", flagged)}
    ).assign_coords({name: data.mobility[name] for name in (*WINDOW_COORDINATES, "frequency")})
    table = intervals(data.windows, dataset, run)
    members = [_inside_and_usual(number, data, dataset, run) for number in range(len(table))]
    table = table.assign(**_predictions(data, members))
    memo, earlier = Memo(folders, "discrepancy"), folders.earlier("discrepancy", "examination")
    base_rates, common_causes = stated_base_rates(settings.discrepancy), settings.common_causes.enabled
    sets = examine_well(data, error_rate * (1 - CHANGES_SHARE), base_rates, memo, earlier, common_causes)
    changes = [
        _change(row, inside, usual, parameters, p_values)
        for row, (inside, usual) in zip(table.to_dict("records"), members, strict=True)
    ]
    dataset["verdict"] = "window", window_verdicts(sets, changes, data.windows)
    folders.write("discrepancy", "discrepancy", dataset)
    folders.write("discrepancy", "examination", joined(sets, data), rig=well.rig.name)
    memo.save()
    folders.write_table("discrepancy", "intervals", table)
    folders.write_table("discrepancy", "verdicts", verdict_table(well.name, all_verdicts(sets, changes)))
    return _failed_tests(dataset.isel(window=data.fits["accepted"].values), error_rate)


def _residual_tests(data: WellData) -> xr.Dataset:
    """Whitened residuals of every window's own fit, and the p-values of their tests."""
    fits, mobility = data.fits, data.mobility
    residual = np.full(mobility["coherence"].shape, complex(np.nan, np.nan))
    p_values = np.full((2, residual.shape[0]), np.nan)
    # where no sweep repeats, the errors of next neighbours are correlated by about a tenth
    first_lag = np.where(data.spectra["sweep_period"].values > 0, 1, 2).tolist()
    for row, (measured, controller) in enumerate(zip(measured_rows(mobility), stored_controllers(fits), strict=True)):
        parameters = fits["value"].values[row]
        if np.isfinite(parameters).all():
            known = data_sheet(data.rig, controller, float(data.windows["bit_depth"][row])).equipment
            white = whitened_residuals(measured, parameters, known)
            residual[row, mobility["gate"].values[row] == Gate.USED] = white
            p_values[:, row] = normality_p_value(white), whiteness_p_value(white, first_lag[row])
    return xr.Dataset(
        {
            "whitened_residual": (("window", "frequency"), residual),
            "chi2_p_value": ("window", fits["fit_p_value"].values),
            "normality_p_value": ("window", p_values[0]),
            "whiteness_p_value": ("window", p_values[1]),
        }
    )


def _change(
    row: Mapping[Hashable, Any],
    inside: Booleans,
    usual: Booleans,
    parameters: Mapping[str, tuple[Floats, Floats]],
    p_values: Sequence[Floats],
) -> Verdict:
    """The verdict on one flagged interval."""
    tested = sum(int(np.isfinite(p_value).sum()) for p_value in p_values)
    p_value = min(tested * float(np.nanmin([track[inside] for track in p_values])), 1.0)
    return change_verdict(parameters, inside, usual, row["from_m"], row["to_m"], p_value, row["evidence"])


def _inside_and_usual(number: int, data: WellData, dataset: xr.Dataset, run: Integers) -> tuple[Booleans, Booleans]:
    """Windows of a flagged interval by its number, and those of its run that are not flagged, with an accepted fit."""
    flagged = dataset["flagged"].values
    known = np.isfinite(_estimate(data.fits, "damping_bha")[0])
    inside = interval_numbers(flagged, run) == number
    return inside & known, ~flagged & np.isin(run, run[inside]) & known


def _predictions(data: WellData, members: Sequence[tuple[Booleans, Booleans]]) -> dict[str, list[float]]:
    """Errors of the predicted speed in each flagged interval, and its noise, rad/s, by their columns."""
    rows = [interval_prediction(data, *each) for each in members]
    return {name: [row[place] for row in rows] for place, name in enumerate(PREDICTION_COLUMNS)}


def _estimate(fits: xr.Dataset, parameter: str) -> tuple[Floats, Floats]:
    """Value and standard error of a parameter, NaN where the fit is not accepted."""
    chosen = fits[["value", "standard_error"]].sel(parameter=parameter).where(fits["accepted"])
    return chosen["value"].values, chosen["standard_error"].values


def residual_level(error_rate: float, windows: int) -> float:
    """p-value below which a test of the residuals fails: tests and accepted windows share the error rate."""
    return error_rate / max(len(RESIDUAL_TESTS) * windows, 1)


def _failed_tests(dataset: xr.Dataset, error_rate: float) -> list[Problem]:
    """One row for the windows of a verdict whose residuals fail a test at the error rate, shared among windows and
    tests.
    """
    bound = residual_level(error_rate, dataset.sizes["window"])
    problems = []
    for name, meaning in RESIDUAL_TESTS.items():
        verdicts = dataset["verdict"].values
        failed = np.flatnonzero(dataset[name].values < bound)
        for verdict in dict.fromkeys(verdicts[failed].tolist()):
            rows = failed[verdicts[failed] == verdict]
            least = float(dataset[name].values[rows].min())
            problems.append(
                Problem(
                    windows_place(dataset, rows.tolist()),
                    f"the whitened residuals {meaning} (p-value {least:.2g}{' at the least' * (rows.size > 1)})",
                    _REMEDY if verdict in ("", NONE) else f"{_REMEDY}; the verdict there is {verdict}",
                )
            )
    return problems


def whitened_residuals(measured: Measured, parameters: Floats, known: KnownEquipment) -> Complex:
    """Measured less fitted mobility over the standard deviation of each component, transformed from Student's t to
    normal; shape (frequency,).
    """
    fitted = command_mobility(drilling_system(parameters, known), laplace(measured.frequency))
    ratio = (measured.mobility - fitted) * np.sqrt(2 / measured.variance)
    freedom = measured.degrees_of_freedom
    return to_normal(ratio.real, freedom) + 1j * to_normal(ratio.imag, freedom)


def normality_p_value(residual: Complex) -> float:
    """p-value of the residuals being standard normal (Kolmogorov–Smirnov over both components)."""
    from scipy.stats import kstest

    return float(kstest(np.concatenate([residual.real, residual.imag]), "norm").pvalue)


def whiteness_p_value(residual: Complex, first_lag: int = 1) -> float:
    """p-value of the residuals being uncorrelated between neighbouring frequencies (Ljung and Box 1978, complex).

    Parameters
    ----------
    residual : (frequency,)
    first_lag : distance from which on neighbours are tested, in frequencies
    """
    from scipy.special import chdtrc

    size = residual.size
    power = np.sum(np.abs(residual) ** 2)
    lags = np.arange(first_lag, first_lag + _LAGS)
    correlation = np.array([np.sum(residual[lag:] * np.conj(residual[:-lag])) / power for lag in lags.tolist()])
    statistic = 2 * size * (size + 2) * np.sum(np.abs(correlation) ** 2 / (size - lags))
    return float(chdtrc(2 * _LAGS, statistic))

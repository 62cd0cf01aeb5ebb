"""What the fitted models leave unexplained: whitened residuals, and parameters that leave their run's level."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from drillid.estimation import Measured
from drillid.fits import known_equipment, measured_rows
from drillid.physics.equipment import Controller
from drillid.physics.model import KnownEquipment, drilling_system
from drillid.physics.responses import command_mobility, laplace
from drillid.schema import WINDOW_COORDINATES, Gate
from drillid.statistics import to_normal
from drillid.store import Problem, WellFolders, window_place

if TYPE_CHECKING:
    from drillid.config import Settings
    from drillid.rig import Rig
    from drillid.sheets import Well

Floats = NDArray[np.float64]

_LAGS = 5
"""Neighbouring frequencies over which residuals are tested for dependence."""
_LEAST_WINDOWS = 6
"""Windows of one run below which there is no level to stand out of."""
_MEDIAN_VARIANCE = np.pi / 2
"""Variance of a Gaussian median, per that of the mean."""
_MAD_EFFICIENCY = 0.37
_TINY = 1e-300
_NORMAL_MAD = 1.4826
"""Standard deviation of a Gaussian per median absolute deviation."""
EVIDENCE = {"damping_pull": "BHA damping", "inertia_pull": "BHA inertia"}


def whitened_residuals(measured: Measured, parameters: Floats, known: KnownEquipment) -> NDArray[np.complex128]:
    """Measured less fitted mobility over the deviation of each component, as if Gaussian; shape (frequency,)."""
    fitted = command_mobility(drilling_system(parameters, known), laplace(measured.frequency))
    ratio = (measured.mobility - fitted) * np.sqrt(2 / measured.variance)
    freedom = measured.degrees_of_freedom
    return to_normal(ratio.real, freedom) + 1j * to_normal(ratio.imag, freedom)


def normality_probability(residual: NDArray[np.complex128]) -> float:
    """Chance of such residuals if standard normal (Kolmogorov–Smirnov over both components)."""
    from scipy.stats import kstest

    return float(kstest(np.concatenate([residual.real, residual.imag]), "norm").pvalue)


def whiteness_probability(residual: NDArray[np.complex128]) -> float:
    """Chance of such correlation between neighbouring frequencies if there is none (Ljung and Box 1978, complex)."""
    from scipy.special import chdtrc

    size = residual.size
    power = np.sum(np.abs(residual) ** 2)
    correlation = np.array([np.sum(residual[lag:] * np.conj(residual[:-lag])) / power for lag in range(1, _LAGS + 1)])
    statistic = 2 * size * (size + 2) * np.sum(np.abs(correlation) ** 2 / (size - np.arange(1, _LAGS + 1)))
    return float(chdtrc(2 * _LAGS, statistic))


def run_pulls(value: Floats, error: Floats, run: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """How far each window stands from the others of its run, and the chance of standing so far above them.

    The level is the median of the other windows. Two yardsticks are taken, and the larger chance
    of the two counts: the standard errors, as a Gaussian, and the others' own scatter (median
    absolute deviation, whose efficiency of 0.37 gives the degrees of freedom of a Student's t). So
    a run that is restless for a reason unknown flags no more often than a quiet one, and errors
    that are too small do not flag at all.

    Returns
    -------
    pull : deviation over the larger yardstick, shape (window,); NaN in a run of too few windows
    chance : shape (window,)
    """
    from scipy.special import ndtr, stdtr

    pulls, chances = np.full(value.shape, np.nan), np.full(value.shape, np.nan)
    for number in np.unique(run):
        members = np.flatnonzero((run == number) & np.isfinite(value) & np.isfinite(error))
        if members.size < _LEAST_WINDOWS:
            continue
        for member in members:
            others = members[members != member]
            level = np.median(value[others])
            scatter = max(_NORMAL_MAD * float(np.median(np.abs(value[others] - level) / error[others])), _TINY)
            deviation = np.sqrt(error[member] ** 2 + _MEDIAN_VARIANCE * np.mean(error[others] ** 2) / others.size)
            stated = (value[member] - level) / deviation
            pulls[member] = stated / max(1.0, scatter)
            freedom = _MAD_EFFICIENCY * (others.size - 1)
            chances[member] = max(ndtr(-stated), stdtr(freedom, -stated / scatter))
    return pulls, chances


def flag(chances: list[Floats], error_rate: float) -> NDArray[np.bool_]:
    """Windows that stand out upwards in any track, by Holm's step-down over all windows and tracks.

    The chance that a well without anything unusual has any flag is at most `error_rate`.
    """
    chance = np.concatenate(chances)
    order = np.argsort(np.where(np.isfinite(chance), chance, np.inf))
    bound = error_rate / np.arange(np.count_nonzero(np.isfinite(chance)), 0, -1)
    passed = chance[order][: bound.size] <= bound
    count = bound.size if passed.all() else int(np.argmin(passed))
    flagged = np.zeros(chance.size, dtype=bool)
    flagged[order[:count]] = True
    return np.asarray(flagged.reshape(len(chances), -1).any(axis=0), dtype=bool)


def intervals(windows: xr.Dataset, discrepancy: xr.Dataset, run: NDArray[np.int64]) -> pd.DataFrame:
    """Stretches of successive flagged windows of one run, a row each, with the evidence in words."""
    flagged = discrepancy["flagged"].values
    starts = np.flatnonzero(flagged & ~(np.roll(flagged, 1) & (np.roll(run, 1) == run) & (np.arange(run.size) > 0)))
    rows = []
    for first in starts:
        last = first
        while last + 1 < run.size and flagged[last + 1] and run[last + 1] == run[first]:
            last += 1
        members = slice(first, last + 1)
        strongest = {name: float(np.nanmax(discrepancy[name].values[members])) for name in EVIDENCE}
        said = [
            f"{EVIDENCE[name]} up by {pull:.1f} standard deviations" for name, pull in strongest.items() if pull > 2
        ]
        depth_from, depth_to = float(windows["depth_from"][first]), float(windows["depth_to"][last])
        rows.append((depth_from, depth_to, last - first + 1, *strongest.values(), "; ".join(said)))
    return pd.DataFrame(rows, columns=["from_m", "to_m", "windows", *EVIDENCE, "evidence"])


def runs(rig: Rig, bit_depth: Floats) -> NDArray[np.int64]:
    """Number of the bottom-hole assembly run that each bit depth (m) belongs to, by the tally."""
    beginnings = sorted(collars.from_depth for collars in rig.collars)
    return np.searchsorted(beginnings, bit_depth, side="right").astype(np.int64)


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Residual tests and the anomaly track of a well."""
    fits, mobility = folders.read("fits", "fits").load(), folders.read("mobility", "mobility").load()
    windows = folders.read("windows", "windows").load()
    controller = stored_controller(fits)
    residual = np.full(mobility["coherence"].shape, complex(np.nan, np.nan))
    chances = np.full((2, residual.shape[0]), np.nan)
    for row, measured in enumerate(measured_rows(mobility)):
        parameters = fits["value"].values[row]
        if np.isfinite(parameters).all():
            known = known_equipment(well.rig, controller, float(windows["bit_depth"][row]))
            white = whitened_residuals(measured, parameters, known)
            residual[row, mobility["gate"].values[row] == Gate.USED] = white
            chances[:, row] = normality_probability(white), whiteness_probability(white)
    run = runs(well.rig, windows["bit_depth"].values)
    tracks = {
        track: run_pulls(*_estimate(fits, parameter), run)
        for track, parameter in (("damping_pull", "damping_bha"), ("inertia_pull", "inertia_bha"))
    }
    dataset = xr.Dataset(
        {
            "whitened_residual": (("window", "frequency"), residual),
            "chi2_probability": ("window", fits["fit_probability"].values),
            "normality_probability": ("window", chances[0]),
            "whiteness_probability": ("window", chances[1]),
            **{name: ("window", pull) for name, (pull, _) in tracks.items()},
            "flagged": ("window", flag([chance for _, chance in tracks.values()], settings.discrepancy.error_rate)),
        },
        {name: mobility[name] for name in (*WINDOW_COORDINATES, "frequency")},
    )
    folders.write("discrepancy", "discrepancy", dataset)
    intervals(windows, dataset, run).to_csv(folders.stage("discrepancy") / "intervals.csv", index=False)
    return _failed_tests(dataset.isel(window=fits["accepted"].values), settings.discrepancy.error_rate)


def stored_controller(fits: xr.Dataset) -> Controller:
    """The controller that the fits took as given."""
    prefix = "controller_"
    return Controller(
        **{str(name)[len(prefix) :]: value for name, value in fits.attrs.items() if str(name).startswith(prefix)}
    )


def _estimate(fits: xr.Dataset, parameter: str) -> tuple[Floats, Floats]:
    """Value and standard error of a parameter, NaN where the fit is not accepted."""
    chosen = fits[["value", "standard_error"]].sel(parameter=parameter).where(fits["accepted"])
    return chosen["value"].values, chosen["standard_error"].values


def _failed_tests(dataset: xr.Dataset, error_rate: float) -> list[Problem]:
    """A row for each window whose residuals fail a test at the error rate, shared among windows and tests."""
    names = {
        "normality_probability": "are not Gaussian",
        "whiteness_probability": "depend on their neighbours in frequency",
    }
    bound = error_rate / max(len(names) * dataset.sizes["window"], 1)
    return [
        Problem(
            window_place(dataset, row),
            f"the whitened residuals {meaning} (chance {float(dataset[name][row]):.2g})",
            "The noise or the model is not as assumed there; read its errors with care",
        )
        for name, meaning in names.items()
        for row in np.flatnonzero(dataset[name].values < bound).tolist()
    ]

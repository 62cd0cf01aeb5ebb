"""Evidence about a set of windows from their time series, without the stages of a well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drillid.cross_spectra import stacked
from drillid.discrepancy.evidence import Conditions, Evidence, Knowledge
from drillid.discrepancy.gather import all_signs, assembled, prior
from drillid.discrepancy.signs import WindowRecord
from drillid.errors import EstimationError
from drillid.estimation import fit
from drillid.fits import measured_rows
from drillid.local_polynomial import local_spectra
from drillid.mobility import closed_loop_responses, gated_mobility
from drillid.periodic import line_spectra, sweep_period
from drillid.spectra import is_usual, usual_sweep

if TYPE_CHECKING:
    import xarray as xr

    from drillid.config import Settings
    from drillid.cross_spectra import Spectra

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Series:
    """One window's channels, each (samples,)."""

    sweep: Floats
    """N m."""
    speed: Floats
    """rad/s."""
    command: Floats
    """N m, sweep included; NaN where it is not logged."""


def gather(
    windows: Sequence[Series], rate: float, conditions: Conditions, knowledge: Knowledge, settings: Settings
) -> Evidence:
    """Evidence from time series: spectra, gate, a fit and the signs of each window.

    Parameters
    ----------
    rate : Hz
    conditions : how each of the windows was drilled
    settings : of spectra, mobility and fits

    Raises
    ------
    EstimationError
        If there are not as many conditions as windows, or no frequency passes the gate.
    """
    if len(windows) != conditions.bit_depth.size or not windows:
        raise EstimationError(
            "evidence", f"{len(windows)} windows and {conditions.bit_depth.size} conditions", "Give one for each window"
        )
    periods = np.array([sweep_period(one.sweep, rate, settings.spectra.frequency_minimum_hz) for one in windows])
    spectra = _spectra(windows, rate, periods, settings)
    mobility = gated_mobility(spectra, settings.mobility).merge(closed_loop_responses(spectra))
    known = knowledge.equipment
    fitted = np.stack(
        [
            fit(measured, known, prior(knowledge, float(depth)), settings.fits).value
            for measured, depth in zip(measured_rows(mobility), conditions.bit_depth, strict=True)
        ]
    )
    rows = zip(windows, periods, fitted, strict=True)
    records = [
        WindowRecord(*_channels(one), rate, float(period), own, known) if np.isfinite(own).all() else None
        for one, period, own in rows
    ]
    return assembled(mobility, conditions, knowledge, fitted, all_signs(records))


def _channels(window: Series) -> tuple[Floats, Floats, Floats]:
    return window.sweep, window.speed, window.command


def _spectra(windows: Sequence[Series], rate: float, periods: Floats, settings: Settings) -> xr.Dataset:
    """Spectra (window, frequency) on the grid of the usual sweep; `periods` are (window,)."""
    usual, frequency = usual_sweep(periods, settings.spectra, rate)
    lines = settings.spectra.noise_lines

    def of(window: Series, repeats: bool) -> Spectra:
        if repeats:
            return line_spectra(*_channels(window), rate, usual, frequency, lines)
        return local_spectra(*_channels(window), rate, frequency, lines // 4)

    return stacked([of(*row) for row in zip(windows, is_usual(periods, usual, rate), strict=True)], frequency)

"""The coherence gate: which frequencies of a window are used, and why others are not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from drillid.arrays import Floats
from drillid.datasets.codes import Gate
from drillid.mobility.responses import command_mobility
from drillid.statistics import mean_ratio_quantile, sharing

if TYPE_CHECKING:
    from drillid.config.settings import MobilitySettings

_SWEEP_FLOOR = 1e-2
"""Sweep power below this share of the median of the sweep's own lines counts as outside of the sweep: its own are those
above the square of this share of the strongest.

At each restart the sweep's slope jumps, so that a recorded sweep contains aliased frequencies, at 50 Hz about 10⁻⁷ of
its median power: 0.3 % of the amplitude at this floor, 0.03 % within the sweep's band."""


def gated_mobility(spectra: xr.Dataset, settings: MobilitySettings) -> xr.Dataset:
    """Command mobility (window, frequency) with the limits of its coherence, and the gate."""
    mobility = command_mobility(spectra)
    return mobility.merge(gate(spectra, mobility["coherence"], settings))


def gate(spectra: xr.Dataset, coherence: xr.DataArray, settings: MobilitySettings) -> xr.Dataset:
    """Least and largest admissible coherence of each frequency, and which frequencies pass.

    Coherence γ² of n averages corresponds to a signal-to-noise ratio F = (n − 1) γ²/(1 − γ²).
    Without response F follows F(2, 2ν), and the upper quantile at the error rate of its mean over a
    band gives the least coherence: a band passes or fails as a whole, so that no frequency is
    selected for its random error. With response F follows the non-central F; the
    best three neighbours of a band, each divided by its sweep power, determine its
    non-centrality, and its upper quantile, at the error rate shared among the band's
    frequencies, gives the largest coherence: above it the noise is implausibly small.
    """
    frequency = spectra["frequency"].values
    bands = np.floor(np.log2(frequency / frequency[0]) / settings.band_octaves).astype(int)
    shape, squared = coherence.shape, coherence.values
    signal = squared / np.maximum(1 - squared, 1e-12)
    numbers, freedoms = spectra["averages"].values, spectra["degrees_of_freedom"].values
    least, largest, gates = np.empty(shape), np.empty(shape), np.zeros(shape, dtype=np.int8)
    power = spectra["sweep_power"].values
    inside = power >= _SWEEP_FLOOR * _median_of_sweep(power)
    for row in range(shape[0]):
        for band in np.unique(bands):
            member = bands == band
            usable = member & inside[row]
            count = max(int(usable.sum()), 1)
            judged = usable if usable.any() else member
            averages, freedom = float(numbers[row, member].mean()), freedoms[row, member].mean()
            ratio = (averages - 1) * signal[row, usable]
            shared = sharing(freedoms[row, judged], numbers[row, judged])
            bound = mean_ratio_quantile(freedoms[row, judged], shared, settings.error_rate)
            best = _best_neighbours(ratio / power[row, usable]) if usable.any() else 0.0
            top = _largest_ratio(2 * best * power[row, member], freedom, settings.error_rate / count)
            least[row, member] = bound / (bound + averages - 1)
            largest[row, member] = top / (top + averages - 1)
            if usable.any() and ratio.mean() < bound:
                gates[row, member] = Gate.TOO_INCOHERENT
    gates[(gates == Gate.USED) & (squared > largest)] = Gate.TOO_COHERENT
    gates[~inside] = Gate.OUTSIDE_SWEEP
    dims = coherence.dims
    return xr.Dataset({"coherence_minimum": (dims, least), "coherence_maximum": (dims, largest), "gate": (dims, gates)})


def _median_of_sweep(power: Floats) -> Floats:
    """Median power (W, 1) of the lines that the sweep excites, of all (W, F): a multisine may leave out most lines."""
    own = [row[row >= _SWEEP_FLOOR**2 * row.max()] for row in power]
    return np.array([[np.median(row) if row.size else np.nan] for row in own])


def _largest_ratio(noncentrality: Floats, freedom: float, p_value: float) -> Floats:
    """Upper quantile of the non-central F(2, 2ν), by Patnaik's central approximation (1949)."""
    from scipy.special import fdtri

    matched = (2 + noncentrality) ** 2 / (2 + 2 * noncentrality)
    return np.asarray((2 + noncentrality) / 2 * fdtri(matched, 2 * max(freedom, 1e-3), 1 - p_value))


def _best_neighbours(ratio: Floats) -> float:
    width = min(3, ratio.size)
    return float(np.convolve(ratio, np.ones(width) / width, "valid").max())

"""Data of a well's figures: its datasets, and the choice of windows to show."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from drillid.arrays import Floats, Integers
from drillid.config.sheets import read_sheets
from drillid.datasets.codes import Gate
from drillid.datasets.registry import DATASETS
from drillid.datasets.store import WellFolders
from drillid.discrepancy import EVIDENCE
from drillid.discrepancy.rules import CHANGES_SHARE
from drillid.discrepancy.sets import read_verdicts
from drillid.discrepancy.stage import residual_level
from drillid.errors import SettingsError

if TYPE_CHECKING:
    from drillid.config.listing import Well
    from drillid.config.rig import Rig
    from drillid.config.settings import Settings


STAND_M = 30.0
"""m; intervals without windows up to this length are filled from the windows beside them."""
_LEAST_HEIGHT_M = 0.5
"""m; height at which a window without progress is drawn."""
_SUCCESSIVE = 6
"""Windows shown where there is no stack, as in the paper."""
_SETS = 3
"""Sets of windows shown beside each other."""


@dataclass(frozen=True)
class WellResults:
    """All datasets of one well, in memory; a row of `depth` is a row of `windows`."""

    name: str
    rig: Rig
    windows: xr.Dataset
    spectra: xr.Dataset
    mobility: xr.Dataset
    stacks: xr.Dataset
    fits: xr.Dataset
    stack_fits: xr.Dataset
    joint: xr.Dataset
    discrepancy: xr.Dataset
    examination: xr.Dataset
    verdicts: pd.DataFrame
    intervals: pd.DataFrame
    depth: xr.Dataset
    error_rate: float
    """Share of clean wells in which an interval may be flagged."""

    @staticmethod
    def load(well: Well, folders: WellFolders, error_rate: float) -> WellResults:
        """Read everything; the spectrograms stay lazy because one window of them is drawn.

        Raises
        ------
        SettingsError
            If an earlier version has made the results, without variables that there are now.
        """
        read = {
            name: folders.read(stage, name).load()
            for stage, name in (
                ("windows", "windows"),
                ("mobility", "mobility"),
                ("mobility", "stacks"),
                ("fits", "fits"),
                ("fits", "stack_fits"),
                ("fits", "joint"),
                ("discrepancy", "discrepancy"),
                ("discrepancy", "examination"),
                ("depth", "depth"),
            )
        }
        lacking = {
            name for held, dataset in read.items() for name in DATASETS[held].variables.keys() - dataset.variables
        }
        if lacking:
            what = f"has results of an earlier version, which lack {', '.join(sorted(lacking))}"
            raise SettingsError(f"well {well.name}", what, "Run the workflow, which redoes what an update changes")
        intervals = folders.read_table("discrepancy", "intervals")
        verdicts = read_verdicts(folders)
        spectra = folders.read("spectra", "spectra")
        return WellResults(
            well.name, well.rig, spectra=spectra, verdicts=verdicts, intervals=intervals, error_rate=error_rate, **read
        )

    @functools.cached_property
    def cells(self) -> DepthCells:
        """The windows in order of depth."""
        return DepthCells.of(self.windows)

    @functools.cached_property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency that a sweep reached in any window, Hz."""
        reached = (self.mobility["gate"] != Gate.OUTSIDE_SWEEP).any("window").values
        frequency = self.mobility["frequency"].values
        inside = frequency[reached] if reached.any() else frequency
        return float(inside[0]), float(inside[-1])

    @property
    def middle(self) -> int:
        """Row of the middle window; in a long well one near it, the same while the well grows by up to a quarter."""
        windows = self.windows.sizes["window"]
        coarse = max(windows.bit_length() - 3, 0)
        return (windows >> coarse << coarse) // 2

    def flagging_level(self) -> float:
        """Pull above which a single window is flagged: the first bound of Holm's step-down."""
        from scipy.special import ndtri

        tested = sum(int(np.isfinite(self.discrepancy[name].values).sum()) for name in EVIDENCE)
        return float(-ndtri(CHANGES_SHARE * self.error_rate / tested)) if tested else float("nan")

    def residual_level(self) -> float:
        """p-value below which a test of the residuals fails; NaN without any accepted window."""
        accepted = int(np.count_nonzero(self.fits["accepted"].values))
        return residual_level(self.error_rate, accepted) if accepted else float("nan")


def stored_results(settings: Settings, name: str) -> WellResults:
    """The datasets of a well listed in the sheets, as a run has left them.

    Raises
    ------
    SettingsError
        If there is no such well, its rig description cannot be read, or it has no results.
    """
    listings = {listing.name: listing for listing in read_sheets(settings).values()}
    if name not in listings:
        raise SettingsError(name, "is not a well of the wells sheet", f"Choose one of {', '.join(listings)}")
    folders = WellFolders(Path(settings.results), listings[name].folder, name=name)
    if not folders.has("depth", "depth") or not folders.read("depth", "depth").sizes["depth"]:
        raise SettingsError(f"well {name}", f"has no results in {settings.results}", "Run the workflow first")
    return WellResults.load(listings[name].load(), folders, settings.discrepancy.error_rate)


def shown_sets(examination: xr.Dataset) -> list[int]:
    """The sets that a figure of several sets shows: the most telling ones, in order of depth."""
    return sorted(_telling(examination)[:_SETS])


def shown_set(examination: xr.Dataset) -> int | None:
    """The set that a figure of a single set shows: the most telling one."""
    return next(iter(_telling(examination)), None)


def _telling(examination: xr.Dataset) -> list[int]:
    """All sets: first those with a cause in their model, then by their p-value, then by their windows."""
    sets = examination["set"].values
    extended = np.isin(sets, examination["extension_set"].values)
    windows = np.array([np.count_nonzero(examination["window_set"].values == number) for number in sets])
    return [int(row) for row in np.lexsort((-windows, examination["p_value_before"].values, ~extended))]


@dataclass(frozen=True)
class SuccessiveWindows:
    """Successive windows that are drawn together: their rows, and the row of their stack or None."""

    rows: list[int]
    stack: int | None


def successive_windows(results: WellResults) -> SuccessiveWindows:
    """The windows of the largest stack, the most central of several; without a stack the middle six."""
    total, stacks = results.windows.sizes["window"], results.stacks
    if stacks.sizes["stack"]:
        windows = results.windows["window"].values
        first = np.searchsorted(windows, stacks["first_window"].values)
        last = np.searchsorted(windows, stacks["last_window"].values)
        off_centre = np.abs((first + last) / 2 - results.middle)
        chosen = int(np.lexsort((off_centre, first - last))[0])
        return SuccessiveWindows(list(range(int(first[chosen]), int(last[chosen]) + 1)), chosen)
    begin = max(0, min(results.middle - _SUCCESSIVE // 2, total - _SUCCESSIVE))
    return SuccessiveWindows(list(range(begin, min(begin + _SUCCESSIVE, total))), None)


@dataclass(frozen=True)
class DepthCells:
    """Windows in order of depth as cells of an image; intervals without windows longer than a stand stay empty.

    order : row of the window in each cell, −1 for an empty cell, shape (cell,)
    edges : depths between the cells, shape (cell + 1,), m
    measured : from and to of each window in order of depth, shape (window, 2), m
    """

    order: Integers
    edges: Floats
    measured: Floats

    @staticmethod
    def of(windows: xr.Dataset) -> DepthCells:
        """Cells of a well's windows."""
        extent = np.sort(np.stack([windows["depth_from"].values, windows["depth_to"].values], axis=1), axis=1)
        centre, height = extent.mean(axis=1), np.maximum(extent[:, 1] - extent[:, 0], _LEAST_HEIGHT_M)
        sequence = np.argsort(centre, kind="stable")
        top, bottom = (centre - height / 2)[sequence], (centre + height / 2)[sequence]
        order, edges = [int(sequence[0])], [float(top[0])]
        for row in range(1, sequence.size):
            if top[row] - bottom[row - 1] > STAND_M:
                edges += [float(bottom[row - 1]), float(top[row])]
                order += [-1, int(sequence[row])]
            else:
                edges.append(float(bottom[row - 1] + top[row]) / 2)
                order.append(int(sequence[row]))
        edges.append(float(bottom[-1]))
        return DepthCells(np.array(order), np.maximum.accumulate(edges), extent[sequence])

    def image(self, rows: Floats) -> np.ma.MaskedArray[tuple[int, ...], np.dtype[np.float64]]:
        """Rows of shape (window, …) as rows of the image, empty cells and non-finite values masked."""
        cells = np.where((self.order < 0)[:, None], np.nan, rows[self.order])
        return np.ma.masked_invalid(cells)


def cell_edges(points: Floats) -> Floats:
    """Edges halfway between increasing points, shape (point + 1,)."""
    if points.size == 1:
        return np.array([points[0] * 0.99, points[0] * 1.01])
    inner = (points[1:] + points[:-1]) / 2
    return np.concatenate([[points[0] - (inner[0] - points[0])], inner, [points[-1] + (points[-1] - inner[-1])]])


def drilled_length(rig: Rig, bit_depth: Floats) -> Floats:
    """Pipe length by depth: bit depth less the collars of the run, shape (window,), m."""
    collars = [rig.collars_at(float(depth)) for depth in bit_depth]
    return np.asarray(bit_depth - np.array([run.length if run else 0.0 for run in collars]), dtype=float)

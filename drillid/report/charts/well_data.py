"""Numbers behind the charts of a well: one row for each window in order of depth, in metric units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from drillid.arrays import Complex, Floats, Integers
from drillid.datasets.codes import Gate
from drillid.figures.data import WellResults, cell_edges
from drillid.figures.windows import degrees
from drillid.report.quantities import QUANTITIES
from drillid.statistics import TWO_SIDED

_MAP_BYTES = 1.0e6
"""What the maps of a well may take in its page, of which base64 makes 4/3."""
_MAPS, _ROW_BYTES = 10, 130
"""Maps of a well, and bytes that a row takes beside its values."""
_LEAST_COLUMNS, _MOST_COLUMNS = 48, 160
_LEAST_PROMINENCE = 0.02
"""Of a mode, in the logarithm of the bit's mobility."""
PARAMETERS_SHOWN = ("kappa", "delta", "damping_bha", "inertia_bha")


@dataclass(frozen=True)
class Channel:
    """A column of the windows with its quantity; '' where it has no unit that changes."""

    column: str
    name: str
    quantity: str
    decimals: int = 1


OPERATION = (
    Channel("weight", "Weight on bit", "weight", 0),
    Channel("rotation", "Rotation", "rotation", 0),
    Channel("torque", "Torque", "torque", 1),
    Channel("flow", "Flow", "flow", 0),
    Channel("pressure", "Stand-pipe pressure", "pressure", 0),
    Channel("penetration", "Rate of penetration", "penetration", 1),
)
"""What the rig did, in the order of the tracks."""


def metric(values: Any, quantity: str) -> Floats:
    """SI values in the metric unit of a quantity."""
    chosen = QUANTITIES[quantity]
    return np.asarray(values, dtype=float) / chosen.metric.factor(chosen.si_unit)


def in_order(results: WellResults) -> Integers:
    """Rows of the windows in order of depth."""
    cells = results.cells
    return cells.order[cells.order >= 0]


def cell_columns(results: WellResults) -> dict[str, Any]:
    """Depths of the windows, of their cells in maps, and their times; rows in order of depth."""
    cells, rows = results.cells, in_order(results)
    own = np.flatnonzero(cells.order >= 0)
    windows = results.windows.isel(window=rows)
    return {
        "window": windows["window"].values.astype(int),
        "depth": windows["hole_depth"].values,
        "depth_from": cells.measured[:, 0],
        "depth_to": cells.measured[:, 1],
        "cell_top": cells.edges[own],
        "cell_bottom": cells.edges[own + 1],
        "cell_height": np.maximum(np.diff(cells.edges)[own], 1e-3),
        "start": [str(np.datetime_as_string(each, unit="m")).replace("T", " ") for each in windows["start"].values],
    }


def operation_columns(results: WellResults) -> dict[str, Floats]:
    """What the rig did in each window; columns of NaN where a channel is not logged."""
    windows = results.windows.isel(window=in_order(results))
    seconds = (windows["end"].values - windows["start"].values) / np.timedelta64(1, "s")
    lowest = results.depth["lowest_stable_speed"].values[in_order(results)]
    return {
        "weight": metric(windows["weight_on_bit"].values, "weight"),
        "rotation": metric(windows["speed"].values, "rotation"),
        "lowest_rotation": metric(lowest, "rotation"),
        "torque": metric(windows["torque"].values, "torque"),
        "flow": metric(windows["flow"].values, "flow"),
        "pressure": metric(windows["standpipe_pressure"].values, "pressure"),
        "penetration": metric((windows["depth_to"].values - windows["depth_from"].values) / seconds, "penetration"),
    }


def parameter_columns(results: WellResults, name: str, factor: float) -> dict[str, Floats]:
    """A parameter of each window with its 95 % interval, and the band from all windows together.

    Parameters
    ----------
    factor : of SI values
    """
    rows = in_order(results)
    fit = results.fits.sel(parameter=name).isel(window=rows)
    joint = results.joint.sel(parameter=name).isel(window=rows)
    value, margin = fit["value"].values * factor, TWO_SIDED * fit["standard_error"].values * factor
    ends = {"": "value", "_lower": "lower", "_upper": "upper"}
    return {
        name: value,
        f"{name}_low": value - margin,
        f"{name}_high": value + margin,
        **{f"{name}_joint{end}": joint[variable].values * factor for end, variable in ends.items()},
    }


def coherence(results: WellResults) -> Floats:
    """Median coherence of each window over the frequencies that its sweep reached, in order of depth."""
    rows = in_order(results)
    inside = results.mobility["gate"].values[rows] != Gate.OUTSIDE_SWEEP
    values = np.where(inside, results.mobility["coherence"].values[rows], np.nan)
    return np.array([np.median(row[np.isfinite(row)]) if np.isfinite(row).any() else np.nan for row in values])


def control_columns(results: WellResults) -> dict[str, Floats]:
    """Gains with the least bit vibration and the present ones, in order of depth."""
    rows = in_order(results)
    depth = results.depth.isel(depth=rows)
    return {
        f"{state}_{gain}": metric(depth[f"{state}_{gain}"].values, gain)
        for state in ("tuned", "present")
        for gain in ("proportional", "integral")
    }


def state_shares(results: WellResults) -> dict[str, Floats]:
    """Share of each rig state in the time since the window before, in order of depth, by the state's name."""
    depth = results.depth.isel(depth=in_order(results))
    seconds = depth["state_time"].values
    total = np.maximum(seconds.sum(axis=1, keepdims=True), 1e-9)
    return {str(state): column for state, column in zip(depth["state"].values, (seconds / total).T, strict=True)}


@dataclass(frozen=True)
class Maps:
    """Rows of the maps: of every window, or of some evenly chosen ones where there are many."""

    rows: Integers
    """Rows of the windows in order of depth, that is of `cell_columns`."""
    frequency: Floats
    """Hz, evenly spaced on the logarithmic axis, shape (column,)."""
    lag: Floats
    """s, shape (lag,)."""
    images: dict[str, Floats]
    """By name, shape (row, column) or (row, lag)."""
    modes: list[Floats]
    """Of each row: modes of the whole system, Hz."""


def maps(results: WellResults) -> Maps:
    """Mobilities, residuals and steps of the windows on few enough points for a page."""
    order = in_order(results)
    most_rows = int(_MAP_BYTES / (_MAPS * (_ROW_BYTES + _LEAST_COLUMNS * 16 / 3)))
    rows = np.unique(np.linspace(0, order.size - 1, min(order.size, most_rows)).round().astype(int))
    budget = (_MAP_BYTES / (_MAPS * rows.size) - _ROW_BYTES) * 3 / 16
    count = int(np.clip(budget, _LEAST_COLUMNS, _MOST_COLUMNS))
    chosen, frequency = order[rows], results.depth["frequency"].values
    grid = np.geomspace(*results.band, count)
    nearest = np.abs(frequency[:, None] - grid).argmin(axis=0)
    depth, lag = results.depth.isel(depth=chosen), results.depth["lag"].values
    stride = max(1, round(lag.size / count))
    used = depth["gate"].values == Gate.USED
    measured = np.where(used, depth["command_mobility"].values, complex(np.nan, np.nan))[:, nearest]
    fitted, stiff, controlled = (
        _between(depth[name].values, frequency, grid)
        for name in ("command_mobility_fitted", "bit_mobility_stiff", "bit_mobility_controlled")
    )
    images = {
        "measured": np.abs(measured),
        "measured_phase": degrees(measured),
        "fitted": np.abs(fitted),
        "fitted_phase": degrees(fitted),
        "coherence_map": depth["coherence"].values[:, nearest],
        "bit_stiff": np.abs(stiff),
        "bit_controlled": np.abs(controlled),
        "step_stiff": depth["bit_step_stiff"].values[:, ::stride],
        "step_controlled": depth["bit_step_controlled"].values[:, ::stride],
        **_residuals(results, chosen, grid),
    }
    modes = [_modes(row, frequency) for row in depth["bit_mobility_controlled"].values]
    return Maps(rows, grid, lag[::stride], images, modes)


def _between(rows: Complex, frequency: Floats, grid: Floats) -> Complex:
    """Rows of a model, which is smooth, at the frequencies of a finer grid than theirs."""
    return np.array([np.interp(grid, frequency, row) for row in rows], dtype=complex)


def _residuals(results: WellResults, chosen: Integers, grid: Floats) -> dict[str, Floats]:
    """Amplitude of the residuals in standard deviations; 'after' only where a cause extends a model."""
    examined = results.examination
    if not examined.sizes["set"]:
        return {}
    frequency = results.depth["frequency"].values
    before = np.abs(examined["residual_before"].values[chosen]) / np.sqrt(2)
    residuals = {"residual_before": _mean_near(before, frequency, grid)}
    if examined.sizes["extension"]:
        after = np.abs(examined["residual_after"].values[chosen]) / np.sqrt(2)
        residuals["residual_after"] = _mean_near(after, frequency, grid)
    return residuals


def _mean_near(values: Floats, frequency: Floats, grid: Floats) -> Floats:
    """Root mean square of the columns around each frequency of the grid; of the nearest one where it is finer."""
    edges, nearest = np.exp(cell_edges(np.log(grid))), np.abs(frequency[:, None] - grid).argmin(axis=0)
    first = np.minimum(np.searchsorted(frequency, edges[:-1]), nearest)
    end = np.maximum(np.searchsorted(frequency, edges[1:]), nearest + 1)
    square, counted = np.nan_to_num(values**2), np.isfinite(values).astype(float)
    sums = (np.pad(np.cumsum(each, axis=1), ((0, 0), (1, 0))) for each in (square, counted))
    total, count = (each[:, end] - each[:, first] for each in sums)
    mean_square: Floats = np.where(count > 0, total / np.maximum(count, 1.0), np.nan)
    return np.sqrt(np.maximum(mean_square, 0.0))


def _modes(bit_mobility: Complex, frequency: Floats) -> Floats:
    """Peaks of the controlled bit mobility, Hz."""
    from scipy.signal import find_peaks

    amplitude = np.abs(bit_mobility)
    if not np.isfinite(amplitude).all():
        return np.array([])
    return np.asarray(frequency[find_peaks(np.log(amplitude), prominence=_LEAST_PROMINENCE)[0]])

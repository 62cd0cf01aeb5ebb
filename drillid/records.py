"""Raw logs → one regular SI series of a well, with a flag for whatever was done to a sample."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from drillid.clock import Ticks, place_rows, share_of_real_jitter
from drillid.errors import LogError
from drillid.formats import read_log
from drillid.grid import LOOK, Grid, Note, clock_notes
from drillid.repair import FAST_CHANNELS, Repair
from drillid.rig import CHANNEL_UNITS, REQUIRED_CHANNELS, Rig
from drillid.store import Problem, WellFolders
from drillid.units import to_si_factor

if TYPE_CHECKING:
    from drillid.config import RecordsSettings, Settings
    from drillid.sheets import Well

_FEWEST_VALUES = 10
"""A column with fewer values counts as empty."""


@dataclass(frozen=True)
class Record:
    """One log as a regular series, and what was done to make it one.

    samples : variables of the RECORDS schema but `log`
    rate : samples per second
    notes : what was done (sentence, remedy)
    """

    samples: xr.Dataset
    rate: float
    notes: tuple[Note, ...]


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Read every log of a well and write its records, log by log; without any usable log there is no store."""
    readable, problems = _in_time_order(well.logs, well.rig)
    rate: float | None = None
    end: np.datetime64 | None = None
    number = 0
    with folders.appending("records", "records") as append:
        for path in readable:
            try:
                record = regular_record(
                    path, well.rig, settings.records, None if end is None else int(end.astype(np.int64))
                )
                samples, late = _after(record.samples, end, path)
                _check_rate(record.rate, rate, path)
            except LogError as error:
                problems.append(Problem(error.where, error.what, error.remedy))
                continue
            problems += [Problem(path.name, what, remedy) for what, remedy in (*record.notes, *late)]
            append(samples.assign(log=("time", np.full(samples.sizes["time"], number))))
            rate, end, number = record.rate, samples["time"].values[-1], number + 1
    return problems


def _in_time_order(logs: tuple[Path, ...], rig: Rig) -> tuple[list[Path], list[Problem]]:
    """Logs by their first stamp, and the logs of which not even the time can be read."""
    starts, problems = [], []
    for path in logs:
        try:
            stamps = read_log(path, rig.time.column, [], rig.time.zone).index
            starts.append((stamps.min(), path))
        except LogError as error:
            problems.append(Problem(error.where, error.what, error.remedy))
    return [path for _, path in sorted(starts)], problems


def _after(samples: xr.Dataset, end: np.datetime64 | None, path: Path) -> tuple[xr.Dataset, list[Note]]:
    """Samples later than the end of the log before, and a note on those that are not."""
    late = 0 if end is None else int(np.searchsorted(samples["time"].values, end, side="right"))
    if late == samples.sizes["time"]:
        raise LogError(str(path), "lies wholly within the time of the logs before it; not used", "List each log once")
    if late == 0:
        return samples, []
    what = f"its first {late} samples overlap the log before it and are not used"
    return samples.isel(time=slice(late, None)), [(what, "List logs that do not overlap")]


def _check_rate(rate: float, usual: float | None, path: Path) -> None:
    if usual is not None and abs(rate / usual - 1) > 1e-9:
        raise LogError(
            str(path),
            f"is sampled at {rate:.6g} Hz, the well's other logs at {usual:.6g} Hz; not used",
            "Export all logs of a well at one rate, or list them as another well",
        )


def regular_record(path: Path, rig: Rig, settings: RecordsSettings, anchor: int | None = None) -> Record:
    """Read one log and put it on a regular grid.

    Parameters
    ----------
    path : the log
    rig : its columns, units, clock
    anchor : time of a sample whose grid this one joins where it can, ns since 1970 UTC

    Raises
    ------
    LogError
        If the log cannot be read or placed on a grid.
    """
    log = read_channels(path, rig)
    sweep, speed = (log[name].to_numpy() for name in ("torque_sweep", "speed"))
    stamps = log.index.to_numpy().astype("datetime64[ns]").astype(np.int64)
    ticks = place_rows(stamps, sweep, speed, rig.time.sample_rate, anchor, str(path))
    grid = Grid.of(ticks)
    notes = clock_notes(ticks, grid, rig.time.sample_rate)
    log = log.iloc[ticks.rows]
    if share_of_real_jitter(log["torque_sweep"].to_numpy(), ticks) > 0.5:
        log = moved_to_ticks(log, ticks)
        rms = 1e3 * float(np.std(ticks.jitter))
        notes.append((f"samples were taken off the regular clock ({rms:.2f} ms rms); interpolated to it", LOOK))
    repair = Repair(grid, ticks.rate, settings)
    channels = {name: repair.channel(name, log[name].to_numpy()) for name in CHANNEL_UNITS if name in log}
    repair.find_stuck(channels)
    repair.note_holes()
    nowhere = np.full(grid.size, np.nan)
    variables = {name: ("time", channels.get(name, nowhere)) for name in CHANNEL_UNITS} | {
        "flags": ("time", repair.flags)
    }
    return Record(xr.Dataset(variables, coords={"time": grid.time}), ticks.rate, (*notes, *repair.notes))


def read_channels(path: Path, rig: Rig) -> pd.DataFrame:
    """Channels of a log in SI units, NaN where it holds no value; an empty optional column is left out.

    Raises
    ------
    LogError
        If the log cannot be read or a needed channel holds no value.
    """
    raw = read_log(path, rig.time.column, [channel.column for channel in rig.channels.values()], rig.time.zone)
    channels = {
        name: raw[column.column].to_numpy() * to_si_factor(column.unit, CHANNEL_UNITS[name])
        for name, column in rig.channels.items()
    }
    empty = [name for name, values in channels.items() if np.sum(np.isfinite(values)) < _FEWEST_VALUES]
    needed = [rig.channels[name].column for name in REQUIRED_CHANNELS if name in empty]
    if needed:
        raise LogError(
            str(path), f"column '{needed[0]}' holds no values", "Correct the rig description's columns, or the export"
        )
    return pd.DataFrame({name: values for name, values in channels.items() if name not in empty}, index=raw.index)


def moved_to_ticks(log: pd.DataFrame, ticks: Ticks) -> pd.DataFrame:
    """Fast channels interpolated from the times of their stamps to the ticks; rows as in `ticks.rows`."""
    from scipy.interpolate import CubicSpline

    taken = ticks.tick / ticks.rate + ticks.jitter
    moved = log.copy()
    for name in FAST_CHANNELS:
        if name in log:
            values = log[name].to_numpy()
            good = np.isfinite(values) & np.concatenate([[True], np.diff(taken) > 0])
            moved[name] = np.where(
                np.isfinite(values), CubicSpline(taken[good], values[good])(ticks.tick / ticks.rate), np.nan
            )
    return moved

"""Raw logs → one regular SI series of a well, with a flag for whatever was done to a sample."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from drillid.clock import FEWEST_ROWS, Ticks, place_rows, rate_tolerance, share_of_real_jitter, too_few_rows
from drillid.errors import LogError
from drillid.formats import read_log
from drillid.grid import LOOK, End, Grid, Note, clock_notes, following
from drillid.repair import FAST_CHANNELS, Repair
from drillid.rig import CHANNEL_UNITS, REQUIRED_CHANNELS, Rig
from drillid.store import Problem, WellFolders
from drillid.units import to_si_factor

if TYPE_CHECKING:
    from drillid.config import RecordsSettings, Settings
    from drillid.sheets import Well

_RATE_TOLERANCE = 0.01
"""Largest share by which the rate of a log's stamps may be off the nominal rate."""


@dataclass(frozen=True)
class Record:
    """One log as a regular series, and what was done to make it one.

    samples : variables of the RECORDS schema but `log`
    end : where the next log may join
    notes : what was done (sentence, remedy)
    """

    samples: xr.Dataset
    end: End
    notes: tuple[Note, ...]


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Read every log of a well and write its records, log by log; without any usable log there is no store."""
    readable, problems = _in_time_order(well.logs, well.rig)
    end: End | None = None
    number = 0
    with folders.appending("records", "records") as append:
        for path in readable:
            try:
                record = regular_record(path, well.rig, settings.records, end)
                samples, late = _after(record.samples, end, path)
            except LogError as error:
                problems.append(Problem(error.where, error.what, error.remedy))
                continue
            problems += [Problem(path.name, what, remedy) for what, remedy in (*record.notes, *late)]
            append(samples.assign(log=("time", np.full(samples.sizes["time"], number))))
            end, number = record.end, number + 1
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


def _after(samples: xr.Dataset, end: End | None, path: Path) -> tuple[xr.Dataset, list[Note]]:
    """Samples later than the end of the log before, and a note on those that are not."""
    last = None if end is None else np.datetime64(end.time, "ns")
    late = 0 if last is None else int(np.searchsorted(samples["time"].values, last, side="right"))
    if late == samples.sizes["time"]:
        raise LogError(str(path), "lies wholly within the time of the logs before it; not used", "List each log once")
    if late == 0:
        return samples, []
    what = f"its first {late} samples overlap the log before it and are not used"
    return samples.isel(time=slice(late, None)), [(what, "List logs that do not overlap")]


def _check_rate(ticks: Ticks, stated: float | None, path: Path) -> None:
    """Refuse a log that is sampled at another rate than the stated one or, without that, the well's other logs."""
    if abs(ticks.found / ticks.rate - 1) <= rate_tolerance(int(ticks.tick[-1]), _RATE_TOLERANCE):
        return
    if stated is not None:
        raise LogError(
            str(path),
            f"its stamps tell {ticks.found:.4g} samples per second, the rig description {stated:.4g}",
            "Correct the sample rate in the rig description, or leave it out",
        )
    raise LogError(
        str(path),
        f"is sampled at {ticks.found:.6g} Hz, the well's other logs at {ticks.rate:.6g} Hz; not used",
        "Export all logs of a well at one rate, or list them as another well",
    )


def regular_record(path: Path, rig: Rig, settings: RecordsSettings, before: End | None = None) -> Record:
    """Read one log and put it on a regular grid.

    Parameters
    ----------
    path : the log
    rig : its columns, units, clock
    before : end of the log before, whose rate and ticks this one takes on

    Raises
    ------
    LogError
        If the log cannot be read or placed on a grid.
    """
    log = read_channels(path, rig)
    sweep, speed = (log[name].to_numpy() for name in ("torque_sweep", "speed"))
    stamps = log.index.to_numpy().astype("datetime64[ns]").astype(np.int64)
    rate, anchor = (before.rate, before.time) if before else (rig.time.sample_rate, None)
    ticks = place_rows(stamps, sweep, speed, rate, anchor, str(path))
    _check_rate(ticks, rig.time.sample_rate, path)
    ticks = ticks if before is None else following(ticks, before)
    grid = Grid.of(ticks)
    notes = clock_notes(ticks, grid)
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
    return Record(xr.Dataset(variables, coords={"time": grid.time}), End.of(ticks), (*notes, *repair.notes))


def read_channels(path: Path, rig: Rig) -> pd.DataFrame:
    """Channels of a log in SI units, NaN where it holds no value; an empty optional column is left out.

    Raises
    ------
    LogError
        If the log cannot be read or a needed channel holds no value.
    """
    raw = read_log(path, rig.time.column, [channel.column for channel in rig.channels.values()], rig.time.zone)
    if len(raw) < FEWEST_ROWS:
        raise too_few_rows(str(path), len(raw))
    channels = {
        name: raw[column.column].to_numpy() * to_si_factor(column.unit, CHANNEL_UNITS[name])
        for name, column in rig.channels.items()
    }
    held = {name: int(np.sum(np.isfinite(values))) for name, values in channels.items()}
    empty = [name for name, values in held.items() if values < FEWEST_ROWS]
    needed = next((name for name in REQUIRED_CHANNELS if name in empty), None)
    if needed:
        values = f"only {held[needed]} values of the {FEWEST_ROWS} needed" if held[needed] else "no values"
        raise LogError(
            str(path),
            f"column '{rig.channels[needed].column}' holds {values}",
            "Correct the rig description's columns, or the export",
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

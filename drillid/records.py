"""Raw logs → one regular SI series of a well, with a flag for whatever was done to a sample."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from drillid.clock import Ticks, place_rows, share_of_real_jitter
from drillid.errors import LogError
from drillid.formats import read_log
from drillid.quality import runs, spikes, stuck
from drillid.rig import CHANNEL_UNITS, REQUIRED_CHANNELS, Rig
from drillid.schema import RecordFlag
from drillid.store import Problem, WellFolders
from drillid.units import to_si_factor

if TYPE_CHECKING:
    from drillid.config import RecordsSettings, Settings
    from drillid.sheets import Well

Floats = NDArray[np.float64]
Flags = NDArray[np.uint8]
Integers = NDArray[np.int64]

FAST_CHANNELS = ("torque_command", "torque_sweep", "speed")
"""Channels the dynamics are read from; the others are slow and only tell the rig's state."""
_LONGEST_STORED_GAP_S = 300.0
"""Gaps up to this length are stored as missing samples; longer ones only show in the times."""
_SLOW_HOLD = 5.0
"""A slow channel is interpolated over up to this many of its own intervals."""
_KEPT = "They are flagged and left as missing; look at the recorder if this recurs"
_REPLACED = "Replaced samples are flagged; look at the recorder if this recurs"


@dataclass(frozen=True)
class Record:
    """One log as a regular series, and what was done to make it one.

    samples : variables of the RECORDS schema but `log`
    rate : samples per second
    notes : what was done (sentence, remedy)
    """

    samples: xr.Dataset
    rate: float
    notes: tuple[tuple[str, str], ...]


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Read every log of a well and write its records, log by log.

    Raises
    ------
    LogError
        If no log of the well can be used.
    """
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
    if rate is None:
        raise LogError(
            f"well {well.name}",
            f"none of its {len(well.logs)} logs can be used",
            "See the rows of the problems table for each of them",
        )
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


def _after(samples: xr.Dataset, end: np.datetime64 | None, path: Path) -> tuple[xr.Dataset, list[tuple[str, str]]]:
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
    grid = _Grid.of(ticks)
    notes = _clock_notes(ticks, grid, rig.time.sample_rate)
    log = log.iloc[ticks.rows]
    if share_of_real_jitter(log["torque_sweep"].to_numpy(), ticks) > 0.5:
        log = _moved_to_ticks(log, ticks)
        rms = 1e3 * float(np.std(ticks.jitter))
        notes.append(
            (f"samples were taken off the regular clock ({rms:.2f} ms rms); interpolated at their stamps", _REPLACED)
        )
    flags = grid.flags.copy()
    channels: dict[str, tuple[str, Floats]] = {}
    for name in CHANNEL_UNITS:
        values = np.full(grid.size, np.nan)
        if name in log:
            values[grid.position[grid.first]] = log[name].to_numpy()[grid.first]
            fill = _fast_channel if name in FAST_CHANNELS else _slow_channel
            values = fill(name, values, ticks.rate, settings, grid, flags, notes)
        channels[name] = ("time", values)
    _flag_stuck({name: values for name, (_, values) in channels.items()}, ticks.rate, settings, grid, flags, notes)
    notes += _gap_notes(flags, grid, ticks.rate)
    samples = xr.Dataset({**channels, "flags": ("time", flags)}, coords={"time": grid.time})
    return Record(samples, ticks.rate, tuple(notes))


def read_channels(path: Path, rig: Rig) -> pd.DataFrame:
    """Channels of a log in SI units, NaN where it holds no value; an empty optional column is left out.

    Raises
    ------
    LogError
        If the log cannot be read or a needed channel holds no value.
    """
    wanted = {name: rig.channels[name] for name in rig.channels}
    raw = read_log(path, rig.time.column, [column.column for column in wanted.values()], rig.time.zone)
    channels = {
        name: raw[column.column].to_numpy() * to_si_factor(column.unit, CHANNEL_UNITS[name])
        for name, column in wanted.items()
    }
    empty = [name for name, values in channels.items() if not np.any(np.isfinite(values))]
    needed = [rig.channels[name].column for name in REQUIRED_CHANNELS if name in empty]
    if needed:
        raise LogError(
            str(path), f"column '{needed[0]}' holds no value", "Correct the rig description's columns, or the export"
        )
    return pd.DataFrame({name: values for name, values in channels.items() if name not in empty}, index=raw.index)


@dataclass(frozen=True)
class _Grid:
    """Stored samples: position of each row, the rows that are first on theirs, time and the clock's flags of each sample."""

    size: int
    position: Integers
    first: NDArray[np.bool_]
    time: NDArray[np.datetime64]
    flags: Flags
    left_out: tuple[tuple[int, float], ...]

    @classmethod
    def of(cls, ticks: Ticks) -> _Grid:
        apart = np.diff(ticks.tick)
        left_out = np.where(apart > _LONGEST_STORED_GAP_S * ticks.rate, apart - 1, 0)
        position = ticks.tick - np.concatenate([[0], np.cumsum(left_out)])
        size = int(position[-1]) + 1
        first = np.concatenate([[True], apart > 0])
        tick = np.arange(size) + np.repeat(
            np.concatenate([[0], np.cumsum(left_out[left_out > 0])]),
            np.diff(np.concatenate([[0], position[1:][left_out > 0], [size]])),
        )
        flags = np.zeros(size, np.uint8)
        flags[position[~first]] |= np.uint8(RecordFlag.DUPLICATE)
        flags[np.searchsorted(tick, ticks.duplicate)] |= np.uint8(RecordFlag.DUPLICATE)
        flags[position[[step.row for step in ticks.steps]]] |= np.uint8(RecordFlag.CLOCK_STEP)
        gaps = tuple((int(position[row]), float(left_out[row] / ticks.rate)) for row in np.flatnonzero(left_out))
        return cls(size, position, first, ticks.times(tick), flags, gaps)

    def at(self, position: int) -> str:
        """Time of a sample for messages."""
        return str(self.time[position].astype("datetime64[ms]"))


def _moved_to_ticks(log: pd.DataFrame, ticks: Ticks) -> pd.DataFrame:
    """Fast channels interpolated from the stamps to the ticks."""
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


def _fast_channel(
    name: str,
    values: Floats,
    rate: float,
    settings: RecordsSettings,
    grid: _Grid,
    flags: Flags,
    notes: list[tuple[str, str]],
) -> Floats:
    """Replace spikes, fill short holes by a cubic spline, flag the rest as gaps."""
    missing = np.isnan(values)
    whole = np.interp(np.arange(values.size), np.flatnonzero(~missing), values[~missing])
    spiky = spikes(whole, rate, settings.spike_error_rate) & ~missing
    holes = missing | spiky
    short, long = _short_and_long(holes, int(settings.interpolate_up_to_s * rate + 1e-9))
    if np.any(short):
        from scipy.interpolate import CubicSpline

        values = values.copy()
        values[short] = CubicSpline(np.flatnonzero(~holes), values[~holes])(np.flatnonzero(short))
    values = np.where(long, np.nan, values)
    flags[spiky] |= np.uint8(RecordFlag.SPIKE)
    flags[short & ~spiky] |= np.uint8(RecordFlag.INTERPOLATED)
    flags[long] |= np.uint8(RecordFlag.GAP)
    if np.any(spiky):
        first = grid.at(int(np.flatnonzero(spiky)[0]))
        notes.append((f"{int(np.sum(spiky))} spikes in {name} replaced, the first at {first}", _REPLACED))
    cells = int(np.sum(missing[grid.position[grid.first]]))
    if cells:
        notes.append((f"{cells} rows hold no {name}", _REPLACED))
    return values


def _short_and_long(holes: NDArray[np.bool_], longest: int) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Holes of up to `longest` samples with good samples on both sides, and the others."""
    short = np.zeros_like(holes)
    for first, stop in runs(holes):
        short[first:stop] = stop - first <= longest and first > 0 and stop < holes.size
    return short, holes & ~short


def _slow_channel(
    name: str,
    values: Floats,
    rate: float,
    settings: RecordsSettings,
    grid: _Grid,
    flags: Flags,
    notes: list[tuple[str, str]],
) -> Floats:
    """Interpolate linearly between the channel's own values, which may be far fewer than the rows."""
    known = np.flatnonzero(np.isfinite(values))
    filled = np.interp(np.arange(values.size), known, values[known])
    own = float(np.median(np.diff(known))) if known.size > 1 else 1.0
    longest = max(settings.interpolate_up_to_s * rate, _SLOW_HOLD * own)
    for first, stop in runs(np.isnan(values)):
        if stop - first > longest:
            filled[first:stop] = np.nan
    return filled


def _flag_stuck(
    channels: dict[str, Floats],
    rate: float,
    settings: RecordsSettings,
    grid: _Grid,
    flags: Flags,
    notes: list[tuple[str, str]],
) -> None:
    moves = {
        name: np.concatenate([[False], np.diff(channels[name]) != 0]) & np.isfinite(channels[name])
        for name in FAST_CHANNELS
    }
    for name in FAST_CHANNELS:
        others = np.any([moves[other] for other in FAST_CHANNELS if other != name], axis=0)
        found = stuck(channels[name], others, rate, settings.stuck_s)
        flags[found] |= np.uint8(RecordFlag.STUCK)
        for first, stop in runs(found):
            what = f"{name} does not change for {(stop - first) / rate:.1f} s from {grid.at(int(first))}"
            notes.append((what, "These samples are flagged and make no window; look at the sensor"))


def _clock_notes(ticks: Ticks, grid: _Grid, stated: float | None) -> list[tuple[str, str]]:
    notes = []
    if stated is not None and ticks.rate != stated:
        what = f"its clock runs {1e6 * (ticks.rate / stated - 1):+.0f} parts in a million off the stated rate of {stated:g} Hz"
        notes.append((what, "The rate of the stamps is used; look at the recorder's clock"))
    if ticks.reordered:
        notes.append(
            (
                f"{ticks.reordered} rows stood out of order and were sorted by time",
                "Look at the recorder if this recurs",
            )
        )
    duplicates = int(ticks.duplicate.size + np.sum(~grid.first))
    if duplicates:
        notes.append((f"{duplicates} rows repeat the time of another row; the first of each is used", _REPLACED))
    for step in ticks.steps:
        at = grid.at(int(grid.position[step.row]))
        goes_on = (
            "the signals run on through it"
            if step.continues
            else "the signals do not run on: time is missing, unknown how much"
        )
        what = f"the clock was set by {step.seconds:+.3f} s at {at}; {goes_on}; later times of this log keep the clock before"
        notes.append((what, "Check the times against the driller's report"))
    return notes


def _gap_notes(flags: Flags, grid: _Grid, rate: float) -> list[tuple[str, str]]:
    """Counts of filled samples, and each gap."""
    notes = []
    empty = np.ones(grid.size, dtype=bool)
    empty[grid.position] = False
    filled = int(np.sum(empty & (flags & np.uint8(RecordFlag.INTERPOLATED) > 0)))
    if filled:
        notes.append((f"{filled} rows missing, filled by interpolation", _REPLACED))
    for first, stop in runs(flags & np.uint8(RecordFlag.GAP) > 0):
        notes.append((f"gap of {(stop - first) / rate:.1f} s at {grid.at(int(first))}", _KEPT))
    for position, seconds in grid.left_out:
        notes.append(
            (f"gap of {seconds:.1f} s at {grid.at(position)}", "No samples are stored there; look at the recorder")
        )
    return notes

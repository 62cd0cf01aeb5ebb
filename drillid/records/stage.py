"""Raw logs → one regular SI series of a well, with a flag for every repair of a sample."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from drillid.arrays import Array, Integers
from drillid.config.rig import CHANNEL_UNITS, REQUIRED_CHANNELS, Channel, Rig
from drillid.datasets.store import Problem, WellFolders
from drillid.errors import LogError
from drillid.formats import first_stamp, read_log
from drillid.records.clock import FEWEST_ROWS, Ticks, place_rows, rate_tolerance, share_of_real_jitter, too_few_rows
from drillid.records.grid import CHECK_RECORDER, End, Grid, Note, clock_notes, following
from drillid.records.repair import FAST_CHANNELS, Repair, spline
from drillid.units import to_si_factor

if TYPE_CHECKING:
    from drillid.config.settings import RecordsSettings, Settings
    from drillid.config.sheets import Well


_PIECE = 1_200_000
"""Samples written at once, a whole number of the store's chunks."""
_RATE_TOLERANCE = 0.01
"""Largest relative deviation of the rate of a log's stamps from the nominal rate."""


@dataclass(frozen=True)
class Record:
    """One log as a regular series, with notes on its repair.

    samples : variables of the RECORDS schema except `log`
    end : where the next log may continue it
    notes : repairs (sentence, remedy)
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
            for first in range(0, samples.sizes["time"], _PIECE):
                piece = samples.isel(time=slice(first, first + _PIECE))
                append(piece.assign(log=("time", np.full(piece.sizes["time"], number))))
            end, number = record.end, number + 1
    return problems


def _in_time_order(logs: tuple[Path, ...], rig: Rig) -> tuple[list[Path], list[Problem]]:
    """Logs in order of their first stamp, and problems of those whose time cannot be read."""
    starts, problems = [], []
    for path in logs:
        try:
            starts.append((first_stamp(path, rig.time.column, rig.time.zone), path))
        except LogError as error:
            problems.append(Problem(error.where, error.what, error.remedy))
    return [path for _, path in sorted(starts)], problems


def _after(samples: xr.Dataset, end: End | None, path: Path) -> tuple[xr.Dataset, list[Note]]:
    """Samples after the end of the previous log, and a note on those before it."""
    last = None if end is None else np.datetime64(end.time, "ns")
    late = 0 if last is None else int(np.searchsorted(samples["time"].values, last, side="right"))
    if late == samples.sizes["time"]:
        raise LogError(str(path), "lies wholly within the time of the previous logs; not used", "List each log once")
    if late == 0:
        return samples, []
    what = f"its first {late} samples overlap the previous log and are not used"
    return samples.isel(time=slice(late, None)), [(what, "List logs that do not overlap")]


def _check_rate(ticks: Ticks, stated: float | None, path: Path) -> None:
    """Reject a log sampled at a rate other than the stated one or, without that, than the well's other logs."""
    if abs(ticks.actual / ticks.rate - 1) <= rate_tolerance(int(ticks.tick[-1]), _RATE_TOLERANCE):
        return
    if stated is not None:
        raise LogError(
            str(path),
            f"its stamps give {ticks.actual:.4g} samples per second, the rig description {stated:.4g}",
            "Correct the sample rate in the rig description, or leave it out",
        )
    raise LogError(
        str(path),
        f"is sampled at {ticks.actual:.6g} Hz, the well's other logs at {ticks.rate:.6g} Hz; not used",
        "Export all logs of a well at one rate, or list them as another well",
    )


def regular_record(path: Path, rig: Rig, settings: RecordsSettings, before: End | None = None) -> Record:
    """Read one log and put it on a regular grid.

    Parameters
    ----------
    path : the log
    rig : its columns, units, clock
    before : end of the previous log, whose rate and ticks are continued

    Raises
    ------
    LogError
        If the log cannot be read or placed on a grid.
    """
    stamps, log = read_channels(path, rig)
    rate, anchor = (before.rate, before.time) if before else (rig.time.sample_rate, None)
    ticks = place_rows(stamps, log["torque_sweep"], log["speed"], rate, anchor, str(path))
    del stamps
    _check_rate(ticks, rig.time.sample_rate, path)
    ticks = ticks if before is None else following(ticks, before)
    grid = Grid.of(ticks)
    notes = clock_notes(ticks, grid)
    if share_of_real_jitter(log["torque_sweep"][ticks.rows], ticks) > 0.5:
        log |= {name: moved_to_ticks(log[name], ticks) for name in FAST_CHANNELS if name in log}
        rms = 1e3 * float(np.std(ticks.jitter))
        notes.append(
            (
                f"the sampling times deviate from the regular clock ({rms:.2f} ms rms); interpolated to it",
                CHECK_RECORDER,
            )
        )
    repair = Repair(grid, ticks.rate, settings)
    missing = np.full(grid.size, np.nan, np.float32)
    channels = {
        name: repair.channel(name, log.pop(name)[ticks.rows]) if name in log else missing for name in CHANNEL_UNITS
    }
    repair.find_stuck({name: channels[name] for name in FAST_CHANNELS if channels[name] is not missing})
    repair.note_holes()
    variables = {name: ("time", values) for name, values in channels.items()} | {"flags": ("time", repair.flags)}
    return Record(xr.Dataset(variables, coords={"time": grid.time}), End.of(ticks), (*notes, *repair.notes))


def read_channels(path: Path, rig: Rig) -> tuple[Integers, dict[str, Array]]:
    """Stamps of a log (ns since 1970 UTC) and its channels in SI units, NaN for missing values, shape (row,).

    An empty optional column is omitted. Fast channels are float64, the others, which only
    determine the rig's state, float32.

    Raises
    ------
    LogError
        If the log cannot be read, is too short, or a required channel holds too few values.
    """
    names: dict[str, list[Channel]] = {}
    for name, channel in rig.channels.items():
        names.setdefault(channel.column, []).append(name)
    raw = read_log(path, rig.time.column, list(names), rig.time.zone)
    if raw.stamps.size < FEWEST_ROWS:
        raise too_few_rows(str(path), raw.stamps.size)
    channels: dict[str, Array] = {}
    for column, same_column in names.items():
        values = raw.pop(column)
        held = int(np.sum(np.isfinite(values)))
        if held < FEWEST_ROWS and not set(same_column).isdisjoint(REQUIRED_CHANNELS):
            number = f"only {held} values of the {FEWEST_ROWS} needed" if held else "no values"
            remedy = "Correct the rig description's columns, or the export"
            raise LogError(str(path), f"column '{column}' holds {number}", remedy)
        for name in same_column if held >= FEWEST_ROWS else []:
            factor = to_si_factor(rig.channels[name].unit, CHANNEL_UNITS[name])
            channels[name] = (values * factor).astype(np.float64 if name in FAST_CHANNELS else np.float32, copy=False)
    return raw.stamps.view(np.int64), channels


def moved_to_ticks(values: Array, ticks: Ticks) -> Array:
    """A fast channel, shape (row,), interpolated from the times of its stamps to the ticks, in the rows of `ticks`."""
    moved, sampled_at = values.copy(), ticks.tick / ticks.rate + ticks.jitter
    known = np.isfinite(values[ticks.rows])
    good = known & np.concatenate([[True], np.diff(sampled_at) > 0])
    at = ticks.tick / ticks.rate
    moved[ticks.rows[known]] = spline(sampled_at[good], values[ticks.rows[good]], at[known])
    return moved

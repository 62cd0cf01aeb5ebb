"""Raw logs → one regular SI series of a well, with a flag for every repair of a sample."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from drillid.arrays import Array
from drillid.config.rig import CHANNEL_UNITS, REQUIRED_CHANNELS, Rig
from drillid.datasets.reuse import Memo
from drillid.datasets.store import Problem, WellFolders
from drillid.errors import DrillidError, LogError, place_in_library
from drillid.formats import first_stamp
from drillid.records.channels import FAST_CHANNELS, read_channels
from drillid.records.clock import FEWEST_ROWS, Ticks, place_rows, rate_tolerance, share_of_real_jitter
from drillid.records.consistency import Samples
from drillid.records.grid import CHECK_RECORDER, End, Grid, Note, clock_notes, following
from drillid.records.joining import LIST_APART, LIST_ONCE, Known, SlowLogs, Source, joined, sources
from drillid.records.placed_logs import EarlierLogs, PlacedLog, distinct_names, file_states, samples_key
from drillid.records.plausibility import judge
from drillid.records.repair import Repair, spline

if TYPE_CHECKING:
    from drillid.config.listing import Well
    from drillid.config.settings import RecordsSettings, Settings


_PIECE = 1_200_000
"""Number of samples written at once, a whole number of the store's chunks."""
FAILS_THE_JOB = (OSError, MemoryError)
"""Faults of the machine that concern more than a log; readers turn those of reading a file into `LogError`."""
_NO_SLOW_LOGS = SlowLogs()
_RATE_TOLERANCE = 0.01
"""Largest relative deviation of the rate of a log's stamps from the nominal rate."""


@dataclass(frozen=True)
class LogOnGrid:
    """One log whose rows have their places on a regular grid, and in which nothing is repaired yet.

    channels : SI units, shape (row,), in the file's order
    span : its first and its last stamp, ns since 1970 UTC
    notes : what was decided and what is questionable (sentence, remedy)
    """

    channels: dict[str, Array]
    ticks: Ticks
    grid: Grid
    span: tuple[int, int]
    notes: tuple[Note, ...]


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
    """Read every log of a well that is new or changed and write its records, log by log.

    Without any usable log there is no store.
    """
    memo, states = Memo(folders, "records"), file_states(well.logs)
    known = functools.partial(_known, memo, states)
    fast, slow = sources(well.logs, well.rig, known)
    starts, problems = in_time_order(fast, known)
    logs = _joined_states(starts, states, slow)
    rigs = {source.path: source.rig for source in fast}
    earlier, placed, end = EarlierLogs(folders, memo, logs), list[PlacedLog](), None
    with folders.appending("records", "records", kept=earlier.kept) as append:
        for path in logs:
            log = earlier.unchanged(path, end)
            samples = earlier.samples(log) if log else None
            if log is None:
                log, samples = _placed_log(path, logs[path], end, rigs[path], settings.records, slow)
            first = sum(each.samples for each in placed)
            log = replace(log, first=first)
            if samples is not None:
                number = sum(each.samples > 0 for each in placed)
                for begin in range(0, log.samples, _PIECE):
                    piece = samples.isel(time=slice(begin, begin + _PIECE)).load().drop_encoding()
                    append(piece.assign(log=("time", np.full(piece.sizes["time"], number))))
            if not log.again:
                memo.found[earlier.key(path, end)] = asdict(log)
            end = log.end
            placed.append(log)
    names = distinct_names(logs)
    used = [(names[path], log) for path, log in zip(logs, placed, strict=True) if log.samples]
    if used:
        folders.write("records", "logs", _logs_dataset(used))
    times = [
        (starts[path], max(starts[path], log.end.time if log.end else 0))
        for path, log in zip(logs, placed, strict=True)
    ]
    problems += [
        replace(problem, where=names[path]) if problem.where == path.name else problem
        for path, log in zip(logs, placed, strict=True)
        for problem in log.problems
    ]
    problems += map(Problem.of, slow.problems(times))
    memo.save()
    return problems


def _known(memo: Memo, states: Mapping[Path, str], kind: str, path: Path, find: Callable[[], Any]) -> Any:
    """A finding about a file, from an earlier run if the file has not changed since, else found anew."""
    return memo.result(memo.key(kind, states[path]), find) if states[path] else find()


def _joined_states(starts: Mapping[Path, int], states: Mapping[Path, str], slow: SlowLogs) -> dict[Path, str]:
    """States of logs with those of the slow logs that may be joined to each before the next begins."""
    if not slow.channels:
        return {path: states[path] for path in starts}
    found, ends = {}, [*list(starts.values())[1:], np.iinfo(np.int64).max // 2]
    for (path, first), last in zip(starts.items(), ends, strict=True):
        beside = [states[file] for file in slow.files_around(first, last)]
        found[path] = " | ".join([states[path], *sorted(slow.channels), *beside]) if states[path] else ""
    return found


def _placed_log(
    path: Path, state: str, end: End | None, rig: Rig, settings: RecordsSettings, slow: SlowLogs
) -> tuple[PlacedLog, xr.Dataset | None]:
    """Read a log that continues a given end; its samples, None where it cannot be used."""
    try:
        record = regular_record(path, rig, settings, end, slow)
        samples, late = _after(record.samples, end, path)
    except FAILS_THE_JOB:
        raise
    except Exception as error:  # one log must not take the well's other logs along
        problem = refusal(path, error)
        again = problem.again or not isinstance(error, DrillidError)
        return PlacedLog(state, "", 0, 0, end, (problem,), again), None
    notes = tuple(Problem(path.name, what, remedy) for what, remedy in (*record.notes, *late))
    return PlacedLog(state, samples_key(samples), 0, samples.sizes["time"], record.end, notes), samples


def _logs_dataset(logs: Sequence[tuple[str, PlacedLog]]) -> xr.Dataset:
    columns = {
        "file": [name for name, _ in logs],
        "first_sample": [log.first for _, log in logs],
        "samples": [log.samples for _, log in logs],
        "key": [log.key for _, log in logs],
    }
    return xr.Dataset({name: ("log", values) for name, values in columns.items()}, {"log": np.arange(len(logs))})


def in_time_order(logs: Sequence[Source], known: Known) -> tuple[dict[Path, int], list[Problem]]:
    """First stamps (ns) of the logs in their order, and problems of those whose time cannot be read."""
    starts, problems = [], []
    for log in logs:
        try:
            starts.append((known("start", log.path, functools.partial(_start, log)), log.path))
        except FAILS_THE_JOB:
            raise
        except Exception as error:  # one log must not take the well's other logs along
            problems.append(refusal(log.path, error))
    return {path: start for start, path in sorted(starts)}, problems


def _start(log: Source) -> int:
    """First stamp of a log, ns since 1970 UTC."""
    return int(first_stamp(log.path, *log.layout).astype("datetime64[ns]").astype(np.int64))


def refusal(path: Path, error: Exception) -> Problem:
    """The problem of a log that is not used; for an unforeseen error, with the place in the library."""
    if isinstance(error, DrillidError):
        return Problem.of(error)
    place = place_in_library(error)
    message = (str(error) or "no message").splitlines()[0]
    return Problem(
        str(path),
        f"cannot be used ({type(error).__name__}: {message}, in {Path(place.filename).name}, line {place.lineno})",
        "A fault in the program: report it with this log; the well's other logs are used",
    )


def _after(samples: xr.Dataset, end: End | None, path: Path) -> tuple[xr.Dataset, list[Note]]:
    """Samples after the end of the previous log, and a note on those before it."""
    last = None if end is None else np.datetime64(end.time, "ns")
    late = 0 if last is None else int(np.searchsorted(samples["time"].values, last, side="right"))
    if late == samples.sizes["time"]:
        raise LogError(str(path), "lies entirely within the time of the previous logs; not used", LIST_ONCE)
    if late == 0:
        return samples, []
    what = f"its first {late} samples overlap the previous log and are not used"
    return samples.isel(time=slice(late, None)), [(what, LIST_APART)]


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


def log_on_grid(path: Path, rig: Rig, before: End | None = None, slow: SlowLogs = _NO_SLOW_LOGS) -> LogOnGrid:
    """Read one log and find the places of its rows on a regular grid.

    Parameters
    ----------
    path : the log
    rig : its columns, units, clock
    before : end of the previous log, whose rate and ticks are continued
    slow : logs of the well with channels that this one may lack

    Raises
    ------
    LogError
        If the log cannot be read or placed on a grid, or its channels contradict each other.
    """
    raw = joined(read_channels(path, rig, slow.channels).in_whole_rows(path.name), slow, path)
    log, columns, stated = raw.channels, raw.columns, rig.for_log(path).time.sample_rate
    rate, anchor = (before.rate, before.time) if before else (stated, None)
    ticks = place_rows(raw.stamps, log["torque_sweep"], log["speed"], rate, anchor, str(path))
    _check_rate(ticks, stated, path)
    ticks = ticks if before is None else following(ticks, before)
    grid = Grid.of(ticks, str(path))
    notes = [*raw.notes, *_placed(log, ticks, grid, path), *clock_notes(ticks, grid)]
    samples = Samples(log, ticks.rows, ticks.tick / ticks.rate, grid.time[0], ticks.rate)
    notes += judge(samples, columns, str(path))
    return LogOnGrid(log, ticks, grid, (int(raw.stamps.min()), int(raw.stamps.max())), tuple(notes))


def regular_record(
    path: Path, rig: Rig, settings: RecordsSettings, before: End | None = None, slow: SlowLogs = _NO_SLOW_LOGS
) -> Record:
    """Read one log, put it on a regular grid and repair it; parameters and errors as of `log_on_grid`."""
    placed = log_on_grid(path, rig, before, slow)
    log, ticks, grid, notes = placed.channels, placed.ticks, placed.grid, list(placed.notes)
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


def _placed(log: dict[str, Array], ticks: Ticks, grid: Grid, path: Path) -> list[Note]:
    """Omit channels with hardly any value on the grid, and note them."""
    notes = []
    for name in list(log):
        if np.sum(np.isfinite(grid.first_values(log[name][ticks.rows]))) < FEWEST_ROWS:
            if name in REQUIRED_CHANNELS:
                what = f"fewer than {FEWEST_ROWS} values of {name} are left once repeated rows are taken out"
                raise LogError(str(path), what, "Export the log again")
            notes.append((f"{name} holds too few values and is not used", "Correct the column, or remove it"))
            del log[name]
    return notes


def moved_to_ticks(values: Array, ticks: Ticks) -> Array:
    """A fast channel, shape (row,), interpolated from the times of its stamps to the ticks, in the rows of `ticks`."""
    moved, sampled_at = values.copy(), ticks.tick / ticks.rate + ticks.jitter
    known = np.isfinite(values[ticks.rows])
    latest = np.maximum.accumulate(np.where(known, sampled_at, -np.inf))
    good = known & (sampled_at > np.concatenate([[-np.inf], latest[:-1]]))
    at = ticks.tick / ticks.rate
    moved[ticks.rows[known]] = spline(sampled_at[good], values[ticks.rows[good]], at[known])
    return moved

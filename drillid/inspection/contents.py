"""What one log file holds: its tables, times, columns with their channels and rates, gaps, and the sweep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from drillid.arrays import Floats, Integers
from drillid.config.rig import CHANNEL_UNITS, CHANNELS, Channel, Clock, LogFile
from drillid.errors import LogError
from drillid.formats import Dialect, Header, format_of, headers, read_log
from drillid.formats.mnemonics import WITHOUT_UNIT, channel_column, is_no_unit, is_unit
from drillid.inspection.sweep import Sweep, find_sweep
from drillid.records.channels import usable_rows
from drillid.records.grid import Note
from drillid.records.mapping import dialect_of, time_of
from drillid.records.order import without_repeats
from drillid.records.plausibility import fitting_units
from drillid.records.shared_stamps import evenly, shared_note
from drillid.units import to_si_factor

_GAP = 5.0
"""Multiple of the usual interval between rows beyond which there is a gap; a gap also exceeds a second."""
_OILFIELD = {
    "N m": ("ft-lbf", "kft-lbf"),
    "m": ("ft",),
    "N": ("lbf", "klbf"),
    "m^3/s": ("gal/min", "bbl/min"),
    "Pa": ("psi",),
}
"""Oilfield units of each kind of quantity."""


@dataclass(frozen=True)
class ColumnContent:
    """One column of numbers.

    unit : as the file states it, else empty
    missing : share of rows without a value
    low, high : least and largest value
    changes_hz : how often its value changes, per second
    """

    name: str
    unit: str
    missing: float
    low: float
    high: float
    changes_hz: float


@dataclass(frozen=True)
class ChannelGuess:
    """The column that is probably a channel.

    guessed : whether its unit is not the file's but one that fits its size
    others : other units that fit its size
    """

    column: str
    unit: str
    guessed: bool = False
    others: tuple[str, ...] = ()


@dataclass(frozen=True)
class Contents:
    """What a log file holds.

    format : usual ending of the names of such files
    table, tables : the table that was looked at, and all of them
    first, last : UTC stamps
    rate : rows per second
    gaps : start (UTC) and length (s) of each
    columns : columns of numbers
    others : columns of text and times
    channels : columns that are probably channels
    notes : what readers decided
    """

    path: Path
    format: str
    table: str
    tables: tuple[str, ...]
    rows: int
    first: np.datetime64
    last: np.datetime64
    rate: float
    gaps: tuple[tuple[np.datetime64, float], ...]
    columns: tuple[ColumnContent, ...]
    others: tuple[str, ...]
    channels: Mapping[Channel, ChannelGuess]
    sweep: Sweep | None
    notes: tuple[Note, ...]


@dataclass
class _Read:
    """Columns of a table in order of time; `aliases` as a header has them."""

    stamps: Integers
    numbers: dict[str, Floats]
    units: dict[str, str]
    notes: list[Note]
    aliases: Mapping[str, str]
    others: list[str] = field(default_factory=list)


def contents(path: Path, clock: Clock, file: LogFile) -> list[Contents]:
    """What each table of a log file with times holds.

    Parameters
    ----------
    clock, file : what the user knows about its times and layout

    Raises
    ------
    LogError
        If it cannot be read, or its times leave a question open that the rig description must answer.
    """
    dialect = dialect_of(file)
    tables = headers(path, dialect)
    found, refused = list[Contents](), list[LogError]()
    for header in tables:
        own = dialect if len(tables) == 1 else dialect_of(file.model_copy(update={"table": header.table}))
        try:
            found.append(_contents(path, header, clock, own, tables))
        except LogError as error:
            refused.append(error)
    if not found:
        raise refused[0]
    return found


def _contents(path: Path, header: Header, clock: Clock, dialect: Dialect, tables: Sequence[Header]) -> Contents:
    read = _read(path, header, clock, dialect)
    _space(read)
    steps = np.diff(read.stamps) * 1e-9
    usual = float(np.median(steps[steps > 0])) if np.any(steps > 0) else np.inf
    wide = np.flatnonzero(steps > max(_GAP * usual, 1.0))
    stamps = read.stamps.view("datetime64[ns]")
    duration = max(float(read.stamps[-1] - read.stamps[0]) * 1e-9, usual)
    recorded = max(duration - float(np.sum(steps[wide])), usual)
    rate = (read.stamps.size - 1 - wide.size) / recorded
    columns = {name: _column(name, values, read.units, recorded) for name, values in read.numbers.items()}
    sweep = find_sweep(read.numbers, read.units, read.stamps, rate, wide)
    return Contents(
        path,
        format_of(path).SUFFIXES[0],
        header.table,
        tuple(each.table for each in tables),
        read.stamps.size,
        stamps[0],
        stamps[-1],
        rate,
        tuple((stamps[at], float(steps[at])) for at in wide.tolist()),
        tuple(columns.values()),
        tuple(read.others),
        _channels(read, sweep),
        sweep,
        tuple(read.notes),
    )


def _read(path: Path, header: Header, clock: Clock, dialect: Dialect) -> _Read:
    """All columns but the times; those that hold no numbers are `others`."""
    described = time_of(clock)
    log = read_log(path, described, header.columns, dialect=dialect)
    stamps = log.stamps.view(np.int64)
    kept, left_out = usable_rows(stamps, path)
    order = np.flatnonzero(kept)[np.argsort(stamps[kept], kind="stable")]
    read = _Read(stamps[order], {}, log.units, left_out, header.aliases)
    if np.any(np.diff(order) < 0):
        what = f"{int(np.sum(order != np.sort(order)))} rows are not in the order of time, and are sorted"
        read.notes.append((what, "None needed where the stamps are right"))
    for name in (name for name in header.columns if name not in log.times):
        try:
            values = log.pop(name)[order]
        except LogError as error:
            read.others.append(name)
            if name in log.units:
                what = f"column '{name}' has a unit but is not read as numbers: {error.where}: {error.what}"
                read.notes.append((what, error.remedy))
            continue
        if np.any(np.isfinite(values)):
            read.numbers[name] = values
        else:
            read.others.append(name)
    read.notes[:0] = log.notes
    return read


def _space(read: _Read) -> None:
    """Space rows that share a stamp as the records stage does, by the two columns that change most often."""
    often = sorted(read.numbers.values(), key=lambda values: -int(np.sum(np.diff(values) != 0)))[:2]
    if not often:
        return
    _, repeats = without_repeats(read.stamps, often[0], often[-1])
    read.stamps, shared = evenly(read.stamps, often[0], often[-1], repeats)
    if shared:
        read.notes.append(shared_note(shared))


def _column(name: str, values: Floats, units: Mapping[str, str], seconds: float) -> ColumnContent:
    known = values[np.isfinite(values)]
    changes = int(np.sum(np.diff(known) != 0)) / seconds
    missing = 1 - known.size / values.size
    return ColumnContent(name, units.get(name, ""), missing, float(known.min()), float(known.max()), changes)


def _channels(read: _Read, sweep: Sweep | None) -> dict[Channel, ChannelGuess]:
    """Columns that are named like a channel and may be it by their unit, the sweep by its signal."""
    found = dict[Channel, ChannelGuess]()
    bare = {column: _without_unit(column, read.units.get(column, "")) for column in read.numbers}
    units = {column: unit for column, (_, unit) in bare.items() if unit} | read.units
    if sweep is not None:
        guess = _guess("torque_sweep", sweep.column, units.get(sweep.column, ""), sweep.rms)
        if guess is not None:
            found["torque_sweep"] = guess
            del bare[sweep.column]
    for name in CHANNELS:
        # the first of several columns of the same name
        named = {own: column for column, (own, _) in reversed(bare.items())}
        aliases = {alias: column for alias, column in read.aliases.items() if column in bare and alias not in named}
        named = dict(reversed(named.items())) | aliases
        called = None if name in found else channel_column(name, named)
        if called is None:
            continue
        column = named[called]
        turning = np.abs(read.numbers[column][np.nan_to_num(read.numbers[column]) != 0])
        level = float(np.median(turning)) if turning.size else 0.0
        guess = _guess(name, column, units.get(column, ""), level)
        if guess is not None:
            found[name] = guess
            del bare[column]
    return _of_one_system(found)


def _of_one_system(found: dict[Channel, ChannelGuess]) -> dict[Channel, ChannelGuess]:
    """Guessed torques in the system of units of the channels whose units are stated or fit in one system alone.

    Their size does not distinguish N m from ft-lbf, which differ by less than a half.
    """
    torque = [name for name in found if CHANNEL_UNITS[name] == "N m"]
    told = [
        {_is_oilfield(unit, name) for unit in (guess.unit, *guess.others)}
        for name, guess in found.items()
        if name not in WITHOUT_UNIT and not (name in torque and guess.guessed)
    ]
    systems = [oilfield for (oilfield,) in (each for each in told if len(each) == 1)]
    oilfield = 2 * sum(systems) > len(systems)
    for name in torque:
        fitting = [unit for unit in (found[name].unit, *found[name].others) if _is_oilfield(unit, name) == oilfield]
        if found[name].guessed and fitting:
            rest = tuple(unit for unit in (found[name].unit, *found[name].others) if unit != fitting[0])
            found[name] = replace(found[name], unit=fitting[0], others=rest)
    return found


def _is_oilfield(unit: str, name: Channel) -> bool:
    si = CHANNEL_UNITS[name]
    return any(to_si_factor(unit, si) == to_si_factor(each, si) for each in _OILFIELD.get(si, ()))


def _without_unit(name: str, stated: str) -> tuple[str, str]:
    """A name such as 'TQ_CMD_kNm' or 'Bit Depth m' without the unit at its end, and that.

    The name itself where none is there, or the file states the unit elsewhere.
    """
    if stated:
        return name.removesuffix(f" {stated}"), stated
    own, _, unit = name.rpartition("_")
    return (own, unit) if own and is_unit(unit) and not is_no_unit(unit) else (name, "")


def _guess(name: Channel, column: str, unit: str, level: float) -> ChannelGuess | None:
    """A column as a channel in its unit, or in one that fits its size; None where its unit is of another kind."""
    if not unit:
        oilfield = _OILFIELD.get(CHANNEL_UNITS[name], ())
        first, *others = fitting_units(name, level, more=oilfield) or [CHANNEL_UNITS[name]]
        return ChannelGuess(column, first, guessed=True, others=tuple(others))
    try:
        to_si_factor(unit, CHANNEL_UNITS[name])
    except ValueError:
        return None
    return ChannelGuess(column, unit)

"""Which columns of a log are its channels, and in which units: by the rig description, WITS and the file itself."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

from drillid.config.rig import CHANNEL_UNITS, CHANNELS, REQUIRED_CHANNELS, Channel, Clock, Column, LogFile, Rig
from drillid.errors import LogError
from drillid.formats import Dialect, Header, TimeColumn, column_in, column_named, headers, names_of, table_with
from drillid.formats.mnemonics import WITHOUT_UNIT, surely
from drillid.records.grid import Note
from drillid.units import to_si_factor

_SAME_UNIT = 1e-6
"""Relative difference below which two units are the same."""


@dataclass(frozen=True)
class MappedColumn:
    """A channel's column in a log, and the unit of its values."""

    column: str
    unit: str


@dataclass(frozen=True)
class Mapping:
    """Channels of one log.

    columns : column and unit of each channel that the log holds
    by_mnemonic : those that the rig description does not name
    time : how its times are stated
    dialect : how it is laid out
    notes : what was decided
    """

    columns: dict[Channel, MappedColumn]
    by_mnemonic: frozenset[Channel]
    time: TimeColumn
    dialect: Dialect
    notes: tuple[Note, ...]


def time_of(clock: Clock) -> TimeColumn:
    """The rig description's times in the form that log readers take."""
    return TimeColumn(clock.column, clock.date, clock.zone, clock.format, clock.unit, clock.start)


def dialect_of(file: LogFile) -> Dialect:
    """The rig description's layout of logs in the form that their readers take."""
    return Dialect(**file.model_dump(exclude={"ignore_units"}))


def layout_of(rig: Rig) -> tuple[TimeColumn, str, Dialect, list[str]]:
    """Arguments of `formats.first_stamp` after the path of a log; the columns are those by which a table is chosen."""
    return time_of(rig.time), rig.time.zone, dialect_of(rig.file), _names(rig)


def _names(rig: Rig) -> list[str]:
    return [column.column for column in rig.channels.values() if column is not None]


def mapped(path: Path, rig: Rig, elsewhere: Collection[Channel] = ()) -> Mapping:
    """The channels of a log by the description that holds for it.

    Parameters
    ----------
    path : the log
    rig : description of the rig
    elsewhere : channels that other logs of the well may hold, so that this one may lack them

    Raises
    ------
    LogError
        If the log cannot be read, lacks a column, or the unit of one is unknown or contradicts the description.
    """
    rig = rig.for_log(path)
    dialect = dialect_of(rig.file)
    header = table_with(path, _names(rig), dialect)
    notes = list(_chosen(path, header, dialect))
    columns: dict[Channel, MappedColumn] = {}
    for name, column in rig.channels.items():
        if column is None or (name in elsewhere and column_in(header, column.column) is None):
            continue
        unit = header.units.get(column_named(column.column, header, path))
        columns[name], noted = _with_unit(name, column, unit, rig.file.ignore_units, path)
        notes += noted
    described = frozenset(columns)
    for name in CHANNELS:
        if name not in rig.channels:
            found, noted = _by_mnemonic(name, header, columns, path)
            notes += noted
            if found is not None:
                columns[name] = found
    for name in REQUIRED_CHANNELS:
        if name not in columns and name not in elsewhere:
            raise _missing(name, header, path)
    by_mnemonic = frozenset(columns) - described
    return Mapping(columns, by_mnemonic, time_of(rig.time), dialect, tuple(notes))


def _chosen(path: Path, header: Header, dialect: Dialect) -> Iterator[Note]:
    """A note on the table that is read, where the file has several and none is stated."""
    others = [f"'{other.table}'" for other in headers(path, dialect) if other.table not in names_of(header)]
    if others and dialect.table is None:
        what = f"holds several tables; '{header.table}' is read, not {', '.join(others)}"
        yield what, "State the one to read as file.table in the rig description if that is wrong"


def _with_unit(
    name: Channel, column: Column, own: str | None, ignore: bool, path: Path
) -> tuple[MappedColumn, list[Note]]:
    """The column with its unit, the described one, which the file must not contradict, else the file's; and a note."""
    where = f"{path}, column '{column.column}'"
    own_factor = None if own is None else _factor(own, name)
    if column.unit is None:
        if own is None:
            what = f"has no unit, neither in the file nor in the rig description's channel {name}"
            raise LogError(where, what, f"Add the unit to channels.{name}")
        if own_factor is None:
            what = f"has the unit '{own}' in the file, which is not a unit of {name}"
            raise LogError(where, what, f"State the unit, one of the kind of {CHANNEL_UNITS[name]}, in channels.{name}")
        return MappedColumn(column.column, own), []
    described = MappedColumn(column.column, column.unit)
    if own is None or ignore:
        return described, []
    remedy = f"Correct the unit of channels.{name}, or, if the file is wrong, state file.ignore_units: true"
    by = f"has the unit '{own}' in the file"
    if own_factor is None:
        what = f"column '{column.column}' {by}, which is not a unit of {name}; '{column.unit}' is used"
        return described, [(what, remedy)]
    if abs(own_factor / to_si_factor(column.unit, CHANNEL_UNITS[name]) - 1) > _SAME_UNIT:
        raise LogError(where, f"{by}, but '{column.unit}' in the rig description", remedy)
    return described, []


def _factor(unit: str, name: Channel) -> float | None:
    try:
        return to_si_factor(unit, CHANNEL_UNITS[name])
    except ValueError:
        return None


def _by_mnemonic(
    name: Channel, header: Header, taken: dict[Channel, MappedColumn], path: Path
) -> tuple[MappedColumn | None, list[Note]]:
    """The column with the channel's WITS mnemonic, where its unit is known and no other channel has it; and a note."""
    used = {column_in(header, column.column) for column in taken.values()}
    named = surely(name, header.columns) or surely(name, header.aliases)
    found = None if named is None else column_in(header, named)
    if found is None or found in used:
        return None, []
    unit = header.units.get(found) or WITHOUT_UNIT.get(name)
    if unit is not None and _factor(unit, name) is not None:
        what = f"{name} is taken from column '{found}' in {unit}, named by its mnemonic in WITS"
        remedy = f"Map {name} under channels of the rig description if that is wrong, or state '{name}: null' there"
        return MappedColumn(found, unit), [(what, remedy)]
    what = "has no unit" if unit is None else f"is in '{unit}', which is not a unit of {name}"
    remedy = f"Map {name} to it under channels of the rig description, with its unit"
    if name in REQUIRED_CHANNELS:
        raise LogError(f"{path}, column '{found}'", f"is {name} by its mnemonic in WITS, and {what}", remedy)
    return None, [(f"column '{found}' is {name} by its mnemonic in WITS, but {what}; it is not used", remedy)]


def _missing(name: str, header: Header, path: Path) -> LogError:
    existing = ", ".join(f"'{column}'" for column in header.columns)
    what = f"has no column known to hold {name}; its columns are {existing}"
    return LogError(str(path), what, f"Map one of them under channels.{name} of the rig description, with its unit")

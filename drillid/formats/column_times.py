"""Times in one column of text or of numbers."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from drillid.errors import LogError
from drillid.formats.counted_times import NoStart, are_dates, from_numbers, unit_named
from drillid.formats.places import shortened
from drillid.formats.since import unit_since
from drillid.formats.stated_times import EXAMPLE, Naive, StatedTimes
from drillid.formats.time_columns import have_offsets, nanoseconds
from drillid.formats.times_of_day import from_midnight
from drillid.formats.written_times import DAY_NS, ORDERS, UnclearDate, has_short_year, parse

_ISO = re.compile(r"^\d{4}(?:-\d{1,2}-\d{1,2}|\d{4})(?:[T ]|$)")
_BEFORE_FRACTION = re.compile(r"(?<=\d\d)[.,](?=\d+$)")
_NUMBER = re.compile(r"^[+-]?\d+(?:[.,]\d*)?(?:[eE][+-]?\d+)?$")


def of_numbers(of: StatedTimes, column: Any) -> Naive:
    """Times from counts, whose unit and start are stated or follow from their size."""
    import pyarrow as pa

    of.check_complete(column)
    header = of.places.header
    values = column.to_numpy() if pa.types.is_integer(column.type) else column.cast(pa.float64()).to_numpy()
    finite = np.isfinite(values)
    if not np.all(finite):
        row = int(np.argmin(finite))
        raise of.wrong(row, values[row])
    stated = header.units.get(of.column, "")
    header_unit = unit_named(unit_since(stated))
    start = of.start()
    is_stated = of.described.start is not None or unit_since(stated) != stated
    if start is not None and not is_stated and are_dates(values, header_unit, start[0]):
        # the start of the log, from which the times do not count
        start = None
    try:
        found = from_numbers(values, of.described.unit, _in_utc(of, start), header_unit)
    except NoStart as error:
        raise of.wrong(
            0,
            column[0].as_py(),
            "If it counts seconds, state their start as time.start and another unit as time.unit "
            f"in the rig description; otherwise {EXAMPLE[0].lower()}{EXAMPLE[1:]}",
        ) from error
    except ValueError as error:
        row = int(np.argmax(np.abs(values.astype(float))))
        remedy = f"Correct the value{of.places.in_line(row)}, or state its unit as time.unit in the rig description"
        raise of.wrong(row, values[row], remedy, fault=str(error)) from error
    if not found.decided:
        counts = of.described.start is None and start is not None
        notes = [of.from_header(int(found.since[0]), in_utc=found.zoned)] if counts else []
        return Naive(found.since, found.zoned, tuple(notes))
    zone = "UTC" if found.zoned else f"in the zone {of.zone()}"
    what = f"the times in column '{of.column}' are read as {found.decided}, {zone}, according to their magnitude"
    return Naive(found.since, found.zoned, ((what, "State time.unit in the rig description if that is wrong"),))


def _in_utc(of: StatedTimes, start: tuple[int, bool] | None) -> tuple[int, bool] | None:
    """A start in UTC, as counts go on where local clocks are changed; as it is where the zone has it twice or never."""
    import pandas as pd

    if start is None or start[1]:
        return start
    zoned = pd.DatetimeIndex([start[0]]).tz_localize(of.zone(), ambiguous="NaT", nonexistent="NaT")
    return start if zoned.hasnans else (int(zoned.as_unit("ns").asi8[0]), True)


def _as_numbers(of: StatedTimes, column: Any) -> Any:
    import pyarrow as pa
    import pyarrow.compute as pc

    trimmed = pc.utf8_trim_whitespace(column)
    try:
        return trimmed.cast(pa.int64())
    except pa.ArrowInvalid:
        pass
    plain = pc.replace_substring(trimmed, ",", ".")
    try:
        return plain.cast(pa.float64())
    except pa.ArrowInvalid as error:
        matches = pc.fill_null(pc.match_substring_regex(plain, _NUMBER.pattern), False)
        row = int(np.argmin(matches.to_numpy()))
        raise of.wrong(row, column[row].as_py()) from error


def of_text(of: StatedTimes, column: Any) -> Naive:
    """Times of any written form, or numbers written as text."""
    import pyarrow.compute as pc

    cell = next((found for found in (each.as_py() for each in column) if found and found.strip()), "")
    if not cell:
        raise of.wrong(0, cell)
    stated = of.form()
    if stated is not None and stated not in ORDERS:
        return formatted(of, column, stated)
    if _NUMBER.match(cell.strip()) and not re.match(r"^(?:19|20)\d{12}(?:[.,]\d*)?$", cell.strip()):
        return of_numbers(of, _as_numbers(of, column))
    if _ISO.match(cell):
        found = _iso(of, column)
        if not isinstance(found, int):
            return found
        wrong: int | None = found
    else:
        wrong = None
    return parsed(of, column, wrong, has_short_year(cell), pc)


def parsed(of: StatedTimes, column: Any, wrong: int | None, short: bool, pc: Any) -> Naive:
    """Times in a form other than ISO."""
    try:
        found = parse(column, of.form())
    except UnclearDate as error:
        raise LogError(
            of.places.cell(of.column, 0),
            f"'{shortened(column[0].as_py())}' may have day or month first, and no row of the log shows which",
            "State time.format in the rig description as 'day first' or 'month first'",
        ) from error
    if found is None or (wrong is not None and np.any(found.wrong)):
        row = wrong or 0
        cell = column[row].as_py()
        if short:
            raise LogError(
                of.places.cell(of.column, row),
                f"'{shortened(cell)}' is not a time: its year has two digits",
                "State the format in the rig description, such as time.format: '%d.%m.%y %H:%M:%S'",
            )
        raise of.wrong(row, cell)
    if np.any(found.wrong):
        row = int(np.argmax(found.wrong))
        raise of.wrong(row, column[row].as_py())
    notes = tuple([of.by_rows(found.decided)] if found.decided else [])
    if found.dated:
        return Naive(found.since, found.zoned, notes)
    return from_midnight(of, Naive(found.since, found.zoned))


def _iso(of: StatedTimes, column: Any) -> Naive | int:
    """ISO stamps, or the first row that is not one."""
    import pandas as pd

    cells = column.to_pandas()
    times = pd.to_datetime(cells, errors="coerce", format="ISO8601", utc=True)
    wrong = np.flatnonzero(times.isna())
    if wrong.size:
        return int(wrong[0])
    have = have_offsets(cells)
    zoned = bool(np.mean(have) > 0.5)
    if np.any(have != zoned):
        raise _odd_offset(of, int(np.argmax(have != zoned)), cells, zoned)
    return Naive(nanoseconds(times), zoned)


def _odd_offset(of: StatedTimes, row: int, cells: Any, zoned: bool) -> LogError:
    """The error for a stamp that lacks the offset that most others have, or has one that they lack."""
    fault = "no offset" if zoned else "an offset"
    return LogError(
        of.places.cell(of.column, row),
        f"'{shortened(cells.iloc[row])}' has {fault} from UTC, unlike most others",
        f"Write every stamp with an offset such as Z or +01:00, or none; correct that{of.places.in_line(row)}",
    )


def _with_fractions(cells: Any, stated: str) -> tuple[Any, str]:
    """Cells and their format, with the decimals of a second that cells have but a file's unit leaves out."""
    has = cells.str.contains(_BEFORE_FRACTION, na=False)
    if not stated.endswith("%S") or not has.any():
        return cells, stated
    return cells.str.replace(_BEFORE_FRACTION, ".", regex=True).where(has, cells + ".0"), f"{stated}.%f"


def formatted(of: StatedTimes, column: Any, stated: str) -> Naive:
    """Times in the stated format."""
    import pandas as pd

    cells = column.to_pandas().str.strip()
    by_user = of.described.format is not None
    if not by_user:
        cells, stated = _with_fractions(cells, stated)
    source = "time.format in the rig description" if by_user else f"the unit of column '{of.column}' in the file"
    try:
        found = pd.to_datetime(cells, errors="coerce", format=stated, utc="%z" in stated)
    except ValueError as error:
        raise LogError(
            of.places.column(of.column),
            f"the format '{stated}' from {source} cannot be used ({error})",
            "Write time.format in the notation of strptime, such as '%d.%m.%Y %H:%M:%S.%f'",
        ) from error
    wrong = np.flatnonzero(found.isna())
    if wrong.size:
        row = int(wrong[0])
        change = "Correct time.format" if by_user else "State another format as time.format"
        remedy = f"{change} in the rig description, or correct the cell{of.places.in_line(row)}"
        raise of.wrong(row, cells.iloc[row], remedy, fault=f"it does not match the format '{stated}' from {source}")
    if "%d" not in stated and "%j" not in stated and not re.search(r"%[cDxF]", stated):
        return from_midnight(of, Naive(nanoseconds(found) % DAY_NS, False))
    return Naive(nanoseconds(found), found.dt.tz is not None)

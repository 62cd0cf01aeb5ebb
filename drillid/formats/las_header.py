"""What the header of a LAS file says about its curves and its times."""

from __future__ import annotations

import io
import logging
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from drillid.formats.counted_times import COUNTED, unit_named
from drillid.formats.description import Unusable
from drillid.formats.header_rows import unique
from drillid.formats.mnemonics import date_among, is_no_unit, key_of, time_among
from drillid.formats.written_times import UnclearDate, parse

_DEPTHS = ("DEPT", "DEPTH", "MD", "TVD", "TDEP", "BDEP")
_LENGTHS = ("M", "FT", "F", "FEET", "METER", "METRE", "METERS", "METRES", ".1IN")
_DATES = ("STRTDATE", "STARTDATE", "STDATE", "SDAT", "SDATE", "DATESTART", "DATE", "DATEDAY")
_MOMENTS = ("STRT", *_DATES, "STRTTIME", "STARTTIME", "STTIME", "STIME", "STIM", "TIMESTART", "STARTDATETIME", "TSTART")
"""Mnemonics of a date with a time of day."""
_CLOCKS = ("STRTTIME", "STARTTIME", "STTIME", "STIM", "TIMESTART", "TIME", "TIM")


_SECTION_OF_3 = re.compile(
    r"^~\s*(?!VERSION_|WELL_|CURVE_|PARAMETER_)\w+_(DEFINITION|PARAMETER)[^\r\n]*", re.IGNORECASE | re.MULTILINE
)
_AS_IN_2 = {"DEFINITION": "~Curve", "PARAMETER": "~Parameter"}
"""Sections of LAS 3.0 by their names in LAS 2.0."""
_OF_THE_FILE = re.compile(r"export|creat|print|written|report|file", re.IGNORECASE)
"""Words about a date that is that of the file and not of its data."""
_NUMBERED = re.compile(r"^([^\S\r\n]*[^.:~#\s][^.:\r\n]*):(\d+(?=[^\S\r\n]*\.))", re.MULTILINE)
_COLON = "\x1f"
"""Stands for the colon in 'TQ:2' and in clocks, of which lasio knows nothing."""
_CLOCK = re.compile(r"(?<![\d:.])\d{1,2}:\d{2}:\d{2}(?!\d)|(?<=:)[^\S\r\n]*\d{1,2}:\d{2}(?=[^\S\r\n]*$)", re.MULTILINE)
_CLOCK_UNIT = re.compile(r"H.*M.*S", re.IGNORECASE)
"""Units of times of day that are written as numbers, which count nothing."""
_OF_DAY = re.compile(r"of (the )?day|midnight", re.IGNORECASE)
_ELAPSED = re.compile(r"^ET\b|^ETIME?\b|elapsed|since|cumul|from start", re.IGNORECASE)
"""Names and descriptions of a curve of times that counts from the log's start."""
_DAY_S = 86_400.0
_FAR_FROM_START_S = 600.0
"""First value from which a count can be none from the log's start."""


@dataclass(frozen=True)
class Moment:
    """A time that a file states.

    since : ns since 1970
    is_utc : whether its zone is stated, so that it is UTC
    offset : of that zone from UTC, ns
    """

    since: int
    is_utc: bool
    offset: int


@dataclass(frozen=True)
class LasHeader:
    """Curves of a LAS file and what the other sections say about its times.

    names : of the curves, each once
    units : by the curves' names
    wrapped : whether a row takes several lines
    delimiter : COMMA, TAB or SPACE where the file says so, else empty
    time : the curve of times, where there is no doubt
    moment : the time that the file states for its first row, and whether STRT itself is that
    day : midnight of the date that the file states
    counts_from_day : whether the file says that the curve counts from there; None where it says nothing
    first, last : STRT and STOP, the first and the last value of the index, where they are numbers
    nulls : numbers for missing values
    """

    names: tuple[str, ...]
    units: dict[str, str]
    wrapped: bool
    delimiter: str
    time: str | None
    moment: Moment | None
    moment_is_first: bool
    day: Moment | None
    counts_from_day: bool | None
    first: float | None
    last: float | None
    nulls: tuple[float, ...]

    def start(self, index: Sequence[float]) -> Moment | None:
        """The time that the curve of times counts from; None where the file leaves it open.

        The moment is that of STRT, the first value; of values from zero on it is that of zero, from which the first may
        be a step away.

        Parameters
        ----------
        index : the first values of the curve, empty where they are no numbers
        """
        unit = self.units.get(self.time or "", "s")
        if not index:
            return self.moment
        if _CLOCK_UNIT.search(unit):
            return None
        step = 1.001 * abs(index[1] - index[0]) if len(index) > 1 else 0.0
        if self.moment is None:
            of_day = self.counts_from_day
            return self.day if (self._may_be_of_day(index[0], step) if of_day is None else of_day) else None
        if abs(index[0]) <= step:
            return self.moment
        first = index[0] if self.moment_is_first else self.first
        if first is None or abs(index[0] - first) > step:
            return None
        size, _ = COUNTED[unit_named(unit) or "s"]
        return replace(self.moment, since=self.moment.since - round(first * size))

    def _may_be_of_day(self, begin: float, step: float) -> bool:
        """Whether the curve may count the seconds of a day, as it begins far from zero and ends within it."""
        last = begin if self.last is None else self.last
        at_first = self.first is not None and abs(begin - self.first) <= step
        in_seconds = unit_named(self.units.get(self.time or "", "")) == "s"
        return in_seconds and at_first and begin >= _FAR_FROM_START_S and max(begin, last) < _DAY_S


def read_header(text: str, data_title: str) -> LasHeader:
    """Read the sections before the data.

    Parameters
    ----------
    text : all sections but the data
    data_title : the line that begins the data, which may name the curves

    Raises
    ------
    ValueError
        If it is no LAS header, or that of a log over depth.
    """
    import lasio

    # what it makes of lines that are none of a header shows in the curves
    logging.getLogger("lasio").setLevel(logging.CRITICAL)
    text = _NUMBERED.sub(rf"\1{_COLON}\2", text)
    text = _CLOCK.sub(lambda match: match[0].replace(":", _COLON), text)
    text = _SECTION_OF_3.sub(lambda match: _AS_IN_2[match[1].upper()], text)
    try:
        las: Any = lasio.read(io.StringIO(text), ignore_data=True, ignore_header_errors=True, mnemonic_case="preserve")
        version = {key_of(item.original_mnemonic): str(item.value).strip().upper() for item in las.version}
        items = {key_of(str(item.original_mnemonic)): _value(item) for item in (*las.params, *las.well)}
        described_first = next(
            (str(item.descr).strip().replace(_COLON, ":") for item in las.well if item.original_mnemonic == "STRT"), ""
        )
        of_the_file = {
            key_of(str(item.original_mnemonic))
            for item in (*las.params, *las.well)
            if _OF_THE_FILE.search(str(item.descr))
        }
        curves = [
            (str(curve.original_mnemonic).strip().replace(_COLON, ":"), str(curve.unit).strip()) for curve in las.curves
        ]
        descriptions = [str(curve.descr) for curve in las.curves]
    except Exception as error:  # lasio raises whatever it meets in a damaged header
        raise ValueError(f"its header is not that of a LAS file: {error}") from error
    if not curves:
        curves = [(name, "") for name in re.split(r"[\s,|]+", data_title.strip())[1:] if name]
        curves = [] if re.match(r"~\s*LOG_DATA", data_title, re.IGNORECASE) else curves
    if not curves:
        raise ValueError("its section ~C names no curves")
    names = unique([name or f"column {at}" for at, (name, _) in enumerate(curves, 1)])
    units = {name: unit for name, (_, unit) in zip(names, curves, strict=True) if not is_no_unit(unit)}
    time = _time(names, units)
    stated = {name: value for name, value in items.items() if name not in of_the_file} if time is not None else {}
    described = "" if time is None else f"{time} {' '.join(descriptions[names.index(time) :][:1])}"
    of_day = True if _OF_DAY.search(described) else (False if _ELAPSED.search(described) else None)
    null = _number(items.get("NULL", ""))
    if "STRT" in stated and moment_in(stated["STRT"]) is None and moment_in(described_first) is not None:
        stated = {"STRT": described_first}
    return LasHeader(
        names,
        units,
        version.get("WRAP", "").startswith("Y"),
        version.get("DLM", ""),
        time,
        _stated(stated),
        moment_in(stated.get("STRT", "")) is not None,
        _date(stated),
        of_day,
        _number(items.get("STRT", "")),
        _number(items.get("STOP", "")),
        () if null is None else (null,),
    )


def _value(item: Any) -> str:
    return str(item.value).strip().replace(_COLON, ":")


def _time(names: tuple[str, ...], units: dict[str, str]) -> str | None:
    """The index where it is a time, else a curve that is named like one."""
    index, unit = names[0], units.get(names[0], "").upper()
    named = time_among(names)
    if named is None and date_among(names) is None and (key_of(index) in _DEPTHS or unit in _LENGTHS):
        raise Unusable(f"is a log over depth, whose index is '{index}'", "Export the log over time")
    if named is not None:
        return named
    return index if unit_named(unit) is not None or re.search(r"Y.*M.*D|H.*M.*S", unit) else None


def _stated(items: dict[str, str]) -> Moment | None:
    """STRT where it is a time, or a date with a time of day."""
    whole = next((found for name in _MOMENTS if (found := moment_in(items.get(name, ""))) is not None), None)
    if whole is not None:
        return whole
    date = _date(items)
    clocks = [found for name in _CLOCKS if (found := moment_in(items.get(name, ""), timed=True)) is not None]
    return replace(clocks[0], since=date.since + clocks[0].since) if date and clocks else None


def _date(items: dict[str, str]) -> Moment | None:
    return next((found for name in _DATES if (found := moment_in(items.get(name, ""), dated=True)) is not None), None)


def moment_in(text: str, dated: bool = False, timed: bool = False) -> Moment | None:
    """Text that holds a date and a time of day; or either alone, where that is asked for."""
    import pyarrow as pa

    if not text:
        return None
    try:
        found = parse(pa.chunked_array([[text]]))
    except UnclearDate:
        return None
    if found is None or found.wrong[0]:
        return None
    wanted = (dated, timed) if dated or timed else (True, True)
    moment = Moment(int(found.since[0]), found.zoned, found.offset)
    return moment if (found.dated, found.timed) == wanted else None


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None

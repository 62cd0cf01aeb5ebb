"""What the header of a LAS file says about its curves and its times."""

from __future__ import annotations

import io
import logging
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from drillid.formats.counted_times import COUNTED, unit_named
from drillid.formats.description import Unusable
from drillid.formats.header_rows import unique
from drillid.formats.mnemonics import date_among, is_no_unit, key_of, time_among
from drillid.formats.since import FAR_FROM_START_S, counts_from_day
from drillid.formats.written_times import parse_one

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
"""Words in the description of a date that is that of the file and not of its data."""
_NUMBERED = re.compile(r"^([^\S\r\n]*[^.:~#\s][^.:\r\n]*):(\d+(?=[^\S\r\n]*\.))", re.MULTILINE)
_COLON = "\x1f"
"""Stands for the colon in 'TQ:2' and in times of day, which lasio cannot handle."""
_CLOCK = re.compile(r"(?<![\d:.])\d{1,2}:\d{2}:\d{2}(?!\d)|(?<=:)[^\S\r\n]*\d{1,2}:\d{2}(?=[^\S\r\n]*$)", re.MULTILINE)
_CLOCK_UNIT = re.compile(r"H.*M.*S", re.IGNORECASE)
"""Units of times of day written as numbers, which are not counts."""
_DAY_S = 86_400.0


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

    names : names of the curves, each once
    units : by the curves' names
    wrapped : whether a row takes several lines
    delimiter : COMMA, TAB or SPACE where the file says so, else empty
    time : the curve of times, where there is no doubt
    moment, moment_is_first : the time that the file states for its first row, and whether STRT itself is that
    day : midnight of the date that the file states
    counts_from_day : whether the file says that the curve counts from midnight; None where it says nothing
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

        The moment belongs to STRT, the first value; where the values begin at zero it belongs to zero, from which the
        first may be a step away.

        Parameters
        ----------
        index : the first values of the curve; empty where they are not numbers
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
        return in_seconds and at_first and begin >= FAR_FROM_START_S and max(begin, last) < _DAY_S


def read_header(text: str, data_title: str) -> LasHeader:
    """Read the sections before the data.

    Parameters
    ----------
    text : all sections except the data
    data_title : the line that begins the data, which may name the curves

    Raises
    ------
    ValueError
        If it is not a LAS header, or is that of a log over depth.
    """
    version, items, curves = _sections(text)
    # other software names the curves in the title of the data alone
    curves = curves or _named_in(data_title)
    if not curves:
        raise ValueError("its section ~C names no curves")
    names = unique([curve.name or f"column {at}" for at, curve in enumerate(curves, 1)])
    units = {name: curve.text for name, curve in zip(names, curves, strict=True) if not is_no_unit(curve.text)}
    time = _time(names, units)
    stated = _stated(items) if time is not None else {}
    null = _number(_text(items, "NULL"))
    return LasHeader(
        names,
        units,
        _text(version, "WRAP").upper().startswith("Y"),
        _text(version, "DLM").upper(),
        time,
        _moment(stated),
        moment_in(stated.get("STRT", "")) is not None,
        _date(stated),
        None if time is None else counts_from_day(f"{time} {curves[names.index(time)].description}"),
        _number(_text(items, "STRT")),
        _number(_text(items, "STOP")),
        () if null is None else (null,),
    )


class _Item(NamedTuple):
    """A line of the header; the text is the unit of a curve, else the value."""

    name: str
    text: str
    description: str


def _sections(text: str) -> tuple[dict[str, _Item], dict[str, _Item], list[_Item]]:
    """Version lines and the well and parameter lines, both by their keys, and the curve lines."""
    import lasio

    # what lasio makes of lines that do not belong to a header shows in the curves
    logging.getLogger("lasio").setLevel(logging.CRITICAL)
    text = _NUMBERED.sub(rf"\1{_COLON}\2", text)
    text = _CLOCK.sub(lambda match: match[0].replace(":", _COLON), text)
    text = _SECTION_OF_3.sub(lambda match: _AS_IN_2[match[1].upper()], text)
    try:
        las: Any = lasio.read(io.StringIO(text), ignore_data=True, ignore_header_errors=True, mnemonic_case="preserve")
        version, others = (
            {key_of(item.name): item for item in (_item(line, line.value) for line in section)}
            for section in (las.version, (*las.params, *las.well))
        )
        curves = [_item(curve, curve.unit) for curve in las.curves]
    except Exception as error:  # lasio raises whatever it meets in a damaged header
        raise ValueError(f"its header is not that of a LAS file: {error}") from error
    return version, others, curves


def _item(line: Any, text: Any) -> _Item:
    return _Item(*(str(part).strip().replace(_COLON, ":") for part in (line.original_mnemonic, text, line.descr)))


def _text(items: dict[str, _Item], name: str) -> str:
    return items[name].text if name in items else ""


def _named_in(data_title: str) -> list[_Item]:
    """Curves named in the line that begins the data."""
    if re.match(r"~\s*LOG_DATA", data_title, re.IGNORECASE):
        return []
    return [_Item(name, "", "") for name in re.split(r"[\s,|]+", data_title.strip())[1:] if name]


def _stated(items: dict[str, _Item]) -> dict[str, str]:
    """What may be times of the data; where STRT is not a time but its description holds one, that alone."""
    stated = {name: item.text for name, item in items.items() if not _OF_THE_FILE.search(item.description)}
    if "STRT" in stated and moment_in(stated["STRT"]) is None:
        described = items["STRT"].description
        return stated if moment_in(described) is None else {"STRT": described}
    return stated


def _time(names: tuple[str, ...], units: dict[str, str]) -> str | None:
    """The index where it is a time, else a curve that is named like one."""
    index, unit = names[0], units.get(names[0], "").upper()
    named = time_among(names)
    if named is None and date_among(names) is None and (key_of(index) in _DEPTHS or unit in _LENGTHS):
        raise Unusable(f"is a log over depth, whose index is '{index}'", "Export the log over time")
    if named is not None:
        return named
    return index if unit_named(unit) is not None or re.search(r"Y.*M.*D|H.*M.*S", unit) else None


def _moment(items: dict[str, str]) -> Moment | None:
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
    """The date and time of day in a text; or either alone, where that is asked for."""
    found = parse_one(text)
    if found is None:
        return None
    wanted = (dated, timed) if dated or timed else (True, True)
    moment = Moment(int(found.since[0]), found.zoned, found.offset)
    return moment if (found.dated, found.timed) == wanted else None


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None

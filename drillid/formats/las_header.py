"""What the header of a LAS file says about its curves and its times."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from drillid.formats.counted_times import unit_named
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


_LOG_SECTION = re.compile(r"^~\s*LOG_(DEFINITION|PARAMETER)[^\r\n]*", re.IGNORECASE | re.MULTILINE)
_AS_IN_2 = {"DEFINITION": "~Curve", "PARAMETER": "~Parameter"}
"""Sections of LAS 3.0 by their names in LAS 2.0."""
_OF_THE_FILE = re.compile(r"export|creat|print|written|report|file", re.IGNORECASE)
"""Words about a date that is that of the file and not of its data."""
_NUMBERED = re.compile(r"^([^\S\r\n]*[^.:~#\s][^.:\r\n]*):(\d+(?=[^\S\r\n]*\.))", re.MULTILINE)
_COLON = "\x1f"
"""Stands for the colon in 'TQ:2', of which lasio knows nothing."""


@dataclass(frozen=True)
class LasHeader:
    """Curves of a LAS file and what the other sections say about its times.

    names : of the curves, each once
    units : by the curves' names
    wrapped : whether a row takes several lines
    delimiter : COMMA, TAB or SPACE where the file says so, else empty
    time : the curve of times, where there is no doubt
    start : time that this curve counts from
    nulls : numbers for missing values
    """

    names: tuple[str, ...]
    units: dict[str, str]
    wrapped: bool
    delimiter: str
    time: str | None
    start: np.datetime64 | None
    nulls: tuple[float, ...]


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

    text = _NUMBERED.sub(rf"\1{_COLON}\2", text)
    text = _LOG_SECTION.sub(lambda match: _AS_IN_2[match[1].upper()], text)
    try:
        las: Any = lasio.read(io.StringIO(text), ignore_data=True, ignore_header_errors=True, mnemonic_case="preserve")
        version = {key_of(item.original_mnemonic): str(item.value).strip().upper() for item in las.version}
        items = {key_of(str(item.original_mnemonic)): str(item.value).strip() for item in (*las.params, *las.well)}
        of_the_file = {
            key_of(str(item.original_mnemonic))
            for item in (*las.params, *las.well)
            if _OF_THE_FILE.search(str(item.descr))
        }
        curves = [
            (str(curve.original_mnemonic).strip().replace(_COLON, ":"), str(curve.unit).strip()) for curve in las.curves
        ]
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
    start = None if time is None else _start({name: value for name, value in items.items() if name not in of_the_file})
    null = _number(items.get("NULL", ""))
    return LasHeader(
        names,
        units,
        version.get("WRAP", "").startswith("Y"),
        version.get("DLM", ""),
        time,
        start,
        () if null is None else (null,),
    )


def _time(names: tuple[str, ...], units: dict[str, str]) -> str | None:
    """The index where it is a time, else a curve that is named like one."""
    index, unit = names[0], units.get(names[0], "").upper()
    named = time_among(names)
    if named is None and date_among(names) is None and (key_of(index) in _DEPTHS or unit in _LENGTHS):
        raise Unusable(f"is a log over depth, whose index is '{index}'", "Export the log over time")
    if named is not None:
        return named
    return index if unit_named(unit) is not None or re.search(r"Y.*M.*D|H.*M.*S", unit) else None


def _start(items: dict[str, str]) -> np.datetime64 | None:
    """The time that a curve of seconds counts from: STRT, or a date with a time of day."""
    whole = next((found for name in _MOMENTS if (found := _moment(items.get(name, ""))) is not None), None)
    if whole is None:
        dates = [found for name in _DATES if (found := _moment(items.get(name, ""), dated=True)) is not None]
        clocks = [found for name in _CLOCKS if (found := _moment(items.get(name, ""), timed=True)) is not None]
        whole = dates[0] + clocks[0] if dates and clocks else None
    return None if whole is None else np.datetime64(whole, "ns")


def _moment(text: str, dated: bool = False, timed: bool = False) -> int | None:
    """Ns since 1970 of text that holds a date and a time of day; or ns of either alone, where that is asked for."""
    import pyarrow as pa

    if not text:
        return None
    try:
        found = parse(pa.chunked_array([[text]]))
    except UnclearDate:
        return None
    if found is None or found.wrong[0]:
        return None
    if dated or timed:
        return int(found.since[0]) if found.dated is dated and found.timed is timed else None
    return int(found.since[0]) if found.dated and found.timed else None


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None

"""WITS streams of level 0 as a recorder saves them: text records of items, each a code of four digits and a value.

A record stands between the lines `&&` and `!!`; the first two digits of a code are the type of the record, the others
the item in it. Items of the type 1, general time-based, are called by their mnemonics, those of other types by their
codes. Units are agreed between sender and receiver and stand nowhere in the stream.

API Publication 3855, Wellsite Information Transfer Specification (WITS), revision 1.1, 1991.
"""

from __future__ import annotations

import mmap
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

from drillid.formats.arrow_tables import with_notes
from drillid.formats.description import Dialect, Header, Note, Unusable

SUFFIXES = (".wits", ".wits0", ".wit")
LEAVES_ROWS_OUT = True
MNEMONICS = (
    *("WELLID", "STKNUM", "RECID", "SEQID", "DATE", "TIME", "ACTC", "DBTM", "DBTV", "DMEA", "DVER", "BPOS", "ROPA"),
    *("HKLA", "HKLX", "WOBA", "WOBX", "TQA", "TQX", "RPMA", "SPPA", "CHKP", "SPM1", "SPM2", "SPM3", "TVA", "TVCA"),
    *("MFOP", "MFOA", "MFIA", "MDOA", "MDIA", "MTOA", "MTIA", "MCOA", "MCIA", "STKC", "LSTK", "DRTM", "GASA"),
)
"""Items 1 to 40 of the records of type 1."""
_TIME_BASED = "01"
_DATE, _TIME = "05", "06"
"""Items that every type of record holds."""
_WRITTEN_DATE = "YYMMDD"
_CLOCK = (r"^(\d\d)(\d\d)(\d\d(?:[.,]\d*)?)$", r"\1:\2:\3")
_MARK = re.compile(rb"^[ \t]*(&&|!!)", re.MULTILINE)
_ITEM = re.compile(rb"^[ \t]*(\d{4})[ \t]*([^\r\n]*?)[ \t]*\r?$", re.MULTILINE)


@contextmanager
def _mapped(path: Path) -> Iterator[mmap.mmap]:
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        yield content


def headers(path: Path, dialect: Dialect) -> list[Header]:
    """A table for each type of record."""
    items: dict[str, dict[str, None]] = {}
    with _mapped(path) as content:
        for _, record in _records(content):
            for code in record:
                items.setdefault(code[:2], {})[code] = None
    if not items:
        raise Unusable("holds no whole record between && and !!", "Save the stream again; it may have been cut short")
    if not any(kind + _TIME in codes for kind, codes in items.items()):
        raise Unusable(
            "holds records without times, which are their items 05 and 06",
            "Configure the sender to send these items, or save the stream as a table with times",
        )
    found = [_header(kind, sorted(codes)) for kind, codes in sorted(items.items())]
    return found if len(found) > 1 else [Header(**{**vars(found[0]), "table": ""})]


def _header(kind: str, codes: Sequence[str]) -> Header:
    layout = {_name(code): code for code in codes}
    date, time = (_name(kind + item) for item in (_DATE, _TIME))
    dated = date in layout and time in layout
    return Header(
        tuple(layout),
        {date: _WRITTEN_DATE} if date in layout else {},
        table=f"record {int(kind)}",
        time=time if time in layout else None,
        date=date if dated else None,
        layout=layout,
        aliases={code: name for name, code in layout.items() if name != code},
    )


def _name(code: str) -> str:
    number = int(code[2:])
    known = code[:2] == _TIME_BASED and 1 <= number <= len(MNEMONICS)
    return MNEMONICS[number - 1] if known else code


def read_columns(
    path: Path, header: Header, columns: Sequence[str], text: Sequence[str], rows: int | None = None
) -> Any:
    """The columns as an Arrow table; a numeric column with a cell that is not a number stays text."""
    import pyarrow as pa

    codes, needed = [header.layout[name] for name in columns], _of_times(header)
    cells: list[list[str | None]] = [[] for _ in columns]
    taken = left_out = 0
    with _mapped(path) as content:
        for _, record in _of_kind(content, _kind(header)):
            if taken == rows:
                break
            if not all(map(record.get, needed)):
                left_out += 1
                continue
            taken += 1
            for column, code in zip(cells, codes, strict=True):
                column.append(record.get(code) or None)
        notes = [] if rows is not None else [*_cut_short(content), *_without_times(header, left_out, taken + left_out)]
    arrays = [
        _column(column, name in text, header.layout[name].endswith(_TIME))
        for column, name in zip(cells, columns, strict=True)
    ]
    return with_notes(pa.table(dict(zip(columns, arrays, strict=True))), notes)


def _column(cells: list[str | None], as_text: bool, is_clock: bool) -> Any:
    import pyarrow as pa
    import pyarrow.compute as pc

    column = pa.array(cells, pa.string())
    if as_text:
        return pc.replace_substring_regex(column, *_CLOCK) if is_clock else column
    try:
        return column.cast(pa.float64())
    except pa.ArrowInvalid:
        return column


def line_of(path: Path, header: Header, row: int) -> int:
    """Number of the line, counted from 1, in which the record of a row begins."""
    needed, count = _of_times(header), 0
    with _mapped(path) as content:
        for begin, record in _of_kind(content, _kind(header)):
            if not all(map(record.get, needed)):
                continue
            if count == row:
                return content[:begin].count(b"\n") + 1
            count += 1
    return 0


def _of_times(header: Header) -> list[str]:
    """Items that a record of a table must have for its time to be known."""
    return [header.layout[name] for name in (header.time, header.date) if name is not None]


def _kind(header: Header) -> str:
    return str(next(iter(header.layout.values())))[:2]


def _without_times(header: Header, left_out: int, whole: int) -> list[Note]:
    """Notes on how many records of a table are left out because their times are not known."""
    if not left_out:
        return []
    what = f"{left_out} of {whole} records of type {int(_kind(header))} hold no date and time and are left out"
    return [(what, "Configure the sender to send the items 05 and 06 in each record if these are needed")]


def _of_kind(content: mmap.mmap, kind: str) -> Iterator[tuple[int, dict[str, str]]]:
    """Records that hold items of a type."""
    return (found for found in _records(content) if any(code.startswith(kind) for code in found[1]))


def _records(content: mmap.mmap) -> Iterator[tuple[int, dict[str, str]]]:
    """Start of every whole record in the stream, and its values by their codes; of a repeated code the last value."""
    begin: int | None = None
    for mark in _MARK.finditer(content):
        if mark[1] == b"!!" and begin is not None:
            items = _ITEM.findall(content, begin, mark.start())
            yield begin, {code.decode(): value.decode("latin-1") for code, value in items}
        # a record within which another begins was cut short
        begin = mark.start() if mark[1] == b"&&" else None


def _cut_short(content: mmap.mmap) -> list[Note]:
    marks = [mark[1] == b"&&" for mark in _MARK.finditer(content)]
    begun = sum(marks)
    whole = sum(before and not after for before, after in pairwise(marks))
    if begun == whole:
        return []
    what = f"{begun - whole} of {begun} records have no end and are left out"
    return [(what, "Check the line between sender and recorder if there are many")]

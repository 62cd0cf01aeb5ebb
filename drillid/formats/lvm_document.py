"""LabVIEW Measurement files as segments, each with its header, the names of its columns and its rows."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from drillid.formats.packing import lines_at_start, opened
from drillid.formats.since import start_of
from drillid.formats.streams import in_utf_8, lines_of
from drillid.formats.text_layout import decoded

X = "X_Value"
"""Name of the columns of times."""
_COMMENT = "Comment"
_END = "***End_of_Header***"
_BEGIN_SPECIAL, _END_SPECIAL = "***Start_Special***", "***End_Special***"
_OF_FILE, _OF_SEGMENT = "LabVIEW Measurement", "Channels"
"""First cells of a file's header, which an appended recording repeats, and of a segment's header."""
_UNSET, _LAST = np.datetime64("1905"), np.datetime64("2200")
"""A start before the first of these was never set, and no log begins after the second."""


@dataclass(frozen=True)
class Segment:
    """Rows under one header.

    number : its place in the file, from 1
    line : number of the line with the names of its columns, from 1
    delimiter : between cells
    names : names of the columns, without that of comments
    stated : cells of its header by their first cell
    of_file : the same for the header of the file
    rows : lines of data
    lines : line numbers of the rows
    """

    number: int
    line: int
    delimiter: str
    names: tuple[str, ...]
    stated: Mapping[str, Sequence[str]]
    of_file: Mapping[str, Sequence[str]]
    rows: list[str] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)

    @property
    def channels(self) -> list[int]:
        """Places of the columns that do not hold times."""
        return [at for at, name in enumerate(self.names) if name and name != X]

    def times_of(self, channel: int) -> int | None:
        """Place of the column with the times of a channel; None where its samples are equally spaced."""
        if self.setting("X_Columns") == "no":
            return None
        return max((at for at, name in enumerate(self.names[:channel]) if name == X), default=None)

    def setting(self, key: str) -> str:
        """Setting in the header of the file, in lower case; empty where it is not stated."""
        return next(iter(self.of_file.get(key, ())[1:2]), "").lower()

    def of(self, key: str, channel: int) -> str:
        """What its header, else that of the file, states about a channel; empty where neither does."""
        at = channel + (0 if self.names[0] in (X, "") else 1)
        cells = self.stated.get(key, ())
        if at < len(cells) and cells[at]:
            return cells[at]
        cells = self.of_file.get(key, ())
        return cells[1] if len(cells) > 1 else ""

    def number_of(self, key: str, channel: int) -> float | None:
        """The same as a number; None where it is not one."""
        try:
            return float(self.of(key, channel).replace(",", "."))
        except ValueError:
            return None

    def start(self, channel: int) -> int | None:
        """Date and time of a channel's start on the rig's clock, ns since 1970; None where they are not set."""
        date, clock = self.of("Date", channel), self.of("Time", channel)
        start = start_of(f"{date} {clock}") if date and clock else None
        return None if start is None or not _UNSET <= start < _LAST else int(start.astype(np.int64))


def segments_of(path: Path, encoding: str | None) -> Iterator[Segment]:
    """All segments of a file with their rows.

    Raises
    ------
    ValueError
        If it ends within a header.
    """
    start = lines_at_start(path, 2**16)
    _, used = decoded(start, encoding)
    parser = _Parser()
    with opened(path) as content:
        for number, line in enumerate(lines_of(in_utf_8(content, used)), 1):
            yield from parser.take(line.decode(errors="replace").rstrip("\r\n"), number)
    yield from parser.end()


class _Parser:
    """Takes lines one by one and yields whole segments."""

    def __init__(self) -> None:
        self.delimiter = "\t"
        self.of_file: dict[str, list[str]] = {}
        self.stated: dict[str, list[str]] = {}
        self.segment: Segment | None = None
        self.count = 0
        self.in_header, self.awaits_names, self.special = True, False, False

    def take(self, line: str, number: int) -> Iterator[Segment]:
        """The segment that this line ends, if any."""
        if not line.strip():
            return
        first = re.split(r"[\t,]", line.lstrip("\ufeff"), maxsplit=1)[0].strip()
        if first in (_BEGIN_SPECIAL, _END_SPECIAL):
            self.special = first == _BEGIN_SPECIAL
            return
        if self.special:
            return
        if not self.in_header and first in (_OF_FILE, _OF_SEGMENT):
            yield from self._ended()
            self.in_header, self.stated = True, {}
        if self.in_header:
            self._of_header(line.lstrip("\ufeff"), first)
        elif self.segment is None or self.awaits_names:
            self._names(line, number)
        else:
            self.segment.rows.append(line)
            self.segment.lines.append(number)

    def end(self) -> Iterator[Segment]:
        """The last segment."""
        if self.in_header or self.awaits_names:
            raise ValueError("it ends within a header")
        yield from self._ended()

    def _ended(self) -> Iterator[Segment]:
        if self.segment is not None:
            yield self.segment
        self.segment = None

    def _of_header(self, line: str, first: str) -> None:
        if first == _OF_FILE:
            self.delimiter = "," if line[len(_OF_FILE) :].startswith(",") else "\t"
        elif first == "Separator":
            self.delimiter = "," if line[len(first) :].startswith(",") else "\t"
        if first != _END:
            self.stated[first] = [cell.strip() for cell in line.split(self.delimiter)]
        elif _OF_SEGMENT in self.stated:
            self.in_header, self.awaits_names = False, True
        else:
            self.of_file, self.stated = self.stated, {}

    def _names(self, line: str, number: int) -> None:
        names = [name.strip() for name in line.split(self.delimiter)]
        names = names[: names.index(_COMMENT)] if _COMMENT in names else names
        while names and not names[-1]:
            names.pop()
        self.count += 1
        self.segment = Segment(self.count, number, self.delimiter, tuple(names), self.stated, self.of_file)
        self.awaits_names = False

"""Sections of a LAS file: which of them hold data, and which describe these."""

from __future__ import annotations

import mmap
import re
from collections.abc import Sequence
from dataclasses import dataclass

_LARGEST_HEADER = 2**22
"""Largest size of a section before the data, bytes."""
_MOST_SECTIONS = 1000
_LONGEST_TITLE = 400
_BEFORE_TITLE = b" \t\xef\xbb\xbf\x1a"
"""Bytes that may precede a title: spaces, the byte-order mark of UTF-8, the end-of-file mark of a preceding file."""
_VERSION = re.compile(r"~\s*V", re.IGNORECASE)
_OTHER = re.compile(r"~\s*O", re.IGNORECASE)
_LOG_DATA = re.compile(r"~\s*(?:A(?!\w*_(?:DEFINITION|PARAMETER))|LOG_DATA)", re.IGNORECASE)
_KIND = re.compile(
    r"~\s*(?!VERSION_|WELL_|CURVE_|PARAMETER_)(?P<kind>\w+)_(?P<part>DEFINITION|PARAMETER|DATA)\s*(?P<number>\[\d+\])?",
    re.IGNORECASE,
)
"""Sections of LAS 3.0: '~Log_Definition[1]', '~Drilling_Data | Drilling_Definition'."""
_REFERENCE = re.compile(r"[|,]\s*(\w+_DEFINITION\s*(?:\[\d+\])?)", re.IGNORECASE)


@dataclass(frozen=True)
class Section:
    """A section of a file, in bytes.

    title : its first line
    """

    title: str
    begin: int
    end: int

    @property
    def is_data(self) -> bool:
        """Whether it holds rows."""
        return self.is_log or self.part == "DATA"

    @property
    def is_log(self) -> bool:
        """Whether it holds the rows of a log, by its name."""
        return _LOG_DATA.match(self.title) is not None

    @property
    def part(self) -> str:
        """DEFINITION, PARAMETER or DATA where its name says so, else empty."""
        match = _KIND.match(self.title)
        return match["part"].upper() if match else ""

    @property
    def kind(self) -> str:
        """Subject of the section by its name, in capitals, with its number: LOG[1] of '~Log_Data[1]'."""
        match = _KIND.match(self.title)
        return match["kind"].upper() + (match["number"] or "") if match else ""


def sections_of(content: mmap.mmap, encoding: str) -> list[Section]:
    """All sections except remarks, in the file's order.

    Raises
    ------
    ValueError
        If a section without data is too large to be one.
    """
    begins, ends = list[int](), list[int]()
    at = content.find(b"~")
    while at >= 0:
        line = max(content.rfind(b"\n", 0, at), content.rfind(b"\r", 0, at)) + 1
        if not content[line:at].strip(_BEFORE_TITLE):
            begins.append(at)
            ends.append(line)
        if len(begins) > _MOST_SECTIONS:
            raise ValueError(f"it has more than {_MOST_SECTIONS} sections")
        at = content.find(b"~", at + 1)
    found = []
    for begin, end in zip(begins, [*ends[1:], len(content)], strict=False):
        start = content[begin : min(end, begin + _LONGEST_TITLE)].decode(encoding, "replace")
        section = Section(re.split(r"[\r\n]", start, maxsplit=1)[0], begin, end)
        if not section.is_data and end - begin > _LARGEST_HEADER:
            raise ValueError(f"its section {section.title.strip()[:20]} is larger than that of any log")
        if not _OTHER.match(section.title):
            found.append(section)
    return found


def data_among(sections: Sequence[Section]) -> tuple[list[Section], list[Section]]:
    """Sections with the rows of logs, else all that hold rows; and the others that hold rows."""
    data = [section for section in sections if section.is_data]
    logs = [section for section in data if section.is_log] or data
    return logs, [section for section in data if section not in logs]


def describing(data: Section, sections: Sequence[Section]) -> list[Section]:
    """The sections that describe a section of data.

    They belong to the same file, as several files may be concatenated; definitions and parameters are those that the
    data's title names, or those of its kind.
    """
    own = _of_one_file(data, sections)
    reference = _REFERENCE.search(data.title)
    named = Section(f"~{reference[1]}", 0, 0).kind if reference else data.kind
    numbered = {section.kind for section in own if section.part == "DEFINITION"}
    bare = named.partition("[")[0] or "LOG"
    kinds = {"": {""}, "DEFINITION": {named if named in numbered else bare}, "PARAMETER": {named, bare}}
    return [section for section in own if not section.is_data and section.kind in kinds[section.part]]


def _of_one_file(data: Section, sections: Sequence[Section]) -> list[Section]:
    """Sections of the file that holds a section of data; where several are in one, each begins with its version."""
    begins = [section.begin for section in sections if _VERSION.match(section.title)][1:]
    before = max((begin for begin in begins if begin <= data.begin), default=0)
    behind = min((begin for begin in begins if begin > data.begin), default=data.end + sections[-1].end)
    return [section for section in sections if before <= section.begin < behind]

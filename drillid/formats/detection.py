"""Choice of the reader for a file: by its name, and by its content where that says otherwise."""

from __future__ import annotations

import functools
import importlib
import pkgutil
import re
from pathlib import Path
from typing import Any

from drillid.errors import LogError, is_of_machine
from drillid.formats import readers
from drillid.formats.apart import apart
from drillid.formats.description import LogFormat, Note, Unusable
from drillid.formats.packing import PACKED, check_no_tar, first_bytes, inner_name, lines_at_start, notes_on

_LOOKED_AT = 4096
_HDF5 = b"\x89HDF\r\n\x1a\n"
_MAGIC: tuple[tuple[bytes, tuple[str, ...]], ...] = (
    (b"PAR1", (".parquet",)),
    (b"ARROW1", (".feather",)),
    (b"TDSm", (".tdms",)),
    (b"CDF\x01", (".nc",)),
    (b"CDF\x02", (".nc",)),
    (b"CDF\x05", (".nc",)),
    (_HDF5, (".h5", ".nc", ".mat")),
    (b"MATLAB 5.0 MAT-file", (".mat",)),
    (b"MATLAB 7.3 MAT-file", (".mat",)),
    (b"LabVIEW Measurement", (".lvm",)),
    (b"\xef\xbb\xbfLabVIEW Measurement", (".lvm",)),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", (".xls",)),
)
"""First bytes of formats, and endings of the readers that take them, the usual one first."""
_PLAIN_TEXT = (".csv",)
_SAVED_AS_TEXT = (".xls",)
"""Endings of readers that other programs also give to files saved as text."""
_WITS = re.compile(rb"^[ \t]*&&[ \t]*\r?\n[ \t]*\d{4}", re.MULTILINE)
_XML = re.compile(rb"<(?:\w+:)?(?:logs|WITSML|log)\b", re.IGNORECASE)


@functools.cache
def formats() -> dict[str, LogFormat]:
    """Every reader by the endings of the names of its files."""
    by_suffix: dict[str, LogFormat] = {}
    for module in pkgutil.iter_modules(readers.__path__):
        reader: Any = importlib.import_module(f"{readers.__name__}.{module.name}")
        by_suffix |= dict.fromkeys(reader.SUFFIXES, apart(reader))
    return by_suffix


def format_of(path: Path) -> LogFormat:
    """The reader of a file, by its content where that shows its format, else by its name.

    Raises
    ------
    LogError
        If neither is known.
    """
    return reader_of(path)[0]


def reader_of(path: Path) -> tuple[LogFormat, tuple[Note, ...]]:
    """The reader of a file, and notes where name and content disagree and on what lies beside it in an archive."""
    named = _by_name(path)
    try:
        suffixes = _by_content(path)
    except Unusable as error:
        raise LogError(str(path), error.what, error.remedy) from error
    beside = notes_on(path) if suffixes else ()
    if named is not None and _agree(named, suffixes):
        return named, beside
    if not suffixes:
        known = ", ".join(sorted(formats()))
        packed = ", ".join(PACKED)
        raise LogError(
            str(path), "is not in a known format", f"Known endings are {known}, packed as {packed} where that is usual"
        )
    what = f"has the content of a file ending in {suffixes[0]}, and is read as one"
    return formats()[suffixes[0]], (*beside, (what, "Name the file after its format"))


def _agree(named: LogFormat, suffixes: tuple[str, ...]) -> bool:
    """Whether the content does not contradict the name; text is taken as what it is called, except for workbooks."""
    readers_of = [formats()[suffix] for suffix in suffixes]
    if suffixes == _PLAIN_TEXT and set(_SAVED_AS_TEXT).isdisjoint(named.SUFFIXES):
        return True
    return not suffixes or named in readers_of


def suffix_of(path: Path) -> str:
    """The longest ending that a reader knows in the name of a file's content; empty where none does."""
    name = inner_name(path).lower()
    return max((suffix for suffix in formats() if name.endswith(suffix)), key=len, default="")


def _by_name(path: Path) -> LogFormat | None:
    return formats().get(suffix_of(path))


def _by_content(path: Path) -> tuple[str, ...]:
    """Endings of the readers that suit the content; none where it does not show its format.

    Raises
    ------
    Unusable
        If it is an archive from which no single log can be taken.
    """
    if not path.is_file():
        return ()
    start = first_bytes(path, _LOOKED_AT)
    found = _of_bytes(start) or _of_archive(path, start)
    if found or (start.startswith(b"PK") and not path.name.lower().endswith(PACKED)):
        return found
    try:
        content = lines_at_start(path, _LOOKED_AT)
    except Unusable:
        raise
    except (ValueError, OSError) as error:
        if is_of_machine(error):
            raise
        return ()
    check_no_tar(content)
    return _of_bytes(content) or _of_text(content)


def _of_bytes(start: bytes) -> tuple[str, ...]:
    return next((suffixes for magic, suffixes in _MAGIC if start.startswith(magic)), ())


def _of_archive(path: Path, start: bytes) -> tuple[str, ...]:
    """Workbooks are zip files with a certain first or second member."""
    if not start.startswith(b"PK"):
        return ()
    if b"opendocument.spreadsheet" in start:
        return (".ods",)
    if b"[Content_Types].xml" in start or b"xl/" in start or b"_rels/.rels" in start:
        return (".xlsx",)
    return ()


def _of_text(content: bytes) -> tuple[str, ...]:
    from drillid.formats.text_layout import decoded, is_text

    if not content or not is_text(content):
        return ()
    text, _ = decoded(content)
    stripped = text.lstrip("\ufeff \t\r\n").encode()
    if re.match(rb"(?:#[^\n]*\n\s*)*~\s*v", stripped, re.IGNORECASE):
        return (".las",)
    if stripped.startswith(b"<"):
        return (".xml",) if _XML.search(stripped) else ()
    if _WITS.search(stripped):
        return (".wits",)
    return (".csv",)

"""Columns of a log by the names that users give them."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from pathlib import Path

from drillid.errors import LogError
from drillid.formats.description import Header
from drillid.formats.long_form import note_on
from drillid.formats.mnemonics import split_unit
from drillid.formats.places import shortened

_MOST_NAMES = 50
"""Columns or tables that a message lists."""


def column_in(header: Header, name: str) -> str | None:
    """The column of a header that a name stands for: exactly, as the file's other name, without its unit, or in other
    case; None without one.
    """
    if name in header.columns:
        return name
    if name in header.aliases:
        return header.aliases[name]
    bare = split_unit(name)[0]
    alike = [column for column in header.columns if split_unit(column)[0] == bare]
    in_any_case = [column for column in header.columns if split_unit(column)[0].casefold() == bare.casefold()]
    return next((found[0] for found in (alike, in_any_case) if len(found) == 1), None)


def column_named(name: str, header: Header, path: Path) -> str:
    """As `column_in`, but required.

    Raises
    ------
    LogError
        If there is no such column; the message suggests the likely one.
    """
    found = column_in(header, name)
    if found is not None:
        return found
    long_form = note_on(header.columns)
    if long_form is not None:
        raise LogError(str(path), f"has no column '{name}' and {long_form[0]}", long_form[1])
    close = difflib.get_close_matches(name, header.columns, n=1)
    hint = f"Did you mean {listed(close)}?" if close else "Name one of them in the rig description"
    raise LogError(str(path), f"has no column '{name}'; its columns are {listed(header.columns)}", hint)


def listed(names: Sequence[str]) -> str:
    """Names as a message quotes them: very many, and very long ones, are shortened."""
    shown = [f"'{shortened(name)}'" for name in names[:_MOST_NAMES]]
    more = [f"and {len(names) - _MOST_NAMES} more"] if len(names) > _MOST_NAMES else []
    return ", ".join(shown + more) or "none"

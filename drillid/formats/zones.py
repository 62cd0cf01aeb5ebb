"""Time zones as files state them: in the name or unit of a column of times, or in a text nearby."""

from __future__ import annotations

import datetime
import functools
import re
import zoneinfo

_OFFSET = re.compile(r"(?:(?:UTC|GMT) ?|(?=[+-]\d{2}:))([+-]) ?(\d{1,2})(?::?(\d{2}))?", re.IGNORECASE)
_UTC = re.compile(r"UTC|GMT|Zulu", re.IGNORECASE)
_OFFSET_IN_NAME = re.compile(r"(?:UTC|GMT) ?[+-] ?\d{1,2}(?::?\d{2})?(?!\d)", re.IGNORECASE)
_UTC_IN_NAME = re.compile(r"(?:UTC|GMT)(?!\d).*|.*(?:UTC|GMT)", re.IGNORECASE)
_ABBREVIATION = re.compile(r"(?:^|[\[( _])([A-Z]{2,4}T|MEZ|MESZ|MSK)[\])]?$")
_ZONE_NEARBY = re.compile(r"(?:time ?zone|zeitzone|(?:utc|gmt) ?offset)[ \"']*[:=,;\t][ \"']*(.+)", re.IGNORECASE)
_FURTHEST_H = 14
"""Largest offset of any zone, hours."""


def zone_in(text: str) -> datetime.tzinfo | None:
    """The zone in a text that is nothing else, such as 'UTC+3', '+03:00', 'UTC' or 'Europe/Oslo'; None for any other.

    Abbreviations such as CST stand for several zones and do not count.
    """
    plain = text.strip()
    if _UTC.fullmatch(plain):
        return datetime.UTC
    match = _OFFSET.fullmatch(plain)
    if match is not None:
        hours, minutes = int(match[2]), int(match[3] or 0)
        if hours > _FURTHEST_H or minutes > 59:
            return None
        offset = datetime.timedelta(hours=hours, minutes=minutes)
        return datetime.timezone(offset if match[1] == "+" else -offset)
    return zoneinfo.ZoneInfo(plain) if "/" in plain and plain in _areas() else None


def zone_of_column(name: str, unit: str) -> datetime.tzinfo | None:
    """The zone that the unit of a column of times states, else its name, as 'Time_UTC' does; None without one."""
    offset = _OFFSET_IN_NAME.search(name)
    stated = zone_in(unit) or (None if offset is None else zone_in(offset[0]))
    if stated is not None:
        return stated
    bare = re.sub(r"[\[({].*|[\W_]", "", name)
    return datetime.UTC if _UTC_IN_NAME.fullmatch(bare) else None


def abbreviation_of_zone(name: str, unit: str) -> str | None:
    """What looks like an abbreviation of a zone, such as CST, as the unit or at the end of the name of a column."""
    match = _ABBREVIATION.search(unit) or _ABBREVIATION.search(name)
    return None if match is None or match[1] == "GMT" else match[1]


def states_zone(text: str) -> bool:
    """Whether a line of text states a time zone, as 'Time zone: UTC+3' does."""
    match = _ZONE_NEARBY.search(text)
    return match is not None and zone_in(match[1].split(",")[0].strip("\"';|\t ")) is not None


@functools.cache
def _areas() -> frozenset[str]:
    return frozenset(zoneinfo.available_timezones())

"""Starts of counted times in files: 'seconds since 2025-03-03 06:00:00', '2025-03-03T06:00:00Z', midnight."""

from __future__ import annotations

import re

import numpy as np

from drillid.formats.written_times import parse_one

FAR_FROM_START_S = 600.0
"""First value from which times cannot count from the log's start."""
_OF_DAY = re.compile(r"of (the )?day|midnight", re.IGNORECASE)
_ELAPSED = re.compile(r"^ET\b|^ETIME?\b|elapsed|since|cumul|from start", re.IGNORECASE)
"""Names and descriptions of a column of times that counts from the log's start."""
_SINCE = re.compile(r"^\s*\w+\s+since\s+(.+)$", re.IGNORECASE)


def start_of(text: str) -> np.datetime64 | None:
    """The time in such a text, UTC where it has a zone; None for any other text."""
    found = stated_start(text)
    return None if found is None else found[0]


def stated_start(text: str) -> tuple[np.datetime64, bool] | None:
    """The time in such a text, and whether it has a zone and is UTC; None for any other text."""
    match = _SINCE.match(text)
    stamp = re.sub(r"(\d)\.?0* ?(?:UTC|GMT)$", r"\1Z", (match[1] if match else text).strip())
    found = parse_one(stamp)
    if found is None or not found.dated:
        return None
    return np.datetime64(int(found.since[0]), "ns"), found.zoned


def unit_since(text: str) -> str:
    """The unit in 'seconds since …', or the text itself."""
    return re.split(r"\s+since\s", text, maxsplit=1)[0].strip() if _SINCE.match(text) else text


def counts_from_day(described: str) -> bool | None:
    """Whether a column with this name or description counts from midnight; None where it does not say."""
    if _OF_DAY.search(described):
        return True
    return False if _ELAPSED.search(described) else None

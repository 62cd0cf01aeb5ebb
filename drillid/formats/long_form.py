"""Tables in long form, which have a row for each value of a tag, where a log has a column for each channel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from drillid.formats.description import Header, Note
from drillid.formats.mnemonics import MNEMONICS, key_of, time_among

_TAGS = (
    *("TAG", "TAGNAME", "TAGID", "CHANNEL", "CHANNELNAME", "CHANNELID", "MNEMONIC", "PARAMETER", "PARAMETERNAME"),
    *("SENSOR", "SENSORNAME", "SENSORID", "SIGNAL", "SIGNALNAME", "VARIABLE", "METRIC", "POINT", "POINTNAME"),
    *("FIELD", "SERIES", "CURVE", "CURVENAME", "ITEM", "NAME"),
)
_VALUES = ("VALUE", "VAL", "VALUES", "DATAVALUE", "NUMERICVALUE", "READING", "WERT", "MESSWERT", "VALOR", "VERDI")


def noted(header: Header) -> Header:
    """A header with a note where its table looks like one in long form."""
    note = note_on(header.columns)
    return header if note is None else replace(header, notes=(*header.notes, note))


def note_on(columns: Sequence[str]) -> Note | None:
    """A note that columns look like the long form, and how to make a log of it; None where they do not."""
    by_key = {key_of(name): name for name in reversed(columns)}
    tag, value = (next((by_key[key] for key in keys if key in by_key), None) for keys in (_TAGS, _VALUES))
    if tag is None or value is None or any(key in by_key for keys in MNEMONICS.values() for key in keys):
        return None
    time = time_among(columns) or "Time"
    what = f"looks like long form: a row for each value of the column '{tag}', and no column for each channel"
    pivoted = f"log.pivot_table(index='{time}', columns='{tag}', values='{value}', aggfunc='last').reset_index()"
    return what, f"Write a column for each channel, such as by pandas with {pivoted}"

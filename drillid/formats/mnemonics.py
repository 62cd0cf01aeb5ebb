"""Names of columns: units in them, the mnemonics of WITS and WITSML, times and dates."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Sequence

from drillid.formats.zones import zone_in
from drillid.units.names import known_units

MNEMONICS = {
    "torque_command": (
        *("TQCMD", "TORQUECOMMAND", "TORQUECMD", "TQREF", "TORQUEREF", "TORQUESETPOINT", "TDTQCMD", "TQA", "TQX", "TQ"),
        *("TORQUE", "STOR", "TORQ", "TRQ", "SURFTORQUE", "SURFACETORQUE", "TDTORQUE", "TDTRQ", "TDTQ", "ROTARYTORQUE"),
        *("TOPDRIVETORQUE", "TORQUEABS", "TORQUEAVG", "DREHMOMENT", "MOMENT", "DREIEMOMENT"),
    ),
    "speed": (
        *("RPMA", "RPM", "SURFRPM", "SURFACERPM", "ROTRPM", "TDRPM", "ROTARYSPEED", "ROTARYRPM", "TDSPEED", "SRPM"),
        *("TOPDRIVERPM", "TOPDRIVESPEED", "RPMSURFACE", "RPMAVG", "ROTATION", "SPEED", "DREHZAHL", "TURTALL"),
        "TOPDRIVEROTARY",
    ),
    "speed_set": (
        *("RPMSP", "RPMSET", "SETRPM", "TDRPMSP", "RPMSETPOINT", "SPEEDSETPOINT", "SPEEDSET", "ROTARYSET", "RPMREF"),
        *("TDRPMSET", "SETPOINT", "SET"),
    ),
    "hole_depth": (
        *("DMEA", "DEPTMEAS", "HOLEDEPTH", "HDEP", "DEPTHHOLE", "HDTH", "MEASUREDDEPTH", "HOLEDEPTHMD", "TOTALDEPTH"),
        *("HOLE", "DEPTH", "TEUFE", "BOHRTEUFE", "HULLDYBDE", "DYBDE"),
    ),
    "bit_depth": (
        *("DBTM", "DEPTBITM", "BITDEPTH", "BDEP", "DEPTHBIT", "DBIT", "BITPOSITION", "BITMD", "BIT"),
        *("BITDYBDE", "MEISSELTEUFE", "MEIßELTEUFE"),
    ),
    "weight_on_bit": ("WOBA", "WOBX", "WOB", "SWOB", "WEIGHTONBIT", "SURFACEWOB", "WOBAVG"),
    "flow": (
        *("MFIA", "MFIP", "FLOWIN", "MUDFLOWIN", "FLWI", "TFLO", "MFI", "FLIN", "FLOW", "FLOWRATE", "PUMPFLOW"),
        *("FLOWINRATE", "TOTALPUMPOUTPUT", "MUDFLOWINAVG"),
    ),
    "standpipe_pressure": ("SPPA", "SPP", "STANDPIPEPRESSURE", "SPPRESS", "PUMPPRESSURE", "STANDPIPE", "SPPAVG"),
    "hook_load": ("HKLA", "HKLX", "HKLD", "HKL", "HOOKLOAD", "HKLO", "HOOKLOADAVG", "HAKENLAST", "KROKLAST"),
}
"""Names under which WITS, WITSML, recorders and offices keep a channel, the likelier first, in capitals without
punctuation. An injected sweep has none."""
SURE = {
    "torque_command": ("TQA",),
    "speed": ("RPMA",),
    "hole_depth": ("DMEA",),
    "bit_depth": ("DBTM",),
    "weight_on_bit": ("WOBA",),
    "flow": ("MFIA",),
    "standpipe_pressure": ("SPPA",),
    "hook_load": ("HKLA",),
}
"""Those of them that are WITS mnemonics, which denote nothing else."""
WITHOUT_UNIT = {"speed": "rpm", "speed_set": "rpm"}
"""Channels that have a single unit in WITS, metric or not."""

_TIMES = (
    *("time", "timestamp", "datetime", "dateandtime", "dateandtimeutc", "timedate", "timeutc", "utctime", "utc"),
    *("timestamputc", "localtime", "timelocal", "datetimeutc", "rtime", "logtime", "timeindex", "zeit", "datumzeit"),
    *("tid", "datotid", "hora", "fechahora", "heure", "время", "etim", "etime", "elapsedtime", "unixtime", "epoch"),
    *("uhrzeit", "zeitstempel", "zeitpunkt", "datumuhrzeit", "tijd", "tijdstip", "datumtijd", "tidspunkt"),
    *(
        "klokkeslett",
        "ora",
        "dataora",
        "orario",
        "horodatage",
        "dateheure",
        "rigtime",
        "rigclock",
        "clock",
        "clocktime",
    ),
    "timeofday",
    *("hhmmss", "seconds", "secs", "ts", "t", "tsec", "timesec", "datenum", "index"),
)
_DATES = (
    *("date", "dateutc", "localdate", "datum", "dato", "fecha", "дата"),
    *("yyyymmdd", "ddmmyyyy", "mmddyyyy", "yymmdd", "ddmmyy", "mmddyy", "day"),
)
_MILLISECONDS = ("millisecond", "milliseconds", "millis", "millisec", "msec", "ms", "millisekunde", "millisekunden")
_PARTS = (
    ("year", "yyyy", "yr", "yy", "jahr"),
    ("month", "mm", "mon", "mo", "monat"),
    ("day", "dd", "dy", "dayofmonth", "tag"),
    ("hour", "hours", "hh", "hr", "hrs", "stunde"),
    ("minute", "minutes", "min", "mins", "mi", "mn", "mm2"),
    ("second", "seconds", "sec", "secs", "ss", "sekunde"),
)
"""Names of the parts of a time; 'mm2' is the second of two columns 'MM'."""
_OFFSETS = ("utcoffset", "offsetutc", "gmtoffset", "timezone", "tz", "tzoffset", "timezoneoffset", "zeitzone", "utcoff")
_AVERAGE = re.compile("^AVERAGED?")
_IN_BRACKETS = re.compile(r"^(?P<name>.*?\S)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>.*)\)|\{(?P<curly>[^{}]*)\})$")
_AFTER_COMMA = re.compile(r"^(?P<name>.*?\S)\s*,\s*(?P<unit>[^,]+)$")
_LAST_WORD = re.compile(r".*\S (\S+)")
_FEWEST_WITH_UNITS = 3
_LONGEST_UNCLEAR = 2
_WORDS = frozenset(("in", "at", "a", "c", "d", "k", "r", "u", "v"))
"""Units that are also words or letters in names."""
_NO_UNIT = {"", "-", "--", "---", "none", "unitless", "n/a", "na", "_", "."}
_OF_OTHER_LOGS = frozenset(
    ("api", "gapi", "degc", "degf", "ppm", "ohmm", "ohm", "euc", "mv", "v", "a", "ma", "us", "gal")
)
_LONGEST_UNIT = 40
_OTHER_UNITS = ("datetime", "date", "text", "string", "unknown", "hh:mm:ss", "yyyy/mm/dd", "yyyy-mm-dd", "dd/mm/yyyy")


def split_unit(name: str) -> tuple[str, str]:
    """Name and unit of a column such as 'TQA [kN.m]', 'Torque (ft-lbf)' or 'Depth, m'; no unit where there is none."""
    stripped = name.strip()
    match = _IN_BRACKETS.match(stripped)
    if match is not None:
        unit = next(part for part in (match["square"], match["round"], match["curly"]) if part is not None).strip()
        if is_unit(unit) or match["square"] is not None:
            return match["name"], "" if unit.lower() in _NO_UNIT else unit
        return stripped, ""
    match = _AFTER_COMMA.match(stripped)
    if match is not None and is_unit(match["unit"].strip()):
        return match["name"], match["unit"].strip()
    return stripped, ""


def units_at_ends(names: Sequence[str]) -> dict[str, str]:
    """Units behind a space at the ends of names such as 'Bit Depth m', where at least half of the names end so."""
    ends = {name: _LAST_WORD.fullmatch(name.strip()) for name in names if split_unit(name) == (name.strip(), "")}
    found = {name: match[1] for name, match in ends.items() if match is not None and _is_unit_at_end(match[1])}
    if len(found) < _FEWEST_WITH_UNITS or 2 * len(found) < len(names):
        return {}
    return {name: unit for name, unit in found.items() if not is_no_unit(unit)}


def _is_unit_at_end(word: str) -> bool:
    """Whether a last word can only be a unit, unlike those of 'Flow In' and 'Drive A'."""
    exact = word in known_units() or len(word) > _LONGEST_UNCLEAR
    return is_unit(word) and exact and word.lower() not in _WORDS


def is_unit(text: str) -> bool:
    """Whether the text is the name of a unit, or says that there is none."""
    plain = text.strip()
    if plain.lower() in (*_NO_UNIT, *_OTHER_UNITS) or _looks_like_date_format(plain) or zone_in(plain) is not None:
        return True
    words = [word for word in re.findall(r"[^\W\d_]+|[%°\"'#]", plain) if word.lower() != "per"]
    return bool(words) and all(word.casefold() in _unit_names() for word in words) and len(plain) < _LONGEST_UNIT


@functools.cache
def _unit_names() -> frozenset[str]:
    """Names of units in lower case; those that only pint knows are not worth its import here."""
    return frozenset(name.casefold() for name in known_units()) | _OF_OTHER_LOGS


def is_no_unit(text: str) -> bool:
    """Whether the text says that a column has no unit."""
    return text.strip().lower() in _NO_UNIT


def _looks_like_date_format(text: str) -> bool:
    return bool(re.fullmatch(r"(?i)[ymdhs.,:/ t-]*(?:yy|hh|ss)[ymdhs.,:/ t-]*(?:\.?[sf0]+)?z?", text))


def key_of(name: str) -> str:
    """A name in capitals, without its unit and without punctuation."""
    return re.sub(r"[\W_]", "", split_unit(name)[0]).upper()


def channel_column(channel: str, columns: Iterable[str]) -> str | None:
    """The column that is named like the channel, the likeliest of several."""
    by_key, averages = dict[str, str](), dict[str, str]()
    for column in columns:
        key = key_of(column)
        by_key.setdefault(key, column)
        averages.setdefault(_AVERAGE.sub("", key), column)
    by_key = averages | by_key
    return next((by_key[name] for name in MNEMONICS.get(channel, ()) if name in by_key), None)


def surely(channel: str, columns: Iterable[str]) -> str | None:
    """The one column that has the channel's mnemonic in WITS."""
    names = list(columns)
    for mnemonic in SURE.get(channel, ()):
        found = [name for name in names if key_of(name) == mnemonic]
        if len(found) == 1:
            return found[0]
    return None


def time_among(columns: Iterable[str]) -> str | None:
    """The column that is named like a time, the likeliest of several."""
    return next(iter(times_among(columns)), None)


def times_among(columns: Iterable[str]) -> list[str]:
    """All columns that are named like a time, the likelier first."""
    return _named(_TIMES, columns)


def date_among(columns: Iterable[str]) -> str | None:
    """The column that is named like a date."""
    return next(iter(_named(_DATES, columns)), None)


def milliseconds_among(columns: Iterable[str]) -> str | None:
    """The column that is named like the milliseconds of a time."""
    return next(iter(_named(_MILLISECONDS, columns)), None)


def parts_among(columns: Sequence[str]) -> tuple[str, ...]:
    """Columns of year, month, day, hour, minute and second; empty where one is missing."""
    found = [next(iter(_named(names, columns)), None) for names in _PARTS]
    whole = tuple(name for name in found if name is not None)
    return whole if len(whole) == len(_PARTS) else ()


def offset_among(columns: Iterable[str]) -> str | None:
    """The column that is named like the time zone of the times, or like their offset from UTC."""
    return next(iter(_named(_OFFSETS, columns)), None)


def _named(names: tuple[str, ...], columns: Iterable[str]) -> list[str]:
    """Columns with one of the names, in the names' order; the first of several columns of a name."""
    by_key: dict[str, str] = {}
    for column in columns:
        by_key.setdefault(key_of(column).lower(), column)
    return [by_key[name] for name in names if name in by_key]

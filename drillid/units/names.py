"""Names of units as rigs, WITSML and LAS files and offices write them, with their values in SI."""

from __future__ import annotations

import difflib
import functools
import itertools
import math
from dataclasses import dataclass
from typing import Any

STANDARD_GRAVITY = 9.80665
"""m/s²; hook load and weight on bit are logged as masses and mean forces."""

Dimension = tuple[int, int, int]
"""Powers of length, mass and time; angles count as numbers."""

_LENGTH, _MASS, _TIME, NUMBER, RATE = (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0), (0, 0, -1)
_FORCE, _TORQUE, _PRESSURE = (1, 1, -2), (2, 1, -2), (-1, 1, -2)
_VOLUME, _FLOW, _DENSITY, _POWER = (3, 0, 0), (3, 0, -1), (-3, 1, 0), (2, 1, -3)
_POUND, _FOOT, _INCH, _GALLON, _GALLON_UK = 0.45359237, 0.3048, 0.0254, 3.785411784e-3, 4.54609e-3
_POUND_FORCE = _POUND * STANDARD_GRAVITY
_BARREL = 42 * _GALLON
TURN = 2 * math.pi

_PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "h": 1e2, "da": 10.0, "d": 0.1, "c": 1e-2, "m": 1e-3, "n": 1e-9, "": 1.0}
_PREFIXES |= dict.fromkeys(("μ", "u"), 1e-6)
_WITH_PREFIX: tuple[tuple[str, str, float, Dimension], ...] = (
    ("m", "k h da d c m μ u", 1.0, _LENGTH),
    ("s", "m μ u n", 1.0, _TIME),
    ("g", "m", 1e-3, _MASS),
    ("N", "M k h da d c m", 1.0, _FORCE),
    ("Pa", "G M k h m", 1.0, _PRESSURE),
    ("bar", "k d m", 1e5, _PRESSURE),
    ("L", "k h d c m", 1e-3, _VOLUME),
    ("l", "k h d c m", 1e-3, _VOLUME),
    ("J", "k M", 1.0, _TORQUE),
    ("W", "k M", 1.0, _POWER),
    ("gf", "k", 1e-3 * STANDARD_GRAVITY, _FORCE),
    # offices count these in thousands
    ("kgf", "k", STANDARD_GRAVITY, _FORCE),
    ("kg", "k", 1.0, _MASS),
    ("daN", "k", 10.0, _FORCE),
    ("ft", "k", _FOOT, _LENGTH),
    ("lb", "k", _POUND, _MASS),
    ("lbs", "k", _POUND, _MASS),
    ("lbm", "k", _POUND, _MASS),
    ("lbf", "k", _POUND_FORCE, _FORCE),
    ("psi", "k", _POUND_FORCE / _INCH**2, _PRESSURE),
)
"""Symbols with the prefixes that they take, their value in SI and their dimension."""
_ONLY_AS_WRITTEN = {"mN", "mPa", "hN", "dN", "cN", "MN", "mg", "um", "us", "ns"}
"""Symbols that no other case of their letters is taken for."""
_NAMES: tuple[tuple[str, float, Dimension], ...] = (
    ("metre metres meter meters mtr mtrs mts м", 1.0, _LENGTH),
    ("foot feet F ' фут", _FOOT, _LENGTH),
    ("ftUS usft", 1200 / 3937, _LENGTH),
    ('inch inches in "', _INCH, _LENGTH),
    ("yd yard yards", 3 * _FOOT, _LENGTH),
    ("mi mile miles", 5280 * _FOOT, _LENGTH),
    ("sec secs second seconds с сек", 1.0, _TIME),
    ("msec msecs millisecond milliseconds", 1e-3, _TIME),
    ("kilogram kilograms kilo kilos кг", 1.0, _MASS),
    ("pound pounds #", _POUND, _MASS),
    ("t T te tne tonne tonnes mt mT MT mton т тн тонн", 1e3, _MASS),
    ("tonUS", 2000 * _POUND, _MASS),
    ("tonUK", 2240 * _POUND, _MASS),
    ("slug slugs", _POUND_FORCE / _FOOT, _MASS),
    ("newton newtons Н", 1.0, _FORCE),
    ("kilonewton kilonewtons кН", 1e3, _FORCE),
    ("kdN", 1e4, _FORCE),  # the thousand decanewtons of WITS, 'KDN'
    ("kp кгс", STANDARD_GRAVITY, _FORCE),
    ("tf тс", 1e3 * STANDARD_GRAVITY, _FORCE),
    ("kip kips", 1e3 * _POUND_FORCE, _FORCE),
    ("tonf tonfUS", 2000 * _POUND_FORCE, _FORCE),
    ("tonfUK", 2240 * _POUND_FORCE, _FORCE),
    ("pdl", _POUND * _FOOT, _FORCE),
    ("dyn dyne", 1e-5, _FORCE),
    ("pascal pascals", 1.0, _PRESSURE),
    ("кПа", 1e3, _PRESSURE),
    ("МПа", 1e6, _PRESSURE),
    ("barg bara bars бар", 1e5, _PRESSURE),
    ("psig psia", _POUND_FORCE / _INCH**2, _PRESSURE),
    ("atm атм", 101325.0, _PRESSURE),
    ("mmHg", 133.322387415, _PRESSURE),
    ("at ata ksc", 1e4 * STANDARD_GRAVITY, _PRESSURE),
    ("litre litres liter liters ltr ltrs lit л", 1e-3, _VOLUME),
    ("gal gals gallon gallons galUS usg", _GALLON, _VOLUME),
    ("galUK", _GALLON_UK, _VOLUME),
    ("bbl bbls barrel barrels", _BARREL, _VOLUME),
    ("cc", 1e-6, _VOLUME),
    ("cf", _FOOT**3, _VOLUME),
    ("gpm usgpm", _GALLON / 60, _FLOW),
    ("igpm", _GALLON_UK / 60, _FLOW),
    ("lpm", 1e-3 / 60, _FLOW),
    ("lps", 1e-3, _FLOW),
    ("bpm", _BARREL / 60, _FLOW),
    ("cfm", _FOOT**3 / 60, _FLOW),
    ("hp", 550 * _POUND_FORCE * _FOOT, _POWER),
    ("ppg", _POUND / _GALLON, _DENSITY),
    ("pcf", _POUND / _FOOT**3, _DENSITY),
    ("sg", 1e3, _DENSITY),
    ("% pct percent", 0.01, NUMBER),
    ("dimensionless unitless frac fraction ratio sample samples Sa", 1.0, NUMBER),
    ("k K thousand", 1e3, NUMBER),
    ("sps", 1.0, RATE),
    ("joule joules", 1.0, _TORQUE),
)
"""Further names with their values in SI. Gauge and absolute pressure are one here: nothing depends on an atmosphere."""
_TURNING: tuple[tuple[str, float, Dimension], ...] = (
    ("min mins minute minutes mn мин", 60.0, _TIME),
    ("h hr hrs hour hours ч", 3600.0, _TIME),
    ("d day days сут", 86400.0, _TIME),
    ("Hz hertz", 1.0, RATE),
    ("mHz", 1e-3, RATE),
    ("kHz", 1e3, RATE),
    ("MHz", 1e6, RATE),
)
"""Names in which nobody gives radians."""
_ANGLES: tuple[tuple[str, float, Dimension], ...] = (
    ("rad rads radian radians рад", 1.0, NUMBER),
    ("mrad", 1e-3, NUMBER),
    ("deg dega degree degrees ° град", math.pi / 180, NUMBER),
    ("rev revs revolution revolutions c cycle cycles rotation rotations turn turns r rot tr U omdr об", TURN, NUMBER),
    ("rpm", TURN / 60, RATE),
    ("rps", TURN, RATE),
)
"""Names that say that an angle is meant."""
_FORCES_OF_TORQUE = (
    *("N", "kN", "daN", "kdaN", "MN", "kgf", "kg", "t", "tf"),
    *("lbf", "lb", "lbs", "klbf", "klb", "klbs", "kip", "kips"),
)
_TON = "may be 1000 kg, 2000 lb or 2240 lb; write 't' for the metric ton, 'tonUS' for the short, 'tonUK' for the long"
_THOUSAND = "has an M that may be a thousand or a million; write out which, such as 'klbf'"
_UNCLEAR = {"ton": _TON, "tons": _TON, "kton": _TON}
_UNCLEAR |= dict.fromkeys(("mlb", "mlbs", "mlbf", "mft", "mpsi"), _THOUSAND)
"""Names, in any case, that mean different things in different places."""


@dataclass(frozen=True)
class Unit:
    """What a unit is worth in SI, and whether it names an angle, which has no dimension."""

    factor: float
    dimension: Dimension
    angle: bool = False
    turns: bool = False
    """Whether it names minutes, hours or hertz, in which nobody gives radians."""

    def __mul__(self, other: Unit) -> Unit:
        powers = [mine + its for mine, its in zip(self.dimension, other.dimension, strict=True)]
        return Unit(
            self.factor * other.factor,
            (powers[0], powers[1], powers[2]),
            self.angle or other.angle,
            self.turns or other.turns,
        )

    def to(self, power: int) -> Unit:
        """The unit to a power."""
        length, mass, time = self.dimension
        factor = self.factor**power if power >= 0 else 1 / self.factor**-power
        return Unit(factor, (power * length, power * mass, power * time), self.angle, self.turns)


def named(name: str, text: str) -> tuple[Unit, ...]:
    """What a name may mean: as written, else in any case of its letters, else as pint knows it."""
    exact, folded = _table()
    if name.lower() in _UNCLEAR and name not in exact:
        raise ValueError(f"the unit '{text}' is unclear: '{name}' {_UNCLEAR[name.lower()]}")
    if name in exact:
        return (exact[name],)
    found = folded.get(name.casefold()) or _from_pint(name)
    if not found:
        close = difflib.get_close_matches(name, [known for known in exact if len(known) > 2], n=1, cutoff=0.75)
        hint = f"; did you mean '{close[0]}'?" if close else ""
        raise ValueError(f"the unit '{text}' is unknown{hint}")
    return found


def known_units() -> dict[str, Unit]:
    """Every unit that needs no pint, by its name."""
    return dict(_table()[0])


@functools.cache
def _table() -> tuple[dict[str, Unit], dict[str, tuple[Unit, ...]]]:
    """Units by their names as written, and by their names in lower case."""
    exact: dict[str, Unit] = {}
    for symbol, prefixes, factor, dimension in _WITH_PREFIX:
        for prefix in ("", *prefixes.split()):
            exact.setdefault(prefix + symbol, Unit(_PREFIXES[prefix] * factor, dimension))
    for names, factor, dimension in _NAMES:
        exact |= dict.fromkeys(names.split(), Unit(factor, dimension))
    for names, factor, dimension in _TURNING:
        exact |= dict.fromkeys(names.split(), Unit(factor, dimension, turns=True))
    for names, factor, dimension in _ANGLES:
        exact |= dict.fromkeys(names.split(), Unit(factor, dimension, angle=True))
    exact = _glued(exact) | exact
    folded: dict[str, dict[Unit, None]] = {}
    for name, unit in exact.items():
        if name not in _ONLY_AS_WRITTEN:
            folded.setdefault(name.casefold(), {})[unit] = None
    return exact, {name: tuple(units) for name, units in folded.items()}


def _glued(exact: dict[str, Unit]) -> dict[str, Unit]:
    """Words of two units without a sign between them: 'kNm', 'ftlb', 'kftlbs', 'kgm2' (its power is read later)."""
    words = {}
    for force, length in itertools.product(_FORCES_OF_TORQUE, ("m", "ft", "in")):
        words[force + length] = exact[force] * exact[length]
        if length != "m":
            words[length + force] = words[force + length]
    thousands = {f"k{word}": Unit(1e3, NUMBER) * unit for word, unit in words.items() if word.startswith(("ft", "in"))}
    words |= {word: unit for word, unit in thousands.items() if not word.startswith(("kftk", "kink"))}
    words["kflb"] = words["kftlb"]  # of WITS
    words |= {f"{force}ms": exact[force] * exact["m"] * exact["s"] for force in ("N", "kN")}
    return words | {f"m{force}": words[f"{force}m"] for force in ("kgf", "kg", "daN")}


@functools.cache
def _from_pint(name: str) -> tuple[Unit, ...]:
    """What pint knows by that name, which has no prefix, or 'k', or one that is spelled out."""
    spelled = _spelled_for_pint(name)
    if spelled is None:
        return ()
    quantity = _registry().Quantity(1.0, spelled).to_base_units()
    powers = dict(quantity.dimensionality)
    length, mass, time = (int(powers.pop(f"[{base}]", 0)) for base in ("length", "mass", "time"))
    angle = "radian" in str(quantity.units)
    return () if powers else (Unit(float(quantity.magnitude), (length, mass, time), angle),)


def _spelled_for_pint(name: str) -> str | None:
    """Pint's own spelling of a name; None where it knows none.

    Pint puts prefixes of one letter before any unit, as in 'usft', which it takes for a millionth of the survey foot.
    Of these letters, only the k of the thousand is believed before any unit.
    """
    found = _registry().parse_unit_name(name)
    return next((prefix + unit for prefix, unit, _ in found if name.startswith((prefix, "k"))), None)


@functools.cache
def _registry() -> Any:
    """Pint's units; it is imported late because that costs most of a second."""
    import pint

    return pint.UnitRegistry()

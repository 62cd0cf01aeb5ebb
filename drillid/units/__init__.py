"""Physical quantities in text ('5.5 in', '1500 N m s/rad', '3 %') as SI floats, checked for dimension."""

from __future__ import annotations

import functools
import math
import re
import unicodedata
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

from drillid.units.expressions import meanings_of
from drillid.units.names import RATE, STANDARD_GRAVITY, TURN, Unit

__all__ = ["RPM", "STANDARD_GRAVITY", "parse", "to_si_factor"]

RPM = math.pi / 30
"""rad/s."""


@functools.cache
def to_si_factor(unit: str, si_unit: str) -> float:
    """Factor that converts values in `unit` to `si_unit`.

    A mass is accepted where a force is expected and converted with standard gravity, as rig
    logs record hook load and weight on bit in tonnes, and torque in ft-lb. Where an angle per
    time is expected, 1/min and Hz count revolutions.

    Raises
    ------
    ValueError
        If `unit` is unknown, may mean several things or has another dimension; the message says which.
    """
    (target,) = meanings_of(si_unit)
    meanings = meanings_of(unit)
    factors = {factor for meaning in meanings if (factor := _factor(meaning, target)) is not None}
    if len(factors) > 1:
        raise ValueError(f"the unit '{unit}' may mean several things; write it with its usual capitals")
    if factors:
        return factors.pop()
    if target.angle and any(meaning.dimension == target.dimension for meaning in meanings):
        raise ValueError(
            f"the unit '{unit}' does not say whether it counts radians or revolutions; write 'rad' or 'rev'"
        )
    raise ValueError(f"the unit '{unit}' cannot be a unit of {si_unit}")


def _factor(unit: Unit, target: Unit) -> float | None:
    """Value of a unit in another; None where it has another dimension, or an unclear angle."""
    length, mass, time = unit.dimension
    if (length + 1, mass, time - 2) == target.dimension and mass == 1:
        return unit.factor * STANDARD_GRAVITY / target.factor
    if unit.dimension != target.dimension:
        return None
    rate = unit.dimension == RATE
    if rate and unit.angle and not target.angle:
        return None
    if target.angle and not unit.angle and (rate or unit.turns):
        return unit.factor * TURN / target.factor if rate and unit.turns else None
    return unit.factor / target.factor


def parse(text: Any, si_unit: str) -> float:
    """A quantity given as text with its unit, or as a bare SI number.

    Raises
    ------
    ValueError
        If the text is not a number with a unit of the dimension of `si_unit`.
    """
    if isinstance(text, int | float) and not isinstance(text, bool):
        try:
            return float(text)
        except OverflowError:
            raise ValueError("the number is too large") from None
    number, unit = _number_and_unit(str(text), si_unit)
    return number * to_si_factor(unit, si_unit)


_NUMBER_AND_UNIT = re.compile(
    r"([+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?|[+-]?(?:nan|inf))(?![\d,])\s*(.*)", re.IGNORECASE
)
_SECOND_NUMBER = re.compile(r"(?!1\s*/\s*[^\s\d])[\d.]")
"""What no unit begins with, but for that of a rate, such as 1/s."""
_FRACTION = re.compile(r"(?:(\d+)[\s-]+)?(\d+)/(\d+)\s*([^\s\d].*)")


def _number_and_unit(text: str, si_unit: str) -> tuple[float, str]:
    """The two parts of '40 ms', '139.7mm', '5-1/2 in', '12¼"'."""
    plain = _without_vulgar_fractions(text.strip())
    fraction = _FRACTION.fullmatch(plain)
    if fraction is not None and int(fraction[3]):
        whole, over, under, unit = fraction.groups()
        return int(whole or 0) + int(over) / int(under), unit
    match = _NUMBER_AND_UNIT.fullmatch(plain)
    if match is None:
        comma = "; write a point before the decimals, and nothing between thousands" if "," in plain else ""
        raise ValueError(f"'{text}' is not a number with a unit of {si_unit}, such as '1 {si_unit}'{comma}")
    if not match[2]:
        raise ValueError(f"'{text}' lacks its unit; write it after the number, such as '{match[1]} {si_unit}'")
    if _SECOND_NUMBER.match(match[2]):
        remedy = "write nothing between thousands, and a fraction as in '5-1/2 in'"
        raise ValueError(f"'{text}' holds a further number after '{match[1]}'; {remedy}")
    return float(match[1]), match[2]


def _without_vulgar_fractions(text: str) -> str:
    """Fractions of one character, as in 12¼, written out."""
    spelled = re.sub(r"(?<=\d)\s*([\u00bc-\u00be\u2150-\u215e])", r" \1", text)
    return re.sub(
        "[\u00bc-\u00be\u2150-\u215e]",
        lambda match: unicodedata.normalize("NFKC", match[0]).replace("\u2044", "/"),
        spelled,
    )


def _quantity(si_unit: str) -> Any:
    schema = {"type": ["string", "number"], "description": f"a number with its unit, or a bare number in {si_unit}"}
    return Annotated[float, BeforeValidator(lambda text: parse(text, si_unit)), WithJsonSchema(schema)]


Metres = _quantity("m")
Seconds = _quantity("s")
Hertz = _quantity("Hz")
TorsionalInertia = _quantity("kg m^2")
TorsionalDamping = _quantity("N m s/rad")
TorsionalStiffness = _quantity("N m/rad")
Pressure = _quantity("Pa")
Density = _quantity("kg/m^3")
Fraction = _quantity("dimensionless")

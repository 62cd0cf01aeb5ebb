"""Physical quantities in text ('5.5 in', '1500 N m s/rad', '3 %') as SI floats, checked for dimension."""

import functools
import math
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

if TYPE_CHECKING:
    import pint

RPM = math.pi / 30
"""rad/s."""
STANDARD_GRAVITY = 9.80665
"""m/s²; hook load and weight on bit are logged as masses and mean forces."""

_FIELD_UNITS = (
    "ft_lbf = foot * force_pound",
    "klbf = 1000 * force_pound",
    "gpm = gallon / minute",
    "lpm = liter / minute",
)


@functools.cache
def registry() -> "pint.UnitRegistry[Any]":
    """The one unit registry; pint is imported on first use because that costs most of a second."""
    import pint

    units: pint.UnitRegistry[Any] = pint.UnitRegistry()
    for definition in _FIELD_UNITS:
        units.define(definition)
    return units


def to_si_factor(unit: str, si_unit: str) -> float:
    """Factor that converts values in `unit` to `si_unit`.

    A mass is accepted where a force is expected and converted with standard gravity, as rig
    logs record hook load and weight on bit in tonnes.

    Raises
    ------
    ValueError
        If `unit` is unknown or has another dimension; the message names both.
    """
    import pint

    try:
        parsed = registry().Quantity(1.0, _hyphens_as_products(unit))
    except (pint.errors.PintError, AssertionError, ValueError, TypeError, AttributeError) as error:
        raise ValueError(f"the unit '{unit}' is unknown ({error})") from error
    target = registry().Unit(si_unit)
    if parsed.check("[mass]") and target.is_compatible_with("N"):
        return float(parsed.to("kg").magnitude * STANDARD_GRAVITY)
    if not parsed.is_compatible_with(target):
        raise ValueError(f"the unit '{unit}' cannot be a unit of {si_unit}")
    return float(parsed.to(target).magnitude)


def _hyphens_as_products(unit: str) -> str:
    return unit.replace("ft-lbf", "ft_lbf").replace("ft-lb", "ft_lbf").replace("-", " ").replace("·", " ")


def parse(text: Any, si_unit: str) -> float:
    """A quantity given as text with its unit, or as a bare SI number.

    Raises
    ------
    ValueError
        If the text is not a number with a unit of the dimension of `si_unit`.
    """
    if isinstance(text, int | float) and not isinstance(text, bool):
        return float(text)
    number, _, unit = str(text).strip().partition(" ")
    try:
        value = float(number)
    except ValueError as error:
        raise ValueError(f"'{text}' is not a number with a unit of {si_unit}, such as '1 {si_unit}'") from error
    if not unit.strip():
        raise ValueError(f"'{text}' lacks its unit; write it after the number, such as '{number} {si_unit}'")
    return value * to_si_factor(unit.strip(), si_unit)


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

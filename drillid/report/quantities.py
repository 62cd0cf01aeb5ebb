"""Quantities for readers in metric and in oilfield units: both are in a page, and its switch of units shows one.

Texts are `Markup`: whatever comes from users is escaped where it is put into them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from markupsafe import Markup, escape

from drillid.units import to_si_factor

MISSING = "–"


@dataclass(frozen=True)
class Scale:
    """A unit as it is parsed and as it is shown, and the usual decimal places."""

    unit: str
    shown: str
    decimals: int

    def factor(self, si_unit: str) -> float:
        """SI value of the unit."""
        return to_si_factor(self.unit, si_unit)


@dataclass(frozen=True)
class Quantity:
    """A quantity with its SI unit and its two scales."""

    si_unit: str
    metric: Scale
    oilfield: Scale

    @cached_property
    def per_metric(self) -> float:
        """Oilfield values per metric one."""
        return self.metric.factor(self.si_unit) / self.oilfield.factor(self.si_unit)

    def text(self, *values: float, joint: str = "\u2013", more: int = 0) -> Markup:
        """Values, such as the ends of an interval, with their unit; a dash for NaN.

        Parameters
        ----------
        values : SI
        more : further decimal places
        """
        if not all(math.isfinite(value) for value in values):
            return Markup(MISSING)
        return both(*(self._in(scale, values, joint, more) for scale in (self.metric, self.oilfield)))

    def number(self, value: float) -> Markup:
        """An SI value without its unit; a dash for NaN."""
        scales = (self.metric, self.oilfield)
        return both(*(number(value / scale.factor(self.si_unit), scale.decimals) for scale in scales))

    def _in(self, scale: Scale, values: Sequence[float], joint: str, more: int) -> str:
        factor = scale.factor(self.si_unit)
        return f"{joint.join(number(value / factor, scale.decimals + more) for value in values)} {scale.shown}".strip()


def _one(si_unit: str, unit: str, shown: str, decimals: int) -> Quantity:
    scale = Scale(unit, shown, decimals)
    return Quantity(si_unit, scale, scale)


QUANTITIES = {
    "depth": Quantity("m", Scale("m", "m", 0), Scale("ft", "ft", 0)),
    "diameter": Quantity("m", Scale("mm", "mm", 0), Scale("in", "in", 2)),
    "weight": Quantity("N", Scale("kN", "kN", 0), Scale("klbf", "klbf", 0)),
    "torque": Quantity("N m", Scale("kN m", "kN m", 1), Scale("kft lbf", "kft·lbf", 1)),
    "rotation": _one("rad/s", "rpm", "rpm", 0),
    "flow": Quantity("m^3/s", Scale("L/min", "L/min", 0), Scale("gal/min", "gal/min", 0)),
    "pressure": Quantity("Pa", Scale("bar", "bar", 0), Scale("psi", "psi", 0)),
    "penetration": Quantity("m/s", Scale("m/h", "m/h", 1), Scale("ft/h", "ft/h", 0)),
    "damping": Quantity("N m s/rad", Scale("N m s/rad", "N m s/rad", 0), Scale("ft lbf s/rad", "ft·lbf·s/rad", 0)),
    "inertia": Quantity("kg m^2", Scale("kg m^2", "kg m²", 0), Scale("lb ft^2", "lb·ft²", 0)),
    "proportional": Quantity("N m s/rad", Scale("kN m/rpm", "kN m/rpm", 3), Scale("ft lbf/rpm", "ft·lbf/rpm", 0)),
    "integral": Quantity("N m/rad", Scale("kN m/rad", "kN m/rad", 2), Scale("ft lbf/rad", "ft·lbf/rad", 0)),
    "mobility": Quantity(
        "rad/(N m s)", Scale("rpm/(kN m)", "rpm per kN m", 2), Scale("rpm/(kft lbf)", "rpm per kft·lbf", 2)
    ),
    "wall damping": Quantity("N s/m^4", Scale("N s/m^4", "N s/m⁴", 0), Scale("lbf s/ft^4", "lbf·s/ft⁴", 2)),
    "internal damping": Quantity("N s/m^2", Scale("MN s/m^2", "MN s/m²", 0), Scale("kpsi s", "kpsi·s", 1)),
    "polar moment": Quantity("m^4", Scale("cm^4", "cm⁴", 0), Scale("in^4", "in⁴", 1)),
    "torque rate": Quantity("N m/s", Scale("kN m/s", "kN m/s", 1), Scale("kft lbf/s", "kft·lbf/s", 1)),
    "time": _one("s", "ms", "ms", 0),
    "frequency": _one("Hz", "Hz", "Hz", 2),
    "angle": _one("rad", "deg", "°", 1),
}


def both(metric: str, oilfield: str) -> Markup:
    """A text in both units, of which the page shows one; the text itself where they are equal."""
    if metric == oilfield:
        return escape(metric)
    return Markup('<span class="metric">{}</span><span class="oilfield">{}</span>').format(metric, oilfield)


def number(value: float, decimals: int = 0) -> str:
    """A number for readers, with separated thousands from ten thousand on; a dash for NaN."""
    if not math.isfinite(value):
        return MISSING
    separator = "," if abs(value) >= 1e4 else ""
    return f"{value:z{separator}.{decimals}f}".replace(",", "\u202f").replace("-", "\u2212")


def digits(value: float, count: int = 3) -> str:
    """A number to so many digits, and no more decimal places than those need."""
    if not math.isfinite(value):
        return MISSING
    if abs(value) >= 10 ** (count - 1):
        return number(value)
    return f"{value:.{count}g}".replace("-", "\u2212")


def size_text(value: float, unit: str, count: int = 3) -> Markup:
    """The size of a cause without its sign, in units that one feels.

    Parameters
    ----------
    unit : of the cause's `Size`
    count : digits; two of shares
    """
    size = abs(value)
    if unit == "s\u00b2":
        size, unit = math.sqrt(size), "s"
    if unit == "1":
        return Markup(f"{digits(100 * size, 2)} %")
    if unit == "s/s":
        return Markup(f"{digits(6e4 * size, 2)} ms in a minute")
    name = _SIZES.get(unit)
    if name is None:
        return Markup("{} {}").format(digits(size, count), unit)
    quantity = QUANTITIES[name]
    values = (
        f"{digits(size / scale.factor(quantity.si_unit), count)} {scale.shown}"
        for scale in (quantity.metric, quantity.oilfield)
    )
    return both(*values)


_SIZES = {
    "s": "time",
    "m": "depth",
    "rad": "angle",
    "rad/s": "rotation",
    "N m": "torque",
    "N m/s": "torque rate",
    "N m s/rad": "damping",
    "N s/m⁴": "wall damping",
}
"""Quantities of the sizes of causes, by their units."""

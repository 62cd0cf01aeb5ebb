"""Bounds of described quantities that no rig lies beyond, and the slips of units behind values that do."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, get_args

from pydantic import GetCoreSchemaHandler
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from drillid.config.validation import KeyFault
from drillid.units import to_si_factor

_PREFIX_SLIPS = {1e3: "a thousand", 1e6: "a million"}


@dataclass(frozen=True)
class Between:
    """Bounds of a quantity, beyond which a value is refused with the slip of units that probably made it.

    Parameters
    ----------
    low, high : bounds in SI; both are allowed values
    unit : the SI unit
    slips : units in which the number may have been meant
    or_zero : whether 0, which stands for an effect that is absent, is allowed below `low`
    """

    low: float
    high: float
    unit: str
    slips: tuple[str, ...] = ()
    or_zero: bool = False

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Check the value after it has been read."""
        return core_schema.no_info_after_validator_function(self._checked, handler(source))

    def __str__(self) -> str:
        return f"{'0, or ' if self.or_zero else ''}{self.low:g} to {self._text(self.high)}"

    def _text(self, value: float) -> str:
        return f"{value:g}" if self.unit == "dimensionless" else f"{value:g} {self.unit}"

    def _holds(self, value: float) -> bool:
        return self.low <= value <= self.high or (self.or_zero and value == 0)

    def _checked(self, value: float) -> float:
        if self._holds(value):
            return value
        raise KeyFault("", f"{self._text(value)} is outside the range of rigs, {self}", self._remedy(value))

    def _remedy(self, value: float) -> str:
        if value <= 0:
            return "Write a value within these bounds, with its unit"
        meant = [unit for unit in self.slips if self._holds(value * to_si_factor(unit, self.unit))]
        if meant:
            texts = " or ".join(f"'{value:g} {unit}'" for unit in meant)
            return f"If another unit is meant, write it after the number: {texts}"
        for factor, word in _PREFIX_SLIPS.items():
            if self._holds(value / factor):
                return f"It is {word} times too large for most rigs: check the prefix of its unit"
            if self._holds(value * factor):
                return f"It is {word} times too small for most rigs: check the prefix of its unit"
        return "Correct the value or its unit"


def text_of_bounds(field: FieldInfo) -> str:
    """The bounds of a setting in words, such as 'above 0 to 300'; empty where it has none."""
    metadata = [*field.metadata, *(part for each in get_args(field.annotation) for part in _metadata(each))]
    own = next((each for each in metadata if isinstance(each, Between)), None)
    if own is not None:
        return str(own)
    found = {kind: value for each in metadata for kind, value in _numbers(each)}
    low = f"{found['ge']:g}" if "ge" in found else f"above {found['gt']:g}" if "gt" in found else ""
    high = f"{found['le']:g}" if "le" in found else f"below {found['lt']:g}" if "lt" in found else ""
    return " to ".join(filter(None, [low, high]))


def _metadata(annotation: Any) -> tuple[Any, ...]:
    return getattr(annotation, "__metadata__", ())


def _numbers(constraint: Any) -> Iterator[tuple[str, float]]:
    for kind in ("ge", "gt", "le", "lt"):
        if isinstance(value := getattr(constraint, kind, None), int | float):
            yield kind, value

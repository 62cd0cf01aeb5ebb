"""The catalogue: every cause is one small class in the file of its part of the rig."""

from drillid.discrepancy.catalogue import bit, sensor, string, time, top_drive
from drillid.discrepancy.catalogue.cause import Cause, OperatingPoint, Size, WindowModel
from drillid.discrepancy.catalogue.symptoms import SYMPTOMS as SYMPTOMS

CATALOGUE: dict[str, Cause] = {
    cause.name: cause
    for module in (top_drive, sensor, string, bit, time)
    for cause in (
        entry()
        for entry in vars(module).values()
        if isinstance(entry, type) and issubclass(entry, Cause) and entry.__module__ == module.__name__
    )
}
"""All causes by name."""

__all__ = ["CATALOGUE", "SYMPTOMS", "Cause", "OperatingPoint", "Size", "WindowModel"]

"""The catalogue of causes: one small class each, in the file of its part of the rig."""

from drillid.discrepancy.catalogue import bit, sensor, string, time, top_drive
from drillid.discrepancy.catalogue.cause import Cause, OperatingPoint, Size, WindowModel, words_of
from drillid.discrepancy.catalogue.symptoms import SYMPTOMS as SYMPTOMS

CATALOGUE: dict[str, Cause] = {
    cause.name: cause() for module in (top_drive, sensor, string, bit, time) for cause in module.CAUSES
}
"""All causes by name."""

__all__ = ["CATALOGUE", "SYMPTOMS", "Cause", "OperatingPoint", "Size", "WindowModel", "words_of"]

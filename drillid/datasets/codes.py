"""Coded values in datasets, each with its meaning."""

import enum


class RigState(enum.IntEnum):
    """State of the rig at one sample."""

    UNKNOWN = 0
    DRILLING = 1
    CONNECTION = 2
    OFF_BOTTOM = 3
    REAMING = 4
    SWEEP_OFF = 5


class RecordFlag(enum.IntFlag):
    """What is wrong with one sample of a record, or how it was repaired."""

    INTERPOLATED = 1
    GAP = 2
    SPIKE = 4
    STUCK = 8
    DUPLICATE = 16
    CLOCK_STEP = 32


class Gate(enum.IntEnum):
    """Why a frequency is used or left out."""

    USED = 0
    OUTSIDE_SWEEP = 1
    TOO_INCOHERENT = 2
    TOO_COHERENT = 3


class Identifiability(enum.IntEnum):
    """How far one window determines a parameter."""

    KNOWN = 0
    BOUNDED_ABOVE = 1
    BOUNDED_BELOW = 2
    UNDETERMINED = 3

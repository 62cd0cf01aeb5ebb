"""Coded values in datasets, each with its meaning."""

import enum


class RigState(enum.IntEnum):
    """What the rig does at one sample."""

    UNKNOWN = 0
    DRILLING = 1
    CONNECTION = 2
    OFF_BOTTOM = 3
    REAMING = 4
    SWEEP_OFF = 5


class RecordFlag(enum.IntFlag):
    """What was done to, or is wrong with, one sample of a record."""

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


class Knowledge(enum.IntEnum):
    """What one window tells of a parameter."""

    KNOWN = 0
    BOUNDED_ABOVE = 1
    BOUNDED_BELOW = 2
    UNDETERMINED = 3

"""What a log's channels can be: bounds from physics and from drilling practice in general, each with its reason.

A value outside its `Range` counts as missing; a channel with most values outside is not used. A `Check` compares a
statistic of one or several channels with what is usual, outside of which the log is questioned, and with what is
possible, outside of which it is refused, since either channel may be the wrong one. No bound is taken from any well.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from drillid.arrays import Array
from drillid.config.rig import CHANNEL_UNITS, REQUIRED_CHANNELS, Channel
from drillid.errors import LogError
from drillid.records import consistency
from drillid.records.consistency import Measure, Samples
from drillid.records.grid import Note
from drillid.records.mapping import MappedColumn
from drillid.units import RPM, to_si_factor

_ANY = (-math.inf, math.inf)
_IMPOSSIBLE_SHARE = 0.2
"""Share of impossible values in a channel, zeros left out, from which the channel is rejected: its unit is wrong."""
_FEW_CODES = 3
"""Up to this many different impossible values are codes of the recorder for missing ones, whatever their share."""
_FT_LBF = 1.3558179483
"""N m."""


@dataclass(frozen=True)
class Range:
    """Values that a channel can have, in SI units.

    possible : least and largest value
    usual : least and largest level while the string turns, for weight while the hole deepens, for the sweep its root
        mean square while it is on
    typical : a usual level, from which the unit that was probably meant is guessed
    """

    possible: tuple[float, float]
    usual: tuple[float, float]
    typical: float
    reason: str


RANGES: Mapping[Channel, Range] = {
    "torque_command": Range(
        (-3e5, 3e5),
        (100.0, 1.5e5),
        1e4,
        "the strongest top drives give 150 kN m, and 300 kN m twists off any drill pipe",
    ),
    "torque_sweep": Range((-2e5, 2e5), (10.0, 3e4), 1e3, "a sweep is a small part of the drive's torque"),
    "speed": Range((-60.0, 60.0), (2.0, 35.0), 120 * RPM, "top drives turn at 20 to 300 rpm"),
    "speed_set": Range((-60.0, 60.0), (2.0, 35.0), 120 * RPM, "top drives turn at 20 to 300 rpm"),
    "hole_depth": Range((-50.0, 16e3), (10.0, 8e3), 2.5e3, "the longest wells have 15 km, and very few more than 8 km"),
    "bit_depth": Range((-50.0, 16e3), (10.0, 8e3), 2.5e3, "the longest wells have 15 km, and very few more than 8 km"),
    "weight_on_bit": Range((-5e6, 2e6), (500.0, 5e5), 1e5, "bits are rated for 20 to 500 kN"),
    "flow": Range((-0.05, 0.5), (1e-3, 0.13), 0.04, "mud pumps give 60 to 8000 L/min"),
    "standpipe_pressure": Range((-2e6, 1.1e8), (1e5, 6e7), 2e7, "mud pumps are rated for up to 7500 psi, 52 MPa"),
    "hook_load": Range(
        (-5e6, 1.5e7), (1e4, 9e6), 1.5e6, "derricks are rated for up to 1360 t, and a hook weighs tonnes"
    ),
}
"""Physical range of every channel that a rig description can map."""

_UNITS = {
    "N m": ("N m", "kN m", "ft-lbf"),
    "rad/s": ("rpm", "rad/s", "Hz", "deg/s"),
    "m": ("m", "ft", "km"),
    "N": ("t", "kN", "klbf", "N", "kg", "lbf"),
    "m^3/s": ("L/min", "gal/min", "m^3/min", "m^3/h", "L/s", "m^3/s"),
    "Pa": ("bar", "psi", "kPa", "MPa", "Pa"),
}
"""Units in which logs hold each kind of quantity."""


@dataclass(frozen=True)
class Check:
    """One check of a log.

    name : short name
    channels : channels that it needs
    statistic : gives its value, None where the log does not show it
    usual, possible : bounds of the value
    what : what is wrong outside of them, with {value} and {at}
    remedy : what the user can do about it
    reason : reason for these bounds
    """

    name: str
    channels: tuple[Channel, ...]
    statistic: Callable[[Samples], Measure | None]
    usual: tuple[float, float]
    possible: tuple[float, float]
    what: str
    remedy: str
    reason: str


_DEPTHS = (
    "Correct the unit or the column of hole or bit depth in the rig description (1 m is 3.28 ft; they may be "
    "swapped), or leave the bit depth out"
)
_SWEEP_UNIT = "Correct the unit or the column of torque sweep or torque command in the rig description"
_RESPONSE = "Correct the columns, units or signs of torque sweep and speed in the rig description"

_TURNING = "while the string turns"
_WHILE: Mapping[str, str] = {
    "torque_sweep": "root mean square while it is on",
    "weight_on_bit": "while the hole deepens",
}

CHECKS = (
    Check(
        "sample rate",
        ("speed",),
        consistency.usable_frequency,
        (5.0, math.inf),
        _ANY,
        "it is sampled too slowly: it is usable only up to {value:.3g} Hz, and the sweep's content above half its "
        "sample rate is aliased to lower frequencies",
        "Export the log at the rate of its recorder; torsional dynamics up to 5 Hz need at least 12.5 Hz",
        "sampling at 2.5 times the highest frequency; sweeps reach about 5 Hz",
    ),
    Check(
        "bit below hole",
        ("speed", "hole_depth", "bit_depth"),
        consistency.bit_below_hole,
        (-math.inf, 5.0),
        (-math.inf, 50.0),
        "the bit is {value:.1f} m below the bottom of the hole",
        _DEPTHS,
        "the bit drills the hole; corrections of the pipe tally are a few metres",
    ),
    Check(
        "bit above bottom",
        ("speed", "hole_depth", "bit_depth"),
        consistency.bit_above_bottom,
        (-math.inf, 5.0),
        (-math.inf, 50.0),
        "the hole deepens while the bit is {value:.1f} m above its bottom",
        _DEPTHS,
        "the bit drills the hole; corrections of the pipe tally are a few metres",
    ),
    Check(
        "hole shrinks",
        ("hole_depth",),
        consistency.hole_shrinks,
        (-math.inf, 5.0),
        _ANY,
        "the depth of the hole decreases by {value:.1f} m {at}",
        "Correct the column of hole depth; it may hold the bit depth, or zeros where there is no value",
        "a hole only gets deeper, apart from corrections and sidetracks",
    ),
    Check(
        "hole jumps",
        ("hole_depth",),
        consistency.hole_jumps,
        (-math.inf, 5.0),
        _ANY,
        "the depth of the hole increases by {value:.1f} m within a second {at}",
        "Correct the export of hole depth; its unit may change within the log",
        "no bit drills metres in a second; corrections of the pipe tally are a few metres",
    ),
    Check(
        "drilling rate",
        ("speed", "hole_depth"),
        consistency.drilling_rate,
        (-math.inf, 200.0),
        (-math.inf, 2000.0),
        "the hole deepens at {value:.0f} m/h",
        "Correct the unit of hole depth in the rig description; it may be ft",
        "even soft formations are drilled at less than 200 m/h; jetting a conductor reaches some 1000 m/h",
    ),
    Check(
        "drilled at once",
        ("speed", "hole_depth"),
        consistency.drilled_at_once,
        (-math.inf, 45.0),
        _ANY,
        "{value:.1f} m are drilled without a stop of the rotation",
        "Correct the unit of hole depth in the rig description; it may be ft",
        "the block travels one stand, at most 37 m, and then a connection stops the rotation",
    ),
    Check(
        "speed and set point",
        ("speed", "speed_set"),
        consistency.speed_over_set_point,
        (2 / 3, 3 / 2),
        _ANY,
        "the speed is {value:.3g} times its set point",
        "Correct the unit or the column of speed or its set point in the rig description: 1 rad/s is 9.55 rpm",
        "a speed control holds the mean speed at the set point",
    ),
    Check(
        "power of the drive",
        ("speed", "torque_command"),
        consistency.power_of_drive,
        (0.0, 1.0),
        _ANY,
        "the drive takes power out of the string while it turns: torque command and speed have opposite signs",
        "Correct the sign of torque command or speed in the export",
        "friction and bit consume power, which only the drive supplies",
    ),
    Check(
        "sweep in command",
        ("torque_sweep", "torque_command"),
        consistency.sweep_in_command,
        (0.5, 2.0),
        (0.05, 20.0),
        "the torque command changes {value:.3g} times as much as the sweep that it contains",
        _SWEEP_UNIT,
        "the command is the sum of sweep and control, and the control responds little to fast changes",
    ),
    Check(
        "unit of the sweep",
        ("torque_sweep", "torque_command"),
        consistency.sweep_in_command_closely,
        (0.8, 1.25),
        _ANY,
        "the torque command changes exactly {value:.3g} times as much as the sweep that it contains",
        f"{_SWEEP_UNIT}: 1 ft-lbf is {_FT_LBF:.3f} N m",
        "the command is the sum of sweep and control; N m taken for ft-lbf or the reverse make 1.36 or 0.74",
    ),
    Check(
        "apparent inertia",
        ("torque_sweep", "speed"),
        consistency.apparent_inertia,
        (30.0, 2e5),
        (2.0, 1e7),
        "the speed follows the sweep as if the top drive had an inertia of {value:.3g} kg m²",
        f"{_RESPONSE}: kN m and N m differ by 1000, rad/s and rpm by 9.55",
        "top drives have 100 to 10,000 kg m², motors and gear included; stiff control adds to the apparent inertia",
    ),
    Check(
        "response",
        ("torque_sweep", "speed"),
        consistency.response_size,
        (0.05, 1.0),
        _ANY,
        "the speed does not move with the sweep: their correlation is {value:.3f}",
        _RESPONSE,
        "a torque turns the drive; noise and stick-slip leave a correlation of at least some percent over minutes",
    ),
    Check(
        "sign of the response",
        ("torque_sweep", "speed"),
        consistency.response_sign,
        (-1.0, math.inf),
        _ANY,
        "the speed moves against the sweep",
        _RESPONSE,
        "rig and control are passive: they absorb power from the sweep and supply none",
    ),
)
"""Every check of a log's channels against each other."""


def possible_values(name: Channel, values: Array, column: MappedColumn, where: str) -> tuple[Array | None, list[Note]]:
    """A channel without its impossible values; None where most of them are impossible.

    Parameters
    ----------
    values : SI units, NaN where missing, shape (row,)
    column : its column and unit
    where : name of the log for messages

    Raises
    ------
    LogError
        If most values of a required channel are impossible.
    """
    low, high = RANGES[name].possible
    wrong = ~((values >= low) & (values <= high)) & ~np.isnan(values)
    count, other = int(np.sum(wrong)), int(np.sum((values != 0) & ~np.isnan(values)))
    if count == 0:
        return values, []
    unit, first = CHANNEL_UNITS[name], float(values[np.argmax(wrong)])
    bounds = f"{low:g} to {high:g} {unit} ({RANGES[name].reason})"
    codes = count < other and np.unique(values[wrong]).size <= _FEW_CODES
    if count <= _IMPOSSIBLE_SHARE * other or codes:
        what = f"{count} values of {name} are outside {bounds}, the first {first:.4g} {unit}; they are not used"
        remedy = f"Leave cells of the column '{column.column}' empty where there is no value; check the sensor"
        return np.where(wrong, np.nan, values), [(what, remedy)]
    with np.errstate(over="ignore"):
        middle = float(np.median(np.abs(values[wrong])))
    what = f"{name}, column '{column.column}' in {column.unit}, is {middle:.4g} {unit} in the median, outside {bounds}"
    remedy = unit_remedy(name, middle, column)
    if name in REQUIRED_CHANNELS:
        raise LogError(where, what, remedy)
    return None, [(f"{what}; the channel is not used", remedy)]


def judge(samples: Samples, columns: Mapping[Channel, MappedColumn], where: str) -> list[Note]:
    """What is unusual about a log, as (sentence, remedy).

    Raises
    ------
    LogError
        If channels contradict each other so far that one of them must be wrong.
    """
    questions, contradictions, units = list[Note](), list[Note](), dict[Channel, str]()
    for name in (name for name in RANGES if name in samples.channels):
        found = _level(samples, name)
        low, high = RANGES[name].usual
        if found is not None and not low <= found.value <= high:
            what = (
                f"{name} is {found.value:.4g} {CHANNEL_UNITS[name]} {_WHILE.get(name, _TURNING)}, where {low:.4g} to "
                f"{high:.4g} is usual ({RANGES[name].reason})"
            )
            units[name] = unit_remedy(name, found.value, columns[name])
            questions.append((what, units[name]))
    for check in CHECKS:
        if all(name in samples.channels for name in check.channels):
            found = check.statistic(samples)
            if found is not None and not check.usual[0] <= found.value <= check.usual[1]:
                what = f"{check.what.format(value=found.value, at=samples.moment(found))} ({check.reason})"
                if check.possible[0] <= found.value <= check.possible[1]:
                    questions.append((what, check.remedy))
                else:
                    likely = [units[name] for name in check.channels if name in units]
                    contradictions += [(what, remedy) for remedy in likely or [check.remedy]]
    if contradictions:
        faults, remedies = (list(dict.fromkeys(texts)) for texts in zip(*contradictions, strict=True))
        raise LogError(where, "; ".join(faults), ". ".join(remedies))
    return questions


def unit_remedy(name: Channel, value: float, column: MappedColumn) -> str:
    """How to correct a channel at an unusual level (SI): the unit in which it would be a usual one, if there is any."""
    si = CHANNEL_UNITS[name]
    found = likely_unit(name, value / to_si_factor(column.unit, si), column.unit)
    if found is None:
        return f"Correct the unit or the column of {name} in the rig description"
    unit, level = found
    return (
        f"If the column '{column.column}' holds {unit} it is {level:.4g} {si}: write unit: {unit} in the rig "
        "description; otherwise correct its column"
    )


def likely_unit(name: Channel, level: float, besides: str = "") -> tuple[str, float] | None:
    """The unit, other than `besides`, in which a channel has a usual level, and that level in SI; None without one."""
    return next(iter(fitting_units(name, level, besides).items()), None)


def fitting_units(name: Channel, level: float, besides: str = "", more: Sequence[str] = ()) -> dict[str, float]:
    """Units, other than `besides`, in which a channel has a usual level, with that level in SI; the likeliest first.

    Parameters
    ----------
    more : units beside those in which most logs hold such a quantity
    """
    si, bounds = CHANNEL_UNITS[name], RANGES[name]
    excluded = to_si_factor(besides, si) if besides else None
    factors = {unit: to_si_factor(unit, si) for unit in (*_UNITS[si], *more)}
    usual = {
        unit: level * factor
        for unit, factor in factors.items()
        if bounds.usual[0] <= level * factor <= bounds.usual[1] and factor != excluded
    }
    return dict(sorted(usual.items(), key=lambda each: abs(math.log(each[1] / bounds.typical))))


def _level(samples: Samples, name: Channel) -> Measure | None:
    if name == "torque_sweep":
        return consistency.sweep_size(samples)
    if name == "weight_on_bit":
        return consistency.drilling_level(samples, name)
    return consistency.level(samples, name)

"""Rows and figure of the motor bench."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.discoveries.motor import HELD_OUT, MotorExamined, examine_motor, gain_of, read_record
from benchmarks.discoveries.motor_fit import DATA
from benchmarks.discoveries.response import Fit, Response
from benchmarks.discoveries.rows import NAN, Discovery, Part
from benchmarks.discoveries.unknown import average
from benchmarks.discoveries.weigh import Weighed, relative_gain
from drillid.arrays import Complex
from drillid.discrepancy import CATALOGUE
from drillid.discrepancy.verdicts.naming import separator
from drillid.discrepancy.verdicts.verdict import NONE, UNKNOWN
from drillid.statistics import TWO_SIDED


def motor_rows(found: MotorExamined) -> tuple[Discovery, ...]:
    """Verdicts on the record as it is, on the record with the angle, and on what is left."""
    return (_of_speed(found), _of_angle(found), _of_rest(found))


def _of_speed(found: MotorExamined) -> Discovery:
    weighed = found.by_speed
    odd, even = found.speed
    before, after = (_relative(one, even) for one in (weighed.base, weighed.fits[weighed.cause]))
    return replace(
        _named("motor, current and speed", weighed, gain_of(weighed, odd=odd, even=even)),
        evidence=f"log Bayes factors {_listed(weighed)}, and {average(weighed.left):.0f} more for something unknown"
        f" beside the best cause; rms of misfit per response on the even periods {before:.0%} before, {after:.1%}"
        " after. Actuator gain and speed scale only rescale the inertias, a clock offset only the delay. The size's"
        " interval counts noise and not what is left unknown",
        what_would_separate="the motor's angle, which the recorder does not filter, and which a lag of the torque"
        " would show in too: next row",
    )


def _of_angle(found: MotorExamined) -> Discovery:
    """The recorded speed beside the angle, and the model that the angle asks for."""
    record, angle = found.of_record, found.by_angle
    even = found.ratio[1]
    lag = angle.fits["drive_lag"]
    best = record.fits[record.cause]
    ratio = best.predicted(even.frequency) / even.value - 1
    corner = 1 / (2 * np.pi * best.size[0])
    gained = relative_gain(record.base.predicted(even.frequency), best.predicted(even.frequency), even)
    return replace(
        _named("motor, with the angle", record, gained),
        gain_unit="of the misfit of the speed by the angle",
        held_out="even periods",
        evidence=f"the recorded speed is the angle's derivative behind a low pass of {corner:.1f} Hz, to"
        f" {_rms(ratio):.1%} at every line; the mobility by the angle has no lag (log Bayes factor of drive_lag"
        f" {angle.evidence['drive_lag']:.1f}, {max(lag.size[0], 0) * 1e3:.2f} ± {lag.size[1] * 1e3:.2f} ms), and two"
        f" inertias with a delay leave {_relative(angle.base, found.angle[1]):.0%} of it",
    )


def _of_rest(found: MotorExamined) -> Discovery:
    """What two inertias with a delay leave of the mobility by the angle."""
    weighed = found.by_angle
    noise = weighed.base.problem.measured.deviation / np.abs(weighed.base.problem.measured.value)
    spread = found.angle[0].deviation / np.abs(found.angle[0].value)
    load, motor = found.balances["softening, load"], found.balances["softening, motor"]
    play = found.balances["play, load"]
    return replace(
        _named("motor, what is left", weighed, (1 - load.after / load.before, NAN, NAN)),
        evidence=f"a misfit that jumps from line to line by {np.median(noise):.1%} and repeats (spread between periods"
        f" {np.median(spread):.1%}), so it is non-linear; what is smooth has log Bayes factor {weighed.disturbed:.0f}"
        f" for something unknown and at most {max(weighed.evidence.values()):.1f} for a cause. The coupling softens"
        f" with twist, at the largest by {-load.relative:.1%} ± {load.error:.1%} in the load's balance of torque and"
        f" {-motor.relative:.1%} ± {motor.error:.1%} in the motor's: no cause of the catalogue. Play would be a gap"
        f" about no twist; the gap found is {-play.relative:.2%} ± {play.error:.2%} of the largest twist",
        gain_unit="of the error of the load's balance, by softening",
        held_out="even periods",
        what_would_separate="multisines of two amplitudes, or one with detection lines",
    )


def _named(data: str, weighed: Weighed, gain: tuple[float, float, float]) -> Discovery:
    """The row of what was weighed, without its words."""
    if weighed.verdict in (NONE, UNKNOWN):
        port = max(weighed.left, key=lambda name: weighed.left[name]) if weighed.verdict == UNKNOWN else ""
        return Discovery(data, weighed.verdict, weighed.share[UNKNOWN], "", family=port, gain=gain)
    members, best = weighed.members(), CATALOGUE[weighed.cause]
    size, error = weighed.fits[weighed.cause].size
    return Discovery(
        data,
        weighed.verdict,
        sum(weighed.share[name] for name in members),
        "",
        family=best.family,
        cause=best.name,
        size=(size, size - TWO_SIDED * error, size + TWO_SIDED * error),
        unit=best.size.unit,
        gain=gain,
        gain_unit="log score a line",
        held_out=HELD_OUT,
        what_would_separate=separator(members) if len(members) > 1 else "",
    )


def _listed(weighed: Weighed) -> str:
    order = sorted({**weighed.evidence, UNKNOWN: weighed.disturbed}.items(), key=lambda entry: -entry[1])
    return ", ".join(f"{name} {value:.0f}" for name, value in order)


def _relative(model: Fit, held: Response) -> float:
    return _rms(model.predicted(held.frequency) / held.value - 1)


def _rms(values: Complex) -> float:
    return float(np.sqrt(np.mean(np.abs(values) ** 2)))


def discover(folder: Path) -> Part:
    """Rows and figure of the motor bench."""
    if not DATA.is_file():
        return Part(absent=f"the motor's record is not at {DATA}")
    from benchmarks.discoveries.figures import draw_motor

    found = examine_motor(read_record())
    path = folder / "motor.png"
    draw_motor(found, path)
    return Part(motor_rows(found), (path,))

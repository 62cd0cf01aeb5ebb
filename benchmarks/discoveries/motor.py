"""The motor bench: what a two-inertia model gets wrong, named as the wells' causes are, and what the angle says of it.

The record holds the torque current, the motor's speed and both angles. The engine first sees current and speed alone.
The angle is then the measurement that separates what those two cannot.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.discoveries.motor_balance import Term, balances
from benchmarks.discoveries.motor_fit import DATA, PERIOD, RATE, motor_mobility, read_motor
from benchmarks.discoveries.response import Candidate, Fit, Problem, Response, extended, fit
from benchmarks.discoveries.weigh import Weighed, held_out_gain, look
from drillid.arrays import Floats
from drillid.discrepancy.catalogue import WindowModel
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, TopDrive
from drillid.physics.responses import string_admittance
from drillid.physics.sensor import Recording
from drillid.physics.top_drive import torque_transfers

START = np.array([0.012, 0.012, 1300.0, 0.1, 0.1, 0.1, 5e-4])
"""Motor's and load's inertia, coupling's stiffness and damping, drag of motor and of load (all per torque constant),
delay (s)."""
_FACTORS: tuple[tuple[float, ...], ...] = (
    (1, 1, 1, 1, 1, 1, 1),
    (0.4, 0.4, 0.4, 1, 1, 1, 1),
    (2.5, 2.5, 2.5, 1, 1, 1, 1),
    (1, 1, 1, 0.1, 10, 1, 3),
)
_MOVES = np.log(np.array(_FACTORS))
_SHAFT_SHARE = 1e-7
"""Inertia of the coupling per load's: a line of nearly no inertia is a spring."""
_RESONANCE_TIME = 1 / (2 * np.pi * 77)
"""s, in which the resonance turns by one radian: times that matter to it."""
CANDIDATES = (
    Candidate("drive_lag", _RESONANCE_TIME),
    Candidate("delay_jitter", _RESONANCE_TIME**2),
    Candidate("recorder_filter", _RESONANCE_TIME, 1.0),
    Candidate("recorder_filter", _RESONANCE_TIME, 2.0),
    Candidate("clock_offset", _RESONANCE_TIME),
    Candidate("actuator_gain", 0.1),
    Candidate("speed_scale", 0.1),
    Candidate("hysteretic_damping", 0.02),
    Candidate("motor_compliance", 1e-4),
)
"""Causes that a motor without speed control, hole or bit can have; a compliant motor is a third inertia here."""
RECORD_CANDIDATES = CANDIDATES[2:5]
"""Causes that a speed record alone can have."""
_FITTED, _HELD = slice(0, None, 2), slice(1, None, 2)
HELD_OUT = "every other line, of the even periods"


@dataclass(frozen=True)
class MotorSetup(WindowModel):
    """A motor that drives a load through a coupling, the string of the drilling system."""

    drag: Any = 0.0
    """N m s/rad, on the motor."""

    def mobility(self, s: Any) -> Any:
        """Recorded speed per torque."""
        top = self.system.top_drive
        command, feedback = torque_transfers(top, s)
        admittance = top.inertia * s + feedback + self.drag + string_admittance(self.system, s)
        return self.recording.transfer(s) * command / admittance


@dataclass(frozen=True)
class RecordSetup(WindowModel):
    """A speed record beside the angle's derivative."""

    def mobility(self, s: Any) -> Any:
        """Recorded per true speed."""
        return self.recording.transfer(s)


def motor(parameters: Sequence[Any]) -> MotorSetup:
    """The base model from parameters in the order of START."""
    inertia, load, stiffness, damping, drag, load_drag, delay = parameters
    coupling = Section(1.0, 1.0, delta=damping, density=_SHAFT_SHARE * load, shear_modulus=stiffness)
    system = DrillingSystem(TopDrive(inertia, delay, Controller(0.0)), (coupling,), Bit(load, load_drag))
    return MotorSetup(system, Recording(), drag=drag)


def record(parameters: Sequence[Any]) -> RecordSetup:
    """A perfect record: no parameters."""
    system = DrillingSystem(TopDrive(1.0, 0.0, Controller(0.0)), (), Bit(1.0))
    return RecordSetup(system, Recording())


@dataclass(frozen=True, eq=False)
class MotorRecord:
    """Each (period, sample)."""

    current: Floats
    """A."""
    speed: Floats
    """rad/s, as recorded."""
    turned: Floats
    """rad/s, the motor's angle differentiated."""
    load_turned: Floats
    """rad/s, the load's, positive as the motor's."""
    twist: Floats
    """rad, of the coupling."""


def read_record(path: Path = DATA) -> MotorRecord:
    """The bench's record; its angles count against each other."""
    from scipy.io import loadmat

    current, speed = read_motor(path)
    content = loadmat(path, variable_names=["theta_mx", "theta_my"])
    motor_angle, load_angle = (
        np.asarray(content[name], float).reshape(-1, PERIOD) for name in ("theta_mx", "theta_my")
    )
    twist = motor_angle + load_angle
    return MotorRecord(current, speed, derivative(motor_angle), derivative(-load_angle), twist - twist[1:].mean())


def derivative(angle: Floats, order: int = 1) -> Floats:
    """Of a periodic signal (period, sample), without what lies above a quarter of the rate."""
    spectrum = np.fft.rfft(angle, axis=1)
    frequency = np.fft.rfftfreq(PERIOD, 1 / RATE)
    spectrum = spectrum * np.where(frequency < RATE / 4, 2j * np.pi * frequency, 0) ** order
    return np.asarray(np.fft.irfft(spectrum, PERIOD, axis=1), dtype=float)


def odd_and_even(drive: Floats, answer: Floats) -> tuple[Response, Response]:
    """Response from the odd and from the even periods; the first period starts from rest and is left out."""
    found = (motor_mobility(drive[first::2], answer[first::2]) for first in (1, 2))
    odd, even = (Response(one.frequency, one.mobility, one.deviation) for one in found)
    return odd, even


@dataclass(frozen=True, eq=False)
class MotorExamined:
    """The two looks at the motor."""

    speed: tuple[Response, Response]
    """By the recorded speed, odd and even periods."""
    angle: tuple[Response, Response]
    """By the angle."""
    ratio: tuple[Response, Response]
    """Recorded speed per the angle's derivative."""
    by_speed: Weighed
    by_angle: Weighed
    of_record: Weighed
    balances: Mapping[str, Term]


def examine_motor(data: MotorRecord) -> MotorExamined:
    """Name on the odd periods what current and speed show, then look again with the angle."""
    speed, angle = (odd_and_even(data.current, each) for each in (data.speed, data.turned))
    ratio = odd_and_even(data.turned, data.speed)
    by_speed, by_angle = (look(base_fit, one[0], CANDIDATES) for one in (speed, angle))
    of_record = look(record_fit, ratio[0], RECORD_CANDIDATES)
    delay = float(START[-1] * np.exp(by_angle.base.coordinates[-1]))
    terms = balances(data.current, data.turned, data.load_turned, data.twist, delay)
    return MotorExamined(speed, angle, ratio, by_speed, by_angle, of_record, terms)


def base_fit(measured: Response) -> Fit:
    """Two inertias with a delay."""
    return fit(Problem(motor, START, measured), _MOVES)


def record_fit(measured: Response) -> Fit:
    """A record that shows the truth."""
    return fit(Problem(record, np.empty(0), measured, ports=("record",)), [np.empty(0)])


def gain_of(weighed: Weighed, *, odd: Response, even: Response) -> tuple[float, float, float]:
    """Log score a line of HELD_OUT, most likely cause over base, both fitted to the other lines of the odd periods."""
    noise = weighed.base.problem.measured.deviation
    fitted, held = replace(odd, deviation=noise).at(_FITTED), replace(even, deviation=noise).at(_HELD)
    candidate = weighed.fits[weighed.cause].problem.given[-1]
    base = base_fit(fitted)
    more = extended(base, candidate)
    return held_out_gain(base.predicted(held.frequency), more.predicted(held.frequency), held)

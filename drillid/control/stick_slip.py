"""Lowest stable rotational speed against weight on bit, for a bit whose torque falls with speed.

About a steady speed Ω the rock adds the admittance T'(Ω) at the bit, negative where torque falls. Steady rotation is
stable as long as −T'(Ω) is below the least real part of the admittance Y = 1/(bit mobility) at the zeros of its
imaginary part: beyond it the negative damping of the rock exceeds the damping of string and top drive.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.control.margins import is_stable
from drillid.control.tuning import controlled_by, first_sample
from drillid.errors import EstimationError, SettingsError, UnstableControlError
from drillid.physics.bottom_end import cutting_admittance
from drillid.physics.equipment import Controller, DrillingSystem, StribeckCutting, window_shape
from drillid.physics.nonlinear import Cutting, NonlinearRig
from drillid.physics.responses import bit_mobility, laplace
from drillid.simulation.simulate import TIME_STEP, simulate

_BAND = np.geomspace(0.02, 10.0, 8000)
"""Hz, searched for crossings."""
_SPEEDS = np.linspace(0.05, 60.0, 6000)
"""rad/s, searched for the lowest stable speed."""
_PULSE = 0.5
"""s, of the torque that starts the vibration whose growth is measured."""


def _stable_without_rock(system: DrillingSystem) -> bool:
    """Whether the speed control is stable with a bit that feeds no vibration, as off bottom."""
    bit = replace(system.bit, damping=np.maximum(system.bit.damping, 0.0), cutting=())
    return is_stable(replace(system, bit=bit))


def critical_slope(system: DrillingSystem, *, stiff: bool = False) -> tuple[float, float]:
    """Critical fall of torque per speed at the bit, and the frequency of the vibration at the stability limit.

    Parameters
    ----------
    system : of a single sample
    stiff : clamp the top drive

    Returns
    -------
    slope : N m s/rad, positive for a torque that falls; negative where the bit's own damping already feeds vibration
    frequency : Hz

    Raises
    ------
    SettingsError
        If the system describes several samples.
    UnstableControlError
        If the speed control is unstable without the rock.
    EstimationError
        If no fall of torque destabilises the system in the searched band.
    """
    if math.prod(window_shape(system)) > 1:
        raise SettingsError("stick-slip", "the system describes several samples", "Give one, such as the first_sample")
    system = first_sample(system)
    if not stiff and not _stable_without_rock(system):
        what = "the speed control is unstable without the rock"
        raise UnstableControlError("stick-slip", what, "Tune the speed control")
    rock_free = replace(system, bit=replace(system.bit, cutting=()))

    def admittance(frequency: Floats) -> Complex:
        return np.asarray(1 / bit_mobility(rock_free, laplace(frequency), stiff=stiff))

    imaginary = admittance(_BAND).imag
    before = np.flatnonzero(np.signbit(imaginary[:-1]) != np.signbit(imaginary[1:]))
    share = imaginary[before] / (imaginary[before] - imaginary[before + 1])
    frequency = _BAND[before] + share * (_BAND[before + 1] - _BAND[before])
    at_crossing = admittance(frequency)
    # for an undamped string the imaginary part also changes sign through infinity
    through_zero = np.abs(at_crossing.imag) < np.minimum(np.abs(imaginary[before]), np.abs(imaginary[before + 1]))
    critical = np.where(through_zero & (at_crossing.real > min(system.bit.damping, 0.0)), at_crossing.real, np.inf)
    if not np.any(np.isfinite(critical)):
        raise EstimationError(
            "stick-slip", "no fall of torque with speed destabilises the system in the searched band", "Check it"
        )
    least = int(np.argmin(critical))
    return float(critical[least]), float(frequency[least])


def lowest_stable_speed(cutting: Cutting, weight: float, slope: float) -> float:
    """Highest speed (rad/s) at which the torque falls as fast as `slope` (N m s/rad); 0 where it never does.

    Parameters
    ----------
    weight : N, on the bit
    """
    from scipy.optimize import brentq

    levels, weakening = (weight * cutting.static, weight * cutting.dynamic), cutting.weakening

    def excess(speed: Any) -> Any:
        law = StribeckCutting(*levels, weakening.threshold, speed, weakening.exponent)
        return -cutting_admittance(law, np.zeros(1, dtype=complex)) - slope

    steep = np.flatnonzero(excess(_SPEEDS) > 0)
    if steep.size == 0:
        return 0.0
    last = int(steep[-1])
    if last == _SPEEDS.size - 1:
        raise EstimationError("stick-slip", f"unstable at every speed up to {_SPEEDS[-1]:.0f} rad/s", "Check the bit")
    return float(brentq(excess, float(_SPEEDS[last]), float(_SPEEDS[last + 1])))


@dataclass(frozen=True, eq=False)
class StickSlipMap:
    """Lowest stable speeds of a system under several controllers."""

    weight: Floats
    """(weight,) N."""
    speed: Mapping[str, Floats]
    """By controller's name, (weight,) rad/s; infinite under a control that is unstable without the rock."""
    frequency: Mapping[str, float]
    """By controller's name, Hz, of the vibration at the stability limit; NaN without one."""


def stick_slip_map(
    system: DrillingSystem, cutting: Cutting, weight: Floats, controllers: Mapping[str, Controller]
) -> StickSlipMap:
    """Lowest stable speed at each weight (N) under each controller."""
    speed, frequency = {}, {}
    for name, controller in controllers.items():
        try:
            slope, frequency[name] = critical_slope(controlled_by(system, controller))
            speed[name] = np.array([lowest_stable_speed(cutting, float(load), slope) for load in weight])
        except UnstableControlError:
            speed[name], frequency[name] = np.full(weight.size, np.inf), np.nan
    return StickSlipMap(weight, speed, frequency)


def simulated_growth(
    system: DrillingSystem, cutting: Cutting, weight: float, speed: float, frequency: float, duration: float = 120.0
) -> float:
    """Growth rate (1/s) of a small vibration of the bit about a steady speed, in the time-domain simulator.

    A short torque at the bit starts it; the rate is the slope of the logarithm of its amplitude, under Hann windows,
    between the second and the last quarter of the time. Steady rotation is stable where no frequency grows.

    Parameters
    ----------
    weight : N
    speed : rad/s
    frequency : Hz, of the vibration that is measured; others may decay at the same time
    duration : s
    """
    steps = round(duration / TIME_STEP)
    pulse = np.zeros(steps)
    pulse[: round(_PULSE / TIME_STEP)] = 1e-4 * weight * cutting.static
    rig = NonlinearRig(system, cutting=cutting)
    result = simulate(rig, np.zeros(steps), np.full(steps, speed), pulse, weight_on_bit=weight)
    baseband = (result.bit_speed - speed) * np.exp(-2j * np.pi * frequency * result.time)
    quarters = np.array_split(baseband, 4)
    early, late = (float(abs(np.hanning(quarters[number].size) @ quarters[number])) for number in (1, 3))
    return float(np.log(late / early) / (duration / 2))


def simulated_lowest_speed(
    system: DrillingSystem, cutting: Cutting, weight: float, bracket: tuple[float, float], tolerance: float = 0.05
) -> float:
    """Speed (rad/s) between two at which the simulated growth passes zero, to the tolerance (rad/s).

    The measured vibration has the frequency predicted by `critical_slope`.

    Raises
    ------
    EstimationError
        If the growth does not change its sign between the two speeds.
    """
    from scipy.optimize import brentq

    frequency = critical_slope(system)[1]

    def growth(speed: float) -> float:
        return simulated_growth(system, cutting, weight, speed, frequency)

    try:
        return float(brentq(growth, *bracket, xtol=tolerance))
    except ValueError as error:
        raise EstimationError(
            "stick-slip",
            f"growth keeps its sign between {bracket[0]:.2f} and {bracket[1]:.2f} rad/s",
            "Widen the bracket",
        ) from error

"""Causes at the lower end."""

from dataclasses import replace
from typing import Any

import numpy as np

from drillid.discrepancy.catalogue.cause import Cause, OperatingPoint, Size, WindowModel
from drillid.discrepancy.catalogue.sensor import AliasedTone
from drillid.discrepancy.detectors.motion import StandingBitDetector, WeakeningBitDetector
from drillid.physics.equipment import Motor, RegenerativeCutting
from drillid.statistics import TWO_SIDED

_HOUSING_SHARE = 0.5
"""Usual share of the lumped inertia below the collars that is in the motor's housing."""
_HOUSING_SPREAD = 1.7
"""Standard deviation of the logit of that share, at which it is nearly uniform (Gelman et al. 2008, Annals of Applied
Statistics 2, 1360-1383)."""
_LEAST_COMPLIANCE = 1e-15
"""rad/(N m), in place of zero, which would be an infinite stiffness."""


class DistributedBha(Cause):
    """Collars longer or shorter than the tally's."""

    name, family, port = "distributed_bha", "bit", "bit"
    shared_by = "tool"
    headline = "the assembly is {size} longer than the collars in the tally: compare the two"
    meaning = "the bottom-hole assembly is longer than the tally's collars, so that waves travel in it"
    looks_like = ("extra_section",)
    separated_by = "the full tally"
    action = "Find out which of assembly and tally is wrong, correct it and run again."
    size = Size("additional length", "m", 50.0, 0.0, 400.0)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Collars longer by the size, pipe shorter by as much."""
        pipe, *below = window_model.system.string
        if not below:
            below = [replace(pipe, length=0.0, polar_moment=3 * pipe.polar_moment)]
        longer = replace(below[0], length=below[0].length + size)
        return window_model.with_string(replace(pipe, length=pipe.length - size), longer, *below[1:])


class MotorCompliance(Cause):
    """A mud motor that twists; the share of the inertia above it is fitted."""

    name, family, port = "motor_compliance", "bit", "bit"
    shared_by = "tool"
    headline = "a mud motor twists above the bit: enter its stiffness in the rig description"
    meaning = "a mud motor above the bit twists, so that the bit does not follow the collars"
    looks_like = ("distributed_bha", "regenerative_cutting")
    separated_by = "a sweep that reaches the motor's own frequency, or the motor's data sheet"
    action = "The motor's data sheet states it."
    size = Size("compliance", "rad/(N m)", 5e-5, 0.0, 1e-3)
    shape_is_fitted = True

    def __init__(self, housing_share: Any = _HOUSING_SHARE) -> None:
        self.housing_share = housing_share

    def shaped(self, coordinate: Any) -> Cause:
        """The motor with another share of the inertia above it."""
        return MotorCompliance(1 / (1 + np.exp(-_HOUSING_SPREAD * coordinate)))

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """A spring between housing and bit."""
        lump = window_model.system.bit.inertia
        bit = replace(window_model.system.bit, inertia=lump * (1 - self.housing_share))
        motor = Motor(1 / (size + _LEAST_COMPLIANCE), inertia=lump * self.housing_share)
        return replace(window_model, system=replace(window_model.system, bit=bit, motor=motor))


class RegenerativeCut(Cause):
    """Regenerative cutting: each blade cuts the surface left by the blade ahead; the shape is the number of blades."""

    name, family, port = "regenerative_cutting", "bit", "bit"
    shared_by = "tool"
    headline = "the bit's blades excite vibration at this speed: change speed or weight on bit"
    meaning = "each blade of the bit cuts the surface left by the blade ahead, which excites vibration"
    looks_like = ("motor_compliance", "stribeck_cutting")
    separated_by = "windows at different speeds, as the blades' period follows the speed"
    action = "Change them in small steps, and watch torque and rate of penetration."
    size = Size("mean cutting torque", "N m", 2000.0, 0.0, 3e4)
    shapes = (3.0, 4.0, 5.0, 6.0, 7.0, 8.0)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """The cutting law at the window's speed."""
        law = RegenerativeCutting(size, operating_point.speed, shape)
        bit = replace(window_model.system.bit, cutting=(*window_model.system.bit.cutting, law))
        return replace(window_model, system=replace(window_model.system, bit=bit))


class StribeckCut(Cause):
    """Bit torque that falls with rising speed (Stribeck effect)."""

    name, family, port = "stribeck_cutting", "bit", "bit"
    shared_by = "tool"
    headline = "the cutting of the rock excites stick-slip at this speed: raise the speed or reduce the weight on bit"
    meaning = "the torque of the bit falls as its speed rises, which excites stick-slip"
    looks_like = ("coulomb_contact", "regenerative_cutting")
    separated_by = "windows at different speeds and weights"
    action = "The advised settings of the speed control damp it as well."
    size = Size("negative damping", "N m s/rad", 100.0, 0.0, 5e3)
    detector = WeakeningBitDetector()

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Bit damping reduced by the size at 10 rad/s, in proportion to one over the square of the speed."""
        slope = size * (10.0 / operating_point.speed) ** 2
        bit = replace(window_model.system.bit, damping=window_model.system.bit.damping - slope)
        return replace(window_model, system=replace(window_model.system, bit=bit))


class StuckSlipRegimes(Cause):
    """Stick-slip: the bit stands still for part of the time."""

    name, family, port = "stuck_slip_regimes", "bit", "bit"
    shared_by = "tool"
    headline = "the bit sticks and slips: raise the speed or reduce the weight on bit"
    meaning = "the bit sticks and slips, so that one linear model cannot hold for the window"
    looks_like = ("stribeck_cutting", "coulomb_contact")
    separated_by = "a higher speed or less weight on bit"
    action = "Until then the parameters of these windows do not hold for smooth drilling."
    distorts_responses = True
    size = Size("amplitude of the bit speed relative to its mean", "1", 1.0, 0.0, 5.0)
    detector = StandingBitDetector()
    stands_alone = True

    def allows(self, other: Cause) -> bool:
        """Whether the other is a fault of the recording other than a tone: stick-slip triggers all other detectors."""
        return other.name == self.name or (other.family == "sensor" and other.name != AliasedTone.name)

    def admits_size(self, size: float, size_error: float) -> bool:
        """Whether the speed swings by its mean or more: with less the bit does not stand."""
        return size + TWO_SIDED * size_error >= 1.0


CAUSES = (DistributedBha, MotorCompliance, RegenerativeCut, StribeckCut, StuckSlipRegimes)
"""What the catalogue takes from this file."""

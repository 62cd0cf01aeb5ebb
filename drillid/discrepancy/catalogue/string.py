"""Causes along the string."""

from dataclasses import replace
from typing import Any

import numpy as np

from drillid.discrepancy.catalogue.cause import Cause, OperatingPoint, Size, WindowModel
from drillid.discrepancy.detectors.motion import WeakeningWallDetector
from drillid.physics.damping import ConstantLossFactor, DampingLaw, RootDrag

_ZONE_SHARE, _ZONE_SPREAD = 0.055, 1.0
"""Usual length of a zone of local damping, as a share of the pipe's, and standard deviation of its logarithm: those of
lengths of 1 to 30 % that are log-uniform."""
_LEAST_ABOVE = 1e-3
"""Least share of the pipe above a zone."""
_HEAVIER, _HEAVIER_SPREAD = 2.8, 0.44
"""Usual polar moment of a section relative to the pipe's, and standard deviation of its logarithm: those of moments of
1.3 to 6 that are log-uniform, from heavy-weight pipe to collars."""


def _with_law(window_model: WindowModel, law: DampingLaw) -> WindowModel:
    sections = (replace(section, laws=(*section.laws, law)) for section in window_model.system.string)
    return window_model.with_string(*sections)


class ExtraSection(Cause):
    """A section of heavier pipe above the collars, whose polar moment relative to the pipe's is fitted."""

    name, family, port = "extra_section", "string", "string"
    headline = "the string contains {size} of heavier pipe that is not in the tally: compare the two"
    meaning = "the string contains a section of heavier pipe that is not in the tally"
    looks_like = ("distributed_bha", "tapered_string")
    separated_by = "the full tally, or windows over a longer interval of depth"
    action = "Find out which of string and tally is wrong, correct it and run again."
    size = Size("length", "m", 100.0, 0.0, 1000.0)
    shape_is_fitted = True

    def __init__(self, heavier: Any = _HEAVIER) -> None:
        self.heavier = heavier

    def shaped(self, coordinate: Any) -> Cause:
        """A section of another polar moment."""
        return ExtraSection(_HEAVIER * np.exp(_HEAVIER_SPREAD * coordinate))

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """A length of the pipe above the collars replaced by heavier pipe."""
        pipe, *below = window_model.system.string
        extra = replace(pipe, length=size, polar_moment=pipe.polar_moment * self.heavier)
        return window_model.with_string(replace(pipe, length=pipe.length - size), extra, *below)


class TaperedString(Cause):
    """Two sizes of pipe; the shape is the share of the length that the upper one takes."""

    name, family, port = "tapered_string", "string", "string"
    headline = "the string is made of two sizes of pipe: compare it with the tally"
    meaning = "the string is made of two sizes of pipe, and the tally lists one"
    looks_like = ("extra_section",)
    separated_by = "the full tally"
    action = "Enter both sizes in the rig description, then run again."
    size = Size("polar moment of the lower pipe relative to the upper's, less one", "1", 0.4, -0.9, 4.0)
    # so dense that waves of 5 Hz in some thousand metres of pipe hardly distinguish one from the next
    shapes = tuple(np.linspace(0.1, 0.9, 21).tolist())
    shape_step = 0.02

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """The lower part's polar moment times one plus the size."""
        pipe, *below = window_model.system.string
        # the lower pipe goes down with the bit: pipe that is added while drilling is upper pipe
        share = (1 - shape) * np.mean(operating_point.length) / operating_point.length
        upper = replace(pipe, length=pipe.length * (1 - share))
        lower = replace(pipe, length=pipe.length * share, polar_moment=pipe.polar_moment * (1 + size))
        return window_model.with_string(upper, lower, *below)


class LocalDampingZone(Cause):
    """Viscous damping over a part of the pipe, whose width is fitted; the shape is the position of its centre along the
    pipe.
    """

    name, family, port = "local_damping_zone", "string", "string"
    headline = "a short section of hole drags on the string{place}: ream or circulate there"
    meaning = "a short section of hole drags on the string: a tight spot, a ledge, a cuttings bed"
    looks_like = ("hysteretic_damping", "mud_drag")
    separated_by = "windows at several depths, as the zone stays in the hole while the string moves on"
    action = "Take care at this depth when tripping, and inspect the cuttings."
    size = Size("damping of the whole zone", "N m s/rad", 100.0, 0.0, 5e3)
    shapes = tuple(np.linspace(0.02, 0.98, 20).tolist())
    shape_step = 0.02
    is_place = True
    shape_is_fitted = True

    def __init__(self, width: Any = _ZONE_SHARE) -> None:
        self.width = width

    def shaped(self, coordinate: Any) -> Cause:
        """The zone at another width."""
        return LocalDampingZone(_ZONE_SHARE * np.exp(_ZONE_SPREAD * coordinate))

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Damping of the size spread over the zone."""
        pipe, *below = window_model.system.string
        # the zone is fixed in the hole: pipe is added above it, and its measured depth is the same in all windows
        mean = np.mean(operating_point.length) / operating_point.length
        # some pipe is left above, as a further cause acts there
        begin = mean * np.maximum(shape - self.width / 2, _LEAST_ABOVE)
        end = mean * np.minimum(shape + self.width / 2, 1.0)
        kappa = pipe.kappa + size / (pipe.length * (end - begin) * pipe.polar_moment)
        # what lies below the bit of a shallower window does not act there
        begin, end = np.minimum(begin, 1.0), np.minimum(end, 1.0)
        above, rest = replace(pipe, length=pipe.length * begin), replace(pipe, length=pipe.length * (1 - end))
        zone = replace(pipe, length=pipe.length * (end - begin), kappa=kappa)
        return window_model.with_string(above, zone, rest, *below)


class MudDrag(Cause):
    """Drag that grows with the square root of frequency."""

    name, family, port = "mud_drag", "string", "string"
    shared_by = "section"
    headline = "the mud drags on the pipe more than it should: check its viscosity"
    meaning = "the mud drags on the pipe through a thin layer, more at high frequency"
    looks_like = ("hysteretic_damping", "local_damping_zone")
    separated_by = "quieter windows, or the mud's density and viscosity"
    action = "Expect more torque at higher speed."
    size = Size("coefficient", "N s^(3/2)/m⁴", 300.0, 0.0, 5e3)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Drag along the whole string."""
        return _with_law(window_model, RootDrag(size))


class HystereticDamping(Cause):
    """Loss of the same share of energy in every cycle, at any frequency."""

    name, family, port = "hysteretic_damping", "string", "string"
    shared_by = "section"
    headline = "steel and connections damp vibration more than mud and wall: nothing needs repair"
    meaning = "steel and connections dissipate the same share of energy in every cycle, at any frequency"
    looks_like = ("local_damping_zone", "mud_drag")
    separated_by = "quieter windows, or a sweep that reaches more modes"
    action = "Use the extended model where damping matters."
    size = Size("loss factor", "1", 0.02, 0.0, 0.3)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """A constant loss factor along the whole string."""
        return _with_law(window_model, ConstantLossFactor(size))


class CoulombContact(Cause):
    """Wall friction that falls with rising speed."""

    name, family, port = "coulomb_contact", "string", "string"
    shared_by = "section"
    headline = "friction at the wall excites stick-slip at this speed: raise the speed or add lubricant"
    meaning = "friction at the wall falls as the speed of the string rises, which excites vibration"
    looks_like = ("stribeck_cutting",)
    separated_by = "windows at different speeds, or a start of rotation"
    action = "Compare torque and drag with the plan of the well."
    size = Size("negative damping", "N s/m⁴", 200.0, 0.0, 5e3)
    detector = WeakeningWallDetector()

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Wall damping reduced by the size at 10 rad/s, in proportion to one over the square of the speed."""
        pipe, *below = window_model.system.string
        slope = size * (10.0 / operating_point.speed) ** 2
        return window_model.with_string(
            replace(pipe, kappa=pipe.kappa - slope),
            *(replace(section, kappa=section.kappa - slope) for section in below),
        )


class WaveSpeed(Cause):
    """A wave speed other than that of plain steel pipe."""

    name, family, port = "wave_speed", "string", "string"
    headline = "waves take {size} {longer} along the pipe than the tally says: enter the tool joints in the data sheet"
    meaning = "waves travel along the pipe at a speed other than that in plain steel pipe: tool joints, another steel"
    separated_by = "windows over a longer interval of depth"
    action = "Nothing on the rig is wrong."
    size = Size("relative change of the pipe's travel time", "1", 0.05, -0.3, 0.5)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """The pipe longer by the size, for the same travel time."""
        pipe, *below = window_model.system.string
        return window_model.with_string(replace(pipe, length=pipe.length * (1 + size)), *below)


CAUSES = (ExtraSection, TaperedString, LocalDampingZone, MudDrag, HystereticDamping, CoulombContact, WaveSpeed)
"""What the catalogue takes from this file."""

"""Causes above the string: drive, control, and the gear of the top drive."""

from typing import Any

import numpy as np

from drillid.discrepancy.catalogue.cause import Cause, OperatingPoint, Size, WindowModel
from drillid.discrepancy.detectors.drive import DelayJitterDetector, TorqueLimitDetector, TorqueRateLimitDetector
from drillid.discrepancy.detectors.gear import BacklashDetector

_LEAST_VARIANCE = 1e-12
"""s², in place of zero, where the square root has no derivative."""


class DriveLag(Cause):
    """First-order lag of the torque loop."""

    name, family, port = "drive_lag", "drive", "drive"
    shared_by = "rig"
    headline = "the drive responds {size} late: have its torque loop checked"
    meaning = "the drive's torque follows its command with a lag, not only after a delay"
    looks_like = ("clock_offset", "recorder_filter", "sample_and_hold")
    separated_by = "a sweep to higher frequency, or a tighter tolerance of the drive's delay"
    action = "Tune the speed control for the lag, and ask the drive's maker for the torque loop's bandwidth."
    size = Size("time constant", "s", 0.03, 0.0, 0.3)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Lag of the size."""
        return window_model.with_top_drive(lag=size)


class ActuatorGain(Cause):
    """A ratio of torque to commanded torque other than one."""

    name, family, port = "actuator_gain", "drive", "drive"
    shared_by = "rig"
    headline = "the drive delivers {size} {more} torque than commanded: have its torque calibration checked"
    meaning = "the drive delivers more or less torque than commanded"
    separated_by = "a measured string torque, or tighter tolerances of top drive and pipe"
    action = "Until then, every torque limit is wrong by the same share."
    size = Size("gain less one", "1", 0.1, -0.6, 1.0)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Gain of one plus the size."""
        return window_model.with_top_drive(gain=1 + size)


class DelayJitter(Cause):
    """A delay that varies from sample to sample."""

    name, family, port = "delay_jitter", "drive", "drive"
    shared_by = "rig"
    headline = "the drive's delay varies by {size}: have the link to its controller checked"
    meaning = "the drive's delay varies from command to command"
    looks_like = ("drive_lag", "recorder_filter", "clock_offset")
    separated_by = "a sweep to higher frequency"
    action = "Leave more margin in the speed control until it is repaired."
    size = Size("root mean square, squared", "s²", 4e-4, 0.0, 4e-2)
    detector = DelayJitterDetector()

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Jitter whose variance is the size."""
        return window_model.with_top_drive(delay_jitter=np.sqrt(size + _LEAST_VARIANCE))


class TorqueLimit(Cause):
    """A limit of the drive's torque."""

    name, family, port = "torque_limit", "drive", "drive"
    shared_by = "rig"
    headline = "the drive is limited to a torque of {size}: raise the limit, or expect more stick-slip"
    meaning = "the drive reaches its torque limit"
    looks_like = ("torque_rate_limit", "actuator_gain")
    separated_by = "a sweep of smaller amplitude"
    action = "Compare it with the make-up torque of the connections before raising it."
    distorts_responses = True
    size = Size("limit", "N m", 1e4, 0.0, 1e5)
    detector = TorqueLimitDetector()


class TorqueRateLimit(Cause):
    """A limit of the rate at which the drive's torque changes."""

    name, family, port = "torque_rate_limit", "drive", "drive"
    shared_by = "rig"
    headline = "the drive's torque changes no faster than {size}: have its ramp limit raised"
    meaning = "the drive's torque cannot change as fast as commanded"
    looks_like = ("drive_lag", "torque_limit", "delay_jitter")
    separated_by = "a sweep of smaller amplitude"
    action = "Until then, do not rely on the speed control at the higher modes."
    distorts_responses = True
    size = Size("rate", "N m/s", 1e4, 0.0, 1e6)
    detector = TorqueRateLimitDetector()


class ControllerGain(Cause):
    """Gains of the speed control other than those of the data sheet."""

    name, family, port = "controller_gain", "control", "control"
    shared_by = "rig"
    headline = "the speed control's gains are {size} {higher} than in the data sheet: compare the drive's settings"
    meaning = "the gains of the speed control differ from those in the data sheet"
    looks_like = ("speed_scale",)
    separated_by = "the logged torque command together with the top drive's inertia"
    action = "Find out which of the two is wrong, correct it and run again."
    size = Size("relative change of both gains", "1", 0.2, -0.9, 3.0)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Both gains times one plus the size."""
        controller = window_model.system.top_drive.controller
        return window_model.with_controller(
            proportional=controller.proportional * (1 + size), integral=controller.integral * (1 + size)
        )


class SpeedFilter(Cause):
    """A filter on the speed that the data sheet does not state."""

    name, family, port = "speed_filter", "control", "control"
    shared_by = "rig"
    headline = "the control filters the speed over {size}: look for that filter in the drive's settings"
    meaning = "the control filters the measured speed"
    looks_like = ("torque_filter",)
    separated_by = (
        "a check of the drive's settings: no response distinguishes this filter from one on the controller's torque"
    )
    action = "Write it into the rig's data sheet: the advised settings then allow for it."
    size = Size("time constant", "s", 0.03, 0.0, 0.5)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """A time constant longer by the size."""
        return window_model.with_controller(speed_filter=window_model.system.top_drive.controller.speed_filter + size)


class TorqueFilter(Cause):
    """A filter on the controller's torque that the data sheet does not state."""

    name, family, port = "torque_filter", "control", "control"
    shared_by = "rig"
    headline = "the control filters its torque over {size}: look for that filter in the drive's settings"
    meaning = "the control filters its own torque before the sweep is added"
    looks_like = ("speed_filter",)
    separated_by = "a check of the drive's settings: no response distinguishes this filter from one on the speed"
    action = "Write it into the rig's data sheet: the advised settings then allow for it."
    size = Size("time constant", "s", 0.03, 0.0, 0.5)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """A time constant longer by the size."""
        return window_model.with_controller(torque_filter=window_model.system.top_drive.controller.torque_filter + size)


class GearBacklash(Cause):
    """Backlash of the top drive's gear."""

    name, family, port = "gear_backlash", "top", "top"
    shared_by = "rig"
    headline = "the top drive's gear has {size} of play: have it inspected, and keep its torque positive"
    meaning = "the gear of the top drive has play, which opens when its torque changes sign"
    looks_like = ("delay_jitter", "coulomb_contact")
    separated_by = "a window of low mean torque beside one of high"
    action = "While the mean torque stays well above zero, the teeth do not part."
    distorts_responses = True
    size = Size("free angle", "rad", 0.05, 0.0, 1.0)
    detector = BacklashDetector()


CAUSES = (
    DriveLag,
    ActuatorGain,
    DelayJitter,
    TorqueLimit,
    TorqueRateLimit,
    ControllerGain,
    SpeedFilter,
    TorqueFilter,
    GearBacklash,
)
"""What the catalogue takes from this file."""

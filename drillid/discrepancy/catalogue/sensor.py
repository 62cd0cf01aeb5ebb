"""Causes in sensors, filters, clocks and recorder."""

from typing import Any

import numpy as np

from drillid.discrepancy.catalogue.cause import Cause, OperatingPoint, Size, WindowModel
from drillid.discrepancy.detectors.held_speed import SampleAndHoldDetector
from drillid.discrepancy.detectors.recorder import ClockDriftDetector, QuantisationDetector, RevolutionDetector
from drillid.discrepancy.detectors.tone import ToneDetector

_LEAST_LAG = 1e-9
"""s, in place of zero, which would be an infinite corner frequency."""


class SpeedScale(Cause):
    """The speed is recorded at another scale than the control measures it."""

    name, family, port = "speed_scale", "sensor", "sensor"
    shared_by = "rig"
    headline = "the recorded speed reads {size} too {high}: have its sensor calibrated"
    meaning = "the recorded speed is wrong by a constant factor"
    looks_like = ("actuator_gain", "controller_gain")
    separated_by = "the logged torque command together with the top drive's inertia, or a count of revolutions"
    action = "Compare it with a count of revolutions over some minutes."
    size = Size("factor less one", "1", 0.05, -0.4, 0.4)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Recorded speed times one plus the size."""
        return window_model.with_recording(scale=window_model.recording.scale * (1 + size))


class SignOrUnit(Cause):
    """A channel with the wrong sign or in another unit than stated; the shape is the factor."""

    name, family, port = "sign_or_unit", "sensor", "sensor"
    shared_by = "rig"
    headline = "a channel has the wrong sign or unit: correct it in the rig description"
    meaning = "a channel has the wrong sign, or is in another unit than the data sheet says"
    separated_by = "a comparison with another channel of the same quantity"
    action = "Then run again: until it is corrected no result of these windows is valid."
    size = Size("share of the factor", "1", 1.0, 1.0, 1.0)
    # sign; ft-lbf and N m; kN m and kft-lbf are the same; in-lbf; kgf m; rpm and rad/s; rev/s and rad/s
    shapes = (-1.0, 1.3558, 0.73756, 0.11298, 8.8507, 9.8067, 0.10197, 9.5493, 0.10472, 6.2832, 0.15915)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Recorded speed times the factor at size 1."""
        return window_model.with_recording(scale=window_model.recording.scale * (1 + size * (shape - 1)))


class ClockOffset(Cause):
    """The speed is recorded later or earlier than the torque."""

    name, family, port = "clock_offset", "sensor", "clock"
    shared_by = "rig"
    headline = "the speed's time stamps are {size} {later} than the torque's: synchronise the recorder's clocks"
    meaning = "the clocks that stamp speed and torque differ"
    looks_like = ("drive_lag", "recorder_filter", "sample_and_hold")
    separated_by = "the logged torque command, or a tighter tolerance of the drive's delay"
    action = "Until then, shift the speed by this offset."
    size = Size("offset", "s", 0.05, -1.0, 1.0)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """The recorded speed delayed by the size."""
        return window_model.with_recording(clock_offset=window_model.recording.clock_offset + size)


class RecorderFilter(Cause):
    """A low-pass filter on the recorded speed; the shape is its order."""

    name, family, port = "recorder_filter", "sensor", "sensor"
    shared_by = "rig"
    headline = "the recorder filters the speed over {size}: ask for the unfiltered record"
    meaning = "the recorder filters the speed"
    looks_like = ("clock_offset", "drive_lag", "sample_and_hold")
    separated_by = "the logged torque command, or a sweep to higher frequency"
    action = "If there is none, write the filter into the rig's data sheet."
    size = Size("one over angular corner frequency", "s", 0.03, 0.0, 0.3)
    shapes = (1.0, 2.0)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """A Butterworth low-pass filter."""
        corner = 1 / (2 * np.pi * (size + _LEAST_LAG))
        return window_model.with_recording(filter_frequency=corner, filter_order=int(shape))


class SampleAndHold(Cause):
    """The recorded speed holds the last of rarer samples."""

    name, family, port = "sample_and_hold", "sensor", "sensor"
    shared_by = "rig"
    headline = "the recorded speed is updated only every {size}: ask for a record of every sample"
    meaning = "the recorder samples the speed less often than it writes rows, and holds it in between"
    looks_like = ("clock_offset", "drive_lag", "recorder_filter")
    separated_by = "the logged torque command, or a sweep to higher frequency"
    action = "If there is none, write the interval into the rig's data sheet."
    size = Size("interval", "s", 0.03, 0.0, 0.5)
    detector = SampleAndHoldDetector()

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """A speed that is late by a uniformly distributed time, up to the size."""
        return window_model.with_recording(renewal=window_model.recording.renewal + size)

    def allows(self, other: Cause) -> bool:
        """Whether the other is no jitter: the lateness of the rows varies as a jittering delay of the drive would."""
        return other.name != "delay_jitter"


class ClockDrift(Cause):
    """A clock offset that grows linearly."""

    name, family, port = "clock_drift", "sensor", "clock"
    shared_by = "rig"
    headline = "the clocks of speed and torque drift apart by {size}: synchronise them"
    meaning = "the clocks of speed and torque run at different rates"
    looks_like = ("length_growth",)
    separated_by = "one clock for both channels"
    action = "Until then, shorter windows are affected less."
    distorts_responses = True
    size = Size("drift", "s/s", 1e-4, -1e-2, 1e-2)
    detector = ClockDriftDetector()


class Quantisation(Cause):
    """Coarse quantisation of the recorded speed."""

    name, family, port = "quantisation", "sensor", "sensor"
    shared_by = "rig"
    headline = "the speed is recorded in steps of {size}: ask for finer ones, as nothing on the rig is wrong"
    meaning = "the speed is recorded in coarse steps"
    separated_by = "a finer record"
    action = "Until then, use longer windows, which average over the steps."
    size = Size("step", "rad/s", 0.05, 0.0, 10.0)
    detector = QuantisationDetector()

    @property
    def may_explain_unknown(self) -> bool:
        """True: rounding errors with coarse steps are not independent noise."""
        return True


class AliasedTone(Cause):
    """A tone above half the sample rate, aliased to below it."""

    name, family, port = "aliased_tone", "sensor", "disturbance"
    shared_by = "rig"
    headline = "the speed contains a tone of {size} that does not come from the rig: have an anti-alias filter fitted"
    meaning = "the record contains a tone that is not from the rig, perhaps aliased from above half its sample rate"
    looks_like = ("once_per_revolution",)
    separated_by = "another sample rate, or an anti-alias filter"
    action = "Look for a source of vibration above half the sample rate."
    size = Size("amplitude", "rad/s", 0.05, 0.0, 1.0)
    detector = ToneDetector()


class OncePerRevolution(Cause):
    """A speed sensor whose error is periodic with the shaft's revolution."""

    name, family, port = "once_per_revolution", "sensor", "sensor"
    shared_by = "rig"
    headline = "the speed has an error of {size} once per revolution: have encoder and coupling checked for run-out"
    meaning = "an eccentric encoder wheel causes an error of the speed once per revolution"
    looks_like = ("aliased_tone",)
    separated_by = "windows at different speeds"
    action = "The gear of the top drive may have run-out as well."
    size = Size("share of the speed", "1", 0.02, 0.0, 0.5)
    detector = RevolutionDetector()


CAUSES = (
    SpeedScale,
    SignOrUnit,
    ClockOffset,
    RecorderFilter,
    SampleAndHold,
    ClockDrift,
    Quantisation,
    AliasedTone,
    OncePerRevolution,
)
"""What the catalogue takes from this file."""

"""Input of the simulator for one window, and its linearisation about steady drilling for the ideal test."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.blind.generator.rigs import DrillingSegment, Equipment
from benchmarks.blind.hidden import altered
from drillid.arrays import Floats
from drillid.physics.equipment import Bit, DrillingSystem, Section
from drillid.physics.nonlinear import NonlinearRig
from drillid.physics.sensor import Recording
from drillid.simulation.recorder import Recorder
from drillid.simulation.simulate import SAMPLE_INTERVAL

Change = Callable[[NonlinearRig, float], NonlinearRig]
"""A rig and the elapsed share of the window, 0 to 1 → the rig at that time."""


@dataclass(frozen=True)
class World:
    """One window of a rig."""

    rig: NonlinearRig
    recorder: Recorder
    """Of the speed."""
    bit_torque: float
    """N m, mean torque of the rock in addition to the rig's own cutting."""
    weight_on_bit: float
    """N."""
    speed: float
    """rad/s, set point."""
    change: Change | None = None

    def with_system(self, **parts: Any) -> "World":
        """The same with other parts of the drilling system."""
        return altered(self, rig=altered(self.rig, system=altered(self.rig.system, **parts)))

    def with_top_drive(self, **parameters: Any) -> "World":
        """The same with other parameters of the top drive."""
        return self.with_system(top_drive=altered(self.rig.system.top_drive, **parameters))

    def with_controller(self, **parameters: Any) -> "World":
        """The same with other parameters of the speed control."""
        controller = altered(self.rig.system.top_drive.controller, **parameters)
        return self.with_top_drive(controller=controller)

    def with_recorder(self, **parameters: Any) -> "World":
        """The same with other parameters of the recorder."""
        return altered(self, recorder=altered(self.recorder, **parameters))

    @property
    def pipe(self) -> Section:
        """Uppermost section."""
        return self.rig.system.string[0]

    def linear(self, share: float) -> DrillingSystem:
        """The system linearised about steady drilling, at an elapsed share of the window."""
        rig = self.rig if self.change is None else self.change(self.rig, share)
        system = rig.linearised(self.speed, self.weight_on_bit)
        if rig.contact is None:
            return system
        widths = np.diff(rig.contact.edges)
        static, dynamic = (
            float(np.average(level, weights=widths)) for level in (rig.contact.static, rig.contact.dynamic)
        )
        slope = rig.contact.weakening.slope(static, dynamic, self.speed)
        string = tuple(altered(part, kappa=part.kappa + slope / part.polar_moment) for part in system.string)
        return altered(system, string=string)

    def recording(self, share: float, seconds: float) -> Recording:
        """Recording of the speed, at an elapsed share of a window of a length in seconds."""
        return recording(self.recorder, share, seconds)


def recording(recorder: Recorder, share: float, seconds: float) -> Recording:
    """Recording of the speed by a recorder, at an elapsed share of a window of a length in seconds."""
    offset = recorder.clock_offset + recorder.clock_drift * seconds * (share - 0.5)
    # rows that hold a sample are late by a uniformly distributed time
    offset, variance = offset + recorder.held / 2, recorder.held**2 / 12
    return Recording(
        recorder.scale, offset, 0.0, recorder.filter_frequency, recorder.filter_order, hold_variance=variance
    )


def base_world(equipment: Equipment, segment: DrillingSegment, nuisances: Floats | None = None) -> World:
    """A window without hidden causes; `nuisances` of shape (12,) are offsets from the truth.

    Their units are those of `benchmarks.blind.ideal.responses.NUISANCES`.
    """
    offset = np.zeros(12) if nuisances is None else nuisances
    kappa, delta = segment.kappa + 100.0 * offset[0], segment.delta * np.exp(offset[1])
    moment = equipment.pipe.polar_moment * (1 + offset[3])
    slow = 1 + equipment.slowness
    pipe = altered(
        equipment.pipe,
        length=segment.pipe_length * (1 + offset[2]),
        polar_moment=moment,
        kappa=kappa,
        delta=delta,
        density=equipment.pipe.density * slow,
        shear_modulus=equipment.pipe.shear_modulus / slow,
    )
    collars = altered(equipment.collars, kappa=kappa, delta=delta)
    true = equipment.top_drive
    controller = altered(
        true.controller,
        proportional=true.controller.proportional * (1 + offset[8]),
        integral=true.controller.integral * (1 + offset[9]),
    )
    top_drive = altered(
        true, inertia=true.inertia * (1 + offset[5]), delay=true.delay + 0.01 * offset[4], controller=controller
    )
    bit = Bit(equipment.bit.inertia + 50.0 * offset[7], segment.damping_bha + 50.0 * offset[6])
    rig = NonlinearRig(DrillingSystem(top_drive, (pipe, collars), bit), control_interval=equipment.control_interval)
    recorder = Recorder(
        SAMPLE_INTERVAL,
        clock_offset=equipment.clock + 1e-3 * offset[10],
        noise=equipment.sensor_noise,
        resolution=equipment.resolution,
    )
    return World(rig, recorder, equipment.bit_torque, equipment.weight_on_bit, segment.speed)

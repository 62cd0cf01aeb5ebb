"""What the simulator is given for one window, and the same about its steady state, for the ideal test."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.blind.generator.rigs import Equipment, Segment
from drillid.arrays import Floats
from drillid.physics.equipment import Bit, DrillingSystem, Section
from drillid.physics.nonlinear import NonlinearRig
from drillid.physics.sensor import Recording
from drillid.simulation.recorder import Recorder
from drillid.simulation.simulate import SAMPLE_INTERVAL

Change = Callable[[NonlinearRig, float], NonlinearRig]
"""A rig and the share of the window that has passed, 0 to 1 → the rig then."""

NUISANCES = {
    "kappa": "100 N s/m⁴",
    "delta": "logarithm",
    "length": "relative",
    "polar_moment": "relative",
    "delay": "10 ms",
    "inertia_td": "relative",
    "damping_bha": "50 N m s/rad",
    "inertia_bit": "50 kg m²",
    "P": "relative",
    "I": "relative",
    "clock": "ms",
}
"""Figures that no test is told, and the unit of what is added to each."""


@dataclass(frozen=True)
class World:
    """One window of a rig."""

    rig: NonlinearRig
    recorder: Recorder
    """Of the speed."""
    bit_torque: float
    """N m, mean that the rock takes beside the rig's own cutting."""
    weight_on_bit: float
    """N."""
    speed: float
    """rad/s, set point."""
    change: Change | None = None

    def with_system(self, **figures: Any) -> "World":
        """The same with other parts of the drilling system."""
        return replace(self, rig=replace(self.rig, system=replace(self.rig.system, **figures)))

    def with_top_drive(self, **figures: Any) -> "World":
        """The same with other figures of the top drive."""
        return self.with_system(top_drive=replace(self.rig.system.top_drive, **figures))

    def with_controller(self, **figures: Any) -> "World":
        """The same with other figures of the speed control."""
        controller = replace(self.rig.system.top_drive.controller, **figures)
        return self.with_top_drive(controller=controller)

    def with_recorder(self, **figures: Any) -> "World":
        """The same with another record of the speed."""
        return replace(self, recorder=replace(self.recorder, **figures))

    @property
    def pipe(self) -> Section:
        """Uppermost section."""
        return self.rig.system.string[0]

    def linear(self, share: float) -> DrillingSystem:
        """Small vibrations about steady drilling, at a share of the window."""
        rig = self.rig if self.change is None else self.change(self.rig, share)
        system = rig.linearised(self.speed, self.weight_on_bit)
        if rig.contact is None:
            return system
        widths = np.diff(rig.contact.edges)
        static, dynamic = (
            float(np.average(level, weights=widths)) for level in (rig.contact.static, rig.contact.dynamic)
        )
        slope = rig.contact.weakening.slope(static, dynamic, self.speed)
        string = tuple(replace(one, kappa=one.kappa + slope / one.polar_moment) for one in system.string)
        return replace(system, string=string)

    def recording(self, share: float, seconds: float) -> Recording:
        """How the speed is recorded, at a share of a window of so many seconds."""
        recorder = self.recorder
        offset = recorder.clock_offset + recorder.clock_drift * seconds * (share - 0.5)
        return Recording(recorder.scale, offset, 0.0, recorder.filter_frequency, recorder.filter_order)


def base_world(equipment: Equipment, stretch: Segment, figures: Floats | None = None) -> World:
    """A window without hidden causes; `figures` of shape (11,) move the nuisances off the truth."""
    by = np.zeros(len(NUISANCES)) if figures is None else figures
    kappa, delta = stretch.kappa + 100.0 * by[0], stretch.delta * np.exp(by[1])
    moment = equipment.pipe.polar_moment * (1 + by[3])
    slow = 1 + equipment.slowness
    pipe = replace(
        equipment.pipe,
        length=stretch.pipe_length * (1 + by[2]),
        polar_moment=moment,
        kappa=kappa,
        delta=delta,
        density=equipment.pipe.density * slow,
        shear_modulus=equipment.pipe.shear_modulus / slow,
    )
    collars = replace(equipment.collars, kappa=kappa, delta=delta)
    told = equipment.top_drive
    controller = replace(
        told.controller,
        proportional=told.controller.proportional * (1 + by[8]),
        integral=told.controller.integral * (1 + by[9]),
    )
    top_drive = replace(
        told, inertia=told.inertia * (1 + by[5]), delay=told.delay + 0.01 * by[4], controller=controller
    )
    bit = Bit(equipment.bit.inertia + 50.0 * by[7], stretch.damping_bha + 50.0 * by[6])
    rig = NonlinearRig(DrillingSystem(top_drive, (pipe, collars), bit), control_interval=equipment.control_interval)
    recorder = Recorder(
        SAMPLE_INTERVAL,
        clock_offset=equipment.clock + 1e-3 * by[10],
        noise=equipment.sensor_noise,
        resolution=equipment.resolution,
    )
    return World(rig, recorder, equipment.bit_torque, equipment.weight_on_bit, stretch.speed)

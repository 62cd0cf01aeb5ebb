"""The description of a rig: its log columns, its top drive and its drill string."""

from typing import Annotated, Literal, Self

from pydantic import model_validator

from drillid.config.bounds import Between
from drillid.config.validation import KeyFault, Strict
from drillid.units import (
    Fraction,
    Hertz,
    Metres,
    Seconds,
    TorsionalDamping,
    TorsionalInertia,
    TorsionalStiffness,
    to_si_factor,
)

CHANNEL_UNITS = {
    "torque_command": "N m",
    "torque_sweep": "N m",
    "speed": "rad/s",
    "speed_set": "rad/s",
    "hole_depth": "m",
    "bit_depth": "m",
    "weight_on_bit": "N",
    "flow": "m^3/s",
    "standpipe_pressure": "Pa",
    "hook_load": "N",
}
"""SI unit of every channel that a rig description can map a column to."""

REQUIRED_CHANNELS = ("torque_sweep", "speed", "hole_depth")

Channel = Literal[
    "torque_command",
    "torque_sweep",
    "speed",
    "speed_set",
    "hole_depth",
    "bit_depth",
    "weight_on_bit",
    "flow",
    "standpipe_pressure",
    "hook_load",
]


_THINNEST_WALL = 1e-4
"""Difference of the diameters, m, below which a tube has no wall."""

Share = Annotated[Fraction, Between(1e-6, 1, "dimensionless", ("%",))]
ProportionalGain = Annotated[TorsionalDamping, Between(10, 1e6, "N m s/rad", ("kN m s/rad", "kN m/rpm"), or_zero=True)]
IntegralGain = Annotated[TorsionalStiffness, Between(1, 1e7, "N m/rad", ("kN m/rad",), or_zero=True)]
FilterTime = Annotated[Seconds, Between(0, 5, "s", ("ms",))]
DriveInertia = Annotated[TorsionalInertia, Between(1, 1e5, "kg m^2", ("t m^2",))]
OuterDiameter = Annotated[Metres, Between(0.02, 0.8, "m", ("mm", "in", "cm"))]
InnerDiameter = Annotated[Metres, Between(0, 0.8, "m", ("mm", "in", "cm"))]
PartLength = Annotated[Metres, Between(0.1, 2000, "m", ("mm", "cm"))]
Depth = Annotated[Metres, Between(0, 15000, "m")]
SampleRate = Annotated[Hertz, Between(0.01, 10000, "Hz")]


class Column(Strict):
    """One column of the log."""

    column: str
    """Name of the column in the log's header."""
    unit: str
    """Unit of its values, such as 'kN m', 'ft-lbf', 'rpm', 'm', 'ft', 'bar', 'psi', 't', 'klbf', 'L/min', 'gal/min'."""


class Clock(Strict):
    """The log's time column."""

    column: str = "Time"
    """Name of the time column."""
    zone: str = "UTC"
    """Time zone of time stamps without one."""
    sample_rate: SampleRate | None = None
    """Nominal sample rate; derived from the time stamps where not given."""


class Stated(Strict):
    """Tolerance of a value from the rig's data sheets: its standard uncertainty, a confidence of about two thirds."""

    relative: Share = 0.05
    """Standard uncertainty as a share of the value."""


class StatedInertia(Stated):
    """Top-drive inertia from the drive's data sheet."""

    value: DriveInertia
    """Effective inertia of motor, gear and top drive at the quill."""


class StatedDelay(Strict):
    """Delay of the drive from torque command to torque."""

    value: Annotated[Seconds, Between(0, 1, "s", ("ms",))]
    """Delay."""
    tolerance: Annotated[Seconds, Between(1e-6, 1, "s", ("ms",))] = 0.005
    """Standard uncertainty."""


class SpeedControl(Strict):
    """The speed controller A(s) = P + I/s, with a first-order filter H on the measured speed."""

    proportional: ProportionalGain
    """Proportional gain P."""
    integral: IntegralGain = 0.0
    """Integral gain I."""
    speed_filter: FilterTime = 0.0
    """Time constant of the filter H on the measured speed; 0 for the raw speed."""
    torque_filter: FilterTime = 0.0
    """Time constant of the filter E on the controller's torque; 0 for none."""
    relative: Share = 0.02
    """Standard uncertainty of the gains."""


class Tube(Strict):
    """A tube by its size."""

    outer_diameter: OuterDiameter
    """Outer diameter of the body."""
    inner_diameter: InnerDiameter
    """Inner diameter of the body."""

    @model_validator(mode="after")
    def _has_a_wall(self) -> Self:
        outer, inner = (f"{1e3 * diameter:.4g} mm" for diameter in (self.outer_diameter, self.inner_diameter))
        if abs(self.inner_diameter - self.outer_diameter) < _THINNEST_WALL:
            what = f"outer and inner diameter are the same, {outer}, so that no wall is left"
            raise KeyFault("", what, "Correct one of the diameters; 0 m is the inner one of a solid bar")
        if self.inner_diameter > self.outer_diameter:
            what = f"outer {outer} is smaller than inner {inner}: they are probably swapped"
            raise KeyFault(
                "", what, "Exchange the values of 'outer_diameter' and 'inner_diameter', or correct their units"
            )
        return self


class Tubular(Tube):
    """One kind of pipe, with how well its size is known."""

    relative: Share = 0.05
    """Standard uncertainty of the polar moment (wear, tool joints)."""


class DrillPipe(Tubular):
    """The drill pipe of the tally."""

    length_relative: Share = 0.1
    """Standard uncertainty of the pipe's length as waves see it: tool joints slow them down."""


class Collars(Tubular):
    """The drill collars of one bottom-hole assembly run."""

    length: PartLength
    """Length of the collars."""
    from_depth: Depth = 0.0
    """Bit depth at which this assembly starts to drill."""


class HoleSection(Strict):
    """One section of the hole."""

    diameter: str
    """Diameter as drillers write it, such as 12¼\"."""
    from_depth: Depth = 0.0
    """Measured depth at which the section begins."""


class Rig(Strict):
    """One rig with its drill string: everything but the channels is optional, and has a tolerance."""

    name: str
    """Name of the rig, for reports."""
    time: Clock = Clock()
    """The log's time column."""
    channels: dict[Channel, Column]
    """Column and unit of each channel; torque_sweep, speed and hole_depth are needed."""
    controller: SpeedControl | None = None
    """Speed controller; where it is not given, it is estimated from the logged torque command."""
    drive_delay: StatedDelay | None = None
    """Delay of the drive."""
    top_drive_inertia: StatedInertia | None = None
    """Inertia of the top drive."""
    pipe: DrillPipe | None = None
    """Drill pipe of the tally."""
    collars: tuple[Collars, ...] = ()
    """Drill collars of each run, shallowest first."""
    hole_sections: tuple[HoleSection, ...] = ()
    """Sections of the hole, shallowest first."""

    @model_validator(mode="after")
    def _channels_usable(self) -> "Rig":
        missing = [name for name in REQUIRED_CHANNELS if name not in self.channels]
        if missing:
            raise KeyFault("channels", f"{', '.join(missing)} missing", "Map each to a column of the log with its unit")
        if self.controller is None and "torque_command" not in self.channels:
            raise KeyFault(
                "controller",
                "neither the controller nor the channel torque_command is given",
                "Add 'controller' with its gain 'proportional', or map the torque command under 'channels'",
            )
        for name, column in self.channels.items():
            try:
                to_si_factor(column.unit, CHANNEL_UNITS[name])
            except ValueError as error:
                unit = CHANNEL_UNITS[name]
                raise KeyFault(
                    f"channels.{name}.unit",
                    f"column '{column.column}': {error}",
                    f"Write the unit in which the log holds it, one of the kind of {unit}",
                ) from error
        return self

    def collars_at(self, bit_depth: float) -> Collars | None:
        """Collars in the hole when the bit drills at `bit_depth` (m)."""
        runs = [run for run in self.collars if run.from_depth <= bit_depth]
        return max(runs, key=lambda run: run.from_depth) if runs else None

"""The description of a rig: its log columns, its top drive and its drill string."""

from typing import Literal, Self

from pydantic import Field, model_validator

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
    sample_rate: Hertz | None = None
    """Nominal sample rate; derived from the time stamps where not given."""


class Stated(Strict):
    """Tolerance of a value from the rig's data sheets: its standard uncertainty, a confidence of about two thirds."""

    relative: Fraction = Field(default=0.05, gt=0)
    """Standard uncertainty as a share of the value."""


class StatedInertia(Stated):
    """Top-drive inertia from the drive's data sheet."""

    value: TorsionalInertia = Field(gt=0)
    """Effective inertia of motor, gear and top drive at the quill."""


class StatedDelay(Strict):
    """Delay of the drive from torque command to torque."""

    value: Seconds = Field(ge=0)
    """Delay."""
    tolerance: Seconds = Field(default=0.005, gt=0)
    """Standard uncertainty."""


class SpeedControl(Strict):
    """The speed controller A(s) = P + I/s, with a first-order filter H on the measured speed."""

    proportional: TorsionalDamping = Field(ge=0)
    """Proportional gain P."""
    integral: TorsionalStiffness = Field(default=0.0, ge=0)
    """Integral gain I."""
    speed_filter: Seconds = Field(default=0.0, ge=0)
    """Time constant of the filter H on the measured speed; 0 for the raw speed."""
    torque_filter: Seconds = Field(default=0.0, ge=0)
    """Time constant of the filter E on the controller's torque; 0 for none."""
    relative: Fraction = Field(default=0.02, gt=0)
    """Standard uncertainty of the gains."""


class Tube(Strict):
    """A tube by its size."""

    outer_diameter: Metres = Field(gt=0)
    """Outer diameter of the body."""
    inner_diameter: Metres = Field(ge=0)
    """Inner diameter of the body."""

    @model_validator(mode="after")
    def _has_a_wall(self) -> Self:
        if self.inner_diameter >= self.outer_diameter:
            raise KeyFault(
                "inner_diameter",
                f"{self.inner_diameter} m is not smaller than the outer diameter, {self.outer_diameter} m",
                "Correct the diameters and their units",
            )
        return self


class Tubular(Tube):
    """One kind of pipe, with how well its size is known."""

    relative: Fraction = Field(default=0.05, gt=0)
    """Standard uncertainty of the polar moment (wear, tool joints)."""


class DrillPipe(Tubular):
    """The drill pipe of the tally."""

    length_relative: Fraction = Field(default=0.1, gt=0)
    """Standard uncertainty of the pipe's length as waves see it: tool joints slow them down."""


class Collars(Tubular):
    """The drill collars of one bottom-hole assembly run."""

    length: Metres = Field(gt=0)
    """Length of the collars."""
    from_depth: Metres = Field(default=0.0, ge=0)
    """Bit depth at which this assembly starts to drill."""


class HoleSection(Strict):
    """One section of the hole."""

    diameter: str
    """Diameter as drillers write it, such as 12¼\"."""
    from_depth: Metres = Field(default=0.0, ge=0)
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

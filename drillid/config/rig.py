"""The description of a rig: its log columns, its top drive and its drill string."""

from collections.abc import Mapping
from datetime import datetime
from pathlib import Path, PurePath
from typing import Annotated, Literal, Self, get_args

from pydantic import Field, field_validator, model_validator

from drillid.config.bounds import Between
from drillid.config.validation import KeyFault, Name, Strict
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

CHANNEL_UNITS: dict[str, str] = {
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

CHANNELS: tuple[Channel, ...] = get_args(Channel)
REQUIRED_CHANNELS: tuple[Channel, ...] = ("torque_sweep", "speed", "hole_depth")


_DELIMITERS = {"tab": "\t", "comma": ",", "semicolon": ";", "space": " "}
_THINNEST_WALL = 1e-4
"""Difference of the diameters, m, below which a tube has no wall."""

Share = Annotated[Fraction, Between(1e-6, 1, "dimensionless", ("%",))]
ProportionalGain = Annotated[TorsionalDamping, Between(10, 1e6, "N m s/rad", ("kN m s/rad", "kN m/rpm"), or_zero=True)]
IntegralGain = Annotated[TorsionalStiffness, Between(1, 1e7, "N m/rad", ("kN m/rad",), or_zero=True)]
ControlInterval = Annotated[Seconds, Between(1e-6, 0.5, "s", ("ms",))]
FilterTime = Annotated[Seconds, Between(0, 5, "s", ("ms",))]
DriveInertia = Annotated[TorsionalInertia, Between(1, 1e5, "kg m^2", ("t m^2",))]
OuterDiameter = Annotated[Metres, Between(0.02, 0.8, "m", ("mm", "in", "cm"))]
InnerDiameter = Annotated[Metres, Between(0, 0.8, "m", ("mm", "in", "cm"))]
PartLength = Annotated[Metres, Between(0.1, 2000, "m", ("mm", "cm"))]
Depth = Annotated[Metres, Between(0, 15000, "m")]
NullValue = Annotated[float, Between(-1e300, 1e300, "dimensionless")]
SampleRate = Annotated[Hertz, Between(0.01, 10000, "Hz")]


class Column(Strict):
    """One column of the log."""

    column: str
    """Name of the column in the log's header; its unit may be left out of the name."""
    unit: str | None = None
    """Unit of its values, such as 'kN m', 'ft-lbf', 'rpm', 'm', 'ft', 'bar', 'psi', 't', 'klbf', 'L/min', 'gal/min';
    needed unless the file itself states it."""


class Clock(Strict):
    """The log's times; what is not stated is taken from the file where that is unambiguous, and noted."""

    column: str | None = None
    """Name of the time column; found by its name where not given."""
    date: str | None = None
    """Name of the column of dates, where they stand apart from the times of day."""
    zone: str = "UTC"
    """Time zone of time stamps without one, such as Europe/Oslo; its daylight saving is observed."""
    format: str | None = None
    """Order 'day first' or 'month first' of written dates, or their format as strptime has it, '%d.%m.%y %H:%M:%S'."""
    unit: (
        Literal["ns", "us", "ms", "s", "min", "h", "day", "excel", "matlab", "labview", "ticks", "filetime"] | None
    ) = None
    """Unit of times that are numbers, counted from `start`, else from 1970; or the serial days of workbooks and
    MATLAB, LabVIEW's seconds, the ticks of .NET, or the file times of Windows."""
    start: str | None = None
    """Time, such as 2025-03-03T06:00:00, from which numbers count, or the date of the first time of day."""
    sample_rate: SampleRate | None = None
    """Nominal sample rate; derived from the time stamps where not given."""

    @field_validator("format")
    @classmethod
    def _is_a_format(cls, stated: str | None) -> str | None:
        if stated is None or stated in ("day first", "month first") or "%" in stated:
            return stated
        what = f"'{stated}' is neither 'day first' nor 'month first' nor a format of strptime"
        raise KeyFault("", what, "Write each part with its letter, such as '%d.%m.%Y %H:%M:%S'")

    @field_validator("start")
    @classmethod
    def _is_a_time(cls, stated: str | None) -> str | None:
        if stated is not None:
            try:
                datetime.fromisoformat(stated)
            except ValueError as error:
                what = f"'{stated}' is not an ISO time"
                raise KeyFault("", what, "Write it as 2025-03-03T06:00:00, or a date as 2025-03-03") from error
        return stated


class LogFile(Strict):
    """How log files are laid out; whatever is not stated is determined from the file."""

    delimiter: str | None = None
    """Character between the columns of a text file, or tab, comma, semicolon or space (any number of spaces)."""
    decimal: Literal[".", ","] | None = None
    """Decimal separator."""
    thousands: str | None = Field(default=None, min_length=1, max_length=1)
    """Thousands separator."""
    encoding: str | None = None
    """Encoding of a text file, such as cp1252."""
    comment: str | None = Field(default=None, min_length=1)
    """Characters that begin lines without data."""
    header_line: int | None = Field(default=None, ge=1, le=200)
    """Line, counted from 1, of the names of the columns in a text file or sheet."""
    units_line: int | None = Field(default=None, ge=1, le=200)
    """Line, counted from 1, of the units."""
    columns: tuple[str, ...] = ()
    """Names of the columns of a file without a header."""
    table: str | None = None
    """Sheet, group, data set or log of a file that holds several; by default the one with most of the channels."""
    null_values: tuple[NullValue, ...] = ()
    """Further numbers that stand for missing values, in addition to -999.25, -9999 and the file's own."""
    ignore_units: bool = False
    """Whether the units of the description apply where the file states others; otherwise such a log is refused."""

    @field_validator("delimiter")
    @classmethod
    def _is_a_character(cls, stated: str | None) -> str | None:
        found = _DELIMITERS.get(stated, stated) if stated is not None else None
        if found is not None and len(found) != 1:
            raise KeyFault("", f"'{stated}' is not one character", f"Write one, or {', '.join(_DELIMITERS)}")
        return found

    @model_validator(mode="after")
    def _separators_differ(self) -> Self:
        if self.decimal is not None and self.decimal == self.thousands:
            raise KeyFault("thousands", f"'{self.decimal}' is already the decimal separator", "Correct one of the two")
        return self


class OtherLogs(Strict):
    """Log files of another shape, such as depth at 1 Hz in files of their own; what is not given is as for all logs."""

    files: str = Field(min_length=1)
    """Pattern of their names, such as '*_depth.csv', or of their last folders and names, such as 'depth/*.csv'."""
    time: Clock | None = None
    """Their times."""
    channels: dict[Channel, Column | None] | None = None
    """Their channels; those that they lack are taken from the well's other logs of the same
    time."""
    file: LogFile | None = None
    """Their layout."""

    @field_validator("files")
    @classmethod
    def _names_files(cls, pattern: str) -> str:
        if not PurePath(pattern).name or pattern.endswith("/"):
            raise KeyFault("", f"'{pattern}' is a folder, not a pattern of files", "Write it as in 'depth/*.csv'")
        return pattern

    def match(self, log: Path) -> bool:
        """Whether a log is one of them, capital letters or not."""
        return PurePath(str(log).casefold()).match(self.files.casefold())


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
            raise KeyFault("", what, "Swap the values of 'outer_diameter' and 'inner_diameter', or correct their units")
        return self


class Tubular(Tube):
    """One kind of pipe, with how well its size is known."""

    relative: Share = 0.05
    """Standard uncertainty of the polar moment (wear, tool joints)."""


class DrillPipe(Tubular):
    """The drill pipe of the tally."""

    length_relative: Share = 0.1
    """Standard uncertainty of the pipe's effective length for torsional waves, which tool joints slow down."""


class Collars(Tubular):
    """The drill collars of one bottom-hole assembly run."""

    length: PartLength
    """Length of the collars; a hole that is no deeper has no pipe, and gives no windows."""
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

    name: Name
    """Name of the rig, for reports."""
    time: Clock = Clock()
    """The log's times."""
    channels: dict[Channel, Column | None]
    """Column and unit of each channel; torque_sweep is needed. Others that are not named are recognised by their
    mnemonics in WITS; 'flow: null' says that a channel is not logged."""
    file: LogFile = LogFile()
    """Layout of the log files."""
    other_logs: tuple[OtherLogs, ...] = ()
    """Log files of other shapes; the first entry whose pattern matches a file applies to it."""
    controller: SpeedControl | None = None
    """Speed controller; where it is not given, it is estimated from the logged torque command."""
    control_interval: ControlInterval | None = None
    """Interval at which the control reads the speed and holds its command in between; where it is not given and
    the log does not show it, any value up to 50 ms is considered possible."""
    drive_delay: StatedDelay | None = None
    """Delay of the drive, including half the interval for which its command is held."""
    top_drive_inertia: StatedInertia | None = None
    """Inertia of the top drive."""
    pipe: DrillPipe | None = None
    """Drill pipe of the tally."""
    collars: tuple[Collars, ...] = ()
    """Drill collars of each run, shallowest first."""
    hole_sections: tuple[HoleSection, ...] = ()
    """Sections of the hole, shallowest first."""

    @model_validator(mode="after")
    def _channels_usable(self) -> Self:
        described = {"": self.channels} | {
            f"other_logs.{at}.": other.channels or {} for at, other in enumerate(self.other_logs)
        }
        if not any(channels.get("torque_sweep") for channels in described.values()):
            what = "torque_sweep is missing, which every log needs"
            raise KeyFault("channels", what, "Map it to the log's column of the injected torque, with its unit")
        for place, channels in described.items():
            _check_channels(channels, place)
        return self

    @model_validator(mode="after")
    def _one_entry_for_each_run(self) -> Self:
        begins = [run.from_depth for run in self.collars]
        for place, depth in enumerate(begins):
            if depth in begins[:place]:
                what = f"another run begins at {depth:g} m as well"
                remedy = (
                    "Give each run's from_depth; collars of several sizes in one run are one entry, all their length"
                )
                raise KeyFault(f"collars.{place}.from_depth", what, remedy)
        return self

    def for_log(self, log: Path) -> Self:
        """The description that holds for one log file, without other shapes."""
        other = next((other for other in self.other_logs if other.match(log)), None)
        changes = {} if other is None else dict(other)
        own = {name: changes[name] for name in ("time", "channels", "file") if changes.get(name) is not None}
        return self.model_copy(update={"other_logs": (), **own})

    def collars_at(self, bit_depth: float) -> Collars | None:
        """Collars in the hole when the bit drills at `bit_depth` (m)."""
        runs = [run for run in self.collars if run.from_depth <= bit_depth]
        return max(runs, key=lambda run: run.from_depth) if runs else None


def _check_channels(channels: Mapping[Channel, Column | None], place: str) -> None:
    """Reject units of another kind, and a needed channel that is said not to be logged."""
    for name, column in channels.items():
        if column is None and name in REQUIRED_CHANNELS:
            raise KeyFault(f"{place}channels.{name}", "is needed and cannot be left out", "Map it to a column")
        if column is None or column.unit is None:
            continue
        try:
            to_si_factor(column.unit, CHANNEL_UNITS[name])
        except ValueError as error:
            unit = CHANNEL_UNITS[name]
            raise KeyFault(
                f"{place}channels.{name}.unit",
                f"column '{column.column}': {error}",
                f"Write the unit in which the log holds it, one of the kind of {unit}",
            ) from error

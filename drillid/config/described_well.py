"""A well described for the simulation of its start of rotation: top drive, string, mud and friction."""

from dataclasses import asdict, fields
from pathlib import Path
from typing import Annotated

import yaml
from pydantic import Field

from drillid.config.bounds import Between
from drillid.config.files import read_yaml
from drillid.config.rig import DriveInertia, IntegralGain, PartLength, ProportionalGain, Tube
from drillid.config.validation import Strict
from drillid.errors import writing
from drillid.physics.equipment import Controller, TopDrive
from drillid.physics.soft_string import Survey
from drillid.simulation.start_up import WellEquipment, WellFriction
from drillid.simulation.start_up_fit import USUAL, StartUpModel
from drillid.units import Density, Pressure

ShearModulus = Annotated[Pressure, Between(1e9, 3e11, "Pa", ("GPa",))]


class DescribedTopDrive(Strict):
    """The top drive and its speed control."""

    inertia: DriveInertia
    """Effective inertia of motor, gear and top drive at the quill."""
    proportional: ProportionalGain
    """Proportional gain of the speed control."""
    integral: IntegralGain = 0.0
    """Integral gain of the speed control."""


class DescribedSection(Tube):
    """One section of the bottom-hole assembly."""

    length: PartLength
    """Length."""


class DescribedFriction(Strict):
    """Friction of the turning string, everywhere in the well."""

    sliding: float = Field(ge=0, le=2)
    """Coefficient of sliding friction."""
    breakaway: float = Field(default=1.0, ge=1, le=20)
    """Static per sliding coefficient."""
    assembly_sliding: float = Field(default=1.0, ge=0, le=20)
    """Sliding coefficient of the bottom-hole assembly per that of the pipe."""
    assembly_breakaway: float = Field(default=1.0, gt=0, le=20)
    """Static per sliding coefficient of the assembly, per that of the pipe."""
    threshold: float = Field(default=1.0, gt=0, le=100)
    """Speed in rad/s over which friction falls from static to sliding, as a Gaussian."""
    rest: float = Field(default=0.0, ge=0, le=20)
    """Relative increase of the pipe's friction after the long rest of a connection."""
    assembly_rest: float = Field(default=0.0, ge=0, le=20)
    """The same for the assembly."""
    rest_angle: float = Field(default=15.0, gt=0, le=1e4)
    """Slip in rad over which these shares fall to 1/e."""
    kappa: float = Field(default=0.0, ge=0, le=1e6)
    """Viscous damping of mud and wall, N s/m⁴."""
    delta: float = Field(default=1e8, ge=0, le=1e12)
    """Internal damping of the steel, N s/m²."""
    assembly_inertia: float = Field(default=1.0, gt=0, le=100)
    """Inertia of the assembly per inertia of solid steel at the stated diameters."""


class DescribedWell(Strict):
    """Everything but the hole's survey that a start of rotation depends on."""

    top_drive: DescribedTopDrive
    """Top drive and speed control."""
    pipe: Tube
    """The pipe, from the assembly to the surface."""
    pipe_shear_modulus: ShearModulus = 79.3e9
    """Shear modulus of the pipe, tool joints included."""
    assembly: tuple[DescribedSection, ...]
    """Sections of the bottom-hole assembly, from the top."""
    assembly_shear_modulus: ShearModulus = 79.3e9
    """Shear modulus of the assembly."""
    mud_density: Annotated[Density, Between(100, 3500, "kg/m^3", ("sg", "ppg"))] = 1200.0
    """Density of the mud, which carries a part of the string's weight."""
    friction: DescribedFriction
    """Friction along the string."""

    @property
    def described_equipment(self) -> WellEquipment:
        """Equipment of the simulation."""
        control = Controller(self.top_drive.proportional, self.top_drive.integral)
        return WellEquipment(
            TopDrive(self.top_drive.inertia, 0.0, control),
            (self.pipe.outer_diameter, self.pipe.inner_diameter),
            self.pipe_shear_modulus,
            tuple((section.length, section.outer_diameter, section.inner_diameter) for section in self.assembly),
            self.assembly_shear_modulus,
            self.mud_density,
        )

    @property
    def described_friction(self) -> WellFriction:
        """Friction of the simulation."""
        return WellFriction(**{field.name: getattr(self.friction, field.name) for field in fields(WellFriction)})

    def model(self, survey: Survey, depth: float, fitted: tuple[str, ...] = ()) -> StartUpModel:
        """Model of a start of rotation.

        Parameters
        ----------
        survey : of the hole
        depth : of the bit along the hole, m
        fitted : what is to be fitted; by default what holds at other depths of the hole as well

        Raises
        ------
        SettingsError
            If something is to be fitted that has no bounds.
        """
        names, equipment = fitted or USUAL, self.described_equipment
        return StartUpModel(equipment, survey, depth, self.described_friction, names, "assembly_rest" not in names)


def write_fitted(described: Path, friction: WellFriction, modulus: float, path: Path) -> None:
    """Write a description with another friction and shear modulus (Pa) of the pipe; all else is as it was described.

    Raises
    ------
    SettingsError
        If the description cannot be read, or the other not be written.
    """
    content = dict(read_yaml(described))
    content["pipe_shear_modulus"] = f"{modulus / 1e9:.5g} GPa"
    content["friction"] = {name: float(f"{value:.6g}") for name, value in asdict(friction).items()}
    with writing(path, "--output"):
        path.write_text(yaml.safe_dump(content, sort_keys=False, allow_unicode=True))

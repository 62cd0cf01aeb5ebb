"""Start of rotation of a described well: string, hole and friction along them, with a prescribed top-drive speed.

The motion follows from the description and a few coefficients of friction, which hold for the whole well, not for one
depth.
"""

from dataclasses import dataclass

import numpy as np

from drillid.arrays import Floats
from drillid.errors import SettingsError
from drillid.physics.equipment import Bit, DrillingSystem, Section, TopDrive, polar_moment
from drillid.physics.nonlinear import NonlinearRig, WallContact, Weakening
from drillid.physics.soft_string import Pipe, SideForces, Survey, side_forces
from drillid.simulation.simulate import simulate

RATE = 100.0
"""Hz, of logged and simulated series."""
STATISTICS_DELAY = 0.25
"""s, from the middle of the half second of the downhole sensor's statistics to its end, the time of their stamps."""
_SMOOTHING_SAMPLES = 21
TIME_STEP = 0.005
"""s, in which a wave travels about 14 m of string."""


@dataclass(frozen=True)
class WellEquipment:
    """Top drive, string and mud of the well, from data sheet and tally."""

    top_drive: TopDrive
    pipe: tuple[float, float]
    """Outer and inner diameter, m; the pipe reaches from the assembly to the surface."""
    pipe_shear_modulus: float
    """Pa."""
    assembly: tuple[tuple[float, float, float], ...]
    """Length, outer and inner diameter (m) of the bottom-hole assembly's sections, from the top."""
    assembly_shear_modulus: float
    """Pa."""
    mud_density: float
    """kg/m³."""

    @property
    def assembly_length(self) -> float:
        """Length of the bottom-hole assembly, m."""
        return sum(length for length, _, _ in self.assembly)


@dataclass(frozen=True)
class WellFriction:
    """Friction and damping of the rotating string, uniform over the well."""

    sliding: float
    """Coefficient of sliding friction."""
    breakaway: float = 1.0
    """Static per sliding coefficient."""
    assembly_sliding: float = 1.0
    """Sliding coefficient of the bottom-hole assembly per that of the pipe."""
    assembly_breakaway: float = 1.0
    """Static per sliding coefficient of the assembly, per that of the pipe."""
    threshold: float = 1.0
    """rad/s, over which friction falls from static to sliding as a Gaussian."""
    rest: float = 0.0
    """Relative increase of the pipe's friction after the long rest of a connection."""
    assembly_rest: float = 0.0
    """The same for the assembly."""
    rest_angle: float = 15.0
    """rad of slip over which these increases fall to 1/e."""
    kappa: float = 0.0
    """Viscous damping of mud and wall, N s/m⁴."""
    delta: float = 1e8
    """Internal damping, N s/m²."""
    assembly_inertia: float = 1.0
    """Inertia of the assembly per inertia of solid steel at the stated diameters."""

    def __post_init__(self) -> None:
        sizes = (self.sliding, self.assembly_sliding, self.kappa, self.delta, self.rest, self.assembly_rest)
        factors = (self.breakaway, self.breakaway * self.assembly_breakaway)
        if min(sizes) < 0 or min(factors) < 1 or self.assembly_inertia <= 0:
            raise SettingsError(
                "friction of the well",
                "a parameter is negative, or static friction is below sliding friction",
                "Give non-negative parameters and breakaways of at least 1",
            )


def rig_at(depth: float, survey: Survey, equipment: WellEquipment, friction: WellFriction) -> NonlinearRig:
    """The rig with its bit at a depth (m along the hole), pipe reaching from the assembly to the surface.

    Raises
    ------
    SettingsError
        If the depth is less than the assembly's length, or below the survey's end.
    """
    above = depth - equipment.assembly_length
    if above <= 0:
        raise SettingsError(f"bit depth {depth} m", "it is above the assembly's own length", "Give a greater depth")
    pipes = [
        Pipe(length, outer, inner, outer) for length, outer, inner in ((above, *equipment.pipe), *equipment.assembly)
    ]
    sections = tuple(
        Section(
            pipe.length,
            polar_moment(pipe.outer_diameter, pipe.inner_diameter),
            friction.kappa,
            friction.delta,
            pipe.density * (friction.assembly_inertia if index else 1.0),
            equipment.assembly_shear_modulus if index else equipment.pipe_shear_modulus,
        )
        for index, pipe in enumerate(pipes)
    )
    forces = side_forces(survey, pipes, equipment.mud_density)
    system = DrillingSystem(equipment.top_drive, sections, Bit(1.0))
    return NonlinearRig(system, contact=_contact(forces, above, friction))


def _contact(forces: SideForces, assembly_top: float, friction: WellFriction) -> WallContact:
    """Sliding and static torque per length, with coefficients of pipe and assembly."""
    below = (forces.edges[:-1] + forces.edges[1:]) / 2 > assembly_top
    torque = forces.side_force * forces.radius
    sliding = torque * friction.sliding * np.where(below, friction.assembly_sliding, 1.0)
    static = sliding * friction.breakaway * np.where(below, friction.assembly_breakaway, 1.0)
    rest = np.where(below, friction.assembly_rest, friction.rest)
    weakening = Weakening(friction.threshold, exponent=2.0)
    return WallContact(forces.edges, static, sliding, weakening, rest, friction.rest_angle)


@dataclass(frozen=True, eq=False)
class StartUp:
    """A simulated start of rotation, (samples,) at RATE."""

    time: Floats
    """s."""
    torque: Floats
    """N m, of the drive, including the part that accelerates its own inertia."""
    bit_speed: Floats
    """rad/s, of the bit itself."""

    def recorded_bit_speed(self) -> Floats:
        """rad/s, bit speed as recorded, with statistics stamped at the end of their interval."""
        return np.asarray(np.interp(self.time - STATISTICS_DELAY, self.time, self.bit_speed), dtype=float)


def start_up(rig: NonlinearRig, top_speed: Floats, time_step: float = TIME_STEP) -> StartUp:
    """Simulate the rig from rest under a measured top-drive speed.

    Parameters
    ----------
    top_speed : (samples,) rad/s at RATE; smoothed over 0.2 s, since it is differentiated
    time_step : s

    Raises
    ------
    SettingsError
        If the speed has fewer samples than it is smoothed over.
    """
    from scipy.signal import savgol_filter

    if top_speed.size < _SMOOTHING_SAMPLES:
        raise SettingsError(
            "start of rotation",
            f"{top_speed.size} samples of the top drive's speed are too few",
            f"Give at least {_SMOOTHING_SAMPLES}",
        )
    smooth, rise = (
        np.asarray(savgol_filter(top_speed, _SMOOTHING_SAMPLES, 3, deriv=order, delta=1 / RATE), dtype=float)
        for order in (0, 1)
    )
    logged = np.arange(top_speed.size) / RATE
    steps = round(top_speed.size / RATE / time_step)
    time = np.arange(steps) * time_step
    prescribed = np.interp(time, logged, np.maximum(smooth - smooth[0], 0.0))
    zeros = np.zeros(steps)
    result = simulate(rig, zeros, zeros, zeros, top_speed=prescribed, time_step=time_step, sample_interval=1 / RATE)
    acceleration_torque = rig.system.top_drive.inertia * rise[: result.time.size]
    return StartUp(result.time, result.string_torque + acceleration_torque, result.bit_speed)

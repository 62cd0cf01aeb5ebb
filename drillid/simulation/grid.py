"""Discretisation of a described rig into the arrays of the simulator's loops."""

from dataclasses import replace

import numpy as np

from drillid.arrays import Floats
from drillid.errors import SettingsError
from drillid.physics.attachments import MountedInertia
from drillid.physics.equipment import Controller, Section, Shaping
from drillid.physics.nonlinear import ErrorLaw, NonlinearRig, Weakening
from drillid.simulation.parts import (
    Control,
    CouplingTable,
    Drive,
    GearPlay,
    LawTable,
    Machine,
    Memory,
    Mounts,
    NodeFriction,
    Rock,
    SpatialGrid,
)
from drillid.simulation.relaxation import Relaxations, rates_of, relaxations

_NO_LAW = LawTable(False, 0.0, 1.0, np.zeros(2), 1.0, 1.0)


def element_counts(rig: NonlinearRig, time_step: float) -> tuple[int, ...]:
    """Elements of each section, as many as leave a wave at least one time step in each.

    Raises
    ------
    SettingsError
        If a section is shorter than the distance that a wave travels in one step.
    """
    return tuple(_elements(section, time_step) for section in rig.system.string)


def _elements(section: Section, time_step: float) -> int:
    distance = np.sqrt(section.shear_modulus / section.density) * time_step
    count = int(section.length / distance)
    if count < 1:
        raise SettingsError(
            f"simulation, section of {section.length} m",
            f"a wave travels {distance:.2f} m in a time step of {time_step} s, more than the section's length",
            "Choose a smaller time step, or join the section to its neighbour",
        )
    return count


def build(rig: NonlinearRig, counts: tuple[int, ...], time_step: float) -> Machine:
    """Discrete rig with `counts` elements in its sections.

    Raises
    ------
    SettingsError
        If the time step is too long for gear, motor or the bit's law, a factor has no realisation, or an interval is
        not a whole number of steps.
    """
    if rig.system.bit.cutting:
        raise SettingsError(
            "simulation",
            "the bit has linear cutting laws",
            "Describe cutting in a NonlinearRig, or convert the system by NonlinearRig.from_linear",
        )
    rates = rates_of(rig.system.string)
    laws = [relaxations(section, rates) for section in rig.system.string]
    grid = _with_ends(rig, _string(rig, laws, counts))
    _check_stable(rig, grid, time_step)
    memory = _memory(rig, laws, rates, counts, time_step / 2)
    grid.viscous[:] += memory.shunt.sum(axis=0)
    grid.coupling[:] += memory.series.sum(axis=0) * time_step / 2
    mounts = _mounts(rig, counts, time_step / 2)
    np.add.at(grid.viscous, mounts.nodes, mounts.load)
    top_inertia = rig.gear.output_inertia if rig.gear.play > 0 else float(rig.system.top_drive.inertia)
    gear = GearPlay(rig.gear.play > 0, rig.gear.play / 2, rig.gear.damping)
    if gear.present:
        grid.coupling[0] = 0.0
    parts = (
        _friction(rig, counts),
        memory,
        mounts,
        _rock(rig),
        _law(rig, grid, time_step),
        _coupling(rig, counts),
        _control(rig, time_step),
        _drive(rig, time_step),
    )
    return Machine(grid, gear, *parts, top_inertia)


def _string(rig: NonlinearRig, laws: list[Relaxations], counts: tuple[int, ...]) -> SpatialGrid:
    """The string alone, with half of each element's inertia and wall damping at either end."""
    nodes = sum(counts) + 1
    inertia, viscous = np.zeros(nodes), np.zeros(nodes)
    stiffness, coupling = np.empty(nodes - 1), np.empty(nodes - 1)
    first = 0
    for section, law, count in zip(rig.system.string, laws, counts, strict=True):
        width = section.length / count
        span = slice(first, first + count)
        stiffness[span] = (section.shear_modulus * section.polar_moment + law.stiffness) / width
        coupling[span] = (section.delta * section.polar_moment + law.coupling) / width
        for ends in (span, slice(first + 1, first + count + 1)):
            inertia[ends] += (section.density * section.polar_moment + law.inertia) * width / 2
            viscous[ends] += (section.kappa * section.polar_moment + law.damping) * width / 2
        first += count
    return SpatialGrid(inertia, viscous, stiffness, coupling)


def _memory(
    rig: NonlinearRig, laws: list[Relaxations], rates: Floats, counts: tuple[int, ...], half_step: float
) -> Memory:
    """Relaxations of all nodes and springs, at the rates that any law uses; gear and motor have none."""
    nodes = sum(counts) + 1
    shunt, series = np.zeros((rates.size, nodes)), np.zeros((rates.size, nodes - 1))
    first = 0
    for section, law, count in zip(rig.system.string, laws, counts, strict=True):
        width = section.length / count
        span = slice(first, first + count)
        series[:, span] = law.series[:, None] / width
        for ends in (span, slice(first + 1, first + count + 1)):
            shunt[:, ends] += law.shunt[:, None] * width / 2
        first += count
    before, after = int(rig.gear.play > 0), int(rig.system.motor is not None)
    shunt, series = (np.pad(gains, ((0, 0), (before, after))) for gains in (shunt, series))
    used = [np.flatnonzero(gains.any(axis=1)) for gains in (shunt, series)]
    decays = [rates[rows] * half_step for rows in used]
    # the trapezoidal rule splits each relaxation into a part from this step's mean and one from its state
    shunt, series = (gains[rows] for gains, rows in zip((shunt, series), used, strict=True))
    weights = [gains / (1 + decay[:, None]) for gains, decay in zip((shunt, series), decays, strict=True)]
    return Memory(bool(used[0].size or used[1].size), decays[0], weights[0], decays[1], weights[1])


def _mounts(rig: NonlinearRig, counts: tuple[int, ...], half_step: float) -> Mounts:
    """Mounted inertias, spread over the nodes of their sections as the sections' own inertia is."""
    nodes: list[int] = []
    found: list[MountedInertia] = []
    first = int(rig.gear.play > 0)
    for section, count in zip(rig.system.string, counts, strict=True):
        shares = np.pad(np.ones(count - 1), 1, constant_values=0.5) / count
        for law in section.laws:
            if isinstance(law, MountedInertia) and law.inertia > 0:
                whole = law.inertia * section.length / law.spread
                nodes += range(first, first + count + 1)
                found += [replace(law, inertia=whole * share) for share in shares]
        first += count
    inertia, stiffness, damping = (
        np.array([getattr(law, name) for law in found], dtype=float) for name in ("inertia", "stiffness", "damping")
    )
    damping = damping + stiffness * half_step
    load = damping * inertia / (inertia + half_step * damping)
    return Mounts(np.array(nodes, dtype=np.int64), inertia, stiffness, damping, load)


def _shaping(shaping: Shaping | None, step: float) -> Floats:
    """Coefficients b₀, b₁, b₂, a₁, a₂ of a rational factor in discrete time by the bilinear transform, (5,)."""
    if shaping is None:
        return np.array([1.0, 0.0, 0.0, 0.0, 0.0])
    zeros, poles = (shaping.zero_1, shaping.zero_2), (shaping.pole_1, shaping.pole_2)
    is_proper = poles[1] > 0 or (zeros[1] == 0 and (poles[0] > 0 or zeros[0] == 0))
    if type(shaping) is not Shaping or not is_proper or min(poles) < 0:
        raise SettingsError(
            "simulation",
            "drive or control has a learnt factor that is not a proper, stable rational one",
            "Predict with the frequency responses, or describe it by filters and lag",
        )
    from scipy.signal import bilinear

    powers = (np.array([second, first, 1.0], dtype=float) for first, second in (zeros, poles))
    # a factor of lower order has fewer coefficients
    forward, backward = (np.pad(each, (0, 3 - each.size)) for each in bilinear(*powers, fs=1 / step))
    return np.asarray(np.concatenate([forward, backward[1:]]), dtype=float)


def _with_ends(rig: NonlinearRig, string: SpatialGrid) -> SpatialGrid:
    """The string with top drive and bit; a gear with play and a motor add a spring and a node each."""
    inertia, viscous, stiffness, coupling = string
    top_inertia, gear, motor, bit = float(rig.system.top_drive.inertia), rig.gear, rig.system.motor, rig.system.bit
    if motor is not None:
        inertia[-1] += motor.inertia
        inertia, viscous = np.append(inertia, 0.0), np.append(viscous, 0.0)
        stiffness, coupling = np.append(stiffness, motor.stiffness), np.append(coupling, motor.damping)
    inertia[-1] += bit.inertia
    viscous[-1] += bit.damping
    if gear.play > 0:
        if not 0 < gear.output_inertia < top_inertia:
            raise SettingsError(
                "gear",
                f"an output inertia of {gear.output_inertia} kg m² is no part of the top drive's {top_inertia} kg m²",
                "Give the part of the top drive's inertia that turns below the gear",
            )
        inertia[0] += gear.output_inertia
        inertia, viscous = np.insert(inertia, 0, 0.0), np.insert(viscous, 0, 0.0)
        stiffness, coupling = np.insert(stiffness, 0, gear.stiffness), np.insert(coupling, 0, gear.damping)
        top_inertia -= gear.output_inertia
    inertia[0] += top_inertia
    return SpatialGrid(inertia, viscous, stiffness, coupling)


def _check_stable(rig: NonlinearRig, grid: SpatialGrid, time_step: float) -> None:
    """Leap-frog is stable below 2 rad of the fastest mode per step; the string alone satisfies this by its elements."""
    if rig.system.motor is None and not rig.gear.play > 0:
        return
    from scipy.linalg import eigvalsh_tridiagonal

    if not np.all(np.isfinite(grid.stiffness)):
        raise SettingsError(
            "simulation",
            "gear or motor is rigid",
            "Leave it out and add its inertia to its neighbour, or give a finite stiffness",
        )
    if not np.all(grid.inertia > 0):
        raise SettingsError("simulation", "a bit below a motor must have an inertia", "Give the bit an inertia")
    ends = np.concatenate([grid.stiffness, [0.0]]) + np.concatenate([[0.0], grid.stiffness])
    links = -grid.stiffness / np.sqrt(grid.inertia[1:] * grid.inertia[:-1])
    last = grid.inertia.size - 1
    fastest = np.sqrt(eigvalsh_tridiagonal(ends / grid.inertia, links, select="i", select_range=(last, last))[0])
    if fastest * time_step > 2 * (1 + 1e-9):
        raise SettingsError(
            "simulation",
            f"gear or motor oscillates at {fastest / (2 * np.pi):.0f} Hz, too fast for a time step of {time_step} s",
            f"Choose a time step below {2 / fastest:.2g} s, or a softer spring",
        )


def _friction(rig: NonlinearRig, counts: tuple[int, ...]) -> NodeFriction:
    """Contacts of the nodes with friction: none on a gear's motor side, only cutting at the bit below a mud motor."""
    cuts = rig.cutting is not None or rig.regenerative is not None
    nodes = sum(counts) + 1
    static, dynamic = np.zeros(nodes), np.zeros(nodes)
    rest, rest_angle, weakening = np.zeros(nodes), 1.0, Weakening()
    if rig.contact is not None:
        widths = np.repeat([s.length / n for s, n in zip(rig.system.string, counts, strict=True)], counts)
        positions = np.concatenate([[0.0], np.cumsum(widths)])
        edges = np.concatenate([positions[:1], (positions[1:] + positions[:-1]) / 2, positions[-1:]])
        static, dynamic = rig.contact.torque_between(edges)
        rest, rest_angle, weakening = rig.contact.rest_between(edges), rig.contact.rest_angle, rig.contact.weakening
    if rig.gear.play > 0:
        static, dynamic, rest = (np.insert(level, 0, 0.0) for level in (static, dynamic, rest))
    if rig.system.motor is not None:
        static, dynamic, rest = (np.append(level, 0.0) for level in (static, dynamic, rest))
    touches = static > 0
    touches[-1] |= cuts
    law = (weakening.threshold, weakening.exponent, rest[touches], rest_angle)
    return NodeFriction(np.flatnonzero(touches), static[touches], dynamic[touches], *law)


def _rock(rig: NonlinearRig) -> Rock:
    cutting, blades = rig.cutting, rig.regenerative
    law = (0.0, 0.0, 1.0, 1.0)
    if cutting is not None:
        law = (cutting.static, cutting.dynamic, cutting.weakening.threshold, cutting.weakening.exponent)
    chips = (0, 0.0, 0.0, 0.0)
    if blades is not None:
        chips = (blades.blades, float(blades.torque_per_depth), float(blades.rate), float(blades.depth_per_weight))
    return Rock(cutting is not None, *law, *chips)


def _law(rig: NonlinearRig, grid: SpatialGrid, time_step: float) -> LawTable:
    """The bit's law, whose torque is extrapolated by half a step."""
    law = rig.law
    if law is None:
        return _NO_LAW
    # extrapolation by half a step halves the greatest stable step
    if law.steepest * time_step > grid.inertia[-1]:
        raise SettingsError(
            "simulation, law of the bit",
            f"a slope of {law.steepest:.3g} N m s/rad is too steep for a time step of {time_step} s",
            f"Choose a time step below {grid.inertia[-1] / law.steepest:.2g} s",
        )
    torque = np.ascontiguousarray(law.torque, dtype=float)
    followed = [float(-np.expm1(-share * time_step / law.memory)) if law.memory > 0 else 1.0 for share in (1.0, 0.5)]
    return LawTable(True, float(law.speed[0]), float(law.speed[1] - law.speed[0]), torque, followed[0], followed[1])


def _coupling(rig: NonlinearRig, counts: tuple[int, ...]) -> CouplingTable:
    """The coupling's law at the spring nearest to its depth."""
    law = rig.coupling
    if law is None:
        return CouplingTable(-1, 0.0, 1.0, np.zeros(2))
    widths = np.repeat([section.length / n for section, n in zip(rig.system.string, counts, strict=True)], counts)
    middle = np.cumsum(widths) - widths / 2
    spring = int(np.argmin(np.abs(middle - law.depth))) + int(rig.gear.play > 0)
    spacing = float(law.torque[1] - law.torque[0])
    return CouplingTable(spring, float(law.torque[0]), spacing, np.gradient(law.twist, spacing))


def _steps_between_readings(rig: NonlinearRig, time_step: float) -> int:
    return whole_steps("control interval", rig.control_interval, time_step) if rig.control_interval > 0 else 1


def _control(rig: NonlinearRig, time_step: float) -> Control:
    every, controller = _steps_between_readings(rig, time_step), rig.system.top_drive.controller
    return Control(
        float(controller.proportional),
        float(controller.integral),
        float(controller.speed_filter),
        float(controller.torque_filter),
        every,
        float(rig.sensor.scale),
        float(rig.sensor.resolution),
        float(rig.sensor.ripple),
        float(controller.compensated_inertia),
        float(controller.compensation_filter),
        *_matching(controller),
        _shaping(controller.shaping, every * time_step),
        _control_law(rig.control_law),
    )


def _control_law(law: ErrorLaw | None) -> LawTable:
    if law is None:
        return _NO_LAW
    torque = np.ascontiguousarray(law.torque, dtype=float)
    return LawTable(True, float(law.error[0]), float(law.error[1] - law.error[0]), torque, 1.0, 1.0)


def _matching(controller: Controller) -> tuple[float, float, float, float]:
    matching = controller.matching
    if matching is None:
        return 0.0, 0.0, 0.0, np.inf
    high_pass = np.inf if matching.high_pass is None else float(matching.high_pass)
    return float(matching.impedance), float(matching.inertia), float(matching.low_pass), high_pass


def _drive(rig: NonlinearRig, time_step: float) -> Drive:
    top_drive, limits = rig.system.top_drive, rig.limits
    # interpolation between steps centres the jumps of a held command half a step before they are commanded
    early = time_step / 2 if _steps_between_readings(rig, time_step) > 1 else 0.0
    return Drive(
        float(top_drive.delay) + early,
        float(top_drive.lag),
        float(top_drive.gain),
        float(limits.torque),
        float(limits.rate),
        _shaping(top_drive.shaping, time_step),
    )


def whole_steps(name: str, interval: float, time_step: float) -> int:
    """Time steps in an interval.

    Raises
    ------
    SettingsError
        If it is not a whole number of them.
    """
    steps = round(interval / time_step)
    if steps < 1 or abs(steps * time_step - interval) > 1e-9:
        raise SettingsError(
            "simulation",
            f"the {name} {interval} s is not a whole number of time steps of {time_step} s",
            "Choose a time step that divides it",
        )
    return steps

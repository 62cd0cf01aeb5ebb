"""Responses of the first world by linear theory of the simulated rig."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.blind.generator.cases import EFFECTS, Case
from benchmarks.blind.generator.effects_string import same_string
from benchmarks.blind.generator.rigs import LOCAL_STEPS
from benchmarks.blind.generator.world import World, recording
from benchmarks.blind.hidden import Hidden, altered
from benchmarks.blind.ideal.line import COLUMNS
from benchmarks.blind.ideal.responses import RATE, WINDOW_S, Ends, Kept, Kind, Line, Priors, Top
from benchmarks.blind.vocabulary import tone_frequency
from drillid.arrays import Complex, Floats
from drillid.excitation.torques import coloured_noise_density
from drillid.physics.attachments import MountedInertia
from drillid.physics.bottom_end import cutting_admittance
from drillid.physics.damping import ConstantLossFactor, RootDrag
from drillid.physics.equipment import DrillingSystem, RegenerativeCutting
from drillid.physics.responses import bit_speed_ratio, command_mobility, laplace, string_admittance
from drillid.physics.top_drive import control, drive, top_admittance
from drillid.simulation.recorder import Recorder

_SPRING = {"length": 1.0, "moment": 1e-5, "density": 1e-3}
"""A motor's spring as a piece without inertia to speak of."""


class OwnResponses:
    """A case of the first world for the ideal test."""

    effects: Mapping[str, Kind] = EFFECTS
    power_law = True
    # a cause may hold the damping of a length of pipe, so that κ depends on the moment; and a motor's damping depends
    # on the inertia of the bit
    mixed = (2, 3, 7)

    def __init__(self, case: Case) -> None:
        self.case = case
        self.windows, self.sweep = len(case.segments), case.equipment.sweep_amplitude
        self.priors = _priors(case)
        self._kept = Kept()

    def size_range(self, hidden: Hidden) -> tuple[float, float]:
        """Least and largest size that is drawn, in the first window."""
        return EFFECTS[hidden.name].range(self.case.world(0, hidden=()), self.case.context(hidden))

    def equal(self, hidden: Hidden) -> tuple[Hidden, ...]:
        """Other causes that are the same rig, or nearly so."""
        return same_string(hidden, self.case.segments[0].pipe_length)

    def expected(
        self, window: int, hidden: tuple[Hidden, ...], nuisances: Floats | None, s: Complex, shares: Sequence[float]
    ) -> list[tuple[Complex, Complex]]:
        """Recorded command mobility and response of the control at elapsed shares of a window, with causes."""
        world = self.case.world(window, nuisances, hidden)
        found = []
        for share in shares:
            system, recorded = world.linear(share), world.recording(share, WINDOW_S).transfer(s)
            found.append((command_mobility(system, s) * recorded, control(system.top_drive.controller, s) / recorded))
        return found

    def lines(
        self, window: int, hidden: tuple[Hidden, ...], nuisances: Floats | None, shares: Sequence[float]
    ) -> list[Line]:
        """The same in numbers."""
        world = self.case.world(window, nuisances, hidden)
        systems = [world.linear(share) for share in (shares if world.change else (0.5,))]
        found, recorder = [], world.recorder
        for number, share in enumerate(shares):
            system = systems[number if world.change else 0]
            top, gains = system.top_drive, system.top_drive.controller
            numbers = (top.delay, top.inertia, gains.proportional, gains.integral, recorder.clock_offset)
            admittance = float(system.string[0].characteristic_admittance)
            rest = (top, recorder, share if recorder.clock_drift else 0.5)
            # the simulator's control reads at every instant
            upper = Top(*(float(value) for value in numbers), 0.0, admittance, rest)
            found.append(Line(*_numbers(system), upper))
        return found

    def ends(self, top: Top, s: Complex) -> Ends:
        """Responses of an upper end."""
        rest: Any = top.rest
        top_drive, recorder, share = rest
        gains = altered(top_drive.controller, proportional=top.proportional, integral=top.integral)
        # inertia and controller do not matter to what follows the command
        driven = altered(top_drive, delay=top.delay, inertia=0.0, controller=None)
        return Ends(
            self._kept(s, (driven,), drive),
            np.zeros_like(s),
            np.zeros_like(s),
            top.inertia * s,
            self._kept(s, (gains,), control),
            self._kept(s, (altered(recorder, clock_offset=top.offset), share), _recorded),
        )

    def noise_density(self, window: int, hidden: tuple[Hidden, ...], s: Complex, share: float = 0.5) -> Floats:
        """One-sided power density of the recorded speed's noise, (rad/s)²/Hz."""
        world = self.case.world(window, hidden=hidden)
        system = world.linear(share)
        loaded = top_admittance(system.top_drive, s) + string_admittance(system, s)
        # by reciprocity, the response of the top to a torque at the bit is that of the bit to one at the top
        transfer = bit_speed_ratio(system, s) / loaded
        frequency = np.abs(s) / (2 * np.pi)
        case = self.case
        bit = coloured_noise_density(frequency, case.segments[window].bit_noise, case.equipment.noise_bandwidth)
        recorded = world.recording(share, WINDOW_S).transfer(s)
        return np.asarray(np.abs(transfer * recorded) ** 2 * bit + _sensor_density(world), dtype=float)

    def sensor_density(self, window: int, hidden: tuple[Hidden, ...]) -> float:
        """One-sided power density of the recorder's noise, in the recorded speed, (rad/s)²/Hz."""
        return _sensor_density(self.case.world(window, hidden=hidden))

    def tone(self, window: int, hidden: Hidden) -> tuple[float, float]:
        """Frequency (Hz) and amplitude (rad/s) of a tone in the record."""
        if hidden.name == "aliased_tone":
            return tone_frequency(hidden.shape) - RATE, hidden.size
        speed = self.case.segments[window].speed
        s = laplace(np.array([speed / (2 * np.pi)]))
        system = self.case.world(window, hidden=()).linear(0.5)
        sensitivity = 1 - command_mobility(system, s) * control(system.top_drive.controller, s)
        return speed / (2 * np.pi), hidden.size * speed * float(np.abs(sensitivity[0]))


def _recorded(recorder: Recorder, share: float, s: Complex) -> Complex:
    return recording(recorder, share, WINDOW_S).transfer(s)


def _numbers(system: DrillingSystem) -> tuple[Floats, tuple[float, float]]:
    """String (pieces, columns), and the blades, of a system."""
    pieces = []
    for section in system.string:
        piece = {
            "length": section.length,
            "moment": section.polar_moment,
            "density": section.density,
            "shear_modulus": section.shear_modulus,
            "wall_damping": section.kappa,
            "steel_damping": section.delta,
        }
        for law in section.laws:
            if isinstance(law, RootDrag):
                piece["root_drag"] = law.coefficient
            elif isinstance(law, ConstantLossFactor):
                piece["loss_factor"] = law.loss_factor
            elif isinstance(law, MountedInertia):
                piece["mounted_inertia"] = law.inertia / law.spread / section.polar_moment
                piece |= {"mounted_frequency": law.frequency, "mounted_loss": law.loss}
            else:
                raise TypeError(f"the ideal test knows no law {law}")
        pieces.append(piece)
    if system.motor is not None:
        pieces[-1]["inertia_below"] = system.motor.inertia
        of_spring = {"shear_modulus": system.motor.stiffness, "steel_damping": system.motor.damping}
        pieces.append({**_SPRING, **{name: value / _SPRING["moment"] for name, value in of_spring.items()}})
    blades, damping = (0.0, 0.0), system.bit.damping
    for cutting in system.bit.cutting:
        if isinstance(cutting, RegenerativeCutting):
            blades = (float(cutting.torque / cutting.speed), float(2 * np.pi / cutting.speed / cutting.blades))
        else:
            damping = damping + cutting_admittance(cutting, np.zeros(1, dtype=complex))
    pieces[-1] |= {"inertia_below": system.bit.inertia, "damping_below": damping}
    return np.array([[float(piece.get(name, 0.0)) for name in COLUMNS] for piece in pieces]), blades


def _sensor_density(world: World) -> float:
    return 2 * (world.recorder.scale * world.recorder.noise) ** 2 / RATE


def _priors(case: Case) -> Priors:
    """From the data sheet's tolerances and the distribution that windows are drawn from."""
    known, first = case.data_sheet, case.segments[0]
    lump = np.hypot(1.0, case.equipment.collars.inertia * known.collar_relative / 50.0)
    shared = [1.5, np.log(3.0), known.length_relative, known.polar_moment_error / known.polar_moment]
    shared += [known.delay_error / 0.01, known.inertia_td_error / known.inertia_td, 2.0, lump]
    shared += [known.controller_relative, known.controller_relative, 1e3 * known.clock_error, 1.0]
    units = np.array([first.kappa / 100.0, 1.0, first.damping_bha / 50.0])
    return Priors(np.array(shared), np.maximum(LOCAL_STEPS * units, 1e-3))

"""Responses of the second world in closed form."""

from collections.abc import Mapping, Sequence
from operator import attrgetter
from typing import Any

import numpy as np

from benchmarks.blind.hidden import Hidden, altered
from benchmarks.blind.ideal.line import MOUNTED, PIECE
from benchmarks.blind.ideal.responses import NUISANCES, RATE, WINDOW_S, Ends, Kept, Kind, Line, Priors, Top, Wrong
from benchmarks.blind.other_world.cases import EFFECTS, Case
from benchmarks.blind.other_world.disturbances import rock_density, wander_density
from benchmarks.blind.other_world.effects_string import same_string
from benchmarks.blind.other_world.rig import DENSITY, Drive, Recording, Window
from benchmarks.blind.other_world.rigs import INTERVAL_SPREAD, LOCAL_SPREAD, WRONG_BY, WRONG_SHEETS, Rig
from benchmarks.blind.other_world.theory import (
    command_mobility,
    control_response,
    drive_response,
    images_kept,
    images_read,
    laplace,
    linear_string,
    noise_response,
    recorded,
    recorded_responses,
)
from benchmarks.blind.vocabulary import tone_frequency
from drillid.arrays import Complex, Floats

_SHARES = (-0.25, -0.125, 0.125, 0.25)
"""Of an interval, by which the delay is off at the beginning of a fit."""
_SELDOM, _OTHER_INTERVALS = 0.01, (0.01, 0.02, 0.025, 0.03, 0.035, 0.05)
"""s, from which that matters, and intervals to begin with where it is not known."""


class OtherResponses:
    """A case of the second world for the ideal test."""

    effects: Mapping[str, Kind] = EFFECTS
    power_law = False
    # a cause may hold the damping of a length of pipe, so that κ depends on the moment
    mixed = (2, 3)

    def __init__(self, case: Case) -> None:
        self.case = case
        self.windows, self.sweep = len(case.segments), case.rig.sweep
        self.priors = _priors(case)
        self._kept = Kept()

    def size_range(self, hidden: Hidden) -> tuple[float, float]:
        """Least and largest size that is drawn, in the first window."""
        return EFFECTS[hidden.name].range(self.case.window(0, ()), self.case.context(hidden))

    def equal(self, hidden: Hidden) -> tuple[Hidden, ...]:
        """Other causes that are the same rig, or nearly so."""
        return same_string(hidden, self.case.segments[0].pipe_length)

    def expected(
        self, window: int, hidden: tuple[Hidden, ...], nuisances: Floats | None, s: Complex, shares: Sequence[float]
    ) -> list[tuple[Complex, Complex]]:
        """Recorded command mobility and response of the control at elapsed shares of a window, with causes."""
        rig = self.case.window(window, hidden, nuisances)
        return [recorded_responses(rig, s, share, WINDOW_S) for share in shares]

    def lines(
        self, window: int, hidden: tuple[Hidden, ...], nuisances: Floats | None, shares: Sequence[float]
    ) -> list[Line]:
        """The same in numbers."""
        rig = self.case.window(window, hidden, nuisances)
        blades = (0.0, 0.0)
        if rig.blades is not None:
            blades = (rig.blades.torque / rig.speed, 2 * np.pi / rig.speed / rig.blades.count)
        changes = bool(rig.growth) or bool(rig.damping_course)
        strings = [_numbers(rig, share) for share in (shares if changes else (0.5,))]
        control, drive, recording = rig.control, rig.drive, rig.recording
        numbers = (
            drive.delay + control.interval / 2,
            drive.inertia,
            control.proportional,
            control.integral,
            recording.offset,
        )
        numbers = (*numbers, control.interval, rig.string[0].admittance)
        tops = [Top(*numbers, (control, drive, recording, share if recording.drift else 0.5)) for share in shares]
        return [Line(strings[number if changes else 0], blades, top) for number, top in enumerate(tops)]

    def ends(self, top: Top, s: Complex) -> Ends:
        """Responses of an upper end."""
        rest: Any = top.rest
        control, drive, recording, share = rest
        control = altered(control, proportional=top.proportional, integral=top.integral, interval=top.interval)
        drive = altered(drive, delay=top.delay - top.interval / 2, inertia=top.inertia)
        recording = altered(recording, offset=top.offset)
        kept = recording, control.interval, drive, top.admittance, share
        return Ends(
            self._kept(s, (drive, control.interval), drive_response),
            self._kept(s, (control, drive, top.admittance), images_read),
            self._kept(s, kept, _images_kept),
            top.inertia * s,
            self._kept(s, (control,), control_response),
            self._kept(s, (recording, share), _recorded),
        )

    def noise_density(self, window: int, hidden: tuple[Hidden, ...], s: Complex, share: float = 0.5) -> Floats:
        """One-sided power density of the recorded speed's noise, (rad/s)²/Hz."""
        rig = self.case.window(window, hidden)
        through = noise_response(rig, s, share) * recorded(rig.recording, s, share, WINDOW_S)
        rock = rock_density(rig.rock, np.abs(s) / (2 * np.pi))
        rock = rock + (rig.rock.mean * rig.rock.wander) ** 2 * wander_density(np.abs(s) / (2 * np.pi))
        # the control answers to the sensor's noise, which its readings fold into the band, and to its set point
        controlled = command_mobility(rig, s, share) * control_response(rig.control, s)
        set_point = (rig.speed * rig.speed_wander) ** 2 * wander_density(np.abs(s) / (2 * np.pi))
        sensor = np.abs(1 - controlled) ** 2 * _sensor_density(rig) + _folded_density(rig)
        return np.asarray(np.abs(through) ** 2 * rock + np.abs(controlled) ** 2 * set_point + sensor, dtype=float)

    def sensor_density(self, window: int, hidden: tuple[Hidden, ...]) -> float:
        """Of the part that the control does not see: the recorder's rounding; its readings it sees itself."""
        step = self.case.window(window, hidden).recording.resolution
        return step**2 / 12 * 2 / RATE

    def tone(self, window: int, hidden: Hidden) -> tuple[float, float]:
        """Frequency (Hz) and amplitude (rad/s) of a tone in the record."""
        if hidden.name == "aliased_tone":
            return tone_frequency(hidden.shape) - RATE, hidden.size
        rig = self.case.window(window, ())
        s = laplace(np.array([rig.speed / (2 * np.pi)]))
        sensitivity = 1 - command_mobility(rig, s) * control_response(rig.control, s)
        return rig.speed / (2 * np.pi), hidden.size * rig.speed * float(np.abs(sensitivity[0]))


def _images_kept(
    recording: Recording, interval: float, drive: Drive, admittance: float, share: float, s: Complex
) -> Complex:
    return images_kept(recording, interval, drive, admittance, s, share, WINDOW_S)


def _recorded(recording: Recording, share: float, s: Complex) -> Complex:
    return recorded(recording, s, share, WINDOW_S)


_row = attrgetter(*PIECE)


def _numbers(rig: Window, share: float) -> Floats:
    """(pieces, columns) of the string at an elapsed share of a window."""
    return np.array([(*_row(piece), *np.zeros(len(MOUNTED))) for piece in linear_string(rig, share)])


def _sensor_density(rig: Window) -> float:
    """One-sided power density of the readings' noise, (rad/s)²/Hz."""
    return 2 * (rig.recording.scale * rig.recording.noise) ** 2 * rig.control.interval


def _folded_density(rig: Window) -> float:
    """The same of what the recorder adds by keeping fewer of them than the control takes, or means of two of them."""
    kept = 1.0 if rig.recording.kind == "hold" else 2 / 3
    return 2 * (rig.recording.scale * rig.recording.noise) ** 2 * max(kept / RATE - rig.control.interval, 0.0)


def _priors(case: Case) -> Priors:
    """From the documents' tolerances and the distribution that windows are drawn from."""
    sheet, first = case.sheet, case.segments[0]
    # a value that is wrong outright is known no better than such values are drawn
    errors = _errors(case) | ({sheet.wrong: WRONG_BY} if sheet.wrong else {})
    own = {name: _deviation(case, name, error) for name, error in errors.items()}
    shared = [1.5, np.log(3.0), sheet.length_relative, own["polar_moment"], own["delay"], own["inertia_td"], 2.0]
    shared += [own["collar_polar_moment"], sheet.controller_relative, sheet.controller_relative]
    shared += [1e3 * sheet.clock_error, _interval_error(case)]
    units = np.array([first.wall_damping / 100.0, 1.0, first.bit_damping / 50.0])
    return Priors(np.array(shared), np.maximum(LOCAL_SPREAD * units, 1e-3), _wrong(case), _starts(case))


def _errors(case: Case) -> dict[str, float]:
    """Relative tolerances of the documents' values that may be wrong outright."""
    sheet = case.sheet
    return {
        "polar_moment": sheet.polar_moment_error / sheet.polar_moment,
        "delay": sheet.delay_error / abs(sheet.delay),
        "inertia_td": sheet.inertia_td_error / sheet.inertia_td,
        "collar_polar_moment": sheet.collar_relative,
    }


def _deviation(case: Case, name: str, error: float) -> float:
    """Prior standard deviation for a relative error of a document's value, in the unit of the nuisance."""
    collars = sum(piece.inertia for piece in case.rig.collars)
    units = {"delay": abs(case.sheet.delay) / 0.01, "collar_polar_moment": collars / 50.0}
    return float(np.hypot(error * units.get(name, 1.0), name == "collar_polar_moment"))


def _wrong(case: Case) -> tuple[Wrong, ...]:
    """Each value that may be wrong outright; where one is, that another is wrong in its place.

    That costs what the wrong one is off by its tolerance, less the odds against it, which the truth pays as well.
    """
    sheet, errors = case.sheet, _errors(case)
    odds = (1 - WRONG_SHEETS) / (WRONG_SHEETS / len(errors))
    against = {name: 2 * np.log(odds * WRONG_BY / error) for name, error in errors.items()}
    spreads: dict[int, float] = {}
    if sheet.wrong:
        off, usual = np.log(getattr(sheet, sheet.wrong) / _right(case.rig, sheet.wrong)), errors[sheet.wrong]
        more = (off / usual) ** 2 - (off / WRONG_BY) ** 2 - against.pop(sheet.wrong)
        against = {name: cost + more for name, cost in against.items()}
        spreads = {_place(sheet.wrong): _deviation(case, sheet.wrong, usual)}
    return tuple(
        Wrong({**spreads, _place(name): _deviation(case, name, WRONG_BY)}, max(float(cost), 0.0))
        for name, cost in against.items()
    )


def _place(name: str) -> int:
    """Index of the nuisance that a document's value states."""
    return list(NUISANCES).index("inertia_bit" if name == "collar_polar_moment" else name)


def _right(rig: Rig, name: str) -> float:
    """What the documents would state of a rig if they were right."""
    return {
        "polar_moment": rig.pipe.moment,
        "delay": rig.delay,
        "inertia_td": rig.drive.inertia,
        "collar_polar_moment": sum(piece.inertia for piece in rig.collars) / DENSITY / rig.collar_length,
    }[name]


def _starts(case: Case) -> tuple[tuple[int, float], ...]:
    """Delays and intervals to begin with: what a control that samples and holds adds to its delay has a kink wherever
    the delay is so many intervals and a half, and an interval that is not known may be any.
    """
    interval, names = case.rig.control.interval, list(NUISANCES)
    delays = tuple((names.index("delay"), share * interval / 0.01) for share in _SHARES if interval >= _SELDOM)
    if _interval_error(case) < INTERVAL_SPREAD:
        return delays
    others = tuple((names.index("interval"), float(np.log10(other / interval))) for other in _OTHER_INTERVALS)
    return delays + others


def _interval_error(case: Case) -> float:
    """Standard uncertainty of the control's interval in decades; no document states it, but rows may show it."""
    interval, kind = case.rig.control.interval, case.rig.recording.kind
    readings = 1 / (RATE * interval)
    in_step = abs(readings - round(readings)) < 1e-6
    # lines between samples much closer than the rows leave hardly any trace
    shown = not in_step and (kind == "hold" or interval > 0.5 / RATE)
    return 0.01 if shown else INTERVAL_SPREAD

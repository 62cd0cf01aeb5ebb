"""Expected responses of a case's windows, whitened by their noise."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from benchmarks.blind.hidden import Hidden
from benchmarks.blind.ideal.line import COLUMNS, DERIVED, top_load, top_load_slopes
from benchmarks.blind.ideal.responses import NUISANCES, WINDOW_S, Ends, Line, Responses, Sealed, Top
from drillid.arrays import Complex, Floats, Integers
from drillid.excitation.torques import SWEEP_PERIOD, exponential_sweeps

SPARSE = 2
"""Decimation of the sweep's lines; the weight of those used is raised accordingly."""
_FIRST, _LAST = 6, 478
"""Harmonics of the sweep from 0.05 to 4 Hz."""
_CONTROL_FLOOR = 3e-3
"""Relative error of the control's response at each of some 40 independent frequencies, common to all windows, from
sampling of the torque command."""
_CONTROL_LINES = 40
_STEP = 1e-6
_SAMPLES = 6000
"""Samples of the sweep's period, from which its lines are computed."""

_KEPT = 600
"""Number of the last responses, and of parts of them, that are kept."""
_NUMBERS = {name: number for number, name in enumerate(NUISANCES)}
_OF_STRING = {
    _NUMBERS[nuisance]: COLUMNS.index(column)
    for nuisance, column in (
        ("kappa", "wall_damping"),
        ("delta", "steel_damping"),
        ("damping_bha", "damping_below"),
        ("inertia_bit", "inertia_below"),
    )
}
"""Column of a string's numbers that each of these nuisances changes."""
_OF_TOP = {
    _NUMBERS[nuisance]: field
    for nuisance, field in (
        ("delay", "delay"),
        ("inertia_td", "inertia"),
        ("P", "proportional"),
        ("I", "integral"),
        ("clock", "offset"),
        ("interval", "interval"),
    )
}
"""Field of the upper end that each of these changes."""
_NOT_DERIVED = [column for column in range(len(COLUMNS)) if column not in DERIVED]
_ALLOWED = 1e-4
"""Largest change of a column by a step, relative to its largest number: beyond, pieces have changed their order."""
_ALLOWED_LUMPS = np.array([1e-3 * name.endswith("below") for name in COLUMNS])
_AT_TRUTH = (0.0,) * len(NUISANCES)


class Theory:
    """Whitened responses of a case's windows: real and imaginary part have unit variance.

    Parameters
    ----------
    parts : number of parts of a window, each with the value of a changing cause at its time
    """

    def __init__(self, case: Sealed, responses: Responses, parts: int = 1) -> None:
        self.case, self.responses = case, responses
        self.windows = responses.windows
        self.shares = (np.arange(parts) + 0.5) / parts
        harmonics = np.arange(_FIRST, _LAST, SPARSE)
        self.s = np.asarray(2j * np.pi * harmonics / SWEEP_PERIOD, dtype=complex)
        sweep = exponential_sweeps(np.arange(_SAMPLES) * SWEEP_PERIOD / _SAMPLES, responses.sweep)
        self.line = np.abs(np.fft.rfft(sweep)[harmonics]) * 2 / _SAMPLES
        # the noise is that of the rig with its hidden causes
        windows = range(self.windows)
        self.weights = [[self._weight(number, share) for share in self.shares] for number in windows]
        self.control_weights = [self._control_weight(number) for number in windows]
        self._response = lru_cache(_KEPT)(self._whitened)
        self._lines = lru_cache(_KEPT)(self._make_lines)
        self._load = lru_cache(_KEPT)(self._compute_load)
        self._ends = lru_cache(_KEPT)(self._compute_ends)
        self._end_slopes = lru_cache(len(NUISANCES))(self._compute_end_slopes)

    def _make_lines(self, window: int, hidden: tuple[Hidden, ...], nuisances: tuple[float, ...]) -> list[Line]:
        return self.responses.lines(window, hidden, np.array(nuisances), self.shares)

    def _compute_ends(self, top: Top) -> Ends:
        return self.responses.ends(top, self.s)

    def _compute_load(self, string: bytes, blades: tuple[float, float]) -> Complex:
        """Torque per speed at the top of a string of numbers, (F,) N m s/rad."""
        numbers = np.frombuffer(string).reshape(-1, len(COLUMNS))
        return top_load(numbers, self.responses.power_law, _cutting(blades, self.s), self.s.imag)

    def _weight(self, window: int, share: float) -> Floats:
        """(F,) one over the standard deviation of real and imaginary part of the mobility of one part of the window."""
        density = self.responses.noise_density(window, self.case.hidden, self.s, share)
        variance = 2 * density / WINDOW_S / self.line**2
        return np.asarray(np.sqrt(2 * SPARSE / variance / self.shares.size), dtype=float)

    def _control_weight(self, window: int) -> Floats:
        """(F,) the same of the control's response, whose error is noise of the speed sensor."""
        ((mobility, control),) = self.responses.expected(window, self.case.hidden, None, self.s, (0.5,))
        line = np.abs(mobility) * self.line
        sensor = 2 * self.responses.sensor_density(window, self.case.hidden) / WINDOW_S / line**2 / SPARSE
        floor = _CONTROL_FLOOR**2 * self.s.size / _CONTROL_LINES * self.windows
        return np.asarray(np.sqrt(2 / (sensor + floor) / self.shares.size) / np.abs(control), dtype=float)

    def response(self, window: int, hidden: tuple[Hidden, ...] = (), nuisances: Floats | None = None) -> Floats:
        """Whitened responses of a window with causes and changed nuisances, (rows,)."""
        return self._response(window, hidden, _AT_TRUTH if nuisances is None else tuple(nuisances))

    def _whitened(self, window: int, hidden: tuple[Hidden, ...], nuisances: tuple[float, ...]) -> Floats:
        lines = self._lines(window, hidden, nuisances)
        parts = []
        for line in lines:
            ends = self._ends(line.top)
            driven = ends.drive / (ends.inertia + self._load(line.string.tobytes(), line.blades))
            plant, kept = driven + ends.images_read, (driven + ends.images_kept) * ends.recorded
            parts.append((kept / (1 + plant * ends.control), ends.control * plant / kept))
        return self._joined(window, parts)

    def _joined(self, window: int, parts: Sequence[tuple[Complex, Complex]]) -> Floats:
        """Real and imaginary parts of mobility and control of a window's parts, whitened, (…, rows)."""
        pieces = []
        for (mobility, control), weight in zip(parts, self.weights[window], strict=True):
            pieces.append(mobility * weight)
            if self.case.command_logged:
                pieces.append(control * self.control_weights[window])
        joined = np.concatenate(pieces, axis=-1)
        return np.concatenate([joined.real, joined.imag], axis=-1)

    def slopes(self, window: int, nuisances: Floats, hidden: tuple[Hidden, ...] = ()) -> Floats:
        """Derivatives of the whitened responses with respect to the nuisances, (rows, 12)."""
        lines = self._lines(window, hidden, tuple(nuisances))
        moved = self._moved(window, nuisances, hidden)
        changes = [_Changes.of(line, {k: each[part] for k, each in moved.items()}) for part, line in enumerate(lines)]
        slopes = self._joined(
            window, [self._part_slopes(line, change) for line, change in zip(lines, changes, strict=True)]
        ).T
        for number in sorted(set().union(*(change.unclear for change in changes))):
            step = np.zeros(len(NUISANCES))
            step[number] = _STEP
            here, there = (self.response(window, hidden, point) for point in (nuisances, nuisances + step))
            slopes[:, number] = (there - here) / _STEP
        return slopes

    def _moved(self, window: int, nuisances: Floats, hidden: tuple[Hidden, ...]) -> dict[int, list[Line]]:
        """A window with each nuisance changed: those together that change other numbers."""
        mixed = self.responses.mixed
        together = np.full(len(NUISANCES), _STEP)
        together[list(mixed)] = 0.0
        steps = {number: _STEP * np.eye(len(NUISANCES))[number] for number in mixed}
        lines = {
            number: self.responses.lines(window, hidden, nuisances + step, self.shares)
            for number, step in {**steps, -1: together}.items()
        }
        return {number: lines.get(number, lines[-1]) for number in range(len(NUISANCES))}

    def _part_slopes(self, line: Line, change: "_Changes") -> tuple[Complex, Complex]:
        """Derivatives of recorded mobility and response of the control, (12, F)."""
        ends, slope = self._ends(line.top), self._end_slopes(line.top, change.tops)
        load, to_load = top_load_slopes(
            line.string,
            self.responses.power_law,
            _cutting(line.blades, self.s),
            self.s.imag,
            change.rates,
            change.places,
        )
        per_total = 1 / (ends.inertia + load)
        driven = ends.drive * per_total
        plant, sampled = driven + ends.images_read, driven + ends.images_kept
        kept, per_closed = sampled * ends.recorded, 1 / (1 + plant * ends.control)
        to_driven = slope.drive * per_total - driven * per_total * (slope.inertia + to_load)
        to_plant = to_driven + slope.images_read
        to_kept = (to_driven + slope.images_kept) * ends.recorded + sampled * slope.recorded
        to_loop = to_plant * ends.control + plant * slope.control
        return (
            (to_kept - kept * per_closed * to_loop) * per_closed,
            (to_loop - ends.control * plant / kept * to_kept) / kept,
        )

    def _compute_end_slopes(self, top: Top, moved: tuple[Top, ...]) -> Ends:
        """Derivatives of an upper end's responses, (12, F) each."""
        zero = Ends(*(np.zeros_like(self.s) for _ in self._ends(top)))
        slopes = [zero if there == top else self._central(top, there) for there in moved]
        return Ends(*(np.stack(each) for each in zip(*slopes, strict=True)))

    def _central(self, top: Top, there: Top) -> Ends:
        """Derivatives between an upper end with a nuisance changed by a step and its mirror image."""
        *numbers, rest = zip(top, there, strict=True)
        back = Top(*(2 * before - after for before, after in numbers), rest[0])
        ends = zip(self._ends(back), self._ends(there), strict=True)
        return Ends(*((after - before) / (2 * _STEP) for before, after in ends))


@dataclass(frozen=True, eq=False)
class _Changes:
    """What the nuisances change of a line."""

    rates: Floats
    """(12, C) derivatives of numbers of the string."""
    places: Integers
    """(C, 2) piece and column of each."""
    tops: tuple[Top, ...]
    """The upper end with each nuisance changed by a step."""
    unclear: frozenset[int]
    """Nuisances that change more than these numbers, such as how many pieces there are."""

    @classmethod
    def of(cls, line: Line, moved: dict[int, Line]) -> "_Changes":
        """From the line with each nuisance changed by a step, alone or with others that change other numbers."""
        rates = np.zeros((len(NUISANCES), *line.string.shape))
        unclear: set[int] = set()
        for there in dict.fromkeys(moved.values()):
            numbers = [number for number, each in moved.items() if each is there]
            change = _change(line, there)
            if change is None:
                unclear.update(numbers)
            elif len(numbers) == 1:
                rates[numbers[0]] = change
            else:
                for number in set(numbers) & set(_OF_STRING):
                    rates[number, :, _OF_STRING[number]] = change[:, _OF_STRING[number]]
        fields = {number: {_OF_TOP[number]: getattr(moved[number].top, _OF_TOP[number])} for number in _OF_TOP}
        admittances = {number: {"admittance": there.top.admittance} for number, there in moved.items()}
        tops = tuple(line.top._replace(**fields.get(number, admittances[number])) for number in range(len(NUISANCES)))
        places = np.argwhere(np.any(rates != 0, axis=0))
        return cls(rates[:, places[:, 0], places[:, 1]], places, tops, frozenset(unclear))


def _change(line: Line, there: Line) -> Floats | None:
    """Derivatives of a string's numbers by a step; None where other things have changed."""
    if there.string.shape != line.string.shape or there.blades != line.blades:
        return None
    change = there.string - line.string
    allowed = _ALLOWED * np.abs(line.string).max(axis=0) + _ALLOWED_LUMPS
    if (np.abs(change) > allowed).any() or change[:, _NOT_DERIVED].any():
        return None
    return change / _STEP


def _cutting(blades: tuple[float, float], s: Complex) -> Complex:
    """Torque per speed of blades that cut what the blade ahead left, (F,) N m s/rad."""
    torque_per_speed, between = blades
    if torque_per_speed == 0:
        return np.zeros_like(s)
    return np.asarray(torque_per_speed * np.expm1(-s * between) / (s * between), dtype=complex)


def compressed(columns: Sequence[Floats]) -> Floats:
    """Triangular factor of columns (rows, C) of one window, which has the same inner products."""
    factor = np.linalg.qr(np.column_stack(list(columns)), mode="r")
    return np.asarray(factor, dtype=float)

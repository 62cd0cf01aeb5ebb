"""One model of a set of windows: coordinates shared by all, coordinates that vary from window to window, causes.

Fourteen parameters describe a window: the eight of the transmission line, the two gains of the control, the offset
between the clocks of speed and torque, the interval of a control that samples and holds, and how far the variances that
it adds to delay and record are off their formula; scaled to be of order one they are the model's coordinates. They are
shared by the set, and four of them (wall damping, internal damping, damping and inertia at the bit) may also deviate
from window to window.
Each has a prior: from the data sheets where they state a value, else as wide as rigs differ. It is Gaussian, or
Student's t where a value is now and then plainly wrong.
"""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from drillid.arrays import Complex, Floats, Indices
from drillid.discrepancy.catalogue import Cause, OperatingPoint, WindowModel
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.inference.control_errors import control_errors
from drillid.discrepancy.inference.rows import Linearised, Products, products_of, weighted
from drillid.physics.compiled_system import compiled_system, data_of
from drillid.physics.dual_numbers import Dual
from drillid.physics.equipment import Bit, DrillingSystem, Section, TopDrive
from drillid.physics.parameters import DELTA, LENGTH
from drillid.physics.responses import laplace
from drillid.physics.sensor import Recording
from drillid.physics.system_products import Data
from drillid.physics.top_drive import control
from drillid.statistics import expected_ratio

COORDINATES = (
    "kappa",
    "delta",
    "length",
    "polar_moment",
    "delay",
    "inertia_td",
    "damping_bha",
    "inertia_bit",
    "P",
    "I",
    "clock",
    "interval",
    "hold",
    "reading",
)
"""Coordinates of a window, of order one; the pipe's length, polar moment and the gains are relative changes."""
SHARED = len(COORDINATES)
"""Number of shared coordinates."""
LOCAL = (0, 1, 6, 7)
"""Indices of the coordinates that deviate from window to window."""
DATA_SHEET = (2, 3, 4, 5, 8, 9, 10)
"""Indices of the coordinates that data sheets state with a tolerance."""
RELATIVE = (2, 3, 8, 9)
"""Indices of the coordinates that are relative changes."""
HEAVY_TAILED: tuple[int, ...] = (3, 4, 5, 7, 8, 9)
"""Indices of those whose values are now and then plainly wrong, as none is measured on the rig by whoever drills:
Student's t with STUDENT_TAIL degrees of freedom."""
_KAPPA, _DELTA, _DELAY, _INERTIA, _DAMPING, _LUMP, _CLOCK, _INTERVAL = 100.0, 3e8, 0.01, 1000.0, 50.0, 50.0, 0.01, 0.01
INTERVAL = COORDINATES.index("interval")
"""Index of the interval of the control."""
_INTERVAL_ERROR = 1e-3
"""Least standard uncertainty of the control's interval."""
_HOLD = 1e-4
"""s²."""
DEVIATION = np.array([0.5, 0.2, 0.5, 0.4])
"""Usual standard deviation of the windows from their set, scaled; the prior where the set itself shows little."""
LOWEST = np.array([-20.0, -3.0, -0.5, -0.7, 0.0, 0.05, -40.0, -60.0, -0.9, -0.9, -20.0, 0.0, -10.0, -10.0])
HIGHEST = np.array([100.0, 3.0, 1.0, 2.0, 30.0, 15.0, 200.0, 60.0, 4.0, 4.0, 20.0, 20.0, 10.0, 10.0])
"""Bounds of the shared coordinates: wider than any rig, and the model is defined within."""
FURTHEST_SHAPE = 2.5
"""Bound of the fitted coordinates of shapes, in standard deviations."""
_WIDE = 30.0
"""Prior standard deviation of a coordinate that the data sheets do not state."""


@dataclass(frozen=True)
class Extension:
    """A cause at one of its shapes."""

    cause: Cause
    shape: float
    windows: tuple[int, ...] | None = None
    """Rows of the windows in which it is present; all where not given."""

    def present(self, windows: int) -> Floats | float:
        """1 where it is present and 0 elsewhere, (W, 1)."""
        if self.windows is None:
            return 1.0
        return np.isin(np.arange(windows), self.windows).astype(float)[:, None]


def fitted_shapes(extensions: tuple[Extension, ...]) -> list[int]:
    """Indices of the extensions of whose shapes a parameter is fitted."""
    return [place for place, extension in enumerate(extensions) if extension.cause.shape_is_fitted]


def coordinate_count(extensions: tuple[Extension, ...]) -> int:
    """Number P of all that is fitted for a set: shared coordinates, sizes, and parameters of shapes, in this order."""
    return SHARED + len(extensions) + len(fitted_shapes(extensions))


@dataclass(frozen=True, eq=False)
class Point:
    """Coordinates of a set, and sizes and shapes of its causes."""

    shared: Floats
    """(14,) coordinates shared by all windows."""
    local: Floats
    """(W, 4) deviations of each window from them."""
    sizes: Floats
    """(extensions,) sizes of the causes, in their units."""
    shapes: Floats = field(default_factory=lambda: np.empty(0))
    """(extensions,) standard normal coordinates of the causes' shapes; zero for the last ones where not given."""

    def __post_init__(self) -> None:
        missing = self.sizes.size - self.shapes.size
        object.__setattr__(self, "shapes", np.append(self.shapes, np.zeros(missing)))

    def coordinates(self, extensions: tuple[Extension, ...]) -> Floats:
        """All that is fitted for the set, (P,)."""
        return np.concatenate([self.shared, self.sizes, self.shapes[fitted_shapes(extensions)]])

    def moved(self, coordinates: Floats, local: Floats, extensions: tuple[Extension, ...]) -> "Point":
        """The point with all that is fitted for the set at other values (P,), and other deviations of the windows."""
        count, shapes = SHARED + len(extensions), np.zeros(len(extensions))
        shapes[fitted_shapes(extensions)] = coordinates[count:]
        return Point(coordinates[:SHARED], local, coordinates[SHARED:count], shapes)

    def without(self, place: int) -> "Point":
        """The point without one of the causes."""
        return replace(self, sizes=np.delete(self.sizes, place), shapes=np.delete(self.shapes, place))


class SetModel:
    """The base model of a set of windows, to which causes can be added.

    Parameters
    ----------
    evidence : where its data sheet states no interval of the control, this is continuous
    deviation : prior standard deviation of the windows from the set, scaled, (4,)
    """

    def __init__(self, evidence: Evidence, deviation: Floats = DEVIATION) -> None:
        self.evidence = evidence
        self.deviation = deviation
        self.heavy_tailed = HEAVY_TAILED
        self.held: tuple[tuple[Extension, float, float], ...] = ()
        self.s = laplace(evidence.frequency)
        sheet, fitted = evidence.data_sheet, evidence.fitted
        length = (evidence.operating_points.bit_depth - sheet.collar_length)[:, None]
        self.length = np.where(np.isfinite(length), length, fitted[:, LENGTH, None])
        self.controller = sheet.controller
        self.polar_moment = sheet.polar_moment if np.isfinite(sheet.polar_moment_error) else _middle(fitted, 3)
        self.prior_mean, self.prior_error = self._prior()
        torque = np.nan_to_num(evidence.operating_points.torque, nan=0.0)[:, None]
        self.operating_point = OperatingPoint(evidence.operating_points.speed[:, None], torque, self.length)

    def _prior(self) -> tuple[Floats, Floats]:
        """Prior mean and standard deviation of the shared coordinates, each (14,)."""
        sheet = self.evidence.data_sheet
        lump = np.hypot(1.0, sheet.collar_relative * self.collar_inertia / _LUMP)
        mean = [1.5, 0.0, 0.0, 0.0, sheet.delay / _DELAY, sheet.inertia_td / _INERTIA, 1.0, 1.0, 0.0, 0.0, 0.0]
        relative = sheet.polar_moment_error / self.polar_moment
        error = [1.5, np.log(3.0), sheet.length_relative, relative]
        error += [sheet.delay_error / _DELAY, sheet.inertia_td_error / _INERTIA, 2.0, lump]
        error += [sheet.controller_relative, sheet.controller_relative, sheet.clock_error / _CLOCK]
        interval = self.control_interval / _INTERVAL
        folded = max(self._folded_error / _HOLD, _INTERVAL_ERROR)
        off = max(sheet.control_interval_relative * interval, _INTERVAL_ERROR)
        mean, error = [*mean, interval, 0.0, 0.0], [*error, off, folded, folded]
        return np.array(mean), np.minimum(error, _WIDE)

    @property
    def _folded_error(self) -> float:
        """Error of the variances by what is folded, s²: the share that the string adds to the top drive's inertia as
        load, at the rate of the control, of an interval's square by six, which is that of this inertia alone.
        """
        string, interval = Section(1.0, self.polar_moment), self.control_interval
        share = float(string.characteristic_admittance) * interval / (2 * np.pi * self.evidence.data_sheet.inertia_td)
        return share * interval**2 / 6

    @property
    def control_interval(self) -> float:
        """Interval of the control that the data sheet states, s; 0 where it states none."""
        return float(np.nan_to_num(self.evidence.data_sheet.control_interval))

    @property
    def collar_inertia(self) -> float:
        """Inertia of the collars in the tally, kg m²."""
        sheet = self.evidence.data_sheet
        return Section(sheet.collar_length, sheet.collar_polar_moment).inertia if sheet.collar_length else 0.0

    @cached_property
    def weight(self) -> Floats:
        """(W, F) reciprocal standard deviation of real and imaginary part of the mobility; 0 where it is not used."""
        evidence = self.evidence
        variance = evidence.variance * expected_ratio(evidence.degrees_of_freedom)
        good = evidence.used & np.isfinite(variance) & (variance > 0)
        return np.where(good, np.sqrt(2 / np.where(good, variance, 1.0)), 0.0)

    @cached_property
    def control_weight(self) -> Floats | None:
        """(W, F) reciprocal standard deviations of the control's response; None where no command is logged."""
        evidence = self.evidence
        if evidence.control is None or evidence.control_variance is None:
            return None
        own, common = self._control_errors
        # an error common to all windows weighs as much as independent ones of W times its variance
        return np.asarray(np.sqrt(2 / (own + evidence.windows * common)), dtype=float)

    @cached_property
    def control_common(self) -> float:
        """Share of errors that all windows have in common in the variance of the control's response, 0 to 1."""
        if self.control_weight is None or not self.control_weight.any():
            return 0.0
        own, common = self._control_errors
        used = self.control_weight > 0
        return float(np.mean(1 / (1 + own[used] / (self.evidence.windows * common[used]))))

    @cached_property
    def _control_errors(self) -> tuple[Floats, Floats]:
        """Variances (W, F) of the control's response, of errors of each window and of those common to all."""
        return control_errors(self.evidence, control(self.controller, self.s), self.weight > 0)

    @property
    def rows(self) -> int:
        """Number of complex rows per window: frequencies of the mobility, then those of the control's response."""
        weight = self.control_weight
        return self.s.size + (0 if weight is None else int(weight.any(axis=0).sum()))

    def start(self) -> Point:
        """The point that the windows' own fits give."""
        fitted = self.evidence.fitted
        shared = self.prior_mean.copy()
        shared[1] = np.log(np.clip(_middle(fitted, DELTA) / _DELTA, 0.05, 20.0))
        shared[2] = np.nanmedian(fitted[:, LENGTH] / self.length[:, 0]) - 1
        shared[3] = _middle(fitted, 3) / self.polar_moment - 1
        shared[4], shared[5] = _middle(fitted, 4) / _DELAY, _middle(fitted, 5) / _INERTIA
        shared[7] = (_middle(fitted, 7) - self.collar_inertia) / _LUMP
        return Point(shared, np.zeros((self.evidence.windows, len(LOCAL))), np.empty(0))

    def expected(self) -> Point:
        """The point that the data sheets state, and the windows' own fits where they do not."""
        fitted, unstated = self.start(), self.prior_error >= _WIDE
        return Point(np.where(unstated, fitted.shared, self.prior_mean), fitted.local, fitted.sizes)

    def window_model(self, quantities: list[Any]) -> WindowModel:
        """The model of all windows from their fourteen quantities, each (W, 1) or a Dual of it."""
        kappa, delta, length, polar, delay, inertia, damping, lump, proportional, integral, clock, *held = quantities
        interval, hold, reading = held
        sheet = self.evidence.data_sheet
        pipe = Section(length, polar, kappa, _DELTA * np.exp(delta))
        collars = replace(pipe, length=sheet.collar_length, polar_moment=sheet.collar_polar_moment)
        controller = replace(self.controller, proportional=proportional, integral=integral)
        string = (pipe, collars) if sheet.collar_length else (pipe,)
        return WindowModel(
            DrillingSystem(
                TopDrive(inertia, delay, controller, hold_variance=hold),
                string,
                Bit(lump, damping),
            ),
            Recording(clock_offset=clock, hold_variance=reading),
            control_interval=interval,
        )

    @cached_property
    def units(self) -> Floats:
        """What a coordinate of one stands for, (14, W, 1); the logarithm of δ stays as it is."""
        control, rest = self.controller, (_CLOCK, _INTERVAL, _HOLD, _HOLD)
        relative = self.length[:, 0], self.polar_moment, control.proportional, control.integral
        units = [_KAPPA, 1.0, *relative[:2], _DELAY, _INERTIA, _DAMPING, _LUMP, *relative[2:], *rest]
        return np.stack([np.full(self.evidence.windows, unit) for unit in units])[..., None]

    def quantities(self, point: Point) -> Floats:
        """Quantities of every window, shape (14, W, 1)."""
        values = np.tile(point.shared[:, None], (1, self.evidence.windows))
        values[list(LOCAL)] += point.local.T
        values[list(RELATIVE)] += 1
        return values[..., None] * self.units

    def with_normal_priors(self) -> "SetModel":
        """The same model whose priors have no heavy tails."""
        normal = copy(self)
        normal.heavy_tailed = ()
        return normal

    def holding(self, extension: Extension, size: float, shape: float = 0.0) -> "SetModel":
        """The same model with one more cause at a size, and coordinate of its shape, that are not fitted."""
        held = copy(self)
        held.held = (*self.held, (extension, size, shape))
        return held

    def extended(
        self, window_model: WindowModel, sizes: list[Any], extensions: tuple[Extension, ...], shapes: Sequence[Any] = ()
    ) -> WindowModel:
        """The window model with causes at their sizes, and at usual shapes or those of some coordinates."""
        given = zip(extensions, sizes, [*shapes, *[0.0] * (len(sizes) - len(shapes))], strict=True)
        for extension, size, shape in (*self.held, *given):
            present = size * extension.present(self.evidence.windows)
            cause = extension.cause.shaped(shape)
            window_model = cause.extend(window_model, present, extension.shape, self.operating_point)
        return window_model

    def window_model_at(self, point: Point, extensions: tuple[Extension, ...] = ()) -> WindowModel:
        """The model of all windows at a point, with parameters of shape (W, 1)."""
        values = (point.sizes.tolist(), point.shapes.tolist()) if extensions else ([], [])
        return self.extended(self.window_model(list(self.quantities(point))), values[0], extensions, values[1])

    def with_evidence(self, evidence: Evidence) -> "SetModel":
        """The same model for other data; the estimated deviation of the windows is kept."""
        return SetModel(evidence, self.deviation)

    def linearised(self, point: Point, extensions: tuple[Extension, ...] = ()) -> Linearised:
        """Residuals and exact derivatives with respect to all that is fitted for the set."""
        return self._whitened(self._differentiated(point, extensions), coordinate_count(extensions))

    def products(self, point: Point, extensions: tuple[Extension, ...], windows: Indices | None = None) -> Products:
        """Sums over the rows of residuals and derivatives; of some windows alone where these are given."""
        count = coordinate_count(extensions)
        window_model = self._differentiated(point, extensions).held()
        compiled = compiled_system(window_model.system, window_model.recording, window_model.course)
        if compiled is None:
            return products_of(self._whitened(window_model, count), self.s.size)
        chosen = self._with_data if windows is None else windows
        of_mobilities, of_all = compiled.products(self._used_data, count, chosen)
        return Products(of_all[:, :-1, :-1], of_all[:, :-1, -1], of_all[:, -1, -1], of_mobilities)

    def _differentiated(self, point: Point, extensions: tuple[Extension, ...]) -> WindowModel:
        """The model of all windows with its derivatives to all that is fitted for the set."""
        fitted = fitted_shapes(extensions)
        further = [np.full((1, 1), own) for own in (*point.sizes, *point.shapes[fitted])]
        values, slopes = [*self.quantities(point), *further], [*self.units, *(np.ones((1, 1)) for _ in further)]
        duals: list[Any] = [
            Dual(value, slope[None], np.array([place]), len(values))
            for place, (value, slope) in enumerate(zip(values, slopes, strict=True))
        ]
        count, shapes = SHARED + len(extensions), list(point.shapes)
        for place, own in zip(fitted, duals[count:], strict=True):
            shapes[place] = own
        return self.extended(self.window_model(duals[:SHARED]), duals[SHARED:count], extensions, shapes)

    def derivative(self, point: Point, extensions: tuple[Extension, ...], further: Extension) -> Complex:
        """Derivative (W, rows) of the whitened responses with respect to the size of a further cause, at zero."""
        size = Dual(np.zeros((1, 1)), np.ones(1))
        return self.slopes(self.extended(self.window_model_at(point, extensions), [size], (further,)))

    def slopes(self, window_model: WindowModel) -> Complex:
        """Derivative (W, rows) of the whitened responses of a model, one of whose quantities is a Dual."""
        return self._whitened(window_model, 1).jacobian[:, 0]

    def whitened_changes(self, mobility: Complex, response: Complex) -> Complex:
        """Whitened rows (W, K, rows) of changes of the mobilities and of the control's responses, (W, K, F) each."""
        pieces, weight = [mobility * self.weight[:, None]], self.control_weight
        if weight is not None:
            rows = weight.any(axis=0)
            pieces.append(response[..., rows] * weight[:, None, rows])
        return np.concatenate(pieces, axis=-1)

    def predicted(self, point: Point, extensions: tuple[Extension, ...] = ()) -> Complex:
        """Command mobility of every window, shape (W, F)."""
        mobility = self.window_model_at(point, extensions).mobility(self.s)
        return np.asarray(np.broadcast_to(mobility, self.evidence.mobility.shape), dtype=complex)

    def residual(self, point: Point, extensions: tuple[Extension, ...] = ()) -> Complex:
        """Whitened residuals (W, rows), without derivatives."""
        return self._whitened(self.window_model_at(point, extensions), 0).residual

    def misfit(self, point: Point, extensions: tuple[Extension, ...]) -> float:
        """Sum of squared whitened residuals."""
        return float(np.sum(np.abs(self.residual(point, extensions)) ** 2))

    def _whitened(self, window_model: WindowModel, count: int) -> Linearised:
        window_model = window_model.held()
        compiled = compiled_system(window_model.system, window_model.recording, window_model.course)
        if compiled is not None:
            return Linearised(*compiled.whitened(self._data, count))
        pieces = [weighted(window_model.mobility(self.s), self.evidence.mobility, self.weight, count)]
        if self.control_weight is not None and self.evidence.control is not None:
            rows = self.control_weight.any(axis=0)
            response = window_model.control(self.s[rows])
            pieces.append(weighted(response, self.evidence.control[:, rows], self.control_weight[:, rows], count))
        residuals, jacobians = zip(*pieces, strict=True)
        return Linearised(np.concatenate(residuals, axis=-1), np.concatenate(jacobians, axis=-1))

    @cached_property
    def _with_data(self) -> Indices:
        """Rows of the windows that have any weight; those held out have none."""
        weight = self._data.weight.any(axis=1) | self._data.control_weight.any(axis=1)
        return np.flatnonzero(weight)

    @cached_property
    def _data(self) -> Data:
        """Mobilities and responses of the control with their weights, for the compiled model."""
        return self._data_at(np.arange(self.s.size))

    @cached_property
    def _used_data(self) -> Data:
        """The same at the frequencies that are used in any window."""
        used = self.weight.any(axis=0)
        if self.control_weight is not None:
            used = used | self.control_weight.any(axis=0)
        return self._data_at(np.flatnonzero(used))

    def _data_at(self, lines: Indices) -> Data:
        evidence, weight = self.evidence, self.control_weight
        # of one layout, as the kernels are compiled anew for every other; a choice of columns has another
        mobilities = evidence.frequency[lines], evidence.mobility.take(lines, axis=1), self.weight[:, lines]
        if weight is None or evidence.control is None:
            rows = np.empty(0, dtype=np.intp)
            control, weight = np.empty((evidence.windows, 0), dtype=complex), np.empty((evidence.windows, 0))
        else:
            rows = np.flatnonzero(weight[:, lines].any(axis=0))
            control, weight = evidence.control.take(lines[rows], axis=1), weight[:, lines[rows]]
        return data_of(*mobilities, rows, control, weight)


def _middle(fitted: Floats, place: int) -> float:
    return float(np.nanmedian(fitted[:, place]))

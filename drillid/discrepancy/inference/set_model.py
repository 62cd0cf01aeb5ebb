"""One model of a set of windows: its coordinates with their priors, and the causes by which it can be extended.

Each coordinate has a prior: from the data sheets where they state a value, else as wide as rigs differ. It is Gaussian,
with wider tails where a value or its tolerance may be wrong.
"""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from drillid.arrays import Booleans, Complex, Floats, Indices
from drillid.discrepancy.catalogue import OperatingPoint, WindowModel
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.inference.coordinates import (
    DEGREES,
    DEVIATION,
    LOCAL,
    MEASURED,
    RELATIVE,
    SHARED,
    Extension,
    Point,
    coordinate_count,
    fitted_shapes,
)
from drillid.discrepancy.inference.measured_rows import MeasuredRows
from drillid.discrepancy.inference.priors import Priors
from drillid.discrepancy.inference.rows import Linearised, Products
from drillid.physics.dual_numbers import Dual
from drillid.physics.equipment import Bit, DrillingSystem, Section, TopDrive
from drillid.physics.parameters import DELTA, LENGTH
from drillid.physics.sensor import Recording

_KAPPA, _DELTA, _DELAY, _INERTIA, _DAMPING, _LUMP, _CLOCK, _INTERVAL = 100.0, 3e8, 0.01, 1000.0, 50.0, 50.0, 0.01, 0.01
_INTERVAL_ERROR = 1e-3
"""Least standard uncertainty of the control's interval."""
_HOLD = 1e-4
"""s²."""
_WIDE = 30.0
"""Prior standard deviation of a coordinate that the data sheets do not state."""


class SetModel:
    """The base model of a set of windows, to which causes can be added.

    Parameters
    ----------
    evidence : the control is taken as continuous where its data sheet states no interval
    deviation : prior standard deviation of the windows from the set, scaled, (4,)
    """

    def __init__(self, evidence: Evidence, deviation: Floats = DEVIATION) -> None:
        self.evidence = evidence
        self.deviation = deviation
        self.held: tuple[tuple[Extension, float, float], ...] = ()
        self.measured = MeasuredRows(evidence)
        sheet, fitted = evidence.data_sheet, evidence.fitted
        length = (evidence.operating_points.bit_depth - sheet.collar_length)[:, None]
        self.length = np.where(np.isfinite(length), length, fitted[:, LENGTH, None])
        self.controller = sheet.controller
        self.polar_moment = sheet.polar_moment if np.isfinite(sheet.polar_moment_error) else _middle(fitted, 3)
        self.prior_mean, error = self._prior()
        self.priors = Priors(error, DEGREES, MEASURED)
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
        """Error of the variances due to aliasing, s²: a sixth of the squared interval, which holds for the top drive's
        inertia alone, times the share that the string adds to this inertia as load at the rate of the control.
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

    def start(self) -> Point:
        """The point that the windows' own fits give."""
        fitted = self.evidence.fitted
        shared = self.prior_mean.copy()
        shared[1] = np.log(np.clip(_middle(fitted, DELTA) / _DELTA, 0.05, 20.0))
        shared[2] = np.nanmedian(fitted[:, LENGTH] / self.length[:, 0]) - 1
        shared[3] = _middle(fitted, 3) / self.polar_moment - 1
        shared[4], shared[5] = _middle(fitted, 4) / _DELAY, _middle(fitted, 5) / _INERTIA
        shared[7] = (_middle(fitted, 7) - self.collar_inertia) / _LUMP / (1 + shared[3])
        return Point(shared, np.zeros((self.evidence.windows, len(LOCAL))), np.empty(0))

    def expected(self) -> Point:
        """The point stated by the data sheets, and by the windows' own fits where these state nothing."""
        fitted = self.start()
        return Point(np.where(self.is_stated, self.prior_mean, fitted.shared), fitted.local, fitted.sizes)

    @property
    def is_stated(self) -> Booleans:
        """(14,) which shared coordinates the data sheets state."""
        stated: Booleans = self.priors.error < _WIDE
        return stated

    def window_model(self, quantities: list[Any]) -> WindowModel:
        """The model of all windows from their fourteen quantities, each (W, 1) or a Dual of it."""
        kappa, delta, length, polar, delay, inertia, damping, lump, proportional, integral, clock, *held = quantities
        interval, hold, reading = held
        sheet = self.evidence.data_sheet
        pipe = Section(length, polar, kappa, _DELTA * np.exp(delta))
        collars = replace(pipe, length=sheet.collar_length, polar_moment=sheet.collar_polar_moment)
        controller = replace(self.controller, proportional=proportional, integral=integral)
        string = (pipe, collars) if sheet.collar_length else (pipe,)
        # how windows deviate is estimated once, and holds whatever impedance the pipe is given later
        relative = polar / self.polar_moment
        return WindowModel(
            DrillingSystem(
                TopDrive(inertia, delay, controller, hold_variance=hold),
                string,
                Bit(lump * relative, damping * relative),
            ),
            Recording(clock_offset=clock, hold_variance=reading),
            control_interval=interval,
        )

    @cached_property
    def units(self) -> Floats:
        """Units of the coordinates, (14, W, 1); that of the logarithm of δ is one."""
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
        """The same model with normal priors instead of heavy-tailed ones."""
        normal = copy(self)
        normal.priors = self.priors.all_normal()
        return normal

    def beside(self, measured: MeasuredRows) -> "SetModel":
        """The same model compared with other rows of the same windows."""
        other = copy(self)
        other.measured = measured
        return other

    def holding(self, extension: Extension, size: float, shape: float = 0.0) -> "SetModel":
        """The same model with one more cause held at a size and shape coordinate, which are not fitted."""
        held = copy(self)
        held.held = (*self.held, (extension, size, shape))
        return held

    def extended(
        self, window_model: WindowModel, sizes: list[Any], extensions: tuple[Extension, ...], shapes: Sequence[Any] = ()
    ) -> WindowModel:
        """The window model with causes at given sizes, and at given shape coordinates or their usual shapes."""
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

    @property
    def s(self) -> Complex:
        """(F,) Laplace variable at the frequencies of the mobilities, rad/s."""
        return self.measured.s

    def with_evidence(self, evidence: Evidence) -> "SetModel":
        """The same model for other data; the estimated deviation of the windows is kept."""
        return SetModel(evidence, self.deviation)

    def linearised(self, point: Point, extensions: tuple[Extension, ...] = ()) -> Linearised:
        """Residuals and exact derivatives with respect to all that is fitted for the set."""
        return self.measured.linearised(self._differentiated(point, extensions), coordinate_count(extensions))

    def products(self, point: Point, extensions: tuple[Extension, ...], windows: Indices | None = None) -> Products:
        """Sums over the rows of products of residuals and derivatives; of some windows only where these are given."""
        window_model = self._differentiated(point, extensions)
        return self.measured.products(window_model, coordinate_count(extensions), windows)

    def _differentiated(self, point: Point, extensions: tuple[Extension, ...]) -> WindowModel:
        """The model of all windows with its derivatives with respect to all that is fitted for the set."""
        fitted = fitted_shapes(extensions)
        further = [np.full((1, 1), own) for own in (*point.sizes, *point.shapes[fitted])]
        values, slopes = [*self.quantities(point), *further], [*self.units, *(np.ones((1, 1)) for _ in further)]
        duals: list[Any] = [
            Dual.of_parameter(value, slope, place, len(values))
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
        return self.measured.linearised(window_model, 1).jacobian[:, 0]

    def predicted(self, point: Point, extensions: tuple[Extension, ...] = ()) -> Complex:
        """Command mobility of every window, shape (W, F)."""
        mobility = self.window_model_at(point, extensions).mobility(self.s)
        return np.asarray(np.broadcast_to(mobility, self.evidence.mobility.shape), dtype=complex)

    def residual(self, point: Point, extensions: tuple[Extension, ...] = ()) -> Complex:
        """Whitened residuals (W, rows), without derivatives."""
        return self.measured.linearised(self.window_model_at(point, extensions), 0).residual

    def misfit(self, point: Point, extensions: tuple[Extension, ...]) -> float:
        """Sum of squared whitened residuals."""
        return float(np.sum(np.abs(self.residual(point, extensions)) ** 2))


def _middle(fitted: Floats, place: int) -> float:
    return float(np.nanmedian(fitted[:, place]))

"""Measured responses of a set of windows, with their weights, for comparison with a model's responses."""

from functools import cached_property

import numpy as np

from drillid.arrays import Complex, Floats, Indices
from drillid.discrepancy.catalogue import WindowModel
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.inference.control_errors import control_errors
from drillid.discrepancy.inference.rows import Linearised, Products, products_of, weighted
from drillid.physics.compiled_system import CompiledSystem, compiled_system, data_of
from drillid.physics.responses import laplace
from drillid.physics.system_products import Data
from drillid.physics.top_drive import control
from drillid.statistics import expected_ratio


class MeasuredRows:
    """Rows of every window: its mobility at F frequencies, then the control's response where a command is logged.

    Parameters
    ----------
    evidence : of the set of W windows
    """

    def __init__(self, evidence: Evidence) -> None:
        self.evidence = evidence
        self.s = laplace(evidence.frequency)

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
        stated = control(self.evidence.data_sheet.controller, self.s)
        return control_errors(self.evidence, stated, self.weight > 0)

    @cached_property
    def residuals(self) -> int:
        """Number of residuals of the mobilities, real and imaginary parts."""
        return 2 * int(np.count_nonzero(self.weight))

    @property
    def count(self) -> int:
        """Number of complex rows per window."""
        weight = self.control_weight
        return self.s.size + (0 if weight is None else int(weight.any(axis=0).sum()))

    def linearised(self, window_model: WindowModel, coordinates: int) -> Linearised:
        """Whitened residuals of a model of all windows, and its derivatives with respect to so many coordinates."""
        window_model = window_model.held()
        compiled = _compiled(window_model)
        if compiled is not None:
            return Linearised(*compiled.whitened(self._data, coordinates))
        pieces = [weighted(window_model.mobility(self.s), self.evidence.mobility, self.weight, coordinates)]
        if self.control_weight is not None and self.evidence.control is not None:
            rows = self.control_weight.any(axis=0)
            response, weight = window_model.control(self.s[rows]), self.control_weight[:, rows]
            pieces.append(weighted(response, self.evidence.control[:, rows], weight, coordinates))
        residuals, jacobians = zip(*pieces, strict=True)
        return Linearised(np.concatenate(residuals, axis=-1), np.concatenate(jacobians, axis=-1))

    def products(self, window_model: WindowModel, coordinates: int, windows: Indices | None = None) -> Products:
        """Sums over the rows of products of residuals and derivatives; of some windows only where these are given."""
        window_model = window_model.held()
        compiled = _compiled(window_model)
        if compiled is None:
            return products_of(self.linearised(window_model, coordinates), self.s.size)
        chosen = self._with_data if windows is None else windows
        of_mobilities, of_all = compiled.products(self._used_data, coordinates, chosen)
        return Products(of_all[:, :-1, :-1], of_all[:, :-1, -1], of_all[:, -1, -1], of_mobilities)

    def whitened(self, mobility: Complex, response: Complex) -> Complex:
        """Whitened rows (W, K, rows) of changes of the mobilities and of the control's responses, (W, K, F) each."""
        pieces, weight = [mobility * self.weight[:, None]], self.control_weight
        if weight is not None:
            rows = weight.any(axis=0)
            pieces.append(response[..., rows] * weight[:, None, rows])
        return np.concatenate(pieces, axis=-1)

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
        # all of one memory layout, as the kernels are recompiled for any other; indexing columns would change it
        mobilities = evidence.frequency[lines], evidence.mobility.take(lines, axis=1), self.weight[:, lines]
        if weight is None or evidence.control is None:
            rows = np.empty(0, dtype=np.intp)
            measured, weight = np.empty((evidence.windows, 0), dtype=complex), np.empty((evidence.windows, 0))
        else:
            rows = np.flatnonzero(weight[:, lines].any(axis=0))
            measured, weight = evidence.control.take(lines[rows], axis=1), weight[:, lines[rows]]
        return data_of(*mobilities, rows, measured, weight)


def _compiled(held: WindowModel) -> CompiledSystem | None:
    return compiled_system(held.system, held.recording, held.course, held.folding)

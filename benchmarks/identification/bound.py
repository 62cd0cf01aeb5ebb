"""The Cramér–Rao bound of simulated windows: the noise that the simulator made, exact derivatives at the truth."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import rfft
from scipy.ndimage import uniform_filter1d

from benchmarks.identification.windows import SimulatedWindow, grid, quiet_window
from drillid.arrays import Booleans, Complex, Floats
from drillid.excitation.torques import SWEEP_PERIOD
from drillid.fits.search import to_scaled
from drillid.fits.solver import minimise
from drillid.fits.window_fit import Measured, Prior, likelihood
from drillid.physics.eight_parameters import command_mobility_with_derivatives
from drillid.physics.parameters import BOUNDS
from drillid.physics.responses import laplace
from tests.simulated import WINDOW_S, Truth

WIDEST = 0.25
"""Largest bound, as a share of the parameter's true value, at which a window counts as identifying the parameter."""
REACH = 3.0
"""Bounds to either side of the truth between which the likelihood is to be a parabola."""
SKEW = 0.2
"""Largest relative difference from the parabola."""
_PERIODS = round(WINDOW_S / SWEEP_PERIOD)
_MANY = 1e6
"""Degrees of freedom of a variance that is known."""
_ITERATIONS = 200
_SETTLED = 1e-8
_AVERAGED_LINES = 11
"""Lines over which the noise power is averaged, beside the average over windows; it is smooth over so few."""


@dataclass(frozen=True, eq=False)
class Noise:
    """Noise of the mobility of a window per bit noise, as the simulator made it.

    variance : (frequency,) of the complex mobility on the sweep's lines, per (N m rms)² of bit noise
    """

    truth: Truth
    variance: Floats

    @staticmethod
    def of(windows: Sequence[SimulatedWindow]) -> "Noise":
        """Mean over windows of one rig, each less what the sweep alone does and over its bit noise."""
        quiet = quiet_window(windows[0].truth)
        harmonics = np.rint(grid() * SWEEP_PERIOD).astype(int) * _PERIODS
        # the noise falls by five decades over the band, so that without a taper its low end leaks over its high end
        taper = np.hanning(quiet.speed.size + 1)[:-1]
        power = np.zeros(taper.size // 2 + 1)
        for window in windows:
            error = (window.speed - quiet.speed) / window.truth.bit_noise
            power += np.abs(rfft((error - error.mean()) * taper)) ** 2 / len(windows)
        per_line = uniform_filter1d(power, _AVERAGED_LINES) * taper.size / np.sum(taper**2)
        return Noise(quiet.truth, per_line[harmonics] / np.abs(rfft(quiet.sweep)[harmonics]) ** 2)

    def cramer_rao(self, bit_noise: float) -> Floats:
        """Least standard deviation of each of the eight parameters from one window, shape (8,), SI."""
        covariance = np.linalg.inv(self.information(bit_noise))
        return np.sqrt(np.diag(covariance))

    def information(self, bit_noise: float) -> Floats:
        """Fisher's information of one window on the eight parameters, shape (8, 8), SI.

        The noise of a line is complex Gaussian, so that its information is 2 Re(J J*)/variance.
        """
        _, derivatives = command_mobility_with_derivatives(self.truth.parameters, self.truth.known, laplace(grid()))
        weighted = derivatives / (np.sqrt(self.variance) * bit_noise)
        return np.asarray(2 * (weighted @ weighted.conj().T).real)

    def efficient_errors(self, mobility: Complex, bit_noise: float) -> Floats:
        """Errors (window, 8) of the linear estimate that reaches the bound, from mobilities (window, frequency)."""
        truth, derivatives = command_mobility_with_derivatives(self.truth.parameters, self.truth.known, laplace(grid()))
        weight = 2 / (self.variance * bit_noise**2)
        slope = ((mobility - truth) * weight @ derivatives.conj().T).real
        return np.asarray(np.linalg.solve(self.information(bit_noise), slope.T).T)

    def excess(self, mobility: Complex, bit_noise: float) -> float:
        """Root mean square error of mobilities (window, frequency) over the noise's: what their estimate costs."""
        truth, _ = command_mobility_with_derivatives(self.truth.parameters, self.truth.known, laplace(grid()))
        return float(np.sqrt(np.mean(np.abs(mobility - truth) ** 2 / (self.variance * bit_noise**2))))

    def identifiable(self, bit_noise: float) -> Booleans:
        """Parameters that one window identifies, so that the bound applies; shape (8,).

        The bound is at most WIDEST of the true value, and the likelihood of a window without error of its own
        is a parabola: at REACH bounds to either side its fall is that of the parabola within SKEW.
        """
        bound = self.cramer_rao(bit_noise)
        narrow = bound <= WIDEST * self.truth.parameters
        skew = [self._skew(index, bit_noise, bound[index]) if narrow[index] else np.inf for index in range(bound.size)]
        return np.asarray(np.array(skew) <= SKEW)

    def _skew(self, index: int, bit_noise: float, bound: float) -> float:
        """Largest relative difference between the profile likelihood's fall and the parabola's."""
        truth, known = self.truth.parameters, self.truth.known
        mobility, _ = command_mobility_with_derivatives(truth, known, laplace(grid()))
        many = np.full(mobility.size, _MANY)
        exact = Measured(grid(), mobility, self.variance * bit_noise**2, many, np.ones(mobility.size))
        data = likelihood(exact, known, Prior.silent())
        # internal damping's prior would sharpen its likelihood
        data = data._replace(prior_weight=np.zeros_like(data.prior_weight))
        held = np.arange(truth.size) == index
        low, high = to_scaled(BOUNDS)
        found = []
        for reach in (-REACH, REACH):
            moved = truth + reach * bound * held
            point, gradient, hessian = to_scaled(moved), np.empty(truth.size), np.empty((truth.size, truth.size))
            fall = minimise(point, data, True, low, high, held, _ITERATIONS, _SETTLED, gradient, hessian)
            found.append(abs(fall / (REACH**2 / 2) - 1))
        return max(found)

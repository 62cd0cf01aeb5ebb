"""Response and transient of one window as local polynomials of frequency, for any excitation.

Over a few neighbouring lines the spectrum of the speed is G(f) times that of the sweep, plus the
transient T(f) of a window that neither begins nor ends at rest, plus noise. G and T are smooth, so
both are polynomials there, and the residual is noise (Schoukens, Vandersteen, Barbé and Pintelon
2009, Automatica 45; Pintelon and Schoukens 2012, System Identification, chapter 7). Beside a sharp
resonance G and T share a denominator: the local rational method (McKelvey and Guérin 2012).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft

from drillid.arrays import Booleans, Complex, Floats, Indices, Integers
from drillid.spectra.cross_spectra import Spectra
from drillid.spectra.noise import autoregressive_level, bands, burst_weights

_ORDER = 2
"""Order of the polynomials of response and transient."""
_DENOMINATOR = 2
"""Order of the denominator of the local rational method."""
_ITERATIONS = 4
"""Iterations of the rational method, each with the output fitted by the previous one."""
_RATIONAL_RATE = 0.01
"""Share of frequencies without resonance at which the rational method may be chosen."""
_RIDGE = 1e-13
_BEYOND = 1.25
"""Highest line from which the noise is modelled, per highest line used."""
LEAST_LINES = 4
"""Lines that each frequency needs for itself: at least half a window's length per frequency spacing."""


@dataclass(frozen=True)
class _Local:
    """Lines about each frequency, (frequency, line), and which of them are the frequency's own."""

    place: Floats
    """(line,) −1 to 1."""
    own: Booleans
    """(line,) nearer to this frequency than to any other."""
    sweep: Complex
    factor: Complex | None = None
    """(line, line) Cholesky factor of the covariance of the lines' noise; None where they are independent."""

    def of(self, chosen: Indices, factor: Complex | None = None) -> _Local:
        """Some of the frequencies."""
        return _Local(self.place, self.own, self.sweep[chosen], self.factor if factor is None else factor)

    @property
    def scale(self) -> Floats:
        """Root mean square of the sweep's lines, (frequency,)."""
        return np.asarray(np.sqrt(np.mean(np.abs(self.sweep) ** 2, axis=1)) + np.finfo(float).tiny, dtype=float)

    def whitened(self, columns: Complex) -> Complex:
        """Columns (frequency, line, column) whose noise is white."""
        return columns if self.factor is None else np.asarray(np.linalg.inv(self.factor) @ columns)

    def unwhitened(self, rows: Complex) -> Complex:
        """Rows (frequency, line) with the noise as measured."""
        return rows if self.factor is None else np.asarray(rows @ self.factor.T)

    @property
    def own_weights(self) -> Complex:
        """(frequency, line) weights of a whitened output in the response of the own lines alone."""
        sweep = np.where(self.own, self.sweep, 0)
        weights = np.conj(sweep)
        if self.factor is not None:
            covariance = (self.factor @ np.conj(self.factor.T))[np.ix_(self.own, self.own)]
            weights[:, self.own] = np.conj(np.linalg.solve(covariance, sweep[:, self.own].T).T)
        weights = weights / (np.sum(weights * sweep, axis=1, keepdims=True) + np.finfo(float).tiny)
        return weights if self.factor is None else np.asarray(weights @ self.factor)


@dataclass(frozen=True)
class _Estimate:
    """Response at each frequency and the residual of the local model."""

    response: Complex
    """(frequency,)."""
    residual: Complex
    """(frequency, line), whitened."""
    noise_gain: Floats
    """(frequency,) variance of the response per variance of a whitened line."""
    freedom: Integers
    """(frequency,) complex degrees of freedom of the residual."""

    def of(self, chosen: Indices) -> _Estimate:
        """Those of some frequencies."""
        return _Estimate(*(values[chosen] for values in vars(self).values()))

    def replace(self, chosen: Indices, other: _Estimate) -> None:
        """Enter the estimates of some frequencies."""
        for name, values in vars(self).items():
            values[chosen] = vars(other)[name]


def local_spectra(
    sweep: Floats, speed: Floats, command: Floats, rate: float, frequencies: Floats, noise_lines: int
) -> Spectra:
    """Spectra of a window whose sweep need not be periodic.

    Over `noise_lines` lines around each frequency the local model is fitted by least squares. The
    response is then that of the lines between the midpoints to its neighbours, less transient and
    curvature as fitted over all lines: so errors of next neighbours are correlated by about a tenth only,
    and together frequencies use each line once. `averages` counts these lines. The variance is that of the
    residual with its degrees of freedom, the lines less the parameters of the local model. Where
    the residual of the rational model is significantly smaller (F-test), that model is used. Where
    bursts make the noise non-stationary, least squares are weighted with the lines' covariance.

    Parameters
    ----------
    sweep, speed, command : (samples,) N m, rad/s, N m; the command may be NaN
    rate : Hz
    frequencies : (frequency,) Hz, equally spaced by at least LEAST_LINES lines of the window
    noise_lines : lines beside each line from which the noise is estimated
    """
    samples = speed.size
    spacing = int((frequencies[1] - frequencies[0]) * samples / rate + 1e-6)
    reach = max((noise_lines + 1) // 2, spacing)
    offsets = np.arange(-reach, reach + 1)
    around = np.rint(frequencies * samples / rate).astype(int)[:, None] + offsets
    own = (offsets >= -(spacing // 2)) & (offsets < spacing - spacing // 2)
    spectra = [rfft(channel - channel.mean()) * (2 / samples) for channel in (sweep, speed, command)]
    local = _Local(offsets / reach, own, _lines(spectra[0], around))
    outputs = [_lines(spectrum, around) for spectrum in spectra[1:]]
    speed_estimate, command_estimate = estimates = _estimates(local, outputs)
    for chosen, factor in _bursts(speed_estimate.residual, own, around, samples / rate):
        for estimate, better in zip(
            estimates, _estimates(local.of(chosen, factor), [output[chosen] for output in outputs]), strict=True
        ):
            estimate.replace(chosen, better)
    power = np.mean(np.abs(local.sweep[:, own]) ** 2, axis=1)
    # such that noise over averages is the variance, as in the other estimators
    per_average = speed_estimate.noise_gain * power * spacing
    noise = np.sum(np.abs(speed_estimate.residual) ** 2, axis=1) / speed_estimate.freedom * per_average
    both = np.sum(speed_estimate.residual * np.conj(command_estimate.residual), axis=1) / np.minimum(
        speed_estimate.freedom, command_estimate.freedom
    )
    return Spectra(
        sweep_power=power,
        speed_power=np.abs(speed_estimate.response) ** 2 * power + noise * (spacing - 1) / spacing,
        speed_noise=noise,
        command_noise=np.sum(np.abs(command_estimate.residual) ** 2, axis=1) / command_estimate.freedom * per_average,
        cross_speed=speed_estimate.response * power,
        cross_command=command_estimate.response * power,
        cross_noise=both * per_average,
        averages=np.full(frequencies.size, float(spacing)),
        degrees_of_freedom=speed_estimate.freedom.astype(float),
        sweep_rounding=np.zeros(frequencies.size),
    )


def _bursts(residual: Complex, own: Booleans, around: Integers, seconds: float) -> Iterator[tuple[Indices, Complex]]:
    """Frequencies of each band with bursts, and the Cholesky factor of their lines' covariance.

    Noise of power p(t) gives lines k and l the covariance Σ p(t) exp(−2πi (k − l) t/T).
    """
    from scipy.linalg import toeplitz

    lines, middle = around[:, own], around[:, around.shape[1] // 2]
    deviation = np.zeros(next_fast_len(int(_BEYOND * lines.max()), real=True) + 1, dtype=complex)
    deviation[lines] = residual[:, own]
    level = autoregressive_level(np.abs(deviation) ** 2)
    for band in bands(int(lines.min()), int(lines.max())):
        power = burst_weights(deviation, level, band, 1, seconds).power.ravel()
        if np.all(power == 1):
            continue
        covariance = toeplitz(rfft(power)[: around.shape[1]] / power.size)
        yield np.flatnonzero((middle >= band[0]) & (middle < band[1])), np.linalg.cholesky(covariance)


def _lines(spectrum: Complex, around: Integers) -> Complex:
    """Lines of a real signal's spectrum, those of negative frequency as complex conjugates."""
    return np.asarray(np.where(around < 0, np.conj(spectrum[np.abs(around)]), spectrum[np.abs(around)]))


def _estimates(local: _Local, outputs: list[Complex]) -> list[_Estimate]:
    """For each output the polynomial model, or the rational one where its residual is significantly smaller."""
    powers = local.place[:, None] ** np.arange(_ORDER + 1)
    excited = (local.sweep / local.scale[:, None])[:, :, None] * powers
    columns = local.whitened(np.concatenate([excited, np.broadcast_to(powers, excited.shape)], axis=2))
    least_squares = _LeastSquares(local, columns)
    estimates = []
    for output in outputs:
        white = local.whitened(output[:, :, None])[:, :, 0]
        plain = least_squares.estimate(white)
        feedback = _feedback(local, powers, output, plain)
        chosen = np.flatnonzero(_resonant(plain, least_squares.residual(feedback)))
        part, rational = local.of(chosen), plain.of(chosen)
        for _ in range(_ITERATIONS):
            wider = np.concatenate([columns[chosen], _feedback(part, powers, output[chosen], rational)], axis=2)
            rational = _LeastSquares(part, wider).estimate(white[chosen])
        plain.replace(chosen, rational)
        estimates.append(plain)
    return estimates


def _feedback(local: _Local, powers: Floats, output: Complex, estimate: _Estimate) -> Complex:
    """Columns of the denominator, from the fitted output: the measured one would fit its own noise."""
    fitted = output - local.unwhitened(estimate.residual)
    return local.whitened(_unit(fitted)[:, :, None] * powers[:, 1 : _DENOMINATOR + 1])


def _unit(output: Complex) -> Complex:
    size = np.sqrt(np.mean(np.abs(output) ** 2, axis=1, keepdims=True))
    return np.asarray(output / (size + np.finfo(float).tiny))


def _resonant(plain: _Estimate, feedback: Complex) -> Booleans:
    """Where the output times powers of frequency explains the residual of the polynomials (F-test)."""
    from scipy.special import fdtri

    conjugate = np.conj(np.swapaxes(feedback, 1, 2))
    cross = np.matvec(conjugate, plain.residual)
    normal = conjugate @ feedback
    size = np.trace(normal, axis1=1, axis2=2).real[:, None, None]
    normal += (_RIDGE * size + np.finfo(float).tiny) * np.eye(_DENOMINATOR)
    explained = np.vecdot(cross, np.linalg.solve(normal, cross[:, :, None])[:, :, 0]).real
    total = np.sum(np.abs(plain.residual) ** 2, axis=1)
    freedom = plain.freedom - _DENOMINATOR
    bound = fdtri(2 * _DENOMINATOR, 2 * freedom, 1 - _RATIONAL_RATE)
    return np.asarray(explained * freedom > bound * _DENOMINATOR * (total - explained))


class _LeastSquares:
    """Least squares on whitened columns (frequency, line, column) by normal equations; column 0 is the response's."""

    def __init__(self, local: _Local, columns: Complex) -> None:
        self.columns, self.conjugate = columns, np.conj(np.swapaxes(columns, 1, 2))
        normal = self.conjugate @ columns
        count = columns.shape[2]
        size = np.trace(normal, axis1=1, axis2=2).real / count
        normal[:, range(count), range(count)] += _RIDGE * size[:, None] + np.finfo(float).tiny
        self.inverse = np.linalg.inv(normal)
        own = local.own_weights
        target = -np.matvec(np.swapaxes(columns, 1, 2), own)
        target[:, 0] += 1 / local.scale
        self.weights = own + np.conj(np.matvec(columns, np.matvec(self.inverse, np.conj(target))))
        """(frequency, line) of the output in the response: the coefficient of column 0, plus the mean
        residual of the frequency's own lines."""

    def residual(self, targets: Complex) -> Complex:
        """Residual of targets (frequency, line, target) after their fit by the columns."""
        return np.asarray(targets - self.columns @ (self.inverse @ (self.conjugate @ targets)))

    def estimate(self, output: Complex) -> _Estimate:
        """Response of an output (frequency, line)."""
        return _Estimate(
            np.sum(self.weights * output, axis=1),
            self.residual(output[:, :, None])[:, :, 0],
            np.sum(np.abs(self.weights) ** 2, axis=1),
            np.full(output.shape[0], output.shape[1] - self.columns.shape[2]),
        )

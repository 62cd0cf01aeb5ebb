"""Experiment design: crest factor, power, coherence and expected standard errors of an excitation; optimal spectra.

The expected errors are the Cramér–Rao bound of the eight parameters for the command mobility measured at the lines
of a periodic torque. With the one-sided noise density S(f) of the top drive's speed, a window of T seconds and P_k the
power (N² m²) of line k, the complex mobility at the line has the variance S/(T P_k), and

    F = Σ P_k · 2T Re(∂M/∂p ∂M*/∂p)/S(f_k),    covariance ≥ F⁻¹.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from drillid.arrays import Floats, Integers
from drillid.errors import EstimationError, SettingsError
from drillid.excitation.torques import Multisine, harmonics_within, powered_sweep
from drillid.physics.eight_parameters import KnownEquipment, command_mobility_with_derivatives, drilling_system
from drillid.physics.parameters import PARAMETERS, SCALES
from drillid.physics.responses import bit_speed_ratio, command_mobility, laplace
from drillid.physics.top_drive import torque_transfers

_ROUNDS = 20000
_TOLERANCE = 1e-6
"""Relative distance from the optimum at which the search ends."""
_LINES_PER_BAND = 40


def crest_factor(torque: Floats) -> float:
    """Peak over rms of a series about zero."""
    return float(np.max(np.abs(torque)) / np.sqrt(np.mean(np.square(torque))))


def half_octaves(lower: float, upper: float) -> Floats:
    """Edges (Hz) of bands half an octave wide, or a little less so that they fill the range, shape (bands + 1,)."""
    return np.geomspace(lower, upper, max(1, int(np.ceil(2 * np.log2(upper / lower) - 1e-9))) + 1)


def line_power(torque: Floats, rate: float) -> tuple[Floats, Floats]:
    """Frequency (Hz) and power (square of the unit) of each line of a series, mean included.

    Parameters
    ----------
    torque : (samples,), whole periods
    rate : Hz
    """
    spectrum: Floats = np.square(np.abs(np.fft.rfft(torque) / torque.size), dtype=float)
    spectrum[1 : (torque.size + 1) // 2] *= 2
    return np.asarray(np.fft.rfftfreq(torque.size, 1 / rate), dtype=float), spectrum


def power_per_band(torque: Floats, rate: float, edges: Floats) -> Floats:
    """Power (square of the unit) of a series in each band (bands + 1 edges in Hz), shape (bands,)."""
    frequency, power = line_power(torque, rate)
    return np.histogram(frequency, edges, weights=power)[0]


@dataclass(frozen=True, eq=False)
class Experiment:
    """Nominal rig, noise, duration and prior of a planned measurement."""

    parameters: Floats
    """(8,) nominal, in the order of the schema."""
    equipment: KnownEquipment
    noise_frequency: Floats
    """Hz, rising."""
    bit_torque_density: Floats
    """One-sided power density of the torque at the bit at these frequencies, (N m)²/Hz."""
    duration: float
    """s, length of the window."""
    prior_error: Floats | None = None
    """(8,) prior standard errors; NaN where there is no prior."""

    @property
    def scale(self) -> Floats:
        """(8,) the nominal values, or the typical magnitude of parameters that are zero."""
        return np.where(self.parameters != 0, self.parameters, SCALES)

    def speed_noise(self, frequency: Floats) -> Floats:
        """One-sided power density of the top drive's speed without sweep, (rad/s)²/Hz.

        By reciprocity the top's response to a torque at the bit is the bit's response to a torque at the top.
        """
        s = laplace(frequency)
        system = drilling_system(self.parameters, self.equipment)
        at_top = command_mobility(system, s) / torque_transfers(system.top_drive, s)[0]
        density = np.interp(frequency, self.noise_frequency, self.bit_torque_density)
        return np.asarray(np.abs(bit_speed_ratio(system, s) * at_top) ** 2 * density, dtype=float)

    def coherence(self, frequency: Floats, density: Floats) -> Floats:
        """Coherence γ² of a sweep of the given one-sided power density (N m)²/Hz with the speed."""
        mobility, _ = command_mobility_with_derivatives(self.parameters, self.equipment, laplace(frequency))
        response = np.abs(mobility) ** 2 * density
        return np.asarray(response / (response + self.speed_noise(frequency)), dtype=float)

    def information(self, frequency: Floats) -> Floats:
        """Fisher information per power of a line, (frequency, 8, 8), for parameters in units of `scale`."""
        _, slopes = command_mobility_with_derivatives(self.parameters, self.equipment, laplace(frequency))
        slopes = slopes * self.scale[:, None]
        products = np.einsum("if,jf->fij", slopes, np.conj(slopes)).real
        information: Floats = 2 * self.duration * products / self.speed_noise(frequency)[:, None, None]
        return information

    def prior_information(self) -> Floats:
        """Information of the prior, (8, 8), for parameters in units of `scale`."""
        if self.prior_error is None:
            return np.zeros((len(PARAMETERS),) * 2)
        return np.diag(np.nan_to_num((self.scale / self.prior_error) ** 2))

    def covariance(self, frequency: Floats, power: Floats) -> Floats:
        """Cramér–Rao bound (8, 8) for lines of the given power (N² m²), in SI units.

        Raises
        ------
        EstimationError
            If the lines do not determine the parameters.
        """
        inside = power > 0
        total = np.einsum("f,fij->ij", power[inside], self.information(frequency[inside])) + self.prior_information()
        return _inverse(total) * np.outer(self.scale, self.scale)

    def standard_errors(self, frequency: Floats, power: Floats) -> Floats:
        """Cramér–Rao standard errors (8,) in SI units; see `covariance`."""
        return np.sqrt(np.diag(self.covariance(frequency, power)))


def lines_within(torque: Floats, rate: float, band: tuple[float, float]) -> tuple[Floats, Floats]:
    """Frequency and power of the lines of one period (samples,) that lie in a band (Hz) and carry power."""
    frequency, power = line_power(torque, rate)
    chosen = (frequency >= band[0]) & (frequency <= band[1]) & (power > 1e-12 * power.max())
    return frequency[chosen], power[chosen]


@dataclass(frozen=True, eq=False)
class Design:
    """Power per band that minimises the expected error of the chosen parameters."""

    edges: Floats
    """(bands + 1,) Hz."""
    power: Floats
    """(bands,) N² m²; the sum is the square of the rms."""
    criterion: float
    """Of the chosen errors relative to `Experiment.scale`: mean square ("errors"), or log of their covariance's
    determinant ("volume").
    """
    distance: float
    """Relative excess of a band's largest sensitivity over the mean; 0 at the optimum (Kiefer and Wolfowitz 1960)."""

    def sweep(self, time: Floats, period: float) -> Floats:
        """Sweep of constant amplitude that repeats after a period (s), N m at each time (s); its peak is √2 its rms."""
        return powered_sweep(time, float(np.sqrt(2 * self.power.sum())), self.edges, self.power, period)

    def multisine(self, period: float, seed: int = 0) -> Multisine:
        """Multisine of low crest factor at all harmonics of the period in the bands, equal power within a band."""
        harmonics = harmonics_within((self.edges[0], self.edges[-1]), period)
        band = np.clip(np.searchsorted(self.edges, harmonics / period, side="right") - 1, 0, self.power.size - 1)
        counts = np.bincount(band, minlength=self.power.size)
        if np.any((counts == 0) & (self.power > 0)):
            raise SettingsError("multisine", f"a band with power has no line at {period} s", "Lengthen the period")
        amplitudes = np.sqrt(2 * self.power[band] / counts[band])
        excited = amplitudes > 0
        phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, int(excited.sum()))
        return Multisine(period, harmonics[excited], amplitudes[excited], phases).with_low_crest()


Criterion = Literal["errors", "volume"]
Limit = Literal["rms", "peak"]


def design(
    experiment: Experiment,
    amplitude: float,
    chosen: tuple[str, ...] = tuple(PARAMETERS),
    *,
    band: tuple[float, float] = (0.05, 4.0),
    limit: Limit = "rms",
    criterion: Criterion = "errors",
) -> Design:
    """Power per half octave that minimises the errors of the chosen parameters, for a torque of limited amplitude.

    Convex, solved by the multiplicative algorithm: each band's power is multiplied by the root of its sensitivity, the
    fall of the criterion per power (Silvey, Titterington and Torsney 1978; monotone after Yu 2010, Annals of
    Statistics 38, 1593–1606).
    Under a limit of peak torque the rms is that of a sweep; its crest factor √2 is hardly reached by multisines.

    Parameters
    ----------
    amplitude : N m
    chosen : names of parameters, as in the schema; the others are nuisance
    limit : whether the amplitude is the rms or the peak of the torque
    criterion : "errors" for the mean square of the relative errors, "volume" for the determinant of their covariance

    Raises
    ------
    SettingsError
        If a parameter is unknown.
    EstimationError
        If the whole band does not determine the parameters.
    """
    names = list(PARAMETERS)
    unknown = [name for name in chosen if name not in names]
    if unknown or not chosen:
        raise SettingsError("design", f"there are no parameters {unknown}", f"Choose from {', '.join(names)}")
    rows = np.array([names.index(name) for name in chosen])
    edges = half_octaves(*band)
    mean_square = amplitude**2 if limit == "rms" else amplitude**2 / 2
    per_band = band_information(experiment, edges) * mean_square
    prior = experiment.prior_information()
    share = np.full(edges.size - 1, 1 / (edges.size - 1))
    sensitivity, value = _sensitivity(share, per_band, prior, rows, criterion)
    for _ in range(_ROUNDS):
        mean = float(share @ sensitivity)
        if sensitivity.max() <= mean * (1 + _TOLERANCE):
            break
        share = share * np.sqrt(sensitivity)
        share /= share.sum()
        sensitivity, value = _sensitivity(share, per_band, prior, rows, criterion)
    return Design(edges, share * mean_square, value, float(sensitivity.max() / (share @ sensitivity)) - 1)


def criterion_of(
    experiment: Experiment, edges: Floats, power: Floats, chosen: tuple[str, ...], criterion: Criterion = "errors"
) -> float:
    """The designer's criterion for any powers (bands,) in N² m², equal within a band."""
    rows = np.array([list(PARAMETERS).index(name) for name in chosen])
    return _sensitivity(power, band_information(experiment, edges), experiment.prior_information(), rows, criterion)[1]


def band_information(experiment: Experiment, edges: Floats) -> Floats:
    """Mean information per power within each band, (bands, 8, 8)."""
    centres = (np.arange(_LINES_PER_BAND) + 0.5) / _LINES_PER_BAND
    frequency = edges[:-1, None] + np.diff(edges)[:, None] * centres
    per_line = experiment.information(frequency.ravel())
    return np.asarray(per_line.reshape(*frequency.shape, *per_line.shape[1:]).mean(axis=1), dtype=float)


def _sensitivity(
    share: Floats, per_band: Floats, prior: Floats, rows: Integers, criterion: Criterion
) -> tuple[Floats, float]:
    """Fall of the criterion per share of each band, (bands,), and the criterion."""
    covariance = _inverse(np.einsum("b,bij->ij", share, per_band) + prior)
    block = covariance[np.ix_(rows, rows)]
    weight: Floats
    if criterion == "errors":
        weight, value = np.eye(rows.size) / rows.size, float(np.trace(block)) / rows.size
    else:
        weight, value = np.asarray(np.linalg.inv(block), dtype=float), float(np.linalg.slogdet(block)[1])
    slope = covariance[:, rows] @ weight @ covariance[rows]
    return np.einsum("ij,bji->b", slope, per_band), value


def _inverse(information: Floats) -> Floats:
    scale = np.sqrt(np.maximum(np.diag(information), np.finfo(float).tiny))
    scaled = information / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(scaled)
    if values[0] <= 1e-13:
        raise EstimationError(
            "expected errors", "the excitation does not determine the parameters", "Excite more frequencies"
        )
    return np.asarray((vectors / values) @ vectors.T / np.outer(scale, scale), dtype=float)

"""The same simulated windows identified with scipy, lmfit and python-control: accuracy, optimum and time.

The peers get what `drillid` does without: a start close to the truth, as the rig's data sheets would give it, and only
the optimum is asked of them, not intervals. Their model is the plain formula in numpy. Where they fit the spectra of
`drillid`, they minimise the very cost that it minimises, so that the optimum is the same one.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.identification.windows import SETTINGS, SimulatedWindow
from drillid.arrays import Complex, Floats
from drillid.excitation.torques import SWEEP_PERIOD
from drillid.fits.window_fit import Measured, Prior, fit
from drillid.physics.eight_parameters import KnownEquipment
from drillid.physics.equipment import STEEL_DENSITY, STEEL_SHEAR_MODULUS
from drillid.physics.parameters import BOUNDS, DAMPING_BHA, DELAY, DELTA, INERTIA_BHA, INERTIA_TD, KAPPA, SCALES
from drillid.physics.responses import laplace
from drillid.physics.top_drive import control
from tests.simulated import RATE, Truth

Model = Callable[[Floats, KnownEquipment, Complex], Complex]

USUAL_DAMPING = 1 / np.log(3.0)
"""Weight of the prior on internal damping: within a factor of three of its usual size."""
SWEPT = 4.0
"""Highest frequency of the sweep, Hz."""


def line_model(values: Floats, known: KnownEquipment, s: Complex) -> Complex:
    """Command mobility (frequency,) of eight parameters (8,), paper's equations 1 to 8."""
    delayed = np.exp(-s * values[DELAY])
    below = values[INERTIA_TD] * s + _string_admittance(values, known, s)
    return np.asarray(delayed / (below + delayed * control(known.controller, s)))


def _string_admittance(values: Floats, known: KnownEquipment, s: Complex) -> Complex:
    kappa, delta, length, polar, _, _, damping_bha, inertia_bha = values
    alpha, beta = STEEL_DENSITY * s + kappa, STEEL_SHEAR_MODULUS / s + delta
    gamma, specific = np.sqrt(alpha / beta), np.sqrt(alpha * beta)
    carried = min(inertia_bha, known.collar_inertia)
    load = (inertia_bha - carried) * s + damping_bha
    for part, moment in (
        (known.collar_length, carried / (STEEL_DENSITY * known.collar_length) if known.collar_length else 0.0),
        (length, polar),
    ):
        if part:
            own, tangent = moment * specific, np.tanh(gamma * part)
            load = own * (load + own * tangent) / (own + load * tangent)
    return np.asarray(load)


def control_model(values: Floats, known: KnownEquipment, s: Complex) -> Complex:
    """The same, the loop closed by python-control; it has no line, so that the string's response is given as data."""
    import control as peer  # type: ignore[import-untyped]  # ships no types

    speed = s.imag
    below = values[INERTIA_TD] * s + _string_admittance(values, known, s)
    plant = peer.FRD(np.exp(-s * values[DELAY]) / below, speed)
    return np.asarray(peer.feedback(plant, peer.FRD(control(known.controller, s), speed)).frdata[0, 0])


@dataclass(frozen=True)
class Problem:
    """Least squares as peers see it: real residuals of scaled parameters, δ as its logarithm."""

    measured: Measured
    known: KnownEquipment
    model: Model
    students: bool
    """Residuals whose squares sum to twice the cost of `drillid`, Student's t, instead of weighted errors."""

    def residuals(self, scaled: Floats) -> Floats:
        """Real and imaginary residuals, then the pull on internal damping; (2 frequency + 1,)."""
        data = self.measured
        error = self.model(unscaled(scaled), self.known, laplace(data.frequency)) - data.mobility
        if self.students:
            freedom = data.degrees_of_freedom
            ratio = np.abs(error) ** 2 / (freedom * data.variance) + np.finfo(float).tiny
            # ln(1 + x)/x is one over the weight that each error loses by being large
            error = error * np.sqrt(2 * (freedom + 1) / (freedom * data.variance) * np.log1p(ratio) / ratio)
        else:
            error = error * data.weight
        return np.concatenate([error.real, error.imag, [scaled[DELTA] * USUAL_DAMPING]])

    def cost(self, values: Floats) -> float:
        """Half the sum of squares at parameters in SI."""
        return float(0.5 * np.sum(self.residuals(scaled_of(values)) ** 2))


def unscaled(scaled: Floats) -> Floats:
    """Parameters (8,) in SI."""
    values: Floats = scaled * SCALES
    values[DELTA] = SCALES[DELTA] * np.exp(scaled[DELTA])
    return values


def scaled_of(values: Floats) -> Floats:
    """Parameters (8,) of order one."""
    scaled = values / SCALES
    scaled[DELTA] = np.log(scaled[DELTA])
    return np.asarray(scaled)


def start_from_data_sheet(truth: Truth) -> Floats:
    """Scaled start: length, pipe, drive and top drive off by a few per cent, usual damping and assembly."""
    values = truth.parameters * np.array([1, 1, 1.005, 1.05, 1.1, 1.05, 1, 1])
    values[[KAPPA, DELTA, DAMPING_BHA]] = SCALES[[KAPPA, DELTA, DAMPING_BHA]]
    values[INERTIA_BHA] = 1.2 * truth.known.collar_inertia
    return scaled_of(values)


def start_from_nothing() -> Floats:
    """Scaled start without advance information: the usual size of everything."""
    return scaled_of(SCALES.copy())


def by_scipy(problem: Problem, start: Floats) -> Floats:
    """scipy.optimize.least_squares within bounds, derivatives by differences."""
    from scipy.optimize import least_squares

    found = least_squares(problem.residuals, start, bounds=(scaled_of(BOUNDS[0].copy()), scaled_of(BOUNDS[1].copy())))
    return unscaled(np.asarray(found.x))


def by_lmfit(problem: Problem, start: Floats) -> Floats:
    """lmfit.minimize with its default method, MINPACK's Levenberg–Marquardt with derivatives by differences."""
    import lmfit  # type: ignore[import-untyped]  # ships no types

    low, high = scaled_of(BOUNDS[0].copy()), scaled_of(BOUNDS[1].copy())
    parameters = lmfit.Parameters()
    for index, value in enumerate(start):
        parameters.add(f"p{index}", value=float(value), min=float(low[index]), max=float(high[index]))

    def residuals(given: lmfit.Parameters) -> Floats:
        return problem.residuals(np.array([given[f"p{index}"].value for index in range(start.size)]))

    with warnings.catch_warnings():
        # lmfit warns where it finds no covariance, which is not asked for
        warnings.simplefilter("ignore")
        found = lmfit.minimize(residuals, parameters)
    return unscaled(np.array([found.params[f"p{index}"].value for index in range(start.size)]))


def classical_spectra(window: SimulatedWindow) -> Measured:
    """H1 estimate by scipy.signal: averages over half-overlapping Hann segments as long as the sweep's period."""
    from scipy.signal import coherence, csd, welch

    length = round(SWEEP_PERIOD * RATE)
    frequency, cross = csd(window.sweep, window.speed, RATE, nperseg=length)
    _, power = welch(window.sweep, RATE, nperseg=length)
    _, gamma = coherence(window.sweep, window.speed, RATE, nperseg=length)
    segments = 2 * window.speed.size // length - 1
    averages = segments / (1 + 2 / 36 * (1 - 1 / segments))
    least = 1 - 0.01 ** (1 / (averages - 1))
    used = (frequency >= SETTINGS.spectra.frequency_minimum_hz) & (frequency <= SWEPT) & (gamma > least)
    mobility = cross[used] / power[used]
    variance = np.abs(mobility) ** 2 * (1 - gamma[used]) / gamma[used] / (averages - 1)
    freedom = np.full(mobility.size, averages - 1)
    return Measured(frequency[used], mobility, variance, freedom, np.ones(mobility.size))


@dataclass(frozen=True)
class Way:
    """One row of the comparison: how windows become parameters.

    name : in the table
    classical : spectra by scipy.signal instead of `drillid`'s
    solve : from problem and start to parameters; None for `drillid`'s own fit, which needs no start
    model : of the problem
    informed : starts from the data sheets instead of from nothing
    """

    name: str
    classical: bool
    solve: Callable[[Problem, Floats], Floats] | None
    model: Model = line_model
    informed: bool = True


LEAST_SQUARES = Way("drillid's spectra + scipy least_squares", False, by_scipy)
LMFIT = Way("drillid's spectra + lmfit", False, by_lmfit)
WAYS = (
    Way("drillid", False, None),
    Way("scipy.signal csd, coherence + least_squares", True, by_scipy),
    Way("scipy.signal csd, coherence + lmfit", True, by_lmfit),
    LEAST_SQUARES,
    LMFIT,
    Way("drillid's spectra + python-control, least_squares", False, by_scipy, control_model),
    Way("drillid's spectra + least_squares from nothing", False, by_scipy, informed=False),
)
"""The first is `drillid` itself."""
WHY_NOT = (
    "python-control alone identifies states of lumped systems (modal realisation, Markov parameters); it has neither a "
    "line nor a fit in frequency, so that it only closes the loop here. slycot, SIPPY and vector fitting (scikit-rf) "
    "fit rational functions, whose poles are not the parameters of a line."
)
"""Why other peers are not in the table."""


def problem_of(way: Way, measured: Measured, window: SimulatedWindow) -> Problem:
    """What is minimised."""
    return Problem(measured, window.truth.known, way.model, students=not way.classical)


def solved(way: Way, measured: Measured, window: SimulatedWindow) -> Floats:
    """Parameters (8,) in SI."""
    if way.solve is None:
        return fit(measured, window.truth.known, Prior.silent(), SETTINGS.fits).value
    start = start_from_data_sheet(window.truth) if way.informed else start_from_nothing()
    return way.solve(problem_of(way, measured, window), start)

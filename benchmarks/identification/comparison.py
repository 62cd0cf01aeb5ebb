"""Accuracy and time of `drillid` beside other tools on the same simulated windows."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.table import Table

from benchmarks.identification.bound import Noise
from benchmarks.identification.peers import WAYS, Way, classical_spectra, problem_of, solved, start_from_data_sheet
from benchmarks.identification.windows import SETTINGS, SimulatedWindow, measured_windows
from drillid.arrays import Floats
from drillid.figures.captions import DISPLAYED_PARAMETERS
from drillid.fits.search import to_scaled
from drillid.fits.solver import minimise
from drillid.fits.window_fit import Measured, Prior, likelihood, optima
from drillid.physics.parameters import BOUNDS, DELAY, INERTIA_BHA, INERTIA_TD, LENGTH, PARAMETERS, POLAR_MOMENT

SHOWN = (LENGTH, POLAR_MOMENT, DELAY, INERTIA_TD, INERTIA_BHA)
SAME_COST = 0.01
"""Difference of cost, a fiftieth of what one standard error makes, at which two optima are the same."""
_ITERATIONS, _SETTLED = 100, 1e-7
_CLOSE = 1.02
"""Ratio of errors below which neither is ahead."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """What one way made of all windows.

    values : (window, 8) SI
    costs : (window,) at the end, of the data it used
    spectra_ms : per window, in the mean
    fit_ms : (window,)
    """

    way: Way
    values: Floats
    costs: Floats
    spectra_ms: float
    fit_ms: Floats

    @property
    def total_ms(self) -> float:
        """Spectra and fit of a usual window."""
        return self.spectra_ms + float(np.median(self.fit_ms))


def spectra_by(way: Way, windows: Sequence[SimulatedWindow]) -> list[Measured]:
    """Mobilities with variance of all windows."""
    return [classical_spectra(window) for window in windows] if way.classical else measured_windows(windows)


def outcome(way: Way, windows: Sequence[SimulatedWindow]) -> Outcome:
    """Identify all windows in one way, with the processor time of each step."""
    # the first window goes ahead, so that no time holds imports or compilation
    solved(way, spectra_by(way, windows[:1])[0], windows[0])
    begin = time.process_time()
    measured = spectra_by(way, windows)
    spectra_ms = 1e3 * (time.process_time() - begin) / len(windows)
    values, costs, fit_ms = [], [], []
    for data, window in zip(measured, windows, strict=True):
        begin = time.process_time()
        values.append(solved(way, data, window))
        fit_ms.append(1e3 * (time.process_time() - begin))
        costs.append(problem_of(way, data, window).cost(values[-1]))
    return Outcome(way, np.array(values), np.array(costs), spectra_ms, np.array(fit_ms))


@dataclass(frozen=True)
class Speed:
    """Median processor times of one fit by `drillid`, ms.

    cold : from a start without advance information to the optimum
    close : from the start that the other tools get, on the same data and cost
    """

    cold: float
    close: float

    @staticmethod
    def of(windows: Sequence[SimulatedWindow]) -> "Speed":
        """Of each window's fit, without intervals."""
        silent, starts, size = Prior.silent(), SETTINGS.fits.starts, len(PARAMETERS)
        low, high = to_scaled(BOUNDS)
        free, gradient, hessian = np.zeros(size, bool), np.empty(size), np.empty((size, size))
        cold, close = [], []
        for data, window in zip(measured_windows(windows), windows, strict=True):
            known = window.truth.known
            begin = time.process_time()
            optima(likelihood(data, known, silent), data, known, silent, starts)
            cold.append(1e3 * (time.process_time() - begin))
            point = start_from_data_sheet(window.truth)
            begin = time.process_time()
            prepared = likelihood(data, known, silent)
            minimise(point, prepared, True, low, high, free, _ITERATIONS, _SETTLED, gradient, hessian)
            close.append(1e3 * (time.process_time() - begin))
        return Speed(float(np.median(cold)), float(np.median(close)))


@dataclass(frozen=True)
class Scores:
    """Accuracy of one estimator.

    errors : root mean square relative errors of the parameters SHOWN
    over_bound : root mean square error over bound, the largest over parameters, of windows that identify the parameter
    worse, better : windows in which its optimum has more or less cost than `drillid`'s on the same data
    """

    errors: Floats
    over_bound: float
    worse: int
    better: int

    @staticmethod
    def of(found: Outcome, ours: Outcome, windows: Sequence[SimulatedWindow], noise: Noise) -> "Scores":
        """Of windows of one rig."""
        truth = noise.truth.parameters
        levels = {window.truth.bit_noise for window in windows}
        bounds, identifiable = (
            {level: made(level) for level in levels} for made in (noise.cramer_rao, noise.identifiable)
        )
        usable = np.array([identifiable[window.truth.bit_noise] for window in windows])
        ratio = (found.values - truth) / np.array([bounds[window.truth.bit_noise] for window in windows])
        some = usable.any(axis=0)
        squares = np.sum(ratio**2, axis=0, where=usable)[some] / usable.sum(axis=0)[some]
        relative = np.sqrt(np.mean((found.values / truth - 1) ** 2, axis=0))
        difference = found.costs - ours.costs
        return Scores(
            relative[list(SHOWN)],
            float(np.sqrt(squares.max())),
            int(np.sum(difference > SAME_COST)),
            int(np.sum(difference < -SAME_COST)),
        )


def verdict(found: Outcome, scores: Scores, ours: Outcome, our_scores: Scores) -> str:
    """Who is ahead in accuracy and in time, and why where it is not `drillid`."""
    faster = found.total_ms / ours.total_ms
    time_told = f"drillid {faster:.1f} times faster" if faster > 1 else f"{1 / faster:.1f} times faster than drillid"
    ratio = scores.over_bound / our_scores.over_bound
    if not found.way.classical and scores.worse == scores.better == 0:
        return f"same data and cost, so the same optimum; {time_told}"
    if ratio > _CLOSE:
        return f"drillid {ratio:.2f} times nearer to the truth; {time_told}"
    if ratio > 1 / _CLOSE:
        return f"equally near, as data and cost are the same; {time_told}"
    return f"nearer by {1 / ratio:.2f}: its start is close to the truth, drillid's is nowhere; {time_told}"


def table(outcomes: Sequence[Outcome], windows: Sequence[SimulatedWindow], noise: Noise) -> Table:
    """One row for each way, `drillid`'s first."""
    made = Table(title=f"The same {len(windows)} windows by other tools; times in ms a window", show_lines=True)
    symbols = [
        f"{DISPLAYED_PARAMETERS[name].symbol}{DISPLAYED_PARAMETERS[name].index}"
        for name in np.array(list(PARAMETERS))[list(SHOWN)]
    ]
    for heading in ("", f"error of {', '.join(symbols)} in %", "over bound", "worse, better optimum", "spectra + fit"):
        made.add_column(heading)
    made.add_column("who is ahead")
    ours = outcomes[0]
    our_scores = Scores.of(ours, ours, windows, noise)
    for one in outcomes:
        scores = Scores.of(one, ours, windows, noise)
        made.add_row(
            one.way.name,
            ", ".join(f"{100 * error:.2g}" for error in scores.errors),
            f"{scores.over_bound:.2f}",
            "other data" if one.way.classical else f"{scores.worse}, {scores.better}",
            f"{one.spectra_ms:.1f} + {np.median(one.fit_ms):.1f}",
            "" if one is ours else verdict(one, scores, ours, our_scores),
        )
    return made


def compared(windows: Sequence[SimulatedWindow]) -> list[Outcome]:
    """All ways on the same windows."""
    return [outcome(way, windows) for way in WAYS]

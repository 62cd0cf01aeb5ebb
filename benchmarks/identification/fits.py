"""How often a fit without advance information ends at the global optimum, over rigs drawn at random.

Judged are rigs whose window identifies the length of their string at all: its Cramér–Rao bound is a tenth of it at
most. Where it does not, strings of many lengths explain the window equally well.

Run it as `python -m benchmarks.identification.fits` at the root of the project.
"""

import numpy as np
import typer
from rich.progress import track

from benchmarks.identification.random_rigs import random_windows
from benchmarks.identification.windows import SETTINGS, SimulatedWindow, measured_windows
from drillid.arrays import Floats
from drillid.fits.likelihood import curvature
from drillid.fits.search import to_scaled
from drillid.fits.solver import minimise
from drillid.fits.window_fit import Measured, Prior, likelihood, optima
from drillid.physics.parameters import BOUNDS, LENGTH, SCALES

SAME_OPTIMUM = 1e-3
"""Cost above that of the optimum found from the truth, within which a fit has found it too."""
USABLE = 0.1
"""Largest Cramér–Rao bound of the length, as a share of it, of a window that counts."""
_USABLE_SHARE = 0.7
"""Share of rigs that are expected to have a usable window, at least."""
_ITERATIONS = 200


def cost_from(start: Floats, measured: Measured, window: SimulatedWindow) -> float:
    """Cost of the optimum that the solver finds from parameters in SI, (8,)."""
    low, high = to_scaled(BOUNDS)
    data = likelihood(measured, window.truth.known, Prior.silent())
    point, free = np.clip(to_scaled(start), low, high), np.zeros(start.size, dtype=bool)
    work = np.empty(start.size), np.empty((start.size, start.size))
    minimise(point, data, False, low, high, free, _ITERATIONS, 1e-3, *work)
    return float(minimise(point, data, True, low, high, free, _ITERATIONS, 1e-8, *work))


def is_usable(measured: Measured, window: SimulatedWindow) -> bool:
    """Whether the window can identify the length of its string."""
    truth, gradient, hessian = window.truth.parameters, np.empty(8), np.empty((8, 8))
    curvature(to_scaled(truth), likelihood(measured, window.truth.known, Prior.silent()), True, gradient, hessian)
    return bool(np.sqrt(np.linalg.inv(hessian)[LENGTH, LENGTH]) * SCALES[LENGTH] <= USABLE * truth[LENGTH])


def usable_windows(count: int) -> list[SimulatedWindow]:
    """The first usable windows of random rigs."""
    windows = random_windows(round(count / _USABLE_SHARE))
    pairs = zip(measured_windows(windows), windows, strict=True)
    return [window for measured, window in pairs if is_usable(measured, window)][:count]


def excess_costs(windows: list[SimulatedWindow]) -> Floats:
    """Cost of fits from a cold start above that of the optimum found from the truth, (window,)."""
    excess = []
    for window, measured in track(
        list(zip(windows, measured_windows(windows), strict=True)), "Fitting random rigs", total=len(windows)
    ):
        known, silent = window.truth.known, Prior.silent()
        _, costs = optima(likelihood(measured, known, silent), measured, known, silent, SETTINGS.fits.starts)
        excess.append(costs[0] - cost_from(window.truth.parameters, measured, window))
    return np.array(excess)


def global_optimum_share(count: int = 300) -> float:
    """Share of random rigs whose fit is as good as the optimum found from the truth, or better."""
    return float(np.mean(excess_costs(usable_windows(count)) < SAME_OPTIMUM))


def main() -> None:
    """Print the share, and the rigs that miss."""
    windows = usable_windows(300)
    excess = excess_costs(windows)
    print(f"global optimum found for {100 * np.mean(excess < SAME_OPTIMUM):.1f} % of {len(windows)} random rigs")
    for number in np.flatnonzero(excess >= SAME_OPTIMUM).tolist():
        length = windows[number].truth.pipe.length
        print(f"rig {number}: string of {length:.0f} m, cost {excess[number]:.3f} above the optimum from the truth")


if __name__ == "__main__":
    typer.run(main)

"""Single windows against the limit that the data set: residuals of the true model, spread of fits, their intervals.

Run it alone as `python -m benchmarks.identification.accuracy` at the root of the project.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np
import typer
from rich.progress import track
from scipy.stats import binom

from benchmarks.identification.bound import Noise
from benchmarks.identification.windows import (
    BIT_NOISE,
    SETTINGS,
    SimulatedWindow,
    at_level,
    mobilities,
    simulated_windows,
)
from drillid.arrays import Booleans, Floats
from drillid.discrepancy.stage import normality_p_value, whitened_residuals, whiteness_p_value
from drillid.fits.window_fit import Fit, Measured, Prior, fit, measured_rows
from drillid.physics.eight_parameters import command_mobility_with_derivatives
from drillid.physics.parameters import PARAMETERS
from drillid.physics.responses import laplace

WINDOWS = 600
"""At each level of bit noise; random errors then move a coverage of 95 % by 0.9 %."""
LEVEL = 0.01
"""Level of the tests of residuals."""


@dataclass(frozen=True)
class Residuals:
    """What the true model leaves of many windows.

    chi2_per_dof : mean over windows
    not_normal, not_white : share of windows that fail the test at LEVEL
    credible_share : largest share that 999 of 1000 right noise models stay below
    """

    chi2_per_dof: float
    not_normal: float
    not_white: float
    credible_share: float

    @staticmethod
    def of(measured: Sequence[Measured], windows: Sequence[SimulatedWindow]) -> "Residuals":
        """Of windows of known rigs."""
        chi2, normal, white = [], [], []
        for data, window in zip(measured, windows, strict=True):
            truth, known = window.truth.parameters, window.truth.known
            mobility, _ = command_mobility_with_derivatives(truth, known, laplace(data.frequency))
            chi2.append(np.mean(np.abs((data.mobility - mobility) * data.weight) ** 2) / 2)
            whitened = whitened_residuals(data, truth, known)
            normal.append(normality_p_value(whitened) < LEVEL)
            white.append(whiteness_p_value(whitened) < LEVEL)
        most = float(binom.ppf(0.999, len(windows), LEVEL)) / len(windows)
        return Residuals(float(np.mean(chi2)), float(np.mean(normal)), float(np.mean(white)), most)

    @staticmethod
    def mean(parts: Sequence["Residuals"]) -> "Residuals":
        """Of as many windows each, which share their noise, so that the credible share is that of one part."""
        return Residuals(
            *(float(np.mean([getattr(part, field.name) for part in parts])) for field in fields(Residuals))
        )


def fits_of(measured: Sequence[Measured], windows: Sequence[SimulatedWindow]) -> list[Fit]:
    """Fits from a cold start without the rig's data sheets."""
    pairs = zip(measured, windows, strict=True)
    return [fit(data, window.truth.known, Prior.silent(), SETTINGS.fits) for data, window in pairs]


@dataclass(frozen=True)
class Spread:
    """Errors of fits of one rig's windows; arrays of shape (level of bit noise, 8).

    Six hundred windows give a spread to 3 %. The linear estimate that reaches the bound has nearly the same errors on
    the same mobilities, so that the ratio of both is known far better; that ratio, times what the mobilities' own
    estimate costs, is the spread over the bound.

    plain : root mean square of errors over the Cramér–Rao bound
    over_bound : the same less random errors of the drawn noise, as above
    identifiable : where the bound means something, as `Noise.identifiable`
    covered : share of windows whose 95 % interval holds the truth
    """

    levels: tuple[float, ...]
    plain: Floats
    over_bound: Floats
    identifiable: Booleans
    covered: Floats

    @staticmethod
    def of(
        fits: Mapping[float, Sequence[Fit]], errors: Mapping[float, Floats], noise: Noise, excess: float
    ) -> "Spread":
        """Of the fits of as many windows at each level of bit noise.

        Parameters
        ----------
        errors : of the linear estimate on the same windows, (window, 8) at each level
        excess : of the mobilities' error over the noise
        """
        truth = noise.truth.parameters
        plain, over_bound, identifiable, covered = [], [], [], []
        for level, found in fits.items():
            size = np.sqrt(np.mean((np.array([one.value for one in found]) - truth) ** 2, axis=0))
            plain.append(size / noise.cramer_rao(level))
            over_bound.append(size / np.sqrt(np.mean(errors[level] ** 2, axis=0)) * excess)
            identifiable.append(noise.identifiable(level))
            covered.append(np.mean([(one.lower <= truth) & (truth <= one.upper) for one in found], axis=0))
        return Spread(tuple(fits), np.array(plain), np.array(over_bound), np.array(identifiable), np.array(covered))

    @property
    def over_bound_max(self) -> float:
        """Largest over parameters of the root mean square over the levels that identify the parameter."""
        return self._largest(self.over_bound)

    @property
    def plain_max(self) -> float:
        """The same, random errors of the drawn noise included."""
        return self._largest(self.plain)

    def _largest(self, ratio: Floats) -> float:
        identified = self.identifiable.any(axis=0)
        squares = np.sum(ratio**2, axis=0, where=self.identifiable)[identified]
        return float(np.sqrt(np.max(squares / self.identifiable.sum(axis=0)[identified])))

    @property
    def coverage(self) -> Floats:
        """Share of covered truths over all levels, (8,)."""
        return np.asarray(self.covered.mean(axis=0))


@dataclass(frozen=True)
class Accuracy:
    """Residuals and spread of the same noise at all levels of bit noise."""

    residuals: Residuals
    spread: Spread

    @staticmethod
    def of(windows: Sequence[SimulatedWindow], levels: Sequence[float] = BIT_NOISE) -> "Accuracy":
        """All windows of one rig at all levels."""
        noise = Noise.of(windows)
        fits: dict[float, list[Fit]] = {}
        errors: dict[float, Floats] = {}
        residuals, excess = [], []
        for level in track(levels, "Fitting windows"):
            louder = at_level(windows, level)
            mobility = mobilities(louder)
            measured, values = measured_rows(mobility), mobility["command_mobility"].values
            fits[level] = fits_of(measured, louder)
            errors[level] = noise.efficient_errors(values, level)
            excess.append(noise.excess(values, level))
            residuals.append(Residuals.of(measured, louder))
        return Accuracy(Residuals.mean(residuals), Spread.of(fits, errors, noise, float(np.mean(excess))))


def main() -> None:
    """Print all figures of many windows at each level."""
    accuracy = Accuracy.of(simulated_windows(WINDOWS))
    spread = accuracy.spread
    print(accuracy.residuals)
    print(f"spread over bound {spread.over_bound_max:.3f}, intervals cover {spread.coverage.min():.3f} and more")
    for row, level in enumerate(spread.levels):
        for column, name in enumerate(PARAMETERS):
            remark = "" if spread.identifiable[row, column] else "  (bound does not apply)"
            print(
                f"{level:5.0f} N m  {name:14s} spread over bound {spread.over_bound[row, column]:5.2f}, "
                f"covered {100 * spread.covered[row, column]:5.1f} %{remark}"
            )


if __name__ == "__main__":
    typer.run(main)

"""Joint fits over 24 windows of one run against their bound, and what stacking does to internal damping.

Run as `python -m benchmarks.identification.joint`. The first run simulates 80 hours of drilling, a quarter of an hour
on two cores.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import typer

from benchmarks.identification.bound import Noise
from benchmarks.identification.windows import (
    BIT_NOISE,
    SETTINGS,
    SWEEP,
    Run,
    SimulatedWindow,
    grid,
    measured_windows,
    mobilities,
    windows_of,
)
from drillid.arrays import Floats
from drillid.config.settings import MobilitySettings
from drillid.fits.joint.coordinates import WALKING, to_parameters, to_state
from drillid.fits.joint.fit import JointFit, joint_fit, prior_levels
from drillid.fits.joint.likelihood import Windows
from drillid.fits.joint.smoother import Gaussian, smoothed
from drillid.fits.window_fit import Measured, Prior, fit, measured_rows
from drillid.mobility.stacks import stack_windows
from drillid.physics.parameters import DELAY, DELTA, INERTIA_TD, LENGTH, PARAMETERS, POLAR_MOMENT
from tests.simulated import DEEP, Truth

WINDOWS = 24
REPEATS = 20
STEP_M = 20.0
FIRST_M = 2700.0
WAVE_FACTOR, OFFSET_M = 1.02, 3.0
"""Length that waves see of the logged length of the pipe: as with tool joints, and a datum that is off."""
WALKS = np.array([0.15, 0.08, 0.15, 0.03])
"""Change of ln κ, ln δ, ln Y_bha and ln J_bha over 100 m, rms."""


@dataclass(frozen=True)
class Stand:
    """One window's place and equipment."""

    bit_depth: float
    truth: Truth


def stands() -> list[Stand]:
    """The windows' rigs: one string that grows longer, whose damping and bit walk at random."""
    random = np.random.default_rng(24)
    walks = np.cumsum(random.standard_normal((WINDOWS, 4)) * WALKS * np.sqrt(STEP_M / 100), axis=0)
    made = []
    for number, (kappa, delta, damping, inertia) in enumerate(np.exp(walks).tolist()):
        depth = FIRST_M + STEP_M * number
        length = WAVE_FACTOR * (depth - DEEP.collars.length) + OFFSET_M
        line = {"kappa": DEEP.pipe.kappa * kappa, "delta": DEEP.pipe.delta * delta}
        bha = DEEP.bit.inertia + DEEP.collars.inertia
        lump = bha * inertia - DEEP.collars.inertia
        truth = replace(
            DEEP,
            pipe=replace(DEEP.pipe, length=length, **line),
            collars=replace(DEEP.collars, **line),
            bit=replace(DEEP.bit, damping=DEEP.bit.damping * damping, inertia=lump),
            bit_noise=BIT_NOISE[number % len(BIT_NOISE)],
            sweep_amplitude=SWEEP,
        )
        made.append(Stand(depth, truth))
    return made


def runs() -> list[Run]:
    """A run of the simulator for each window, as long as all repeats."""
    return [Run(stand.truth, REPEATS, 24_000 + number) for number, stand in enumerate(stands())]


def repeats() -> list[list[SimulatedWindow]]:
    """All repeats of the same 24 windows, each with noise of its own."""
    windows = windows_of(runs())
    return [windows[number::REPEATS] for number in range(REPEATS)]


def joint_fits(rows: Sequence[Sequence[SimulatedWindow]]) -> list[JointFit]:
    """The joint fit of each repeat, without the rig's data sheets, begun from fits of every fifth window alone."""
    known = [stand.truth.known for stand in stands()]
    depth = np.array([stand.bit_depth for stand in stands()])
    found = []
    for windows in rows:
        measured = measured_windows(windows)
        starts = np.full((WINDOWS, len(PARAMETERS)), np.nan)
        for row in range(2, WINDOWS, 5):
            starts[row] = fit(measured[row], known[row], Prior.silent(), SETTINGS.fits).value
        found.append(joint_fit(measured, known, depth, Prior.silent(), starts, SETTINGS.fits))
    return found


@dataclass(frozen=True)
class Truth24:
    """The truth as the joint fit parametrises it.

    states : shape (window, 9)
    slopes : derivatives of the parameters to them, shape (window, 8, 9)
    steps : variance of the walks by which the truth was drawn, shape (window − 1, 4)
    noise : of each window, as the simulator made it
    """

    states: Floats
    slopes: Floats
    steps: Floats
    prior: Gaussian
    noise: list[Noise]

    @staticmethod
    def of(rows: Sequence[Sequence[SimulatedWindow]]) -> "Truth24":
        """From all repeats, which give the noise."""
        places = stands()
        truth = np.stack([stand.truth.parameters for stand in places])
        logged = np.array([stand.bit_depth - stand.truth.collars.length for stand in places])
        states = to_state(truth, WAVE_FACTOR, OFFSET_M)
        slopes = to_parameters(states, logged)[1]
        per_log = slopes[:, WALKING, range(len(WALKING))] / truth[:, WALKING]
        steps = (WALKS / per_log[1:]) ** 2 * STEP_M / 100
        prior = prior_levels(Prior.silent(), [stand.truth.known for stand in places], SETTINGS.fits).density()
        noise = [Noise.of([windows[row] for windows in rows]) for row in range(WINDOWS)]
        return Truth24(states, slopes, steps, prior, noise)

    def bound(self) -> Floats:
        """Least standard deviation of each window's parameters from all windows, shape (window, 8), SI.

        Fisher's information at the truth with the simulator's own noise, and the law by which the
        varying parameters were drawn: the bound for a mixture of fixed and random parameters (Van Trees 1968).
        """
        information = np.stack(
            [noise.information(stand.truth.bit_noise) for noise, stand in zip(self.noise, stands(), strict=True)]
        )
        hessian = np.einsum("wis,wij,wjt->wst", self.slopes, information, self.slopes)
        factors = Gaussian.expanded(self.states, np.zeros(WINDOWS), np.zeros(self.states.shape), hessian)
        covariance = smoothed(self.prior, factors, self.steps).moments()[1]
        return np.asarray(np.sqrt(np.einsum("wis,wst,wit->wi", self.slopes, covariance, self.slopes)))

    def efficient_errors(self, measured: Sequence[Measured]) -> Floats:
        """Errors of the estimate that reaches the bound, shape (window, 8), SI.

        One step of scoring from the truth, given the true noise and the law of the random walks.
        """
        exact = []
        for window, noise, stand in zip(measured, self.noise, stands(), strict=True):
            lines = np.searchsorted(grid(), window.frequency - 1e-9)
            variance = noise.variance[lines] * stand.truth.bit_noise**2
            exact.append(replace(window, variance=variance, degrees_of_freedom=np.full(lines.size, 1e9)))
        known = [stand.truth.known for stand in stands()]
        windows = Windows(exact, known, np.array([stand.bit_depth for stand in stands()]))
        factors = Gaussian.expanded(self.states, *windows.terms(self.states))
        away = smoothed(self.prior, factors, self.steps).moments()[0] - self.states
        return np.asarray(np.einsum("wis,ws->wi", self.slopes, away))


@dataclass(frozen=True)
class JointAccuracy:
    """How near joint fits come to their bound, and how often their bands hold the truth; by parameter.

    Of what all windows share; of the length, in the middle window. Twenty repeats give a spread
    to 16 %. The estimate that reaches the bound has nearly the same errors on the same noise, so that
    the ratio of both spreads is known far better.
    """

    over_bound: dict[str, float]
    """Root-mean-square error over that of the estimate that reaches the bound, on the same windows."""
    spread: dict[str, float]
    """Standard deviation over repeats per bound."""
    offset: dict[str, float]
    """Mean error per bound; 0.22 is one standard error of it with twenty repeats."""
    coverage: dict[str, float]
    """Share of 95 % bands, over windows and repeats, that hold the truth."""

    @property
    def over_bound_max(self) -> float:
        """The largest ratio."""
        return max(self.over_bound.values())


def joint_accuracy(found: Sequence[JointFit], rows: Sequence[Sequence[SimulatedWindow]]) -> JointAccuracy:
    """Errors of all repeats against the truth."""
    truth = Truth24.of(rows)
    values = np.stack([stand.truth.parameters for stand in stands()])
    middle, names = WINDOWS // 2, list(PARAMETERS)
    bound = truth.bound()[middle]
    error = np.stack([each.value for each in found])[:, middle] - values[middle]
    efficient = np.stack([truth.efficient_errors(measured_windows(windows))[middle] for windows in rows])
    held = np.stack([(each.lower <= values) & (values <= each.upper) for each in found])

    def named(ratio: Floats) -> dict[str, float]:
        return {names[index]: float(ratio[index]) for index in (DELAY, INERTIA_TD, POLAR_MOMENT, LENGTH)}

    return JointAccuracy(
        named(np.sqrt(np.mean(error**2, axis=0) / np.mean(efficient**2, axis=0))),
        named(np.std(error, axis=0) / bound),
        named(np.mean(error, axis=0) / bound),
        {name: float(share) for name, share in zip(names, held.mean(axis=(0, 1)), strict=True)},
    )


def stacked_damping(rows: Sequence[Sequence[SimulatedWindow]], count: int = 6) -> Floats:
    """Internal damping from stacks of the first windows, over its true mean there, shape (repeat,)."""
    truth = [stand.truth.parameters[DELTA] for stand in stands()[:count]]
    known = stands()[count // 2].truth.known
    settings = MobilitySettings(stack_windows=count, stack_depth_share=1.0, agreement_error_rate=1e-12)
    time = np.datetime64("2025-01-01", "ns") + np.arange(count) * np.timedelta64(600, "s")
    depth = [stand.bit_depth for stand in stands()[:count]]
    coordinates = {"window": np.arange(count), "hole_depth": ("window", depth)}
    coordinates |= {"start": ("window", time), "end": ("window", time + np.timedelta64(600, "s"))}
    found = []
    for windows in rows:
        stacks = stack_windows(mobilities(windows[:count]).assign_coords(coordinates), settings)[0]
        measured = measured_rows(stacks)[0]
        found.append(fit(measured, known, Prior.silent(), SETTINGS.fits).value[DELTA] / np.mean(truth))
    return np.array(found)


def main() -> None:
    """Print all figures."""
    rows = repeats()
    found = joint_fits(rows)
    accuracy = joint_accuracy(found, rows)
    print(f"Joint fits of {WINDOWS} windows, {REPEATS} repeats")
    for name, ratio in accuracy.over_bound.items():
        remark = f"spread {accuracy.spread[name]:.2f} and mean {accuracy.offset[name]:+.2f} of the bound"
        print(f"  {name:14} error over that of the estimate that reaches the bound {ratio:.2f}; {remark}")
    for name, share in accuracy.coverage.items():
        print(f"  {name:14} 95 % bands hold the truth in {100 * share:.1f} %")
    print(f"  repeats with a change where there is none: {sum(bool(each.changes) for each in found)}")
    truth = np.array([stand.truth.parameters[DELTA] for stand in stands()[:6]])
    joint = np.array([np.mean(each.value[:6, DELTA]) for each in found]) / truth.mean()
    stacked = stacked_damping(rows)
    for name, ratio in (("a stack of six windows", stacked), ("the joint fit", joint)):
        error = ratio.std(ddof=1) / np.sqrt(ratio.size)
        print(
            f"  internal damping of {name} over the truth: {ratio.mean():.3f} ± {error:.3f}, spread {ratio.std():.3f}"
        )


if __name__ == "__main__":
    typer.run(main)

"""Joint fits of a string that grows longer find what the time-domain simulator was given: shared, walking, jumping."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from drillid.arrays import Floats
from drillid.errors import EstimationError
from drillid.fits.joint.fit import JointFit, joint_fit
from drillid.fits.window_fit import Fit, Measured, Prior, fit
from drillid.physics.equipment import Bit
from drillid.physics.parameters import DAMPING_BHA, DELAY, INERTIA_TD, LENGTH, PARAMETERS, POLAR_MOMENT
from drillid.physics.responses import laplace
from tests.simulated import SHALLOW, Truth
from tests.truth.measured import SETTINGS, measured

WINDOWS, JUMP_BELOW = 8, 3
FACTOR, OFFSET = 1.02, 2.0
"""Length that waves see: of the logged length of the pipe."""


@dataclass(frozen=True)
class Run:
    """Windows of one string, what was true, and what was found window by window and together."""

    truth: tuple[Truth, ...]
    windows: list[Measured]
    bit_depth: Floats
    alone: list[Fit]
    together: JointFit

    @property
    def starts(self) -> Floats:
        """Values of the windows alone, shape (window, 8)."""
        return np.stack([found.value for found in self.alone])

    def joint(self, windows: list[Measured]) -> JointFit:
        """All of so many windows."""
        chosen = slice(len(windows))
        known = [truth.known for truth in self.truth[chosen]]
        return joint_fit(windows, known, self.bit_depth[chosen], Prior.silent(), self.starts[chosen], SETTINGS.fits)


@pytest.fixture(scope="module")
def run() -> Run:
    depth = 960.0 + 15.0 * np.arange(WINDOWS)
    truths = tuple(
        replace(
            SHALLOW,
            pipe=replace(SHALLOW.pipe, length=FACTOR * (each - SHALLOW.collars.length) + OFFSET),
            bit=Bit(SHALLOW.bit.inertia, 120.0 if number > JUMP_BELOW else 10.0),
        )
        for number, each in enumerate(depth.tolist())
    )
    windows = [measured(truth, 100 + number) for number, truth in enumerate(truths)]
    alone = [
        fit(window, truth.known, Prior.silent(), SETTINGS.fits) for window, truth in zip(windows, truths, strict=True)
    ]
    not_yet: Any = None
    unfinished = Run(truths, windows, depth, alone, not_yet)
    return replace(unfinished, together=unfinished.joint(windows))


def test_what_is_shared_is_found_within_its_errors(run: Run) -> None:
    truth = [*SHALLOW.parameters[[DELAY, INERTIA_TD, POLAR_MOMENT]], FACTOR, OFFSET]
    pulls = (run.together.shared - truth) / run.together.shared_error
    assert np.abs(pulls).max() < 3.5, pulls
    np.testing.assert_array_equal(np.ptp(run.together.value[:, [DELAY, INERTIA_TD, POLAR_MOMENT]], axis=0), 0.0)


def test_bands_hold_the_truth_and_are_narrower_than_of_windows_alone(run: Run) -> None:
    truth = np.stack([each.parameters for each in run.truth])
    held = (run.together.lower <= truth) & (truth <= run.together.upper)
    assert held.mean() > 0.85
    alone = np.median([found.error for found in run.alone], axis=0)
    together = np.median(run.together.error, axis=0)
    for index in (DELAY, INERTIA_TD):
        assert together[index] < 0.5 * alone[index], list(PARAMETERS)[index]
    assert together[LENGTH] < alone[LENGTH]


def test_the_jump_is_found_and_dated_and_nothing_else(run: Run) -> None:
    [change] = run.together.changes
    assert change.parameter == DAMPING_BHA
    middle = float(run.bit_depth[JUMP_BELOW : JUMP_BELOW + 2].mean())
    assert change.depth_from <= middle <= change.depth_to
    assert change.depth == pytest.approx(middle)
    assert change.probability > 0.95


def test_no_window_of_the_same_string_is_weighted_down(run: Run) -> None:
    np.testing.assert_array_equal(run.together.weight, 1.0)
    assert run.together.agreement.min() > 1e-3 / WINDOWS


def test_one_window_with_another_delay_does_little_harm(run: Run) -> None:
    late = run.windows[5]
    wrong = replace(late, mobility=late.mobility * np.exp(-0.01 * laplace(late.frequency)))
    spoilt = run.joint([*run.windows[:5], wrong, *run.windows[6:]])
    assert spoilt.weight[5] < 0.2
    assert (np.delete(spoilt.weight, 5) == 1).all()
    moved = (spoilt.shared - run.together.shared) / run.together.shared_error
    assert np.abs(moved).max() < 2.5, moved


def test_a_window_without_frequencies_takes_the_band_of_its_neighbours(run: Run) -> None:
    nothing = Measured(*(values[:0] for values in vars(run.windows[2]).values()))
    found = run.joint([*run.windows[:2], nothing, *run.windows[3:]])
    assert np.isfinite(found.value).all()
    assert (found.error[2] > 0.98 * run.together.error[2]).all()


def test_a_window_whose_speed_stands_still_takes_nothing_from_the_others(run: Run) -> None:
    still = replace(run.windows[2], mobility=0 * run.windows[2].mobility, variance=0 * run.windows[2].variance)
    nothing = Measured(*(values[:0] for values in vars(still).values()))
    found, without = (run.joint([*run.windows[:2], each, *run.windows[3:]]) for each in (still, nothing))
    for name in ("value", "error", "shared_error", "weight", "agreement"):
        np.testing.assert_array_equal(getattr(found, name), getattr(without, name), name)


def test_without_any_fit_to_start_from_there_is_an_error(run: Run) -> None:
    with pytest.raises(EstimationError, match="no window has a fit of its own to start from"):
        joint_fit(
            run.windows,
            [truth.known for truth in run.truth],
            run.bit_depth,
            Prior.silent(),
            np.full((WINDOWS, len(PARAMETERS)), np.nan),
            SETTINGS.fits,
        )

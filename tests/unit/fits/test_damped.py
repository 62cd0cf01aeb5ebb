"""Damped steps on small problems: the cost never rises, the damping follows its rule, a fit ends where it should."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest

from drillid.arrays import Floats
from drillid.fits.damped import (
    DEVIATIONS,
    HALVING,
    JOINT_END,
    SET,
    SET_END,
    WINDOW,
    Damping,
    Ending,
    descend,
    lowered,
    raised,
)

THOROUGH = Ending(200, 400, fall=1e-14)


@dataclass(frozen=True)
class Valley:
    """Rosenbrock's curved valley, whose least cost of 0 lies at (1, 1)."""

    point: Floats

    @property
    def residuals(self) -> Floats:
        """Whose squares are summed, (2,)."""
        x, y = self.point
        return np.array([10 * (y - x**2), 1 - x])

    @property
    def cost(self) -> float:
        """Half the sum of squares."""
        return 0.5 * float(np.sum(self.residuals**2))

    def step(self, damping: float) -> Floats:
        """Levenberg–Marquardt's step, (2,)."""
        jacobian = np.array([[-20 * self.point[0], 10.0], [-1.0, 0.0]])
        matrix = jacobian.T @ jacobian
        damped = matrix + damping * np.diag(np.diag(matrix))
        return np.asarray(np.linalg.solve(damped, -jacobian.T @ self.residuals))


@dataclass
class Recorded:
    """Steps in the valley, with the damping and the cost of each trial."""

    damped: bool
    dampings: list[float] = field(default_factory=list)
    costs: list[float] = field(default_factory=list)

    def steps_from(self, here: Valley) -> Callable[[float], Valley]:
        """Trial steps."""

        def trial(damping: float) -> Valley:
            step = here.step(damping) if self.damped else here.step(0.0) / damping
            found = Valley(here.point + step)
            self.dampings.append(damping)
            self.costs.append(found.cost)
            return found

        return trial


@pytest.mark.parametrize("rule", [WINDOW, SET, DEVIATIONS, HALVING], ids=["window", "set", "deviations", "halving"])
def test_every_rule_finds_the_minimum_of_a_curved_valley(rule: Damping) -> None:
    found = descend(Valley(np.array([-1.2, 1.0])), Recorded(rule is not HALVING).steps_from, rule, THOROUGH)
    np.testing.assert_allclose(found.point, 1.0, atol=1e-6)


@pytest.mark.parametrize(("rule", "end"), [(SET, SET_END), (HALVING, JOINT_END)], ids=["set", "joint"])
def test_the_result_is_the_best_of_all_trials(rule: Damping, end: Ending) -> None:
    start, record = Valley(np.array([-1.2, 1.0])), Recorded(rule is SET)
    found = descend(start, record.steps_from, rule, end)
    assert found.cost == min(record.costs) < start.cost


@pytest.mark.parametrize("factor", [rule.reduction for rule in (WINDOW, SET)])
def test_the_damping_falls_with_the_gain(factor: float) -> None:
    rule = Damping(1.0, 1e-9, 1e12, factor, 2.0, 2.0)
    assert lowered(rule, 1.0, 1.0) == (factor, 2.0)
    assert lowered(rule, 1.0, 0.5) == (1.0, 2.0)
    assert lowered(rule, 1.0, 0.0) == (2.0, 2.0)
    assert lowered(rule, 1e-9, 1.0)[0] == 1e-9


def test_rejected_steps_in_a_row_raise_the_damping_ever_faster() -> None:
    state = (1.0, WINDOW.growth)
    dampings = []
    for _ in range(3):
        state = raised(WINDOW, *state)
        dampings.append(state[0])
    assert dampings == [2.0, 8.0, 64.0]
    assert raised(SET, 1.0, SET.growth) == (8.0, 8.0)


@dataclass(frozen=True)
class Flat:
    """A cost that no step lowers."""

    cost: float = 1.0


def test_steps_are_halved_until_none_is_left() -> None:
    dampings: list[float] = []

    def steps_from(_: Flat) -> Callable[[float], Flat]:
        def trial(damping: float) -> Flat:
            dampings.append(damping)
            return Flat(2.0)

        return trial

    start = Flat()
    assert descend(start, steps_from, HALVING, JOINT_END) is start
    assert dampings == [2.0**halvings for halvings in range(12)]


@pytest.mark.parametrize("worse", [1.0, 1.0 + 0.5 * SET_END.rise])
def test_a_set_that_no_step_changes_is_at_its_end(worse: float) -> None:
    tried: list[float] = []

    def steps_from(_: Flat) -> Callable[[float], Flat]:
        def trial(damping: float) -> Flat:
            tried.append(damping)
            return Flat(worse)

        return trial

    descend(Flat(), steps_from, SET, SET_END)
    assert tried == [SET.first]


def test_a_cost_that_is_no_number_is_never_accepted() -> None:
    start = Flat()
    for rule, end in ((SET, SET_END), (HALVING, JOINT_END)):
        assert descend(start, lambda _: lambda _: Flat(np.nan), rule, end) is start


def falling(by: float) -> Callable[[Flat], Callable[[float], Flat]]:
    """Steps that lower the cost by so much each."""
    return lambda here: lambda _: Flat(here.cost - by)


def test_steps_and_trials_are_limited() -> None:
    assert descend(Flat(), falling(1.0), SET, Ending(5, 100, fall=0.0)).cost == -4.0
    assert descend(Flat(), falling(1.0), SET, Ending(100, 7, fall=0.0)).cost == -6.0


@pytest.mark.parametrize(("enough", "steps"), [(np.inf, SET_END.steps), (-5.0, SET_END.steps), (-50.0, 1)])
def test_a_fit_that_falls_too_slowly_to_the_cost_asked_for_is_left(enough: float, steps: int) -> None:
    """Ten falls like the last must reach it; a fit that is asked for no cost goes on."""
    assert 1.0 - descend(Flat(), falling(1.0), SET, SET_END, enough).cost == steps


def test_a_fit_that_comes_where_another_one_ended_is_left() -> None:
    assert descend(Flat(), falling(1.0), SET, SET_END, is_known=lambda here: here.cost <= -4.0).cost == -4.0

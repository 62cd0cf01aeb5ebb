"""Damped Gauss–Newton steps of all least-squares fits: how the damping follows the trial steps, and when a fit ends.

A Gauss–Newton step leads to the minimum of a quadratic model of the cost, which may lie where the model no longer
holds; a damped step is shorter. A trial step that lowers the cost is accepted and the damping falls, any other is
rejected and the damping rises. What the damping acts on differs from fit to fit:

- a window, and a set of windows, add it to the model's matrix as a share of the diagonal (Levenberg 1944, Marquardt
  1963);
- the joint fit of a well divides the whole step by it, because the step is solved for by a smoother over all windows,
  which would have to run again for a damped matrix.

The rules of all fits are the constants below.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

LEAST_CURVATURE = 1e-12
"""Lower limit of the diagonal elements by which damping is scaled."""


class Damping(NamedTuple):
    """How the damping starts, and how it follows accepted and rejected steps; read by compiled functions too."""

    first: float
    least: float
    largest: float
    """Damping above which no further step is tried."""
    reduction: float
    """Factor on the damping after an accepted step that lowers the cost as expected."""
    growth: float
    """Factor on the damping after a rejected step."""
    acceleration: float
    """Factor by which the growth itself rises with each further rejected step in a row."""


WINDOW = Damping(1e-3, 1e-9, 1e12, 1 / 3, 2.0, 2.0)
"""Nielsen's rule (1999): with only eight parameters, the fall expected from the model is worth computing."""
SET = Damping(1e-3, 1e-9, 1e8, 1 / 8, 8.0, 1.0)
"""Marquardt's rule, by factors alone: with hundreds of deviations eliminated, it needs no expected fall."""
DEVIATIONS = SET._replace(least=0.0)
"""For each window's own four deviations: a few iterations of small systems, without a lower limit of the damping."""
HALVING = Damping(1.0, 1.0, 2.0**11, 0.0, 2.0, 1.0)
"""Damping by which a step is divided: first the whole step is tried, then a half, a quarter …"""


@dataclass(frozen=True)
class Ending:
    """When a fit ends."""

    steps: int
    """Largest number of accepted steps."""
    trials: int
    """Largest number of trial steps."""
    fall: float
    """Fall of the cost, in units of log-likelihood, below which an accepted step is the last."""
    rise: float = 0.0
    """Rise of the cost below which a rejected step is the last: the cost is flat."""
    patience: float = 1.0
    """Number of further falls as large as the last that a fit may still need to reach the cost asked for."""


SET_END = Ending(60, 60, fall=1e-2, rise=1e-3, patience=10.0)
"""Causes are compared by gains of order one, so a coarse end is enough."""
JOINT_END = Ending(40, 480, fall=1e-5)
"""Walks and jumps are compared by the evidence at the optimum, and the fit starts afresh for each of them."""


def lowered(rule: Damping, damping: float, gain: float) -> tuple[float, float]:
    """Damping and its growth after an accepted step.

    Parameters
    ----------
    gain : ratio of the cost's fall to that expected from the quadratic model, at most 1; 1 if none is computed
    """
    return max(damping * max(rule.reduction, 1.0 - (2.0 * gain - 1.0) ** 3), rule.least), rule.growth


def raised(rule: Damping, damping: float, growth: float) -> tuple[float, float]:
    """Damping and its growth after a rejected step."""
    return damping * growth, growth * rule.acceleration


class Expanded(Protocol):
    """A point of the fit, with all that a step from there needs."""

    @property
    def cost(self) -> float:
        """Half the sum of squares, in units of log-likelihood."""
        ...


State = TypeVar("State", bound=Expanded)


def descend(
    start: State,
    steps_from: Callable[[State], Callable[[float], State]],
    rule: Damping,
    end: Ending,
    enough: float = np.inf,
    is_known: Callable[[State], bool] = lambda _: False,
) -> State:
    """Follow the cost downhill by damped steps; the cost of the result is never above that of the start.

    Parameters
    ----------
    steps_from : trial steps from a state, as a function of the damping
    enough : cost asked for; a fit that falls too slowly to reach it is stopped
    is_known : whether an optimum to which a state leads has been found before; the fit is stopped there
    """
    here, steps, accepted = start, steps_from(start), 0
    damping, growth = rule.first, rule.growth
    for _ in range(end.trials):
        trial = steps(damping)
        fall = here.cost - trial.cost
        if fall > 0:
            here, accepted = trial, accepted + 1
            if fall < max(end.fall, (here.cost - enough) / end.patience) or accepted == end.steps:
                break
            if is_known(here):
                break
            steps = steps_from(here)
            damping, growth = lowered(rule, damping, 1.0)
        else:
            damping, growth = raised(rule, damping, growth)
            if damping > rule.largest or -fall < end.rise:
                break
    return here

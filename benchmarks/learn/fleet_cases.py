"""Fleets of simulated wells of one rig: drawn by the generator of the sealed proof, with the ideal test over all wells.

Wells of a rig have its top drive, control, recorder and pipe in common, and one data sheet with its errors; string,
collars, bit, damping and noise are each well's own.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import ndtr

from benchmarks.blind.generator.cases import EFFECTS, Case
from benchmarks.blind.generator.rigs import draw_data_sheet, draw_equipment, draw_segments
from benchmarks.blind.hidden import Hidden
from benchmarks.blind.ideal.own import OwnResponses
from benchmarks.blind.ideal.responses import LOCAL, NUISANCES
from benchmarks.blind.ideal.theory import Theory
from drillid.arrays import Floats
from drillid.physics.equipment import Section, polar_moment

_SEAL = 20261
_RIG = (2, 3, 4, 5, 8, 9, 10)
"""Nuisances of the ideal test that wells of a rig have in common."""
_OWN = (0, 1, 6, 7)
"""Those that are each well's own."""
_ROUNDS, _STEPS = 8, 6


@dataclass(frozen=True)
class Fleet:
    """Wells of one rig with a cause in common, or none."""

    seed: int
    wells: tuple[Case, ...]

    def with_cause(self, hidden: Hidden) -> "Fleet":
        """The same fleet with a cause in all wells."""
        return replace(self, wells=tuple(replace(well, hidden=(hidden,)) for well in self.wells))

    @cached_property
    def ideal(self) -> "FleetIdeal":
        """The ideal test over the fleet."""
        return FleetIdeal(self)


def plain_fleet(seed: int, wells: int, windows: int = 1) -> Fleet:
    """Wells of one rig without any cause; a larger fleet of the same seed begins with the wells of a smaller one."""
    generator = np.random.default_rng([_SEAL, seed])
    rig = draw_equipment(generator)
    sheet = draw_data_sheet(generator, rig)
    logged = bool(generator.random() < 0.7)
    cases = []
    for number in range(wells):
        generator = np.random.default_rng([_SEAL, seed, number])
        other = draw_equipment(generator)
        share = rig.pipe.polar_moment / other.pipe.polar_moment
        pipe = replace(rig.pipe, length=other.pipe.length, kappa=other.pipe.kappa, delta=other.pipe.delta)
        outer = 0.14 * float(generator.uniform(1.1, 1.5)) * share_of_diameter(rig.pipe)
        collars = Section(other.collars.length, polar_moment(outer, 0.45 * outer), pipe.kappa, pipe.delta)
        bit = replace(other.bit, inertia=other.bit.inertia * share, damping=other.bit.damping * share)
        own = replace(rig, pipe=pipe, collars=collars, bit=bit, bit_torque=other.bit_torque * share)
        own = replace(own, noise_bandwidth=other.noise_bandwidth, noise_swing=other.noise_swing)
        tally = collars.polar_moment * (1 + sheet.collar_relative / 2 * generator.standard_normal())
        known = replace(sheet, collar_length=float(collars.length), collar_polar_moment=float(tally))
        segments = draw_segments(generator, own, windows)
        cases.append(Case(1000 * seed + number, own, segments, known, (), False, logged))
    return Fleet(seed, tuple(cases))


def share_of_diameter(pipe: Section) -> float:
    """Diameter of a pipe relative to 5½", by its polar moment."""
    return float((pipe.polar_moment / polar_moment(0.1397, 0.1214)) ** 0.25)


class _Theory(Theory):
    """A well's theory, whose control's responses have errors in common with those of all windows of the fleet."""

    def __init__(self, case: Case, total: int) -> None:
        self.total = total
        super().__init__(case, OwnResponses(case))

    def _control_weight(self, window: int) -> Floats:
        own, self.windows = self.windows, self.total
        weight = super()._control_weight(window)
        self.windows = own
        return weight


class FleetIdeal:
    """The likelihood ratio test that knows the cause and its shape; nuisances are fitted by Gauss–Newton."""

    def __init__(self, fleet: Fleet) -> None:
        total = sum(len(well.segments) for well in fleet.wells)
        self.theories = [_Theory(well, total) for well in fleet.wells]

    def noncentrality(self, hidden: Hidden, wells: Sequence[int] | None = None) -> float:
        """λ of a cause that all wells have, or of the chosen ones alone: least squared distance to rigs without it."""
        chosen = [_Well(self.theories[well], hidden) for well in (wells or range(len(self.theories)))]
        tolerance = self.theories[0].responses.priors.shared[list(_RIG)]
        rig, least = np.zeros(len(_RIG)), np.inf
        for _ in range(_STEPS):
            # each well's distance with its own nuisances eliminated, quadratic in what all have in common
            matrix, vector = np.diag(tolerance**-2.0), -rig / tolerance**2
            for well in chosen:
                own_matrix, own_vector = well.expanded(rig)
                matrix, vector = matrix + own_matrix, vector + own_vector
            cost = float(np.sum((rig / tolerance) ** 2)) + sum(well.cost for well in chosen)
            if not cost < least - 0.01:
                break
            least, step = min(cost, least), np.linalg.solve(matrix, vector)
            rig = rig + step
            for well in chosen:
                well.move(step)
        return least

    def largest_alone(self, hidden: Hidden) -> float:
        """√λ of the well that alone shows most."""
        return float(np.sqrt(max(self.noncentrality(hidden, [well]) for well in range(len(self.theories)))))


class _Well:
    """One well's nuisances on the way to the closest rig without the cause."""

    def __init__(self, theory: Theory, hidden: Hidden) -> None:
        self.theory = theory
        self.target = [theory.response(number, (hidden,)) for number in range(theory.windows)]
        priors = theory.responses.priors
        self.deviation = np.concatenate([priors.shared[list(_OWN)], np.tile(priors.local, theory.windows)])
        self.own = np.zeros(self.deviation.size)
        self.cost = np.inf
        self._solved = np.zeros((self.own.size, len(_RIG) + 1))

    def expanded(self, rig: Floats) -> tuple[Floats, Floats]:
        """Matrix (7, 7) and right side (7,) of what all wells have in common, about the present point."""
        count, first = len(_RIG), len(_OWN)
        matrix, vector = np.zeros((count + self.own.size,) * 2), np.zeros(count + self.own.size)
        self.cost = float(np.sum((self.own / self.deviation) ** 2))
        for number, target in enumerate(self.target):
            local = slice(first + len(LOCAL) * number, first + len(LOCAL) * (number + 1))
            nuisances = np.zeros(len(NUISANCES))
            nuisances[list(_RIG)], nuisances[list(_OWN)] = rig, self.own[:first]
            nuisances[list(LOCAL)] += self.own[local]
            rest = target - self.theory.response(number, (), nuisances)
            slopes = self.theory.slopes(number, nuisances)
            rows = np.column_stack([slopes[:, list(_RIG)], slopes[:, list(_OWN)], slopes[:, list(LOCAL)]])
            places = [*range(count + first), *range(count + local.start, count + local.stop)]
            matrix[np.ix_(places, places)] += rows.T @ rows
            vector[places] += rows.T @ rest
            self.cost += float(rest @ rest)
        own = np.arange(count, vector.size)
        matrix[own, own] += self.deviation**-2.0
        vector[own] -= self.own / self.deviation**2
        border = matrix[count:, :count]
        self._solved = np.linalg.solve(matrix[count:, count:], np.column_stack([border, vector[count:]]))
        return matrix[:count, :count] - border.T @ self._solved[:, :-1], vector[:count] - border.T @ self._solved[:, -1]

    def move(self, step: Floats) -> None:
        """Follow a step of what all wells have in common."""
        self.own = self.own + self._solved[:, -1] - self._solved[:, :-1] @ step


def power(root: float, threshold: float) -> float:
    """Power of a one-sided test at √λ."""
    return float(ndtr(root - threshold))


def sized(fleet: Fleet, name: str, wanted: float, most_alone: float, sign: float = 1.0) -> tuple[Hidden, float]:
    """A cause of a wanted √λ over the fleet, smaller where a single well would show it, and the √λ that it has.

    Parameters
    ----------
    most_alone : √λ that no single well may exceed
    """
    first = fleet.wells[0]
    shape = float(np.random.default_rng([_SEAL, fleet.seed, 7]).random())
    low, high = EFFECTS[name].range(first.world(0, hidden=()), first.context(Hidden(name, 0.0, shape)))
    low = low / 100

    def excess(size: float) -> tuple[float, float]:
        hidden = Hidden(name, sign * size, shape)
        root = float(np.sqrt(fleet.ideal.noncentrality(hidden)))
        return max(root / wanted, fleet.ideal.largest_alone(hidden) / most_alone), root

    below, above = np.log(low), np.log(high)
    for _ in range(_ROUNDS):
        middle = (below + above) / 2
        below, above = (below, middle) if excess(float(np.exp(middle)))[0] > 1 else (middle, above)
    size = float(np.exp(below))
    return Hidden(name, sign * size, shape), excess(size)[1]

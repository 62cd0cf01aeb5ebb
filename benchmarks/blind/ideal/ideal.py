"""The ideal test: a likelihood ratio that knows the cause, its shape and all but the nuisance parameters."""

from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from scipy.special import chdtri, chndtr, chndtrinc, ndtr, ndtri

from benchmarks.blind.hidden import Hidden
from benchmarks.blind.ideal.responses import LOCAL, NUISANCES, WINDOW_S, Responses, Sealed
from benchmarks.blind.ideal.theory import Theory, compressed
from benchmarks.blind.vocabulary import CAUSES, ERROR_RATE, PORTS, SMOOTH_FREEDOMS, tone_frequency
from drillid.arrays import Floats

IN_TIME = ("length_growth", "parameter_drift", "regime_change", "clock_drift")
"""Causes that change within a window."""
ADDITIVE = ("aliased_tone", "once_per_revolution")
"""Causes that add a tone to the record."""
_PARTS = 5
_FEW = (1, 2, 6)
"""Numbers of windows from which a distance is bounded before it is computed from all."""
_ROUNDS, _FAR_ROUNDS = 20, 3
"""Rounds of a fit; and those at first, of one that begins elsewhere than at the truth, in which linear theory does not
say where it ends."""
_SIZE_STEP = 1e-4
_LEAST = 1e-6
"""Smallest size of a rival relative to its largest, as some causes are not defined at zero."""
_ALIKE = 1e-6
"""Relative singular value below which columns count as collinear."""
_LOWEST = np.array([-0.9 if unit == "relative" else -np.inf for unit in NUISANCES.values()])
"""Lower bounds of the nuisances, so that no length or moment becomes negative."""
_UNEXPECTED = float(chdtri(SMOOTH_FREEDOMS, 1 - (1 - ERROR_RATE) ** (1 / PORTS)))
"""χ² threshold, at the rate of false alarms, of a smooth disturbance of unknown shape at any port."""
_SHRINKS = (1.0, 0.3, 0.1)
_GROWTH = (0.25, 0.5, 0.75, 1.0)
"""Shares of a cause's size at which the continuation stops."""
_SHAPES = {
    "extra_section": (0.1, 0.5, 0.9),
    "tapered_string": tuple(np.linspace(0.0, 1.0, 13).tolist()),
    "local_damping_zone": tuple(np.linspace(0.0, 1.0, 10).tolist()),
    "recorder_filter": (0.2, 0.8),
    "regenerative_cutting": (0.1, 0.5, 0.9),
    "regime_change": (0.0, 0.5, 1.0),
}
"""Shapes of causes that a test would try one by one."""
CONTINUOUS = ("extra_section", "tapered_string", "local_damping_zone", "regime_change")
"""Causes whose shape may lie between those."""


class Ideal:
    """The ideal test of a case's windows, or of some of them."""

    def __init__(self, case: Sealed, responses: Responses) -> None:
        self.case, self.responses = case, responses
        self.effects, self.priors = responses.effects, responses.priors
        self.windows = tuple(range(responses.windows))
        self._theories: dict[int, Theory] = {}
        self._noncentrality = lru_cache(maxsize=None)(self._least_noncentrality)

    @cached_property
    def parts(self) -> list["Ideal"]:
        """The test of fewer windows, and of more, whose distances are lower bounds of those of all windows.

        The squared distance is a sum over windows, none of which is negative, and the priors of a window that is left
        out cost nothing.
        """
        count, parts = len(self.windows), []
        for few in _FEW:
            if 2 * few <= count:
                parts.append(self._with(windows=tuple(np.linspace(0, count - 1, few).round().astype(int).tolist())))
        return parts

    def theory(self, names: frozenset[str]) -> Theory:
        """The theory that shows causes of these names: of whole windows, or of windows divided into parts."""
        parts = _PARTS if names & set(IN_TIME) else 1
        if parts not in self._theories:
            self._theories[parts] = Theory(self.case, self.responses, parts)
        return self._theories[parts]

    def taking_as_linear(self, name: str) -> "Ideal":
        """The test where a cause never comes to what makes it not linear."""
        return self._with(effects={**self.effects, name: replace(self.effects[name], linear=True)})

    def _with(self, **changed: Any) -> "Ideal":
        """The test with some of its attributes changed, and its distances forgotten."""
        other = copy(self)
        vars(other).update(changed)
        other._noncentrality = lru_cache(maxsize=None)(other._least_noncentrality)
        return other

    def noncentrality(self, hidden: tuple[Hidden, ...], beside: tuple[Hidden, ...] = ()) -> float:
        """λ of causes: least squared distance, in units of noise and tolerances, to any rig without them.

        NaN where the causes are not linear, so that it cannot be computed.

        Parameters
        ----------
        beside : other hidden causes; linear ones are present in the rig without the cause as well, at any size
        """
        return self._noncentrality(hidden, beside)

    def _least_noncentrality(self, hidden: tuple[Hidden, ...], beside: tuple[Hidden, ...]) -> float:
        if any(not self.effects[cause.name].linear and cause.name not in ADDITIVE for cause in hidden):
            return float("nan")
        tones = sum(self._tone(cause) for cause in hidden if cause.name in ADDITIVE)
        rest = tuple(cause for cause in hidden if cause.name not in ADDITIVE)
        return tones + (self._distance_without(rest, beside) if rest else 0.0)

    def _distance_without(self, hidden: tuple[Hidden, ...], beside: tuple[Hidden, ...]) -> float:
        """Squared distance to any rig without linear causes; with any value of the documents wrong outright, where that
        costs less than what it explains.
        """
        linear = tuple(cause for cause in beside if self.effects[cause.name].linear)
        whole = (*hidden, *linear)
        if linear:
            # the others start at their sizes, or are continued with the causes
            ends = [self.closest(whole, linear, grown=grown) for grown in (False, True)]
        else:
            ends = [self._closest_from_anywhere(hidden)]
        least, point = min(ends, key=lambda end: end[0])
        for each in self.priors.wrong:
            if least > each.cost:
                shared = self.priors.shared.copy()
                shared[list(each.spreads)] = list(each.spreads.values())
                other = self._with(priors=replace(self.priors, shared=shared, wrong=()))
                for begin in (point, self._at_truth(linear)):
                    found = other.closest(whole, linear, rejected=least - each.cost, begin=begin)[0]
                    least = min(least, each.cost + found)
        return least

    def _tone(self, hidden: Hidden) -> float:
        """λ of a tone of known frequency in noise of known density, A²T/S over all windows."""
        total = 0.0
        for number in self.windows:
            frequency, amplitude = self.responses.tone(number, hidden)
            s = np.array([2j * np.pi * frequency])
            density = float(self.responses.noise_density(number, (), s)[0])
            total += amplitude**2 * WINDOW_S / density
        return total

    def least_distance(self, hidden: tuple[Hidden, ...]) -> float:
        """Squared distance at the best nuisances, from the truth and from wherever else there may be a minimum."""
        return self._closest_from_anywhere(hidden)[0]

    def _closest_from_anywhere(self, hidden: tuple[Hidden, ...]) -> tuple[float, "Point"]:
        """The same, and the point at which it is reached."""
        best = self.closest(hidden)
        for nuisance, offset in self.priors.starts:
            shared = np.zeros(len(NUISANCES))
            shared[nuisance] = offset
            begin = self._at_truth(())
            end = self.closest(hidden, rejected=best[0], begin=replace(begin, shared=shared), patience=_FAR_ROUNDS)
            best = min(best, end, key=lambda each: each[0])
        return best

    def closest(
        self,
        hidden: tuple[Hidden, ...],
        rivals: tuple[Hidden, ...] = (),
        *,
        grown: bool = True,
        rejected: float = np.inf,
        hopeless: float = np.inf,
        begin: "Point | None" = None,
        patience: int = 0,
    ) -> tuple[float, "Point"]:
        """Squared distance at the best nuisances and the best sizes of rival causes, by Gauss–Newton.

        Parameters
        ----------
        grown : whether they are fitted by continuation in the size of the cause, as a start at its full size may be too
            far off
        rejected : squared distance above which the fit stops
        hopeless : the same at parts of the cause's size; the distance of the whole cause is then told as infinite
        begin : point from which the whole cause is fitted; by default that of the truth, for parts of it first
        patience : rounds after which a fit that linear theory takes to end above `rejected` is stopped

        Returns
        -------
        squared distance
        point : at which it is reached
        """
        theory = self.theory(frozenset(cause.name for cause in hidden))
        point = self._at_truth(rivals) if begin is None else begin
        least, before = np.inf, 1.0
        whole = begin is not None or not grown or any(cause.name == "sign_or_unit" for cause in hidden)
        for share in (1.0,) if whole else _GROWTH:
            wanted = tuple(replace(cause, size=share * cause.size) for cause in hidden)
            target = {number: theory.response(number, wanted) for number in self.windows}
            start = self._within(point.scaled(share / before))
            least, point = self._settled(theory, target, start, rejected, patience)
            before = share
            if least > rejected:
                break
            if share < 1 and least > hopeless:
                return np.inf, point
        return least, point

    def _at_truth(self, rivals: tuple[Hidden, ...]) -> "Point":
        """The nuisances' true values, with rivals beside them."""
        return Point(np.zeros(len(NUISANCES)), np.zeros((len(self.windows), len(LOCAL))), rivals)

    @np.errstate(all="ignore")  # outside the domain of the theory costs are infinite
    def _settled(
        self, theory: Theory, target: dict[int, Floats], point: "Point", rejected: float, patience: int
    ) -> tuple[float, "Point"]:
        """Least squared distance from a target, and the point at which it is reached."""
        least = self._cost(theory, target, point)
        for done in range(_ROUNDS):
            step, predicted = self._step(theory, target, point)
            if done >= patience and predicted > rejected:
                break
            costs = []
            for share in _SHRINKS:
                trial = self._within(point.moved(step, share))
                costs.append(self._cost(theory, target, trial))
                if costs[-1] < least:
                    break
            if not costs[-1] < least:
                break
            fall, least = least - costs[-1], costs[-1]
            point = trial
            if fall < 0.01 * least + 0.01:
                break
        return least, point

    def _within(self, point: "Point") -> "Point":
        shared = np.maximum(point.shared, _LOWEST)
        return replace(point, shared=shared, rivals=tuple(self.bounded(rival) for rival in point.rivals))

    def bounded(self, rival: Hidden) -> Hidden:
        """A rival with its size clipped to the catalogue's bounds, which are wider than the sizes that are hidden."""
        limits = CAUSES[rival.name]
        low = limits.low if limits.low < 0 or limits.fixed else _LEAST * limits.high
        return replace(rival, size=float(np.clip(rival.size, low, limits.high)))

    def _cost(self, theory: Theory, target: dict[int, Floats], point: "Point") -> float:
        pulls = np.sum((point.shared / self.priors.shared) ** 2) + np.sum((point.local / self.priors.local) ** 2)
        nuisances = point.nuisances
        misfits = [
            np.sum((window - theory.response(number, point.rivals, own)) ** 2)
            for (number, window), own in zip(target.items(), nuisances, strict=True)
        ]
        total = float(np.sum(misfits) + pulls)
        return total if np.isfinite(total) else np.inf

    def _step(self, theory: Theory, target: dict[int, Floats], point: "Point") -> tuple[Floats, float]:
        """Gauss–Newton step, and the squared distance that it predicts."""
        factors = []
        for (number, window), own in zip(target.items(), point.nuisances, strict=True):
            here = theory.response(number, point.rivals, own)
            slopes = theory.slopes(number, own, point.rivals)
            factors.append(compressed([slopes, *point.slopes(theory, number, own, here), window - here]))
        design, rest = self._design(factors)
        pulls = -np.concatenate([point.shared / self.priors.shared, (point.local / self.priors.local).ravel()])
        target_rows = np.concatenate([rest[:, -1], pulls])
        columns = rest[:, : len(point.rivals)]
        design = np.column_stack([design, np.concatenate([columns, np.zeros((pulls.size, columns.shape[1]))])])
        if not (np.isfinite(design).all() and np.isfinite(target_rows).all()):
            # no step at the edge of the theory's domain
            return np.zeros(design.shape[1]), 0.0
        step = self._least(design, target_rows, point.rivals)
        return step, float(np.sum((design @ step - target_rows) ** 2))

    def _least(self, design: Floats, target: Floats, rivals: tuple[Hidden, ...]) -> Floats:
        """Least squares with bounded sizes of rivals: one at its bound is fixed there, and the others are refitted."""
        step, first = np.zeros(design.shape[1]), design.shape[1] - len(rivals)
        free = np.ones(step.size, dtype=bool)
        for _ in range(len(rivals) + 1):
            step[free] = _shared(design[:, free], target - design[:, ~free] @ step[~free])
            over = False
            for place, rival in enumerate(rivals, first):
                wanted = replace(rival, size=rival.size + float(step[place]))
                allowed = self.bounded(wanted)
                if free[place] and allowed != wanted:
                    step[place], free[place], over = allowed.size - rival.size, False, True
            if not over:
                break
        return step

    def _design(self, factors: list[Floats]) -> tuple[Floats, Floats]:
        """Design matrix of the nuisances, rows of all windows and of the priors; and the windows' further columns."""
        count, local = len(NUISANCES), len(LOCAL)
        blocks = []
        for number, factor in enumerate(factors):
            block = np.zeros((factor.shape[0], count + local * len(factors)))
            block[:, :count] = factor[:, :count]
            first = count + local * number
            block[:, first : first + local] = factor[:, list(LOCAL)]
            blocks.append(block)
        deviations = np.concatenate([self.priors.shared, np.tile(self.priors.local, len(factors))])
        return np.concatenate([*blocks, np.diag(1 / deviations)]), np.concatenate(
            [factor[:, count:] for factor in factors]
        )

    def small(self, in_time: bool) -> list[Hidden]:
        """Linear causes at a small size, in every shape: those that change within a window, or the others."""
        small = []
        for name, effect in self.effects.items():
            if effect.linear and effect.in_catalogue and (name in IN_TIME) == in_time:
                for shape in _SHAPES.get(name, (0.5,)):
                    low, _ = self.responses.size_range(Hidden(name, 0.0, shape))
                    small.append(Hidden(name, low, shape))
        return small

    @staticmethod
    def shape_step(name: str) -> float:
        """Spacing of the shapes tried of a cause with a continuous shape."""
        return 1.0 / (len(_SHAPES[name]) - 1)

    def beyond(self, theory: Theory, sets: list[tuple[Hidden, ...]]) -> Floats:
        """Effect of sets of causes on the whitened responses, orthogonal to the nuisances, (rows, sets)."""
        factors = []
        for number in self.windows:
            plain = theory.response(number)
            moved = [theory.response(number, hidden) - plain for hidden in sets]
            factors.append(compressed([theory.slopes(number, np.zeros(len(NUISANCES))), *moved]))
        design, rest = self._design(factors)
        rows = np.concatenate([rest, np.zeros((design.shape[0] - rest.shape[0], rest.shape[1]))])
        return np.asarray(rows - design @ np.linalg.lstsq(design, rows, rcond=None)[0], dtype=float)

    @cached_property
    def candidates(self) -> float:
        """Number of effectively distinct candidates: linear ones by Li and Ji, and all others.

        Li and Ji 2005, Heredity 95, 221–227: of the eigenvalues of the correlation between tests, whole parts count
        as one and fractions as they are.
        """
        added = self.beyond(self.theory(frozenset()), [(cause,) for cause in self.small(in_time=False)])
        size = np.linalg.norm(added, axis=0)
        unit = added[:, size > 0] / size[size > 0]
        values = np.abs(np.linalg.eigvalsh(unit.T @ unit))
        linear = float(np.sum((values >= 1) + values - np.floor(values)))
        return linear + sum(
            not effect.linear or name in IN_TIME for name, effect in self.effects.items() if effect.in_catalogue
        )

    def threshold(self, *, family: bool) -> float:
        """One-sided normal threshold of the ideal test, for one known cause or for the whole family."""
        return threshold(self.candidates if family else 1.0)

    def power(self, noncentrality: float, *, family: bool, tones: float = 0.0) -> float:
        """Power of the ideal test.

        Parameters
        ----------
        tones : number of frequencies, for a tone of unknown phase at any of them; 0 for other causes
        """
        if not tones:
            return float(ndtr(np.sqrt(noncentrality) - self.threshold(family=family)))
        # the power of a line is χ² of two degrees of freedom
        p_value = ndtr(-self.threshold(family=family)) / (tones if family else 1.0)
        return float(1 - chndtr(-2 * np.log(p_value), 2, noncentrality))

    @staticmethod
    def power_unaware(noncentrality: float) -> float:
        """Power of a test that knows of a cause only that it is smooth and at one of the ports."""
        return float(1 - chndtr(_UNEXPECTED, SMOOTH_FREEDOMS, noncentrality))

    @staticmethod
    def distance_unaware(power: float) -> float:
        """Standard deviations at which such a test has a power."""
        return float(np.sqrt(chndtrinc(_UNEXPECTED, SMOOTH_FREEDOMS, 1 - power)))

    @staticmethod
    def tones(hidden: tuple[Hidden, ...]) -> float:
        """Number of possible frequencies of a tone: all lines of a window, or that of the shaft; 0 without a tone."""
        if len(hidden) != 1 or hidden[0].name not in ADDITIVE:
            return 0.0
        low, high = (tone_frequency(shape) - tone_frequency(0.0) for shape in (0.0, 1.0))
        return (high - low) * WINDOW_S if hidden[0].name == "aliased_tone" else 1.0


def threshold(candidates: float, error_rate: float = ERROR_RATE) -> float:
    """Threshold of the largest of several effectively distinct normal scores, at the rate of false alarms."""
    return float(ndtri((1 - error_rate) ** (1 / candidates)))


def _shared(design: Floats, target: Floats) -> Floats:
    """Minimum-norm least squares, in which collinear columns share what they explain."""
    scale = np.maximum(np.linalg.norm(design, axis=0), np.finfo(float).tiny)
    return np.asarray(np.linalg.lstsq(design / scale, target, _ALIKE)[0] / scale, dtype=float)


@dataclass(frozen=True, eq=False)
class Point:
    """Nuisances of a set and rival causes at some sizes."""

    shared: Floats
    local: Floats
    rivals: tuple[Hidden, ...]

    @property
    def nuisances(self) -> Floats:
        """Nuisances of every window, (W, 12)."""
        nuisances = np.tile(self.shared, (self.local.shape[0], 1))
        nuisances[:, list(LOCAL)] += self.local
        return nuisances

    def slopes(self, theory: Theory, window: int, nuisances: Floats, here: Floats) -> list[Floats]:
        """Derivatives of a window's responses to the rivals' sizes."""
        slopes = []
        for place, rival in enumerate(self.rivals):
            step = _SIZE_STEP * rival.size or _SIZE_STEP
            moved = (*self.rivals[:place], replace(rival, size=rival.size + step), *self.rivals[place + 1 :])
            slopes.append((theory.response(window, moved, nuisances) - here) / step)
        return slopes

    def scaled(self, factor: float) -> "Point":
        """The point times a factor."""
        rivals = tuple(replace(rival, size=factor * rival.size) for rival in self.rivals)
        return Point(factor * self.shared, factor * self.local, rivals)

    def moved(self, step: Floats, share: float) -> "Point":
        """The point moved by a share of a step."""
        count, size = self.shared.size, self.local.size
        sizes = share * step[count + size :]
        rivals = tuple(
            replace(rival, size=rival.size + float(more)) for rival, more in zip(self.rivals, sizes, strict=True)
        )
        local = self.local + share * step[count : count + size].reshape(self.local.shape)
        return Point(self.shared + share * step[:count], local, rivals)

"""What cannot be told from a hidden cause at a case's noise: other causes, one or two of them together."""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.cases import EFFECTS, Hidden
from benchmarks.blind.effects_sensor import nearest_factor, wrong_factor
from benchmarks.blind.ideal import IN_TIME, Ideal
from drillid.discrepancy import CATALOGUE
from drillid.discrepancy.naming import SAME

Floats = NDArray[np.float64]

_SCALES = (0.05, 1.0)
"""Shares of a cause's size at which its direction is compared with those of others."""
_NEAR = 0.1
"""Square of the correlation from which another cause is looked at closely; at its best size it may come nearer."""
_PAIRS = 6
"""Pairs of causes that are looked at closely, those that leave least by linear reckoning."""
_RIDGE = 1e-6
"""Share by which two causes with one direction are kept apart."""


def same(ideal: Ideal, hidden: Hidden, beside: tuple[Hidden, ...] = ()) -> frozenset[str]:
    """Causes that at this noise come too close to a hidden one to be told from it.

    Those that come near by linear reckoning, to the cause as it is or to a faint one, are followed to their best
    size, while those that are hidden beside it take any size.
    """
    if not EFFECTS[hidden.name].linear:
        return frozenset({hidden.name})
    beside = tuple(one for one in beside if EFFECTS[one.name].linear)
    reckoned, found = _Reckoned.of(ideal, hidden, beside), {hidden.name}
    for place, one in enumerate(reckoned.small):
        near, size = reckoned.near(place)
        if hidden.name == "sign_or_unit" and one.name == "speed_scale":
            size = wrong_factor(hidden.shape) - 1
        elif "sign_or_unit" in (hidden.name, one.name) or near < _NEAR:
            continue
        rival = ideal.bounded(replace(one, size=size))
        if one.name not in found and ideal.least_distance((hidden, *beside), (rival, *beside)) < SAME**2:
            found.add(one.name)
    if hidden.name == "speed_scale" and _is_unit(ideal, hidden):
        found.add("sign_or_unit")
    return frozenset(found)


def imitated(ideal: Ideal, hidden: Hidden) -> bool:
    """Whether two other causes together come too close to a hidden one to be told from it."""
    if not EFFECTS[hidden.name].linear or hidden.name == "sign_or_unit":
        return False
    reckoned = _Reckoned.of(ideal, hidden, ())
    pairs = (tuple(ideal.bounded(one) for one in pair) for pair in reckoned.pairs())
    return any(ideal.least_distance((hidden,), pair) < SAME**2 for pair in pairs)


def _is_unit(ideal: Ideal, scale: Hidden) -> bool:
    """Whether a scale comes too close to that of a wrong unit, which leaves the rest of it."""
    rest = replace(scale, size=(1 + scale.size) / nearest_factor(1 + scale.size) - 1)
    return ideal.least_distance((rest,)) < SAME**2


@dataclass(frozen=True, eq=False)
class _Reckoned:
    """A hidden cause and small others, as they show beyond the nuisances."""

    hidden: Hidden
    small: list[Hidden]
    targets: Floats
    """(scales, rows) of the hidden cause at shares of its size."""
    added: Floats
    """(causes, rows) of the small ones."""

    @classmethod
    def of(cls, ideal: Ideal, hidden: Hidden, beside: tuple[Hidden, ...]) -> "_Reckoned":
        """By the ideal test; what is hidden beside the cause may take any size."""
        small = ideal.small(hidden.name in IN_TIME)
        whole = [(replace(hidden, size=scale * hidden.size),) for scale in _SCALES]
        theory = ideal.theory(frozenset(one.name for one in (hidden, *beside)))
        others = [(one,) for one in (*beside, *small)]
        rows = ideal.beyond(theory, [*whole, *others]).T
        count = len(_SCALES) + len(beside)
        basis = np.linalg.qr(rows[len(_SCALES) : count].T)[0]
        rows = rows - (rows @ basis) @ basis.T
        return cls(hidden, small, rows[: len(_SCALES)], rows[count:])

    def near(self, place: int) -> tuple[float, float]:
        """Largest square of the correlation with a small cause, and the size at which that comes nearest."""
        along, lengths = self.added[place], np.sum(self.targets**2, axis=1)
        length, signed = float(along @ along), CATALOGUE[self.small[place].name].size.low < 0
        if length == 0 or not lengths.all():
            return 0.0, 0.0
        ratio = self.targets @ along / length
        near = np.where((ratio > 0) | signed, ratio**2 * length / lengths, 0.0)
        best = int(np.argmax(near))
        return float(near[best]), float(self.small[place].size * ratio[best] / _SCALES[best])

    def pairs(self) -> list[tuple[Hidden, Hidden]]:
        """Pairs of other causes, at the sizes at which they leave least, for each scale those that leave least."""
        names = [one.name for one in self.small]
        fit = [place for place, name in enumerate(names) if name not in (self.hidden.name, "sign_or_unit")]
        gram = self.added @ self.added.T
        found = []
        for scale, target in zip(_SCALES, self.targets, strict=True):
            along, tried = self.added @ target, []
            for pair in combinations(fit, 2):
                if names[pair[0]] == names[pair[1]]:
                    continue
                own = gram[np.ix_(pair, pair)]
                size = np.linalg.solve(own + _RIDGE * np.diag(np.diag(own)), along[list(pair)])
                if all(one > 0 or CATALOGUE[names[place]].size.low < 0 for one, place in zip(size, pair, strict=True)):
                    tried.append((float(along[list(pair)] @ size), pair, size / scale))
            tried.sort(key=lambda entry: -entry[0])
            for _, (first, second), (one, other) in tried[:_PAIRS]:
                left, right = self.small[first], self.small[second]
                found.append((replace(left, size=one * left.size), replace(right, size=other * right.size)))
        return found

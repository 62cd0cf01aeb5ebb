"""What cannot be told from a hidden cause at a case's noise: other causes, one or two of them together."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from benchmarks.blind.generator.cases import EFFECTS, Hidden
from benchmarks.blind.generator.effects_sensor import nearest_factor, wrong_factor
from benchmarks.blind.ideal.ideal import CONTINUOUS, IN_TIME, Ideal
from drillid.arrays import Floats
from drillid.discrepancy import CATALOGUE
from drillid.discrepancy.rules import DISTINCT, DISTINGUISHED_SHARE

UNTOLD = Ideal.distance_unaware(DISTINGUISHED_SHARE)
"""Standard deviations below which a cause that is not in the catalogue counts as imitated by others."""
_SIZES = 3
"""Sizes of a cause, from small to the largest that the catalogue allows, that are reckoned with."""
_FARTHEST = 5.0
"""Factor by which linear reckoning may put a rival off the size that it starts from."""
_NEAR = 0.1
"""Share of a cause that a rival must explain by linear reckoning to be looked at closely; it may then come nearer."""
_STARTS, _PAIRS = 2, 12
"""Of every cause, and of all pairs, those that are looked at closely, as they leave least by linear reckoning."""
_HOPELESS, _CLOSE, _TRIES = 1.5, 3.0, 8
"""How many times what counts as the same a rival may be off to be followed further; the same where its shape can be
sought between those tried, and steps of that search."""
_RIDGE = 1e-6
"""Share by which two causes with one direction are kept apart."""


def same(ideal: Ideal, hidden: Hidden, beside: tuple[Hidden, ...] = ()) -> frozenset[str]:
    """Causes that at this noise come too close to a hidden one to be told from it.

    Those that come near by linear reckoning are followed to their best size, and shape where that is continuous, while
    those that are hidden beside it take any size.
    """
    if not EFFECTS[hidden.name].linear:
        return frozenset({hidden.name})
    beside = tuple(one for one in beside if EFFECTS[one.name].linear)
    if hidden.name == "sign_or_unit":
        starts = [Hidden("speed_scale", wrong_factor(hidden.shape) - 1, 0.5)]
    else:
        starts = _Reckoned.of(ideal, hidden, beside).nearest()
    found = {hidden.name}
    alone = ideal.noncentrality((hidden,), beside)
    for rival in starts:
        if (
            rival.name not in found
            and _least(ideal, hidden, (ideal.bounded(rival),), alone, DISTINCT, beside) < DISTINCT
        ):
            found.add(rival.name)
    if hidden.name == "speed_scale" and _is_unit(ideal, hidden):
        found.add("sign_or_unit")
    return frozenset(found)


def stands_in(ideal: Ideal, hidden: Hidden, name: str, near: float, beside: tuple[Hidden, ...] = ()) -> bool:
    """Whether a certain other cause comes nearer than some standard deviations, from any of its shapes and sizes.

    Linear reckoning overlooks some, as slower waves for a heavier bit; for what an answer names no start is spared.
    """
    if not EFFECTS[hidden.name].linear or not EFFECTS[name].linear or "sign_or_unit" in (name, hidden.name):
        return False
    beside = tuple(one for one in beside if EFFECTS[one.name].linear)
    whole: tuple[Hidden, ...] = (hidden, *beside)
    best: tuple[float, tuple[Hidden, ...]] = (np.inf, ())
    for small in ideal.small(name in IN_TIME):
        for rival in _sizes(small) if small.name == name else []:
            for grown in (True, False):
                found = ideal.closest(whole, (ideal.bounded(rival), *beside), grown=grown)
                best = min(best, found, key=lambda entry: entry[0])
                if best[0] < near**2:
                    return True
    return name in CONTINUOUS and _at_best_shape(ideal, whole, best[1], np.inf) < near


def imitated(ideal: Ideal, hidden: Hidden) -> bool:
    """Whether another cause, or two together, come so close that a test that does not know the hidden one is blind."""
    if not EFFECTS[hidden.name].linear or hidden.name == "sign_or_unit":
        return False
    reckoned = _Reckoned.of(ideal, hidden, ())
    alone = ideal.noncentrality((hidden,))
    return any(
        _least(ideal, hidden, tuple(ideal.bounded(one) for one in rivals), alone, UNTOLD) < UNTOLD
        for rivals in (*((one,) for one in reckoned.nearest()), *reckoned.pairs())
    )


def _is_unit(ideal: Ideal, scale: Hidden) -> bool:
    """Whether a scale comes too close to that of a wrong unit, which leaves the rest of it."""
    rest = replace(scale, size=(1 + scale.size) / nearest_factor(1 + scale.size) - 1)
    return ideal.least_distance((rest,)) < DISTINCT**2


def _least(
    ideal: Ideal,
    hidden: Hidden,
    rivals: tuple[Hidden, ...],
    alone: float,
    near: float,
    beside: tuple[Hidden, ...] = (),
) -> float:
    """Least distance of rivals, from where they start and as they grow with the cause.

    Parameters
    ----------
    alone : squared distance of the cause from any rig without it and without rivals
    near : distance below which nobody asks how near
    """
    continuous = len(rivals) == 1 and rivals[0].name in CONTINUOUS
    # a large cause bends linear reckoning: on its way a rival may be as far off as none at all
    whole = (hidden, *beside)
    far = max(((_CLOSE if continuous else _HOPELESS) * near) ** 2, alone)
    squared, reached = ideal.closest(whole, (*rivals, *beside), grown=False, rejected=far)
    if squared >= near**2:
        other, end = ideal.closest(whole, (*rivals, *beside), rejected=far)
        squared, reached = min((squared, reached), (other, end), key=lambda entry: entry[0])
    if not continuous or not near**2 <= squared < far:
        return float(np.sqrt(squared))
    return _at_best_shape(ideal, whole, reached, far)


def _at_best_shape(ideal: Ideal, whole: tuple[Hidden, ...], reached: tuple[Hidden, ...], far: float) -> float:
    """Least distance of the first of some rivals at shapes about its own, the others staying what they are."""
    rival = reached[0]

    def distance(shape: float) -> float:
        shaped = (replace(rival, shape=shape), *reached[1:])
        return float(np.sqrt(ideal.closest(whole, shaped, grown=False, rejected=far)[0]))

    step = ideal.shape_step(rival.name)
    around = (max(rival.shape - step, 0.0), min(rival.shape + step, 1.0))
    return float(minimize_scalar(distance, bounds=around, method="bounded", options={"maxiter": _TRIES}).fun)


@dataclass(frozen=True, eq=False)
class _Reckoned:
    """A hidden cause and others at several sizes, as they show beyond the nuisances."""

    rivals: list[Hidden]
    target: Floats
    """(rows,) of the hidden cause."""
    added: Floats
    """(rivals, rows)."""

    @classmethod
    def of(cls, ideal: Ideal, hidden: Hidden, beside: tuple[Hidden, ...]) -> "_Reckoned":
        """By the ideal test; what is hidden beside the cause may take any size."""
        small = ideal.small(hidden.name in IN_TIME)
        rivals = [sized for one in small if one.name not in (hidden.name, "sign_or_unit") for sized in _sizes(one)]
        theory = ideal.theory(frozenset(one.name for one in (hidden, *beside)))
        rows = ideal.beyond(theory, [(one,) for one in (hidden, *beside, *rivals)]).T
        basis = np.linalg.qr(rows[1 : 1 + len(beside)].T)[0]
        rows = rows - (rows @ basis) @ basis.T
        return cls(rivals, rows[0], rows[1 + len(beside) :])

    def nearest(self) -> list[Hidden]:
        """Of every cause the few that explain most, at the sizes at which they leave least; the best first."""
        along, own = self.added @ self.target, np.sum(self.added**2, axis=1)
        size = np.divide(along, own, out=np.zeros_like(own), where=own > 0)
        gain = np.where(size > 0, size * along, 0.0)
        found: list[Hidden] = []
        for place in np.argsort(-gain):
            one = self.rivals[place]
            if gain[place] < _NEAR * float(self.target @ self.target):
                break
            if sum(one.name == other.name for other in found) < _STARTS:
                found.append(_moved(one, float(size[place])))
        return found

    def pairs(self) -> list[tuple[Hidden, Hidden]]:
        """Pairs of causes, at the sizes at which they leave least; those that explain most first."""
        names = np.array([one.name for one in self.rivals])
        gram, along = self.added @ self.added.T, self.added @ self.target
        own = np.diag(gram) * (1 + _RIDGE)
        with np.errstate(all="ignore"):
            size = (along[:, None] * own[None] - along[None] * gram) / (np.outer(own, own) - gram**2)
            gain = size * along[:, None] + size.T * along[None]
        apart = (names[:, None] < names[None]) & (size > 0) & (size.T > 0) & np.isfinite(gain)
        found: dict[tuple[str, str], tuple[Hidden, Hidden]] = {}
        for place in np.argsort(-np.where(apart, gain, -np.inf), axis=None):
            first, second = np.unravel_index(place, gain.shape)
            if not apart[first, second] or len(found) == _PAIRS:
                break
            pair = (
                _moved(self.rivals[first], float(size[first, second])),
                _moved(self.rivals[second], float(size[second, first])),
            )
            found.setdefault((pair[0].name, pair[1].name), pair)
        return list(found.values())


def _sizes(small: Hidden) -> list[Hidden]:
    """A cause from its small size to the largest, either way where it has a sign."""
    limits = CATALOGUE[small.name].size
    up = np.geomspace(small.size, limits.high, _SIZES)
    down = -np.geomspace(small.size, -limits.low, _SIZES) if limits.low < 0 else np.empty(0)
    return [replace(small, size=float(size)) for size in (*up, *down)]


def _moved(one: Hidden, factor: float) -> Hidden:
    return replace(one, size=one.size * float(np.clip(factor, 1 / _FARTHEST, _FARTHEST)))

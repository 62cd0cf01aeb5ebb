"""Causes that cannot be distinguished from a hidden cause at a case's noise, one or two of them together."""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from benchmarks.blind.hidden import Hidden
from benchmarks.blind.ideal.ideal import CONTINUOUS, IN_TIME, Ideal
from benchmarks.blind.vocabulary import CAUSES, DISTINCT, DISTINGUISHED_SHARE, nearest_factor, wrong_factor
from drillid.arrays import Floats

INDISTINGUISHABLE = Ideal.distance_unaware(DISTINGUISHED_SHARE)
"""Standard deviations below which a cause that is not in the catalogue counts as imitated by others."""
_SIZES = 3
"""Number of sizes of a cause, from small to the largest that the catalogue allows, in the linear approximation."""
_FARTHEST = 5.0
"""Largest factor by which the linear approximation may change a rival's size."""
_NEAR = 0.1
"""Share of a cause that a rival must explain in the linear approximation for a non-linear fit, which may bring it
nearer."""
_LIKELY = 0.5
"""The same from which a rival is fitted from all its shapes and sizes."""
_BENT = 2.0
"""Squared distance to first order, per squared distance, or that of the whole cause per four times that of its half,
from which linear theory says nothing of what is near."""
_STARTS, _PAIRS = 2, 12
"""Number of starts for each cause, and of pairs in all, with a non-linear fit: those that leave least in the linear
approximation."""
_REJECTED, _CLOSE, _TRIES = 1.5, 3.0, 8
"""Distances, relative to that of indistinguishable causes, up to which the fit of a rival is continued: in general, and
where its shape is continuous; and evaluations of the search over that shape."""
_AGREEING, _AGREE = 2, 0.02
"""Number of fits of one shape from different starts that must reach the least squared distance alike, to within a
share, for it to be taken as the least there is."""
_HOPELESS = 2.0
"""Squared distance at a part of a cause's size, relative to that of indistinguishable causes, from which the whole
cause is farther still."""
_RIDGE = 1e-6
"""Relative regularisation of pairs of collinear causes."""


def same(
    ideal: Ideal, hidden: Hidden, beside: tuple[Hidden, ...] = (), among: Collection[str] = CAUSES
) -> frozenset[str]:
    """Causes that at this noise cannot be distinguished from a hidden one.

    Those that are near in the linear approximation are fitted in size, and in shape where that is continuous, while
    causes hidden beside it may take any size.

    Parameters
    ----------
    among : causes that are asked for
    """
    if not ideal.effects[hidden.name].linear:
        return frozenset({hidden.name})
    beside = tuple(cause for cause in beside if ideal.effects[cause.name].linear)
    if hidden.name == "sign_or_unit":
        starts = [Hidden("speed_scale", wrong_factor(hidden.shape) - 1, 0.5)]
    else:
        starts = [*ideal.responses.equal(hidden), *_Linearised.of(ideal, hidden, beside, among).nearest()]
    names = {hidden.name}
    for rival in starts:
        if rival.name in {*among} - names and _comes_near(ideal, hidden, (ideal.bounded(rival),), DISTINCT, beside):
            names.add(rival.name)
    if hidden.name == "speed_scale" and "sign_or_unit" in among and _is_unit(ideal, hidden):
        names.add("sign_or_unit")
    return frozenset(names)


def likely(ideal: Ideal, hidden: Hidden, beside: tuple[Hidden, ...] = (), among: Collection[str] = CAUSES) -> list[str]:
    """Causes that may come near a hidden one: at some size and shape they explain a good part of it to first order.

    Where the nuisances take up far more of the cause than they would to first order, or of its half than of the whole,
    that says nothing, and any may.

    Parameters
    ----------
    among : causes that are asked for
    """
    if not ideal.effects[hidden.name].linear or hidden.name == "sign_or_unit":
        return []
    beside = tuple(cause for cause in beside if ideal.effects[cause.name].linear)
    linearised = _Linearised.of(ideal, hidden, beside, among)
    whole, half = (ideal.noncentrality((sized,), beside) for sized in (hidden, replace(hidden, size=hidden.size / 2)))
    bent = float(linearised.target @ linearised.target) > _BENT * whole or whole > 4 * _BENT * half
    return linearised.explaining(0.0 if bent else _LIKELY)


def stands_in(ideal: Ideal, hidden: Hidden, name: str, near: float, beside: tuple[Hidden, ...] = ()) -> bool:
    """Whether a certain other cause comes nearer than some standard deviations, from any of its shapes and sizes.

    The linear approximation misses some, such as slower waves for a heavier bit.
    """
    if not ideal.effects[hidden.name].linear or not ideal.effects[name].linear or "sign_or_unit" in (name, hidden.name):
        return False
    beside = tuple(cause for cause in beside if ideal.effects[cause.name].linear)
    starts = [rival for small in ideal.small(name in IN_TIME) if small.name == name for rival in _sizes(small)]
    for part in (*ideal.parts, ideal):
        found = _first_near(part, (hidden, *beside), starts, near)
        if found is None:
            return False
        # what was near on fewer windows is tried first on more
        starts.insert(0, starts.pop(found))
    return True


def _first_near(ideal: Ideal, whole: tuple[Hidden, ...], starts: list[Hidden], near: float) -> int | None:
    """Number of the first start from which a rival comes nearer than some standard deviations; None without one.

    Parameters
    ----------
    whole : a hidden cause, and those beside it, which may take any size
    """
    best: tuple[float, tuple[Hidden, ...], int] = (np.inf, (), 0)
    reached: dict[float, list[float]] = {}
    for number, grown in _spread(len(starts)):
        rival = starts[number]
        least = sorted(reached.setdefault(rival.shape, []))[:_AGREEING]
        if len(least) == _AGREEING and least[-1] < (1 + _AGREE) * least[0]:
            continue
        squared, point = ideal.closest(
            whole, (ideal.bounded(rival), *whole[1:]), grown=grown, hopeless=_HOPELESS * near**2
        )
        reached[rival.shape].append(squared)
        best = min(best, (squared, point.rivals, number), key=lambda entry: entry[0])
        if best[0] < near**2:
            return number
    refined = starts[0].name in CONTINUOUS and _at_best_shape(ideal, whole, best[1], np.inf) < near
    return best[2] if refined else None


def _spread(count: int) -> list[tuple[int, bool]]:
    """Numbers of starts, each with and without continuation in size; those that follow each other differ in both."""
    order = [*range(0, count, 2), *range(1, count, 2)]
    turns = [(number, bool(place % 2)) for place, number in enumerate(order)]
    return [*turns, *((number, not grown) for number, grown in turns)]


def imitated(ideal: Ideal, hidden: Hidden) -> bool:
    """Whether another cause, or two together, come so close that a test unaware of the hidden one has no power."""
    if not ideal.effects[hidden.name].linear or hidden.name == "sign_or_unit":
        return False
    linearised = _Linearised.of(ideal, hidden)
    return any(
        _comes_near(ideal, hidden, tuple(ideal.bounded(rival) for rival in rivals), INDISTINGUISHABLE)
        for rivals in (*((rival,) for rival in linearised.nearest()), *linearised.pairs())
    )


def _is_unit(ideal: Ideal, scale: Hidden) -> bool:
    """Whether a scale cannot be distinguished from that of a wrong unit; the test is on the ratio of both."""
    rest = replace(scale, size=(1 + scale.size) / nearest_factor(1 + scale.size) - 1)
    return ideal.least_distance((rest,)) < DISTINCT**2


def _comes_near(
    ideal: Ideal, hidden: Hidden, rivals: tuple[Hidden, ...], near: float, beside: tuple[Hidden, ...] = ()
) -> bool:
    """Whether rivals come nearer than some standard deviations; where they do not on few windows, they never do."""
    return all(_least(part, hidden, rivals, near, beside) < near for part in (*ideal.parts, ideal))


def _least(ideal: Ideal, hidden: Hidden, rivals: tuple[Hidden, ...], near: float, beside: tuple[Hidden, ...]) -> float:
    """Least distance of rivals, fitted from their starts and by continuation in the size of the cause.

    Parameters
    ----------
    near : distance at which the fit may stop
    """
    # from any rig without the cause and without rivals
    alone = ideal.noncentrality((hidden,), beside)
    continuous = len(rivals) == 1 and rivals[0].name in CONTINUOUS
    # for a large cause the linear approximation fails: during the fit a rival may be as far off as none at all
    whole = (hidden, *beside)
    far = max(((_CLOSE if continuous else _REJECTED) * near) ** 2, alone)
    end = ideal.closest(whole, (*rivals, *beside), grown=False, rejected=far)
    if end[0] >= near**2:
        end = min(end, ideal.closest(whole, (*rivals, *beside), rejected=far), key=lambda each: each[0])
    squared, point = end
    if not continuous or not near**2 <= squared < far:
        return float(np.sqrt(squared))
    return _at_best_shape(ideal, whole, point.rivals, far)


def _at_best_shape(ideal: Ideal, whole: tuple[Hidden, ...], reached: tuple[Hidden, ...], far: float) -> float:
    """Least distance over shapes of the first rival about its own, the other rivals fixed in shape."""
    rival = reached[0]

    def distance(shape: float) -> float:
        shaped = (replace(rival, shape=shape), *reached[1:])
        return float(np.sqrt(ideal.closest(whole, shaped, grown=False, rejected=far)[0]))

    step = ideal.shape_step(rival.name)
    around = (max(rival.shape - step, 0.0), min(rival.shape + step, 1.0))
    return float(minimize_scalar(distance, bounds=around, method="bounded", options={"maxiter": _TRIES}).fun)


@dataclass(frozen=True, eq=False)
class _Linearised:
    """Linear approximation of a hidden cause and rivals at several sizes, orthogonal to the nuisances."""

    rivals: list[Hidden]
    target: Floats
    """(rows,) response of the hidden cause."""
    added: Floats
    """(rivals, rows) responses of the rivals."""

    @classmethod
    def of(
        cls, ideal: Ideal, hidden: Hidden, beside: tuple[Hidden, ...] = (), among: Collection[str] = CAUSES
    ) -> "_Linearised":
        """From the ideal test; causes hidden beside it may take any size."""
        names = {*among} - {hidden.name, "sign_or_unit"}
        small = [cause for cause in ideal.small(hidden.name in IN_TIME) if cause.name in names]
        rivals = [sized for cause in small for sized in _sizes(cause)]
        theory = ideal.theory(frozenset(cause.name for cause in (hidden, *beside)))
        rows = ideal.beyond(theory, [(cause,) for cause in (hidden, *beside, *rivals)]).T
        basis = np.linalg.qr(rows[1 : 1 + len(beside)].T)[0]
        rows = rows - (rows @ basis) @ basis.T
        return cls(rivals, rows[0], rows[1 + len(beside) :])

    def nearest(self) -> list[Hidden]:
        """For each cause the few starts that explain most, at their least-squares sizes; the best first."""
        along, own = self.added @ self.target, np.sum(self.added**2, axis=1)
        size = np.divide(along, own, out=np.zeros_like(own), where=own > 0)
        gain = np.where(size > 0, size * along, 0.0)
        starts: list[Hidden] = []
        for place in np.argsort(-gain):
            rival = self.rivals[place]
            if gain[place] < _NEAR * float(self.target @ self.target):
                break
            if sum(rival.name == other.name for other in starts) < _STARTS:
                starts.append(_scaled(rival, float(size[place])))
        return starts

    def explaining(self, share: float) -> list[str]:
        """Causes that explain at least a share of the hidden one at some size and shape."""
        along, own = self.added @ self.target, np.sum(self.added**2, axis=1)
        gain = np.divide(along**2, own, out=np.zeros_like(own), where=own > 0)
        enough = (along > 0) & (gain >= share * float(self.target @ self.target))
        return sorted({rival.name for rival, kept in zip(self.rivals, enough, strict=True) if kept})

    def pairs(self) -> list[tuple[Hidden, Hidden]]:
        """Pairs of causes at their least-squares sizes; those that explain most first."""
        names = np.array([rival.name for rival in self.rivals])
        gram, along = self.added @ self.added.T, self.added @ self.target
        own = np.diag(gram) * (1 + _RIDGE)
        with np.errstate(all="ignore"):
            size = (along[:, None] * own[None] - along[None] * gram) / (np.outer(own, own) - gram**2)
            gain = size * along[:, None] + size.T * along[None]
        apart = (names[:, None] < names[None]) & (size > 0) & (size.T > 0) & np.isfinite(gain)
        chosen: dict[tuple[str, str], tuple[Hidden, Hidden]] = {}
        for place in np.argsort(-np.where(apart, gain, -np.inf), axis=None):
            first, second = np.unravel_index(place, gain.shape)
            if not apart[first, second] or len(chosen) == _PAIRS:
                break
            pair = (
                _scaled(self.rivals[first], float(size[first, second])),
                _scaled(self.rivals[second], float(size[second, first])),
            )
            chosen.setdefault((pair[0].name, pair[1].name), pair)
        return list(chosen.values())


def _sizes(small: Hidden) -> list[Hidden]:
    """A cause at sizes from small to the largest, of either sign where it may have both."""
    limits = CAUSES[small.name]
    up = np.geomspace(small.size, limits.high, _SIZES)
    down = -np.geomspace(small.size, -limits.low, _SIZES) if limits.low < 0 else np.empty(0)
    return [replace(small, size=float(size)) for size in (*up, *down)]


def _scaled(cause: Hidden, factor: float) -> Hidden:
    return replace(cause, size=cause.size * float(np.clip(factor, 1 / _FARTHEST, _FARTHEST)))

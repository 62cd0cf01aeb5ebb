"""The offer of a learnt extension: its gain on windows that it has not seen decides.

Elements, their number and their places are learnt anew without each part of the windows, and the difference of log
scores is measured on that part, whose deviations from the set base and extended model are fitted to alike: so all
windows judge, each something that it took no part in (cross-fitting; Stone 1974, Journal of the Royal Statistical
Society B 36, 111–147). What is learnt of all windows is offered where the lower limit of that gain is above zero. Of a
single window either half of the frequencies judges the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drillid.arrays import Booleans, Indices
from drillid.discrepancy.inference.coordinates import Extension, Point
from drillid.discrepancy.inference.held_out_gain import every_other_line, gain_on
from drillid.discrepancy.inference.set_fit import SetFit, fit_set
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.learning.fingerprint import Fingerprint, fingerprint
from drillid.discrepancy.learning.search import Candidate, learn
from drillid.discrepancy.predictive_gain import NO_PREDICTIVE_GAIN, PredictiveGain

_PARTS = 4
"""Number of parts of the windows that judge in turn; learning is repeated for each."""


@dataclass(frozen=True, eq=False)
class LearntExtension:
    """An extension that was learnt, with its gain on data that it has not seen."""

    elements: tuple[tuple[str, float], ...]
    """Name and place of each element, in the order in which they were added."""
    extensions: tuple[Extension, ...]
    """Their terms."""
    fit: SetFit
    """Fit to all windows."""
    gain: PredictiveGain
    """Gain per window, of what is learnt without the windows that it is measured on."""
    fingerprint: Fingerprint

    @property
    def offered(self) -> bool:
        """Whether the lower limit of the gain is above zero."""
        return self.gain.low > 0


def held_out_parts(model: SetModel) -> list[Booleans]:
    """Parts of the data (W, F) that learning does not see in turn; together they are all data."""
    windows = model.evidence.windows
    parts = np.zeros((min(windows, _PARTS) if windows > 1 else 2, *model.evidence.used.shape), dtype=bool)
    for number, part in enumerate(parts):
        if windows > 1:
            part[number :: len(parts)] = True
        else:
            part |= every_other_line(model.evidence.used, number)
    return list(parts)


def learnt_extension(model: SetModel, base: SetFit) -> LearntExtension | None:
    """Learn what a model lacks; None where no element predicts better.

    Parameters
    ----------
    base : fit of the model without extensions
    """
    chosen, firsts = learn(model, base)
    if not chosen:
        return None
    best = chosen[-1]
    gain = joined([gain_without(model, base, part) for part in held_out_parts(model)], model.evidence.windows)
    elements = tuple((each.element.name, each.place) for each in chosen)
    return LearntExtension(elements, best.extensions, best.fit, gain, fingerprint(model, base, firsts))


def gain_without(model: SetModel, base: SetFit, held: Booleans) -> PredictiveGain:
    """The gain on some data (W, F) of what is learnt from the others; no gain where nothing is learnt."""
    seen = np.flatnonzero(~held.all(axis=1))
    evidence = replace(model.evidence, used=model.evidence.used & ~held).subset(seen)
    training = SetModel(evidence, model.deviation)
    start = Point(base.point.shared, base.point.local[seen], base.point.sizes)
    chosen, _ = learn(training, fit_set(training, start))
    if not chosen:
        return NO_PREDICTIVE_GAIN
    point = _for_all(chosen[-1], seen, model.evidence.windows)
    return gain_on(model, held, (base.point, ()), (point, chosen[-1].extensions))


def joined(gains: Sequence[PredictiveGain], windows: int) -> PredictiveGain:
    """The gain per window of parts that are all data of some windows together.

    Parameters
    ----------
    gains : of the parts, each per window of its own, or of some frequencies of all windows
    """
    counts = np.array([gain.windows or windows for gain in gains], dtype=float)
    value = float(np.sum(counts * [gain.value for gain in gains])) / windows
    error = float(np.hypot.reduce(counts * [gain.error for gain in gains])) / windows
    return PredictiveGain(value, error, windows if windows > 1 else 0)


def _for_all(learnt: Candidate, seen: Indices, windows: int) -> Point:
    """Where the fit of an extension begins in all windows: those that it has not seen are like the others."""
    own = learnt.fit.point
    local = np.tile(np.median(own.local, axis=0), (windows, 1))
    local[seen] = own.local
    return Point(own.shared, local, own.sizes)

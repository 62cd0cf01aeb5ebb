"""The offer of a learnt extension: its gain on windows that it has not seen decides.

Elements, their number and their places are chosen on some of the windows; on the others, whose deviations from the set
base and extended model are fitted to alike, the difference of log scores is measured. The extension is offered where
the lower limit of that gain is above zero, fitted to all windows. Of a single window half of the frequencies are kept.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from drillid.arrays import Booleans
from drillid.discrepancy.inference.held_out_gain import gain_on
from drillid.discrepancy.inference.set_fit import SetFit, fit_set
from drillid.discrepancy.inference.set_model import Extension, Point, SetModel
from drillid.discrepancy.learning.fingerprint import Fingerprint, fingerprint
from drillid.discrepancy.learning.search import Candidate, learn
from drillid.discrepancy.predictive_gain import PredictiveGain

_EVERY = 3
"""Of so many windows one is held back."""


@dataclass(frozen=True, eq=False)
class LearntExtension:
    """An extension that was learnt, with its gain on data that it has not seen."""

    elements: tuple[tuple[str, float], ...]
    """Name and place of each element, in the order in which they were added."""
    extensions: tuple[Extension, ...]
    """Their terms."""
    fit: SetFit
    """To all windows."""
    gain: PredictiveGain
    """Per window, on data that was not used."""
    fingerprint: Fingerprint
    """Of what was found in the data that learning saw."""

    @property
    def offered(self) -> bool:
        """Whether the lower limit of the gain is above zero."""
        return self.gain.low > 0


def held_back(model: SetModel) -> Booleans:
    """Data (W, F) that learning does not see."""
    windows = model.evidence.windows
    held = np.zeros(model.evidence.used.shape, dtype=bool)
    if windows > 1:
        held[1::_EVERY] = True
    else:
        held[:, 1::2] = True
    return held


def learnt_extension(model: SetModel, base: SetFit) -> LearntExtension | None:
    """Learn what a model lacks; None where no element predicts better within the data that learning sees.

    Parameters
    ----------
    base : fit of the model without extensions to all windows
    """
    held = held_back(model)
    seen_rows = np.flatnonzero(~held.all(axis=1))
    evidence = replace(model.evidence, used=model.evidence.used & ~held).subset(seen_rows)
    training = SetModel(evidence, model.deviation)
    start = Point(base.point.shared, base.point.local[seen_rows], base.point.sizes)
    trained = fit_set(training, start)
    chosen, firsts = learn(training, trained)
    if not chosen:
        return None
    best = chosen[-1]
    fit = _on_all(model, base, best, seen_rows)
    gain = gain_on(model, held, (base.point, ()), (fit.point, best.extensions))
    elements = tuple((each.element.name, each.place) for each in chosen)
    return LearntExtension(elements, best.extensions, fit, gain, fingerprint(training, trained, firsts))


def _on_all(model: SetModel, base: SetFit, best: Candidate, seen_rows: np.ndarray) -> SetFit:
    """The chosen extension fitted to all windows."""
    local = np.tile(np.median(best.fit.point.local, axis=0), (model.evidence.windows, 1))
    local[seen_rows] = best.fit.point.local
    starts = [Point(best.fit.point.shared, local, best.fit.point.sizes)]
    starts.append(Point(base.point.shared, base.point.local, best.fit.point.sizes))
    return min((fit_set(model, start, best.extensions) for start in starts), key=lambda fit: fit.cost)

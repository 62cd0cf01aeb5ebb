"""What an extension is worth on data that it was not fitted to."""

from dataclasses import replace

import numpy as np

from drillid.arrays import Booleans, Complex
from drillid.discrepancy.inference.set_fit import fit_local, fit_set
from drillid.discrepancy.inference.set_model import Extension, Point, SetModel
from drillid.discrepancy.predictive_gain import PredictiveGain
from drillid.discrepancy.rules import NEIGHBOURS_SHARE_VARIANCE

_FOLDS = 4
_LEAST_WINDOWS = 2


def held_out_gain(
    model: SetModel, base: tuple[Point, tuple[Extension, ...]], extended: tuple[Point, tuple[Extension, ...]]
) -> PredictiveGain:
    """Fit base and extended model without some windows, then predict those.

    The figures that windows do not share are fitted to the held-out window, with the prior that ties them to the
    set, by both models alike. A single window is split into its even and odd frequencies. The responses of the
    control count beside the mobilities, and the data sheets' figures once for the set: a cause may show against them
    alone.
    """
    evidence = model.evidence
    windows = evidence.windows
    folds = min(windows, _FOLDS) if windows >= _LEAST_WINDOWS else 2
    before, after = np.zeros((2, windows, model.rows), dtype=complex)
    for fold in range(folds):
        held = np.zeros(evidence.used.shape, dtype=bool)
        if windows >= _LEAST_WINDOWS:
            held[fold::folds] = True
        else:
            held[:, fold::2] = True
        before += _residuals(model, held, *base)
        after += _residuals(model, held, *extended)
    pulls, fewer = (fit_set(model, *one).off_data_sheet for one in (base, extended))
    total = 0.5 * float(np.sum(np.abs(before) ** 2 - np.abs(after) ** 2) + np.sum(pulls**2 - fewer**2))
    # what two predictions differ by is known; the noise turns it into a gain with as much variance
    error = float(
        np.sqrt(NEIGHBOURS_SHARE_VARIANCE * np.sum(np.abs(before - after) ** 2) + np.sum((pulls - fewer) ** 2))
    )
    held_out = windows if windows >= _LEAST_WINDOWS else 0
    return PredictiveGain(total / windows, error / windows, held_out)


def trained_without(model: SetModel, held: Booleans, start: Point, extensions: tuple[Extension, ...]) -> Point:
    """Figures of the set without the held-out data (W, F); a window that is held out whole then has its own fitted.

    Damping and inertia at the bit and along the string are every window's own, and no other window tells them.
    """
    evidence = model.evidence
    training = model.with_evidence(replace(evidence, used=evidence.used & ~held))
    trained = fit_set(training, start, extensions).point
    unseen = np.asarray(held.all(axis=1), dtype=bool)
    if not unseen.any():
        return trained
    # windows are alike: what is left to one begins where the others are
    local = np.where(unseen[:, None], np.median(trained.local[~unseen], axis=0), trained.local)
    return fit_local(model, replace(trained, local=local), extensions)


def _residuals(model: SetModel, held: Booleans, start: Point, extensions: tuple[Extension, ...]) -> Complex:
    """Whitened errors of predicting the held-out rows; zero elsewhere, (W, rows)."""
    residual = model.residual(trained_without(model, held, start, extensions), extensions)
    rows = held & model.evidence.used
    if model.control_weight is not None:
        rows = np.concatenate([rows, rows[:, model.control_weight.any(axis=0)]], axis=1)
    return np.where(rows, residual, 0.0)

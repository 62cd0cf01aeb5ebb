"""Predictive gain of an extension on data that it was not fitted to, by cross-validation."""

from dataclasses import replace

import numpy as np

from drillid.arrays import Booleans, Complex
from drillid.discrepancy.inference.coordinates import Extension, Point
from drillid.discrepancy.inference.set_fit import fit_local, fit_set
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.predictive_gain import PredictiveGain
from drillid.discrepancy.rules import NEIGHBOURS_SHARE_VARIANCE

_FOLDS = 4
_LEAST_WINDOWS = 2


def held_out_gain(
    model: SetModel, base: tuple[Point, tuple[Extension, ...]], extended: tuple[Point, tuple[Extension, ...]]
) -> PredictiveGain:
    """Fit base and extended model without some windows, then predict those.

    The coordinates that windows do not share are fitted to the held-out window, with the prior that ties them to the
    set, by both models alike. Of a single window every other frequency is held out, then the rest. The responses of
    the control count as well as the mobilities, and so do the parameters that data sheets state once for the set: a
    cause may show only as a deviation from these.

    Parameters
    ----------
    base, extended : start of the fit and extensions of each model
    """
    evidence = model.evidence
    windows = evidence.windows
    folds = min(windows, _FOLDS) if windows >= _LEAST_WINDOWS else 2
    before, after = np.zeros((2, windows, model.measured.count), dtype=complex)
    for fold in range(folds):
        held = np.zeros(evidence.used.shape, dtype=bool)
        if windows >= _LEAST_WINDOWS:
            held[fold::folds] = True
        else:
            held |= every_other_line(evidence.used, fold)
        before += _residuals(model, held, *base)
        after += _residuals(model, held, *extended)
    pulls_before, pulls_after = (fit_set(model, *variant).pulls for variant in (base, extended))
    total = 0.5 * float(np.sum(np.abs(before) ** 2 - np.abs(after) ** 2) + np.sum(pulls_before**2 - pulls_after**2))
    # given the difference of two predictions the gain is linear in the noise; its variance is that difference squared
    error = float(
        np.sqrt(
            NEIGHBOURS_SHARE_VARIANCE * np.sum(np.abs(before - after) ** 2) + np.sum((pulls_before - pulls_after) ** 2)
        )
    )
    held_out = windows if windows >= _LEAST_WINDOWS else 0
    return PredictiveGain(total / windows, error / windows, held_out)


def every_other_line(used: Booleans, first: int = 0) -> Booleans:
    """Every other line (W, F) of those that are used, from the first or second on: a sweep of odd harmonics has no even
    ones.
    """
    rank = np.cumsum(used, axis=1) - 1
    return np.asarray(used & (rank % 2 == first), dtype=bool)


def gain_on(
    model: SetModel,
    held: Booleans,
    base: tuple[Point, tuple[Extension, ...]],
    extended: tuple[Point, tuple[Extension, ...]],
) -> PredictiveGain:
    """The gain on some data (W, F), by the responses alone; `base` and `extended` as in `held_out_gain`.

    It is given per held-out window, or per window of the set where only some frequencies are held out.
    """
    before, after = _residuals(model, held, *base), _residuals(model, held, *extended)
    total = 0.5 * float(np.sum(np.abs(before) ** 2 - np.abs(after) ** 2))
    error = float(np.sqrt(NEIGHBOURS_SHARE_VARIANCE * np.sum(np.abs(before - after) ** 2)))
    windows = int(np.count_nonzero(held.all(axis=1)))
    count = windows or model.evidence.windows
    return PredictiveGain(total / count, error / count, windows)


def trained_without(model: SetModel, held: Booleans, start: Point, extensions: tuple[Extension, ...]) -> Point:
    """Fit of the set without the held-out data (W, F); windows held out entirely then have their deviations fitted.

    Damping and inertia at the bit and along the string vary from window to window, and other windows do not determine
    them.
    """
    evidence = model.evidence
    training = model.with_evidence(replace(evidence, used=evidence.used & ~held))
    trained = fit_set(training, start, extensions).point
    unseen = np.asarray(held.all(axis=1), dtype=bool)
    if not unseen.any():
        return trained
    # windows are similar: the fit of a held-out one starts from the median of the others
    local = np.where(unseen[:, None], np.median(trained.local[~unseen], axis=0), trained.local)
    return fit_local(model, replace(trained, local=local), extensions, np.flatnonzero(unseen))


def _residuals(model: SetModel, held: Booleans, start: Point, extensions: tuple[Extension, ...]) -> Complex:
    """Whitened prediction errors of the held-out rows, zero elsewhere; (W, rows)."""
    residual = model.residual(trained_without(model, held, start, extensions), extensions)
    rows = held & model.evidence.used
    if model.measured.control_weight is not None:
        rows = np.concatenate([rows, rows[:, model.measured.control_weight.any(axis=0)]], axis=1)
    return np.where(rows, residual, 0.0)

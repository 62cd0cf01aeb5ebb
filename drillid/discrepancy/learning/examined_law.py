"""An examination with a law of the bit, learnt in time where its verdict is unknown and nothing linear is offered."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from drillid.arrays import Floats
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.learning.law import MOST_WINDOWS, LawWindow, learnt_law
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.verdict import UNKNOWN
from drillid.errors import SettingsError
from drillid.physics.equipment import of_window
from drillid.spectra.periodic import sweep_period

_HARMONICS, _HIGHEST_SHARE = 2.0, 0.3
"""Highest frequency at which a law is compared, per highest one of the responses, and per rate of the samples."""


def with_law(examination: Examination, channels: Callable[[int], tuple[Floats, Floats]], rate: float) -> Examination:
    """The examination with a law of the bit, where the verdict is unknown and no linear extension is offered.

    Parameters
    ----------
    channels : sweep (N m) and speed (rad/s) of a window, (samples,) each
    rate : Hz
    """
    if examination.extensions or not any(verdict.verdict == UNKNOWN for verdict in examination.verdicts):
        return examination
    windows = law_windows(examination.model, examination.base, channels, rate)
    try:
        law = learnt_law(windows) if windows else None
    except SettingsError:
        # a rig that the simulator cannot divide into elements, such as one with a very short section, has no law
        return examination
    if law is None or not law.offered:
        return examination
    verdicts = tuple(
        replace(
            verdict,
            predictive_gain=law.gain.value,
            predictive_gain_low=law.gain.low,
            predictive_gain_high=law.gain.high,
            held_out_windows=law.gain.windows,
            evidence=f"{verdict.evidence}; learnt: {law.words}",
        )
        if verdict.verdict == UNKNOWN
        else verdict
        for verdict in examination.verdicts
    )
    return replace(examination, verdicts=verdicts, law=law)


def law_windows(
    model: SetModel, base: SetFit, channels: Callable[[int], tuple[Floats, Floats]], rate: float
) -> list[LawWindow]:
    """Windows of a set from which a law can be learnt, at most MOST_WINDOWS; `channels` and `rate` as in `with_law`."""
    window_model, evidence = model.window_model_at(base.point), model.evidence
    chosen = np.unique(np.linspace(0, evidence.windows - 1, MOST_WINDOWS).round().astype(int))
    found = []
    for row in chosen.tolist():
        sweep, speed = channels(row)
        used = evidence.frequency[model.weight[row] > 0]
        if not used.size or not (np.isfinite(sweep).all() and np.isfinite(speed).all()):
            continue
        period = sweep_period(sweep, rate, float(evidence.frequency[0]))
        band = float(used.min()), min(_HARMONICS * float(used.max()), _HIGHEST_SHARE * rate)
        own = of_window(window_model, (row,), (evidence.windows,))
        found.append(LawWindow.of(own, (sweep, speed), rate, period, band))
    return [window for window in found if window is not None]

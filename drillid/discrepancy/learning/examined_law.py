"""An examination with a law that is learnt in time, where its verdict is unknown and nothing linear is offered, or
where the linear responses show nothing and the harmonics of the sweep's period do.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from drillid.arrays import Floats
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.learning.law import MOST_WINDOWS, LearntLaw, learnt_law
from drillid.discrepancy.learning.law_kinds import law_p_value
from drillid.discrepancy.learning.law_window import LawWindow
from drillid.discrepancy.rules import LAW_SHARE
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.verdict import NONE, UNKNOWN, Verdict, calibrated
from drillid.errors import SettingsError
from drillid.physics.equipment import of_window
from drillid.spectra.periodic import sweep_period

_HARMONICS, _HIGHEST_SHARE = 2.0, 0.3
"""Highest frequency at which a law is compared, per highest one of the responses, and per rate of the samples."""


def with_law(
    examination: Examination, channels: Callable[[int], tuple[Floats, Floats]], rate: float, error_rate: float = 0.05
) -> Examination:
    """The examination with a law, where the verdict is unknown and no linear extension is offered; a verdict none
    becomes unknown where a law is offered that surely shows.

    Parameters
    ----------
    channels : sweep (N m) and speed (rad/s) of a window, (samples,) each
    rate : Hz
    error_rate : chance that a set in which nothing is wrong gets another verdict than none
    """
    verdicts = {verdict.verdict for verdict in examination.verdicts}
    if examination.extensions or not verdicts.intersection((NONE, UNKNOWN)):
        return examination
    windows = law_windows(examination.model, examination.base, channels, rate)
    if not windows:
        return examination
    p_value = law_p_value(windows)
    if UNKNOWN not in verdicts and p_value >= error_rate * LAW_SHARE:
        return examination
    try:
        law = learnt_law(windows)
    except SettingsError:
        # a rig that the simulator cannot divide into elements, such as one with a very short section, has no law
        return examination
    if not law.offered:
        return examination
    told = tuple(_told(examination, verdict, law, p_value) for verdict in examination.verdicts)
    return replace(examination, verdicts=told, law=law, fingerprint=law.fingerprint)


def _told(examination: Examination, verdict: Verdict, law: LearntLaw, p_value: float) -> Verdict:
    """The verdict with the law, where it is unknown or none."""
    if verdict.verdict == NONE:
        unknown = Verdict(
            UNKNOWN,
            law.kind.family,
            examination.base_rates.probability([UNKNOWN], law.evidence),
            verdict.from_m,
            verdict.to_m,
            evidence_nats=law.evidence,
            evidence=f"harmonics of the sweep's period, p-value {p_value:.2g} where all is linear",
        )
        verdict = calibrated(unknown)
    if verdict.verdict != UNKNOWN:
        return verdict
    return replace(
        verdict,
        predictive_gain=law.gain.value,
        predictive_gain_low=law.gain.low,
        predictive_gain_high=law.gain.high,
        held_out_windows=law.gain.windows,
        evidence=f"{verdict.evidence}; learnt: {law.words}",
    )


def law_windows(
    model: SetModel, base: SetFit, channels: Callable[[int], tuple[Floats, Floats]], rate: float
) -> list[LawWindow]:
    """Windows of a set from which a law can be learnt, at most MOST_WINDOWS; `channels` and `rate` as in `with_law`."""
    chosen = np.unique(np.linspace(0, model.evidence.windows - 1, MOST_WINDOWS).round().astype(int))
    found = [law_window(model, base, row, channels, rate) for row in chosen.tolist()]
    return [window for window in found if window is not None]


def law_window(
    model: SetModel, base: SetFit, row: int, channels: Callable[[int], tuple[Floats, Floats]], rate: float
) -> LawWindow | None:
    """One window of a set; None where its sweep does not repeat, or nothing of it is used."""
    evidence = model.evidence
    sweep, speed = channels(row)
    used = evidence.frequency[model.weight[row] > 0]
    if not used.size or not (np.isfinite(sweep).all() and np.isfinite(speed).all()):
        return None
    period = sweep_period(sweep, rate, float(evidence.frequency[0]))
    band = float(used.min()), min(_HARMONICS * float(used.max()), _HIGHEST_SHARE * rate)
    own = of_window(model.window_model_at(base.point), (row,), (evidence.windows,))
    torque = float(np.nan_to_num(evidence.operating_points.torque[row]))
    return LawWindow.of(own, (sweep, speed), rate, period, band, torque, row)

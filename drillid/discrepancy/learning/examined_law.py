"""An examination with a law that is learnt in time, where its verdict is unknown, or where the harmonics of the sweep's
period show what its model lacks.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from drillid.arrays import Floats
from drillid.discrepancy.inference.most_mass import of_most_mass
from drillid.discrepancy.learning.examined import with_learnt
from drillid.discrepancy.learning.law import MOST_WINDOWS, LearntLaw, learnt_law
from drillid.discrepancy.learning.law_kinds import law_p_value
from drillid.discrepancy.learning.law_window import TIME_STEP, LawWindow
from drillid.discrepancy.rules import EVEN_ODDS, LAW_SHARE
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.verdict import LEARNT, NONE, UNKNOWN, Verdict, calibrated
from drillid.errors import SettingsError
from drillid.physics.equipment import of_window
from drillid.simulation.short_sections import with_short_sections_extended
from drillid.spectra.period import sweep_period

_HARMONICS, _HIGHEST_SHARE = 2.0, 0.3
"""Highest frequency at which a law is compared, per highest one of the responses, and per rate of the samples."""


def with_linear_or_law(
    examination: Examination, channels: Callable[[int], tuple[Floats, Floats]], rate: float, error_rate: float = 0.05
) -> Examination:
    """The examination with a linear extension that was learnt, or with a law: where a law surely shows, and surely
    predicts more, it takes the place of the former. Parameters as of `with_law`.
    """
    linear = with_learnt(examination)
    if linear.fingerprint is None:
        return with_law(examination, channels, rate, error_rate)
    told = with_law(examination, channels, rate, error_rate, surely=True)
    gain = max(verdict.predictive_gain for verdict in linear.verdicts if verdict.verdict == UNKNOWN)
    if told.law is not None and told.law.gain.low > gain:
        return told
    return replace(linear, law_p_value=told.law_p_value)


def with_law(
    examination: Examination,
    channels: Callable[[int], tuple[Floats, Floats]],
    rate: float,
    error_rate: float = 0.05,
    *,
    surely: bool = False,
) -> Examination:
    """The examination with a law beside its extended model, where the verdict is unknown, or where a law surely shows
    and is likelier than none: a verdict none becomes unknown, and a named cause gets a verdict unknown beside it.

    Parameters
    ----------
    channels : sweep (N m) and speed (rad/s) of a window, (samples,) each
    rate : Hz
    error_rate : chance that a set in which nothing is wrong gets another verdict than none
    surely : learn it only where it surely shows
    """
    windows = law_windows(examination, channels, rate)
    if not windows:
        return examination
    p_value = law_p_value(windows)
    examination = replace(examination, law_p_value=p_value)
    is_unknown = any(verdict.verdict == UNKNOWN for verdict in examination.verdicts)
    if (surely or not is_unknown) and p_value >= error_rate * LAW_SHARE:
        return examination
    try:
        law = learnt_law(windows)
    except SettingsError:
        # a rig that the simulator cannot divide into elements, such as one with a very stiff spring, has no law
        return examination
    if not law.offered:
        return examination
    verdicts = tuple(verdict for verdict in examination.verdicts if verdict.verdict != NONE)
    if not is_unknown:
        unknown = _unknown(examination, law, p_value)
        if unknown.probability < EVEN_ODDS:
            return examination
        verdicts = (*verdicts, unknown)
    told = tuple(_with_gain(verdict, law) if verdict.verdict == UNKNOWN else verdict for verdict in verdicts)
    return replace(examination, verdicts=told, law=law, fingerprint=law.fingerprint)


def _unknown(examination: Examination, law: LearntLaw, p_value: float) -> Verdict:
    """The verdict on a law where the linear responses show nothing unknown."""
    depth = examination.model.evidence.operating_points.hole_depth
    verdict = Verdict(
        UNKNOWN,
        law.kind.family,
        examination.base_rates.probability([UNKNOWN], law.evidence),
        float(depth.min()),
        float(depth.max()),
        evidence_nats=law.evidence,
        evidence=f"harmonics of the sweep's period, p-value {p_value:.2g} where all is linear",
    )
    return calibrated(verdict)


def _with_gain(verdict: Verdict, law: LearntLaw) -> Verdict:
    return replace(
        verdict,
        predictive_gain=law.gain.value,
        predictive_gain_low=law.gain.low,
        predictive_gain_high=law.gain.high,
        held_out_windows=law.gain.windows,
        evidence=f"{verdict.evidence}{LEARNT}{law.words}",
    )


def law_windows(
    examination: Examination, channels: Callable[[int], tuple[Floats, Floats]], rate: float
) -> list[LawWindow]:
    """Windows of a set from which a law can be learnt, at most MOST_WINDOWS; `channels` and `rate` as in `with_law`."""
    last = examination.model.evidence.windows - 1
    chosen = np.unique(np.linspace(0, last, MOST_WINDOWS).round().astype(int))
    # a resonance that follows the noise of single lines would answer the sweep as no law does
    mass = of_most_mass(examination.model, examination.extended, examination.extensions)
    settled = replace(examination, extended=replace(examination.extended, point=mass))
    found = [law_window(settled, row, channels, rate) for row in chosen.tolist()]
    return [window for window in found if window is not None]


def law_window(
    examination: Examination, row: int, channels: Callable[[int], tuple[Floats, Floats]], rate: float
) -> LawWindow | None:
    """One window of a set by its extended model; None where its sweep does not repeat, or nothing of it is used."""
    model, evidence = examination.model, examination.model.evidence
    sweep, speed = channels(row)
    used = evidence.frequency[model.measured.weight[row] > 0]
    if not used.size or not (np.isfinite(sweep).all() and np.isfinite(speed).all()):
        return None
    period = sweep_period(sweep, rate, float(evidence.frequency[0]))
    band = float(used.min()), min(_HARMONICS * float(used.max()), _HIGHEST_SHARE * rate)
    whole = model.window_model_at(examination.extended.point, examination.extensions)
    own = of_window(whole, (row,), (evidence.windows,))
    own = replace(own, system=with_short_sections_extended(own.system, TIME_STEP))
    torque = float(np.nan_to_num(evidence.operating_points.torque[row]))
    return LawWindow.of(own, (sweep, speed), rate, period, band, torque, row)

"""The engine: from a set of windows to verdicts."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import expit, logsumexp

from drillid.discrepancy.catalogue import CATALOGUE, SYMPTOMS, Cause
from drillid.discrepancy.detectors.pooling import pool
from drillid.discrepancy.evidence import Evidence
from drillid.discrepancy.inference.screen import screen
from drillid.discrepancy.inference.set_fit import fit_set, with_own_deviation, without_outlier_windows
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.rules import DETECTIONS_SHARE, EVEN_ODDS, RESPONSES_SHARE
from drillid.discrepancy.verdicts.examination import Examination, nameless, unextended
from drillid.discrepancy.verdicts.from_detections import with_detections
from drillid.discrepancy.verdicts.from_responses import base_model_rejected, explained
from drillid.discrepancy.verdicts.verdict import NONE, Verdict, calibrated
from drillid.errors import EstimationError


def examine(
    evidence: Evidence, *, catalogue: Sequence[Cause] | None = None, error_rate: float = 0.05, seed: int = 0
) -> Examination:
    """Show, name, extend and measure.

    Parameters
    ----------
    evidence : a set of windows
    catalogue : causes that may be named; all where not given
    error_rate : chance that a set in which nothing is wrong gets another verdict than none
    seed : of the draws that give p-values

    Raises
    ------
    EstimationError
        If no window has a fit of its own.
    """
    if not np.isfinite(evidence.fitted).all(axis=1).any():
        raise EstimationError(
            "evidence",
            "no window has a fit of its own",
            "Take windows in which more passes the coherence gate",
        )
    causes = list(CATALOGUE.values()) if catalogue is None else list(catalogue)
    model = SetModel(evidence)
    base = min((fit_set(model, start) for start in (model.start(), model.expected())), key=lambda one: one.cost)
    model, base = with_own_deviation(model, base)
    base = without_outlier_windows(model, base)
    generator = np.random.default_rng(seed)
    before = screen(model, base, (), causes, generator)
    names = {*(cause.name for cause in causes), *SYMPTOMS}
    detections = tuple(one for one in pool(evidence.detections) if one.cause in names)
    examination = Examination((), model, base, base, (), before, before, None, detections)
    if before.p_value < error_rate * RESPONSES_SHARE or base_model_rejected(model, base):
        examination = explained(examination, causes, generator)
    found = [one for one in detections if one.p_value < error_rate * DETECTIONS_SHARE / len(detections)]
    return _at_even_odds(with_detections(examination, found, error_rate))


def _at_even_odds(examination: Examination) -> Examination:
    """Verdicts with calibrated probabilities; names that are likelier wrong than right are not given."""
    told = examination.verdicts or (_none(examination),)
    verdicts = tuple(calibrated(one) for one in told)
    # the line of names is known from even odds of the posterior on
    kept = tuple(
        one
        for one, before in zip(verdicts, told, strict=True)
        if not one.members or min(one.probability, before.probability) >= EVEN_ODDS
    )
    if kept:
        return replace(examination, verdicts=kept)
    unknown = nameless(max(told, key=lambda one: one.probability), "it is likelier something else, or nothing")
    return replace(unextended(examination), verdicts=(calibrated(unknown),))


def _none(examination: Examination) -> Verdict:
    """Nothing, with its posterior at even odds that something is wrong."""
    operating_points, before = examination.model.evidence.operating_points, examination.before
    logs = [*before.by_cause.values(), before.unknown_evidence, *(one.log_evidence for one in examination.detections)]
    odds = float(logsumexp(logs) - np.log(len(logs)))
    return Verdict(
        verdict=NONE,
        family="",
        probability=float(expit(-odds)),
        from_m=float(operating_points.hole_depth.min()),
        to_m=float(operating_points.hole_depth.max()),
        evidence=f"p-value {before.p_value:.2g} of so much misfit where nothing is wrong",
    )

"""Detections of changes in time: first by the derivative of the response, then along the course of a parameter."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.special import ndtr

from drillid.discrepancy.detectors.course import CHANGES, ChangingWindow, jump, separation
from drillid.discrepancy.detectors.detector import Detector, Inspection
from drillid.discrepancy.detectors.residual_record import ResidualRecord
from drillid.discrepancy.detectors.score import Candidate, Score, normal_of_p_value, score, whitened
from drillid.discrepancy.rules import CHANGE_FOLLOWED
from drillid.physics.parameters import DAMPING_BHA, DELAY, INERTIA_TD, LENGTH

_MOVING = (LENGTH, DELAY, INERTIA_TD, DAMPING_BHA)
"""Parameters of the model that may change linearly in time, whatever the cause."""


class ChangeDetector(Detector):
    """A parameter of the model that changes linearly over the window, or jumps at one moment.

    Parameters
    ----------
    parameter : its index among the eight
    jumps : whether it jumps, instead of changing linearly
    one_sided : whether it can only grow
    """

    needs_periods = True
    accuracy = 0.05

    def __init__(self, parameter: int, *, jumps: bool = False, one_sided: bool = False) -> None:
        self.parameter, self.jumps, self.one_sided = parameter, jumps, one_sided

    def candidate(self, name: str, inspection: Inspection) -> Candidate:
        """Derivative of the response with respect to the parameter, times the parameter's change so far."""
        residual = inspection.residual
        derivative = residual.response_to_sweep(residual.derivatives[self.parameter])
        duration = residual.samples / residual.record.rate
        change = jump(residual.elapsed, duration, CHANGES) if self.jumps else (residual.elapsed - 0.5)[None]
        return Candidate(name, change * derivative, one_sided=self.one_sided)

    @classmethod
    def reviewed(
        cls, detectors: Mapping[str, Detector], scores: dict[str, Score], inspection: Inspection
    ) -> dict[str, Score]:
        """Scores, sizes and errors of apparent changes, from a fit of the whole course.

        Among causes that change the same parameter, the one whose course fits best gets the best score, by that fit
        or by the derivative, and the others are lower by the difference of their fits.
        """
        own = {name: detector for name, detector in detectors.items() if isinstance(detector, ChangeDetector)}
        for parameter in dict.fromkeys(detector.parameter for detector in own.values()):
            sharing = {name: detector for name, detector in own.items() if detector.parameter == parameter}
            scores = scores | _followed(parameter, sharing, scores, inspection.residual)
        return scores


class TrendDetector(Detector):
    """A response to the sweep that changes linearly in time, whichever parameters of the model cause it."""

    needs_periods = True

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Joint score of trends in all those parameters."""
        residual = inspection.residual
        derivatives = residual.response_to_sweep(residual.derivatives[list(_MOVING)])
        trend = Candidate(name, (residual.elapsed - 0.5) * derivatives, together=True)
        return score(whitened(trend, residual), residual.error, residual)


def _followed(
    parameter: int, detectors: Mapping[str, ChangeDetector], scores: dict[str, Score], residual: ResidualRecord
) -> dict[str, Score]:
    """Scores of the causes that change one parameter, by their courses; none where no such change is apparent."""
    best = max((scores[name] for name in detectors), key=lambda candidate: candidate.normal)
    if best.normal < CHANGE_FOLLOWED:
        return {}
    window = ChangingWindow(parameter, residual)
    courses = {name: window.course(scores[name], jumps=detector.jumps) for name, detector in detectors.items()}
    nearest = min(courses.values(), key=lambda course: course.penalised_cost)
    apart = separation(list(courses.values()))
    # a free course has several optima, one near each of the others
    free = min(window.free_cost(course) for course in courses.values())
    # the best of several tests: one of each cause, and one of the course
    largest, log_ratio = max(best.normal, nearest.normal), max(best.log_ratio, nearest.gain)
    normal = normal_of_p_value(min((len(detectors) + 1) * float(ndtr(-largest)), 1.0))
    return {
        name: replace(
            scores[name],
            normal=float(np.sqrt(max(normal**2 - 2 * (course.penalised_cost - nearest.penalised_cost), 0.0))),
            log_ratio=max(log_ratio - (course.penalised_cost - nearest.penalised_cost), 0.0),
            size=course.size,
            size_error=course.size_error,
            misfit=course.misfit_against(free),
            separation=apart,
        )
        for name, course in courses.items()
    }

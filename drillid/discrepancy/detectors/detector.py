"""What a detector is: a small class that looks in one window's record for what its linear response does not show.

Some detectors know what their cause would add to the speed. These compete: the strongest is taken out of the record
before the others are judged. The others test the record by themselves, after that competition.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, ClassVar, TypeVar

import numpy as np

from drillid.arrays import Floats
from drillid.discrepancy.detectors.residual_record import ResidualRecord
from drillid.discrepancy.detectors.score import Candidate, Score
from drillid.discrepancy.rules import CLEAR_DETECTION

Result = TypeVar("Result")


class Inspection:
    """One window's residual record, and what has been computed from it and detected in it so far."""

    def __init__(self, residual: ResidualRecord) -> None:
        self.residual = residual
        self.scores: dict[str, Score] = {}
        """By the name of the cause or symptom."""
        self.explained: Floats = np.zeros(residual.samples)
        """(samples,) rad/s, speed that the clearly detected candidates account for."""
        self._computed: dict[Callable[[ResidualRecord], Any], Any] = {}

    def once(self, compute: Callable[[ResidualRecord], Result]) -> Result:
        """What a function gives of the residual record, computed once for all detectors that need it."""
        if compute not in self._computed:
            self._computed[compute] = compute(self.residual)
        result: Result = self._computed[compute]
        return result

    def clearly_detected(self, name: str) -> bool:
        """Whether a cause or symptom stands out so clearly that others are judged beside it."""
        return name in self.scores and is_clear(self.scores[name])

    @cached_property
    def unexplained(self) -> Floats:
        """(samples,) rad/s, what neither the sweep nor a clearly detected candidate accounts for."""
        return self.residual.left - self.residual.without_sweep(self.explained)


class Detector:
    """Looks for one cause or symptom; it is an attribute of that cause's class, which gives it its name."""

    needs_command: ClassVar[bool] = False
    """Whether it needs the logged torque command."""
    needs_periods: ClassVar[bool] = False
    """Whether it needs a sweep that repeats within the window."""
    excluded_by: ClassVar[tuple[str, ...]] = ()
    """Causes and symptoms that, clearly detected, account for what it would see."""

    def can_inspect(self, residual: ResidualRecord) -> bool:
        """Whether the record has what the detector needs."""
        return (residual.record.has_command or not self.needs_command) and bool(
            residual.periods or not self.needs_periods
        )

    def candidate(self, name: str, inspection: Inspection) -> Candidate | None:
        """What the cause would add to the speed; None where the detector does not compete."""
        return None

    @classmethod
    def reviewed(
        cls, detectors: Mapping[str, Detector], scores: dict[str, Score], inspection: Inspection
    ) -> dict[str, Score]:
        """Scores after the competition, with those of detectors of this class looked at once more.

        Parameters
        ----------
        detectors : those of this class that have a score, by name
        scores : of all that competed
        """
        return scores

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Score by a test of its own after the competition; None where the record does not allow one."""
        return None


def is_clear(score: Score) -> bool:
    """Whether a score is so large that other causes are judged beside this one."""
    return score.normal >= CLEAR_DETECTION

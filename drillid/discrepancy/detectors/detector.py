"""The interface of detectors: small classes that test a window's record for effects its linear response does not show.

Detectors that can predict what their cause adds to the speed offer it as a candidate. Candidates compete: the strongest
is subtracted from the record before the others are scored. The other detectors run tests of their own afterwards.
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
    """One window's residual record with the intermediate results and scores obtained so far."""

    def __init__(self, residual: ResidualRecord, logged: ResidualRecord | None = None) -> None:
        self.residual = residual
        self.logged = residual if logged is None else logged
        """Residual record of the rows as they are logged, where `residual` is that of the samples that they hold."""
        self.scores: dict[str, Score] = {}
        """Scores by the name of the cause or symptom."""
        self.explained: Floats = np.zeros(residual.samples)
        """(samples,) rad/s, speed explained by the clearly detected candidates."""
        self._cache: dict[Callable[[ResidualRecord], Any], Any] = {}

    def cached(self, compute: Callable[[ResidualRecord], Result]) -> Result:
        """Value of a function of the residual record, computed once for all detectors that need it."""
        if compute not in self._cache:
            self._cache[compute] = compute(self.residual)
        result: Result = self._cache[compute]
        return result

    def clearly_detected(self, name: str) -> bool:
        """Whether a cause or symptom is detected so clearly that others are scored conditionally on it."""
        return name in self.scores and is_clear(self.scores[name])

    @cached_property
    def unexplained(self) -> Floats:
        """(samples,) rad/s, speed explained by neither the sweep nor a clearly detected candidate."""
        return self.residual.speed_residual - self.residual.without_sweep(self.explained)


class Detector:
    """Test for one cause or symptom; an attribute of that cause's class, which gives it its name."""

    needs_command: ClassVar[bool] = False
    """Whether it needs the logged torque command."""
    needs_periods: ClassVar[bool] = False
    """Whether it needs a sweep that repeats within the window."""
    excluded_by: ClassVar[tuple[str, ...]] = ()
    """Causes and symptoms that, where clearly detected, explain whatever it would find."""
    accuracy: ClassVar[float] = 0.0
    """Relative standard uncertainty of sizes that all windows have in common: that of the model by which they are read
    off the record, as sizes deviate in simulated rigs of little noise."""
    least_shown: ClassVar[float] = 1.0
    """Least share of a cause's size that its detection may show, where the law that the cause follows is not known."""
    acts_beyond: ClassVar[bool] = False
    """Whether the cause acts only beyond its size, as a limit does: a window that does not reach it tells no size."""
    least: ClassVar[float] = 0.0
    """Size that any rig may have: a smaller one is no cause, however surely many windows show it."""

    def can_inspect(self, residual: ResidualRecord) -> bool:
        """Whether the record has what the detector needs."""
        return (residual.record.has_command or not self.needs_command) and bool(
            residual.periods or not self.needs_periods
        )

    def candidate(self, name: str, inspection: Inspection) -> Candidate | None:
        """Speed that the cause would add; None where the detector does not take part in the competition."""
        return None

    @classmethod
    def reviewed(
        cls, detectors: Mapping[str, Detector], scores: dict[str, Score], inspection: Inspection
    ) -> dict[str, Score]:
        """Scores after the competition, with those of this class's detectors reviewed.

        Parameters
        ----------
        detectors : detectors of this class that have a score, by name
        scores : of all candidates
        """
        return scores

    def score(self, name: str, inspection: Inspection) -> Score | None:
        """Score by a separate test after the competition; None where the record does not allow one."""
        return None


def is_clear(score: Score) -> bool:
    """Whether a score is so large that other causes are scored conditionally on this one."""
    return score.normal >= CLEAR_DETECTION

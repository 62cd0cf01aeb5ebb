"""A bit that stands in a limit cycle is told by its swing where its time at standstill is blurred: the second world."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.blind import world
from benchmarks.blind.draw import draw
from benchmarks.blind.engines import evidence_of
from benchmarks.blind.other_world.cases import simulated
from benchmarks.blind.world import WORLDS

STICKING, SWINGING = 200438, 210019
"""Seeds of a bit that sticks and slips, and of one that swings without."""


@pytest.mark.parametrize(("seed", "stands"), [(STICKING, True), (SWINGING, False)])
def test_a_bit_that_would_turn_backward_stands(
    seed: int, stands: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(world, "FOLDER", tmp_path)
    case = draw(seed, world=WORLDS["other"])
    case = replace(case, segments=case.segments[:1])
    assert (simulated(case, 0)["standing"] > 0.1) == stands
    scores = [each.score for each in evidence_of(case).detections if each.cause == "stuck_slip_regimes"]
    assert (max(scores, default=-np.inf) > 4) == stands

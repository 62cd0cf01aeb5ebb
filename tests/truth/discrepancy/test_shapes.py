"""What the shape of an effect leaves is no second cause: a wide zone with smooth ends, from the second world."""

from pathlib import Path

import pytest

from benchmarks.blind import world
from benchmarks.blind.draw import obvious
from benchmarks.blind.engines import evidence_of
from benchmarks.blind.other_world.effects_string import zone
from benchmarks.blind.vocabulary import ERROR_RATE
from benchmarks.blind.world import WORLDS
from drillid.discrepancy.verdicts.engine import examine


def test_a_wide_zone_has_its_size_width_and_place(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(world, "FOLDER", tmp_path)
    case = obvious(50002, "local_damping_zone", 1, 25.0, WORLDS["other"])
    middle, width, _ = zone(case.context(case.hidden[0]))
    pipe = case.segments[0].pipe_length
    found = examine(evidence_of(case), error_rate=ERROR_RATE, seed=case.seed)
    (verdict,) = found.verdicts
    assert verdict.verdict == "local_damping_zone"
    assert verdict.size_low < case.hidden[0].size < verdict.size_high
    assert verdict.location_m == pytest.approx(middle, abs=0.05 * pipe)
    fitted = found.extensions[0].cause.shaped(found.extended.point.shapes[0]).width
    assert fitted == pytest.approx(width / pipe, rel=0.3)

"""What the shape of an effect leaves is no second cause, in the second world: a zone with smooth ends, any section."""

from pathlib import Path

import pytest

from benchmarks.blind import world
from benchmarks.blind.draw import obvious
from benchmarks.blind.engines import evidence_of
from benchmarks.blind.other_world.effects_string import section_moment, zone
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


def test_a_section_of_heavier_pipe_has_its_length_and_moment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(world, "FOLDER", tmp_path)
    case = obvious(50003, "extra_section", 1, 25.0, WORLDS["other"])
    found = examine(evidence_of(case), error_rate=ERROR_RATE, seed=case.seed)
    (verdict,) = found.verdicts
    assert "extra_section" in verdict.members
    assert found.posterior is not None
    section = next(each for each in found.posterior.fitted_causes if each.name == "extra_section")
    assert section.fit.point.sizes[0] == pytest.approx(case.hidden[0].size, abs=3 * float(section.fit.size_errors[0]))
    fitted = section.extension.cause.shaped(section.fit.point.shapes[0]).heavier
    assert fitted == pytest.approx(section_moment(case.hidden[0].shape), rel=0.3)

"""The field well's log: the authors' own misses come out as published, and ours are held."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.field import DATA, JITTER, LADDER, jittered_scores, table, write
from drillid.field_well import FieldLog, read_field_log, score


@pytest.fixture(scope="module")
def log() -> FieldLog:
    if not DATA.is_file():
        pytest.skip(f"the field log is not at {DATA}")
    return read_field_log(DATA)


def test_the_scores_are_the_authors_own_scores(log: FieldLog) -> None:
    authors = score(log, log.authors_torque, log.authors_bit_speed)
    assert authors.torque_rms == pytest.approx(3.79, abs=0.01)
    assert authors.bit_rms == pytest.approx(41.8, abs=0.05)


def test_each_part_of_the_model_gains_also_when_friction_is_a_little_off(log: FieldLog) -> None:
    misses = [np.mean((jittered_scores(friction, log)[:, :2] / (1.9, 21.0)) ** 2) for friction, _ in LADDER.values()]
    assert np.all(np.diff(misses) < 0)


def test_the_best_model_misses_less_than_the_authors_also_when_friction_is_a_little_off(log: FieldLog) -> None:
    friction = list(LADDER.values())[-1][0]
    torque, bit, _ = np.max(jittered_scores(friction, log), axis=0)
    assert torque < 3.4
    assert bit < 38.0


def test_the_table_and_the_files_say_the_same(log: FieldLog, tmp_path: Path) -> None:
    friction = list(LADDER.values())[-1][0]
    write(log, friction, tmp_path)
    content = json.loads((tmp_path / "field.json").read_text())
    torque, bit, _ = jittered_scores(friction, log)[JITTER.index(1.0)]
    assert content["torque_rms_knm"] == pytest.approx(torque)
    assert content["bit_rms_rpm"] == pytest.approx(bit)
    assert replace(friction, **content["parameters"]) == friction
    assert (tmp_path / "field.png").stat().st_size > 10_000
    assert f"{torque:7.2f}" in table(log)

"""What was learnt is compared over the fleet, and told in the report."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from drillid.datasets.store import WellFolders, write_store
from drillid.datasets.tables import write_table
from drillid.discrepancy.learning.fingerprint import PLACE_TOLERANCE, SAME, SIZE_TOLERANCE, Described, Fingerprint
from drillid.discrepancy.learning.fleet import COLUMNS, LearntInWell, learnt_table, write_learnt
from drillid.discrepancy.learning.law import LearntLaw
from drillid.discrepancy.learning.law_kinds import CouplingLaw
from drillid.discrepancy.learning.law_spline import LawSpline
from drillid.discrepancy.predictive_gain import PredictiveGain
from drillid.report.learnt import learnt_rows


def joint(compliance: float, place: float) -> Fingerprint:
    """A soft joint, well determined."""
    values, covariance = np.array([compliance, place]), np.diag([(0.05 * compliance) ** 2, 1e-4])
    return Fingerprint(40.0, (Described("joint", values, covariance, 0.0),))


def in_well(well: str, rig: str, fingerprint: Fingerprint) -> LearntInWell:
    """Learnt between 1000 and 1200 m."""
    return LearntInWell(well, rig, 1000.0, 1200.0, fingerprint)


def test_the_same_is_told_with_the_wells_of_the_rig_and_of_others() -> None:
    soft = 3.3e-5
    found = [
        in_well("A", "R1", joint(soft, 0.7)),
        in_well("B", "R1", joint(1.02 * soft, 0.71)),
        in_well("C", "R1", joint(soft, 0.69)),
        in_well("D", "R2", joint(1.01 * soft, 0.7)),
        in_well("E", "R1", joint(9.0 * soft, 0.2)),
    ]
    table = learnt_table(found).set_index("well")
    assert table.loc["B", "same_as"] == "A|C|D"
    assert "the same as in wells A and C of this rig; the same as in well D of other rigs" in table.loc["B", "sentence"]
    assert "a series spring of 30.3 kN m/rad at 70% of the string" in table.loc["A", "resembles"]
    assert table.loc["E", "same_as"] == ""
    assert np.isnan(table.loc["E", "least_p_value"])
    assert table.loc["A", "least_p_value"] > 0.5


def test_the_same_thing_is_told_apart_no_more_often_than_its_p_value_says() -> None:
    """In each well sizes and place deviate by their tolerances and by their own errors."""
    rng, error, sizes = np.random.default_rng(20), 0.02, np.array([50.0, 1.2, 0.3])

    def found() -> Fingerprint:
        deviations = np.hypot([*(SIZE_TOLERANCE * sizes), PLACE_TOLERANCE], error * np.append(sizes, 1.0))
        values = np.append(sizes, 0.5) + deviations * rng.standard_normal(4)
        covariance = np.diag((error * np.append(sizes, 1.0)) ** 2)
        return Fingerprint(40.0, (Described("mounted inertia", values, covariance, 0.0),))

    p_values = np.array([found().likeness(found()) for _ in range(2000)])
    for rate in (0.01, 0.05, 0.2):
        assert np.mean(p_values < rate) < 1.5 * rate + 0.01


def test_couplings_sought_at_neighbouring_places_are_the_same_and_those_at_the_ends_are_not() -> None:
    spline, gain = LawSpline(np.zeros(1), np.array([1e-9]), -5e3, 5e3), PredictiveGain(5.0, 1.0, 3)

    def found(at: float) -> Fingerprint:
        return LearntLaw(CouplingLaw(at), spline, np.diag([0.0, 1e-20]), 0.0, 0.0, 50.0, gain, 0).fingerprint

    assert found(0.5).likeness(found(0.75)) >= SAME
    assert found(0.0).likeness(found(1.0)) < SAME


def test_a_well_with_a_number_for_a_name_keeps_it(tmp_path: Path) -> None:
    write_table(learnt_table([in_well("007", "R1", joint(3e-5, 0.7))]), tmp_path / "learnt.csv")
    assert [row["well"] for row in learnt_rows(tmp_path)] == ["007"]


def test_a_well_is_not_compared_with_itself() -> None:
    twice = [in_well("A", "R1", joint(3e-5, 0.7)), in_well("A", "R1", joint(3e-5, 0.7))]
    assert learnt_table(twice)["same_as"].tolist() == ["", ""]


def test_stored_fingerprints_become_the_table_and_lines_of_the_report(tmp_path: Path) -> None:
    for well in ("A", "B"):
        texts = np.array(["", json.dumps(joint(3e-5, 0.7).content())], dtype=np.dtypes.StringDType())
        stored = xr.Dataset(
            {"fingerprint": ("set", texts), "from_m": ("set", [0.0, 100.0]), "to_m": ("set", [100.0, 250.0])},
            attrs={"well": f"well {well}", "rig": "R1"},
        )
        write_store(stored, WellFolders(tmp_path, well).stage("discrepancy") / "examination.zarr")
    assert learnt_rows(tmp_path) == []
    write_learnt(tmp_path, ["A", "absent", "B"])
    table = pd.read_csv(tmp_path / "learnt.csv")
    assert list(table) == list(COLUMNS)
    assert table[["well", "from_m", "same_as"]].to_numpy().tolist() == [
        ["well A", 100.0, "well B"],
        ["well B", 100.0, "well A"],
    ]
    first, _ = learnt_rows(tmp_path)
    assert first["well"] == "well A"
    assert "the same as in well well B of this rig" in first["sentence"]

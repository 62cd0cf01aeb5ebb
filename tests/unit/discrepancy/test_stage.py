"""Intervals of flagged windows, residual tests of simulated wells, and what is stored of them."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from drillid.datasets.codes import Gate
from drillid.datasets.examined import DISCREPANCIES
from drillid.discrepancy import Verdict, intervals, runs
from drillid.discrepancy.sets import COLUMNS, ExaminedSet, window_sets, window_verdicts
from drillid.discrepancy.stage import RESIDUAL_TESTS, _failed_tests
from drillid.discrepancy.verdicts.intervals import change_verdict, interval_numbers, probability
from drillid.figures.data import WellResults
from tests.simulated import RIG, Processed


def table(flagged: list[int], run: list[int], damping: list[float] | None = None) -> list[tuple[float, float, int]]:
    windows, discrepancy = track(flagged, damping)
    found = intervals(windows, discrepancy, np.array(run))
    return list(zip(found["from_m"], found["to_m"], found["windows"], strict=True))


def track(flagged: list[int], damping: list[float] | None = None) -> tuple[xr.Dataset, xr.Dataset]:
    """Windows of 10 m from 1000 m on, and their anomaly track."""
    count = len(flagged)
    depth = 1000.0 + 10 * np.arange(count)
    windows = xr.Dataset({"depth_from": ("window", depth), "depth_to": ("window", depth + 10)})
    pulls = {
        "flagged": ("window", np.array(flagged, dtype=bool)),
        "damping_pull": ("window", np.array(damping or [0.0] * count)),
        "inertia_pull": ("window", np.linspace(0.0, 5.0, count)),
    }
    return windows, xr.Dataset(pulls)


def test_successive_flagged_windows_are_one_interval() -> None:
    assert table([0, 1, 1, 1, 0, 1], [0] * 6) == [(1010.0, 1040.0, 3), (1050.0, 1060.0, 1)]
    assert table([1, 0, 0, 0, 0, 1], [0] * 6) == [(1000.0, 1010.0, 1), (1050.0, 1060.0, 1)]
    assert table([1, 1, 1, 1, 1, 1], [0] * 6) == [(1000.0, 1060.0, 6)]
    assert table([0] * 6, [0] * 6) == []


def test_an_interval_ends_with_its_run() -> None:
    assert table([0, 1, 1, 1, 1, 0], [0, 0, 0, 1, 1, 1]) == [(1010.0, 1030.0, 2), (1030.0, 1050.0, 2)]


def test_an_interval_within_which_the_depth_goes_back_holds_all_its_windows() -> None:
    windows, discrepancy = track([0, 0, 1, 1, 0, 0])
    # a hole drilled anew beside the first one
    windows["depth_from"][3:] = windows["depth_from"][3:] - 500.0
    windows["depth_to"][3:] = windows["depth_to"][3:] - 500.0
    (found,) = intervals(windows, discrepancy, np.zeros(6, dtype=np.int64)).to_dict("records")
    assert (found["from_m"], found["to_m"], found["windows"]) == (530.0, 1030.0, 2)
    flagged = np.array([0, 1, 1, 0, 1, 1, 1], dtype=bool)
    assert interval_numbers(flagged, np.array([0, 0, 0, 0, 0, 1, 1])).tolist() == [-1, 0, 0, -1, 1, 2, 2]


def test_the_evidence_names_what_stands_out() -> None:
    windows, discrepancy = track([0, 1, 1, 0], [0.0, 3.0, 7.25, 0.0])
    found = intervals(windows, discrepancy, np.zeros(4, dtype=np.int64))
    assert found["evidence"].tolist() == [
        "BHA damping up by 7.2 standard deviations; BHA inertia up by 3.3 standard deviations"
    ]
    assert found["damping_pull"].tolist() == [7.25]
    discrepancy["inertia_pull"][:] = 1.0
    found = intervals(windows, discrepancy, np.zeros(4, dtype=np.int64))
    assert found["evidence"].tolist() == ["BHA damping up by 7.2 standard deviations"]


def test_runs_follow_the_tally() -> None:
    collars = [RIG.collars[0].model_copy(update={"from_depth": depth}) for depth in (0.0, 3000.0)]
    rig = RIG.model_copy(update={"collars": tuple(collars)})
    assert runs(rig, np.array([500.0, 2999.0, 3000.0, 3400.0])).tolist() == [1, 1, 2, 2]
    assert runs(rig.model_copy(update={"collars": ()}), np.array([500.0, 3400.0])).tolist() == [0, 0]


def test_a_sound_well_shows_nothing(healthy: Processed) -> None:
    found = healthy.dataset("discrepancy", "discrepancy")
    assert healthy.problems["discrepancy"] == []
    assert not found["flagged"].any()
    assert np.isnan(found["damping_pull"]).all()  # four windows have no level to stand out of
    header = (healthy.folders.stage("discrepancy") / "intervals.csv").read_text().splitlines()
    errors = "error_by_usual,error_by_interval,speed_noise"
    assert header == [f"from_m,to_m,windows,damping_pull,inertia_pull,evidence,{errors}"]
    used = (healthy.dataset("mobility", "mobility")["gate"] == Gate.USED).values
    residual = found["whitened_residual"].values
    assert np.isfinite(residual[used]).all()
    assert np.isnan(residual[~used]).all()
    assert np.mean(np.abs(residual[used]) ** 2) / 2 == pytest.approx(1, abs=0.1)


def test_attributes_are_those_of_the_schema(healthy: Processed) -> None:
    found = healthy.dataset("discrepancy", "discrepancy")
    assert found.attrs["well"] == "healthy"
    assert found.attrs["title"] == DISCREPANCIES.title
    for name, declared in DISCREPANCIES.variables.items():
        assert found[name].dims == declared.dims
        assert found[name].attrs["long_name"] == declared.long_name


def test_a_window_without_fit_has_no_residuals(troubled: Processed) -> None:
    found = troubled.dataset("discrepancy", "discrepancy")
    assert np.isnan(found["whitened_residual"].values[2]).all()
    assert np.isnan(found["normality_p_value"].values[2])
    assert not found["flagged"].any()


@pytest.mark.parametrize(
    ("fault", "said"), [("coloured", "depend on their neighbours in frequency"), ("wide", "are not Gaussian")]
)
def test_residuals_that_fail_a_test_are_rows(healthy: Processed, tmp_path: Path, fault: str, said: str) -> None:
    well = healthy.copied(tmp_path / "results")
    mobility = well.dataset("mobility", "mobility")
    deviation = np.sqrt(mobility["command_mobility_variance"].values[1])
    if fault == "coloured":
        mobility["command_mobility"].values[1] += deviation * np.exp(0.1j * np.arange(deviation.size))
    else:
        mobility["command_mobility_variance"].values[1] /= 4
    well.folders.write("mobility", "mobility", mobility)
    problems = well.run("discrepancy")
    assert {problem.where.split(" at ")[0] for problem in problems} == {"window 1"}
    assert any(said in problem.what for problem in problems)
    assert all(problem.remedy for problem in problems)


def test_windows_of_one_verdict_that_fail_a_test_are_one_row() -> None:
    tracks = {
        "hole_depth": [1000.0, 1010.0, 1020.0, 1030.0, 1040.0],
        "normality_p_value": [1e-9, 1e-7, 0.5, 1e-8, 1e-6],
        "whiteness_p_value": [0.5] * 5,
        "verdict": ["drive_lag", "drive_lag", "drive_lag", "drive_lag", "none"],
    }
    dataset = xr.Dataset({name: ("window", values) for name, values in tracks.items()}, {"window": np.arange(3, 8)})
    of_cause, of_none = _failed_tests(dataset, 0.05)
    assert of_cause.where == "windows 3 to 4, 6 at 1000.0 to 1030.0 m"
    assert "1e-09" in of_cause.what
    assert of_cause.remedy.endswith("the verdict there is drive_lag")
    assert of_none.where == "window 7 at 1040.0 m"
    assert "verdict" not in of_none.remedy


@pytest.mark.parametrize("further", [{}, {"chi2_p_value": "are too large"}], ids=["as it is", "with a further test"])
def test_a_test_fails_below_the_level_that_the_figure_draws(
    further: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, meaning in further.items():
        monkeypatch.setitem(RESIDUAL_TESTS, name, meaning)
    accepted = np.array([True, False, True, True, False])
    drawn: Any = SimpleNamespace(fits={"accepted": xr.DataArray(accepted)}, error_rate=0.05)
    level = WellResults.residual_level(drawn)
    tracks: dict[str, Any] = {name: [0.5] * 3 for name in RESIDUAL_TESTS}
    tracks |= {"hole_depth": [1000.0, 1010.0, 1020.0], "verdict": ["none"] * 3}
    tracks["normality_p_value"] = [0.999 * level, 1.001 * level, 0.5]
    dataset = xr.Dataset({name: ("window", values) for name, values in tracks.items()}, {"window": [0, 2, 3]})
    (failed,) = _failed_tests(dataset, 0.05)
    assert failed.where == "window 0 at 1000.0 m"


def test_a_damping_that_leaves_its_run_is_an_interval(
    healthy: Processed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # copies of one window are no set that the engine could examine
    monkeypatch.setattr("drillid.discrepancy.stage.examine_well", lambda *given: [])
    well = healthy.copied(tmp_path / "results")
    for stage, name in ((one, one) for one in ("windows", "spectra", "mobility", "fits")):
        four = well.dataset(stage, name)
        twelve = xr.concat([four] * 3, "window", data_vars="minimal", coords="minimal", compat="override", join="exact")
        if name == "fits":
            tracks = {
                "damping_bha": [20, 30, 25, 18, 22, 28, 15, 900, 26, 33, 19, 24],
                "inertia_bha": 80 + np.arange(12),
            }
            for name_of_track, values in tracks.items():
                place = twelve["parameter"].values.tolist().index(name_of_track)
                twelve["value"].values[:, place] = values
                twelve["standard_error"].values[:, place] = 20.0
        control = {key: value for key, value in four.attrs.items() if str(key).startswith("controller_")}
        well.folders.write(stage, name, twelve.assign_coords(window=np.arange(12)), **control)
    well.run("discrepancy")
    flagged = well.dataset("discrepancy", "discrepancy")["flagged"].values
    assert np.flatnonzero(flagged).tolist() == [7]
    rows = (well.folders.stage("discrepancy") / "intervals.csv").read_text().splitlines()
    assert len(rows) == 2
    assert "BHA damping up by" in rows[1]


def test_a_sound_well_is_told_so(healthy: Processed) -> None:
    table = pd.read_csv(healthy.folders.stage("discrepancy") / "verdicts.csv")
    assert table.columns.tolist() == list(COLUMNS)
    assert table["verdict"].tolist() == ["none"]
    assert table["well"].tolist() == ["healthy"]
    assert set(healthy.dataset("discrepancy", "discrepancy")["verdict"].values) == {"none"}
    assert set(healthy.dataset("depth", "depth")["verdict"].values) == {"none"}


def test_windows_without_fit_are_in_no_set(troubled: Processed) -> None:
    said = troubled.dataset("discrepancy", "discrepancy")["verdict"].values
    assert said[2] == ""
    assert all(said[:2])


def test_sets_are_the_runs_of_the_tally() -> None:
    collars = [RIG.collars[0].model_copy(update={"from_depth": depth}) for depth in (0.0, 3000.0)]
    rig = RIG.model_copy(update={"collars": tuple(collars)})
    windows = xr.Dataset({"bit_depth": ("window", [2900.0, 2950.0, 3000.0, 3050.0])})
    value = np.ones((4, 8))
    value[1, 3] = np.nan
    fits = xr.Dataset({"value": (("window", "parameter"), value)})
    assert [rows.tolist() for rows in window_sets(rig, windows, fits)] == [[0], [2, 3]]
    assert [rows.tolist() for rows in window_sets(RIG, windows, fits)] == [[0, 2, 3]]


def change(inside: list[float], usual: list[float], p_value: float = 1e-4) -> Verdict:
    """The verdict on windows with a damping of their own, their errors 20."""
    damping = np.array([*inside, *usual])
    error, flagged = np.full(damping.size, 20.0), np.arange(damping.size) < len(inside)
    tracks = {"damping_bha": (damping, error), "inertia_bha": (np.full(damping.size, 80.0), error)}
    return change_verdict(tracks, flagged, ~flagged, 1010.0, 1040.0, p_value, "said")


def test_an_interval_that_its_own_windows_predict_is_a_change() -> None:
    found = change([420.0, 390.0, 400.0], [20.0, 30.0, 25.0, 18.0, 22.0, 28.0])
    assert (found.verdict, found.cause, found.held_out_windows) == ("regime_change", "regime_change", 3)
    assert found.size == pytest.approx(403.3 - 23.8, abs=0.1)
    assert found.size_high - found.size == pytest.approx(1.96 * 20 * np.sqrt(1 / 3 + 1 / 6))
    assert found.size - found.size_low == pytest.approx(found.size_high - found.size)
    assert found.predictive_gain_low > 30
    assert found.probability == pytest.approx(1 / (1 + np.e * 1e-4 * np.log(1e4)))


def test_an_interval_that_its_own_windows_do_not_predict_has_no_name() -> None:
    found = change([420.0, -380.0, 20.0], [20.0, 30.0, 25.0, 18.0, 22.0, 28.0])
    assert (found.verdict, found.cause) == ("unknown", "")
    assert found.predictive_gain < 0


def test_a_window_that_stands_alone_pays_for_its_level() -> None:
    rest = [20.0, 30.0, 25.0, 18.0, 22.0, 28.0]
    found = change([420.0], rest)
    level, error = np.mean(rest), 20 / np.sqrt(6)
    variance = 400 + error**2
    usual = -0.5 * ((420 - level) ** 2 / variance + np.log(variance))
    assert found.held_out_windows == 0
    alike = -0.5 * np.log(400) + 0.5 * np.log(variance)
    assert found.predictive_gain == pytest.approx(-0.5 * np.log(400) - 1 - usual + alike - 1)


def test_the_probability_of_a_change_falls_to_even_odds() -> None:
    assert [probability(p_value) for p_value in (1.0, 0.5, np.exp(-1))] == [0.5, 0.5, 0.5]
    odds = [probability(p_value) for p_value in (0.2, 0.05, 1e-3, 0.0)]
    assert odds == sorted(odds)
    assert odds[1] == pytest.approx(0.711, abs=1e-3)  # the authors' bound of 0.289 on no effect at 5 %


def test_a_verdict_on_an_interval_is_told_in_its_windows_alone() -> None:
    windows = xr.Dataset({"hole_depth": ("window", [1000.0, 1020.0, 1030.0, 1050.0])})
    quiet = Verdict("none", "", 0.9, 1000.0, 1050.0)
    named = Verdict("drive_lag", "drive", 0.9, 1000.0, 1025.0, cause="drive_lag")
    change_there = Verdict("regime_change", "time", 0.9, 1010.0, 1040.0)
    sets = [examined([0, 1], named), examined([2], quiet)]
    said = window_verdicts(sets, [change_there], windows).tolist()
    assert said == ["drive_lag", "drive_lag + regime_change", "regime_change", ""]


def examined(rows: list[int], *verdicts: Verdict) -> ExaminedSet:
    """A set of which only the verdicts are looked at."""
    examination: Any = SimpleNamespace(verdicts=verdicts)
    return ExaminedSet(np.array(rows), examination)

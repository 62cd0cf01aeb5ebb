"""Extended models as they are stored, reflectogram, immittance and advice, on data of the time-domain simulator."""

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from typer.testing import CliRunner

from drillid.arrays import Complex, Floats
from drillid.commands import app
from drillid.control.margins import margins
from drillid.datasets.examined import EXAMINATIONS
from drillid.datasets.store import WellFolders
from drillid.discrepancy import CATALOGUE, Evidence, Examination, Verdict
from drillid.discrepancy.inference.coordinates import COORDINATES, Extension, Point
from drillid.discrepancy.inference.localisation import fits_at_shapes, place_probability
from drillid.discrepancy.inference.set_fit import fit_set, without_outlier_windows
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.predictive_gain import PredictiveGain
from drillid.discrepancy.products import simulated_window
from drillid.discrepancy.products.advice import advise, present_separation
from drillid.discrepancy.products.dataset import examination_dataset
from drillid.discrepancy.products.extended_model import (
    coordinates,
    identified_window_models,
    simulated_rigs,
    window_model_of,
)
from drillid.discrepancy.products.immittance import missing_immittance
from drillid.discrepancy.products.reflectogram import Reflectogram, reflectogram
from drillid.discrepancy.products.simulated_window import COLUMNS
from drillid.discrepancy.sets import ExaminedSet, WellData, evidence_of, read_verdicts, window_sets
from drillid.discrepancy.verdicts import from_responses as linear_verdicts
from drillid.discrepancy.verdicts.engine import examine
from drillid.discrepancy.verdicts.explanations import likeliest_cause
from drillid.discrepancy.verdicts.verdict import UNKNOWN
from drillid.physics.eight_parameters import drilling_system
from drillid.physics.equipment import DrillingSystem, RegenerativeCutting
from drillid.physics.responses import bit_mobility, laplace
from drillid.physics.stability import loop_transfer
from drillid.physics.top_drive import control
from drillid.simulation.simulate import TIME_STEP
from drillid.units import RPM
from tests.simulated import RATE, SHALLOW, Processed, Truth, drilled
from tests.truth.discrepancy.wells import processed_well

LAG = 0.04
"""s."""
LAGGING = replace(SHALLOW, top_drive=replace(SHALLOW.top_drive, lag=LAG))


@pytest.fixture(scope="module")
def lagging(tmp_path_factory: pytest.TempPathFactory) -> Processed:
    """Two windows of a rig whose drive lags, which its data sheets do not state."""
    return processed_well(tmp_path_factory.mktemp("lagging"), [drilled(LAGGING, 1200.0, 77)], "discrepancy", "depth")


def well_data(well: Processed) -> WellData:
    """Its datasets, with nothing in the records."""
    windows, spectra, mobility, fits = (well.dataset(name, name) for name in ("windows", "spectra", "mobility", "fits"))
    return WellData(well.well.rig, well.dataset("records", "records") * np.nan, windows, spectra, mobility, fits)


def evidence(well: Processed) -> Evidence:
    """Evidence from a well of one run, without detections."""
    data = well_data(well)
    (rows,) = window_sets(well.well.rig, data.windows, data.fits)
    return evidence_of(data.at(rows))


@pytest.fixture(scope="module")
def examined(lagging: Processed) -> Examination:
    """The engine's view of the lagging rig."""
    return examine(evidence(lagging))


def test_the_lag_is_named_with_its_size(lagging: Processed) -> None:
    table = pd.read_csv(lagging.folders.stage("discrepancy") / "verdicts.csv")
    named = table[table["cause"] == "drive_lag"]
    assert len(named) == 1
    assert named["size_low"].item() <= LAG <= named["size_high"].item()
    assert named["predictive_gain"].item() > 0


def test_bit_mobility_and_steps_are_those_of_the_lagging_rig(lagging: Processed) -> None:
    """The plain model's own fit misses them."""
    depth, fits = lagging.dataset("depth", "depth"), lagging.dataset("fits", "fits")
    frequency = depth["frequency"].values
    near = (frequency > 0.2) & (frequency < 1.5)
    truth = bit_mobility(LAGGING.system, laplace(frequency[near]))
    extended = depth["bit_mobility_controlled"].values[0, near]
    assert error(extended, truth) < 0.15
    plain = drilling_system(fits["value"].values[0], LAGGING.known)
    assert error(bit_mobility(plain, laplace(frequency[near])), truth) > 2 * error(extended, truth)
    assert np.isfinite(depth["bit_step_controlled"].values).all()


def error(estimate: Complex, truth: Complex) -> float:
    """Root mean square of the relative error."""
    return float(np.sqrt(np.mean(np.abs(estimate / truth - 1) ** 2)))


def test_the_stored_model_is_the_one_that_was_fitted(lagging: Processed, examined: Examination) -> None:
    stored = identified_window_models(lagging.dataset("discrepancy", "examination"))
    assert stored.keys() == {0, 1}
    for row, window_model in stored.items():
        expected = examined.model.predicted(examined.extended.point, examined.extensions)[row]
        np.testing.assert_allclose(window_model.mobility(examined.model.s), expected, rtol=1e-9)
        assert isinstance(window_model.system.top_drive.lag, float)


@pytest.mark.parametrize("name", [name for name, cause in CATALOGUE.items() if cause.is_linear])
def test_coordinates_and_causes_reproduce_the_model(examined: Examination, name: str) -> None:
    cause, model = CATALOGUE[name], examined.model
    extensions = (Extension(cause, cause.shapes[0], (1,)),)
    size = 0.3 * cause.size.typical
    point = Point(examined.base.point.shared, examined.base.point.local, np.array([size]))
    reproduced = window_model_of(coordinates(model, point), extensions, [size])
    np.testing.assert_allclose(reproduced.mobility(model.s), model.predicted(point, extensions), rtol=1e-12)


def test_the_held_out_window_is_predicted_better_with_the_lag(lagging: Processed) -> None:
    examination = lagging.dataset("discrepancy", "examination").isel(set=0)
    misfit = {
        name: float(np.sqrt(np.mean((examination["period_speed"] - examination[name]) ** 2)))
        for name in ("period_base", "period_extended")
    }
    assert misfit["period_extended"] < misfit["period_base"]
    assert misfit["period_extended"] < 1.5 * float(examination["period_error"])


def test_residuals_shrink_to_noise(lagging: Processed) -> None:
    examination = lagging.dataset("discrepancy", "examination")
    before, after = (
        float(np.nanmean(np.abs(examination[f"residual_{when}"]) ** 2) / 2) for when in ("before", "after")
    )
    assert after < before
    assert after == pytest.approx(1, abs=0.1)


def test_the_base_model_leaves_echoes_and_the_extended_one_none(examined: Examination) -> None:
    """Where the control's interval is stated: a control that holds for longer would take a part of the lag."""
    stated = replace(examined.model.evidence.data_sheet, control_interval=TIME_STEP)
    model = SetModel(replace(examined.model.evidence, data_sheet=stated))
    before = reflectogram(model, fit_set(model, model.start()), (), 0.01)
    after = reflectogram(examined.model, examined.extended, examined.extensions, 0.01)
    assert _echoes(before)
    assert not _echoes(after)


@dataclass(frozen=True)
class Braked(Truth):
    """The shallow rig with a zone of damping in its pipe."""

    place: float = 0.6
    """Of the zone's middle, as a share of the pipe."""
    damping: float = 60.0
    """N m s/rad, of the whole zone."""

    @property
    def system(self) -> DrillingSystem:
        """All of the equipment."""
        pipe, width = self.pipe, 0.05
        more = self.damping / (width * pipe.length * pipe.polar_moment)
        zone = replace(pipe, length=width * pipe.length, kappa=pipe.kappa + more)
        above = replace(pipe, length=(self.place - width / 2) * pipe.length)
        below = replace(pipe, length=(1 - self.place - width / 2) * pipe.length)
        return DrillingSystem(self.top_drive, (above, zone, below, self.collars), self.bit)


@pytest.fixture(scope="module")
def braked(tmp_path_factory: pytest.TempPathFactory) -> Examination:
    truth = Braked(**vars(SHALLOW))
    given = evidence(processed_well(tmp_path_factory.mktemp("braked"), [drilled(truth, 1200.0, 5)]))
    # the simulator's control samples at every step; not to know that leaves the place a little less sure
    sheet = replace(given.data_sheet, control_interval=TIME_STEP)
    return examine(replace(given, data_sheet=sheet))


def test_the_reflectogram_points_at_a_zone_of_damping(braked: Examination) -> None:
    distance, reflection = _echoes(reflectogram(braked.model, braked.base, (), 0.01))[0]
    assert reflection < 0  # damping acts like a larger admittance: the reflected speed has the opposite sign
    assert distance == pytest.approx(0.6 * SHALLOW.pipe.length, abs=0.15 * SHALLOW.pipe.length)


@pytest.mark.parametrize(("members", "located"), [((), True), (("mud_drag",), False)])
def test_a_class_with_a_cause_that_is_everywhere_has_no_place(
    braked: Examination, monkeypatch: pytest.MonkeyPatch, members: tuple[str, ...], located: bool
) -> None:
    zone = "local_damping_zone"
    monkeypatch.setattr(linear_verdicts, "_members", lambda *_: (zone, *members))
    causes = [CATALOGUE[zone]]
    likeliest = likeliest_cause(braked, causes)
    explained = linear_verdicts.explain_responses(braked, likeliest, causes, np.random.default_rng(0))
    verdict = explained.verdicts[0]
    assert (verdict.cause, bool(np.isfinite(verdict.location_m))) == (zone, located)


@pytest.mark.parametrize(("noise", "placed"), [(1.0, True), (100.0, False)])
def test_a_place_is_stated_where_the_noise_permits(braked: Examination, noise: float, placed: bool) -> None:
    evidence = braked.model.evidence
    model = SetModel(replace(evidence, variance=evidence.variance * noise))
    fit = fit_set(model, braked.extended.point, braked.extensions)
    assert (place_probability(fits_at_shapes(model, fit, braked.extensions, 0)) > 0.95) == placed


def test_a_delay_of_the_record_is_read_as_one(examined: Examination) -> None:
    """A delay that came after the rig was identified appears at a port, where the drive's own is known."""
    own = SHALLOW.top_drive.delay
    known = replace(
        examined.model.evidence.data_sheet, delay=own, delay_error=1e-5, clock_error=1e-5, control_interval=TIME_STEP
    )
    lagging = replace(examined.model.evidence, data_sheet=known, control=None, control_variance=None)
    before, lag = SetModel(lagging), (Extension(CATALOGUE["drive_lag"], 0.0),)
    stated = before.expected()
    identified = fit_set(before, Point(stated.shared, stated.local, np.array([LAG])), lag)
    assert abs(identified.off_data_sheet[COORDINATES.index("delay")]) < 3
    late = replace(lagging, mobility=lagging.mobility * np.exp(-0.03 * laplace(lagging.frequency)))
    missing = missing_immittance(SetModel(late), identified, "record", lag)
    delay = re.search(r"a delay of ([\d.]+) ± ([\d.]+) ms", missing.reading)
    assert delay is not None, missing.reading
    assert abs(float(delay[1]) - 30) < 4 * float(delay[2])


def test_an_outlier_window_is_brought_back(examined: Examination) -> None:
    model, base = examined.model, examined.base
    local = base.point.local.copy()
    local[0] = 8.0
    with_outlier = replace(base, point=replace(base.point, local=local), cost=np.inf)
    assert without_outlier_windows(model, with_outlier).cost == pytest.approx(base.cost, abs=0.1)


def test_lines_whose_ratio_is_biased_carry_no_weight_for_the_control(examined: Examination) -> None:
    """The mean of 1/(1 + n) over complex normal n of variance v is 1 - exp(-1/v): 0.96 at 0.3."""
    evidence = examined.model.evidence
    power = control_power(evidence)
    used = np.flatnonzero(examined.model.measured.weight.all(axis=0))
    for noise, own, weighted in ((0.002, 0.002, True), (0.002, 0.3, False), (0.018, 0.3, False), (0.05, 0.05, False)):
        variance = noise * power
        variance[:, used[50]] = own * power[:, used[50]]
        weight = SetModel(replace(evidence, control_variance=variance)).measured.control_weight
        assert weight is not None
        assert np.all((weight[:, used[50]] > 0) == weighted)


def control_power(evidence: Evidence) -> Floats:
    """Squared response of the stated control, (W, F)."""
    response = control(evidence.data_sheet.controller, laplace(evidence.frequency))
    return np.abs(response) ** 2 * np.ones((evidence.windows, 1))


@pytest.mark.parametrize(("noise", "rounding", "gained"), [(0.0, 0.0, 1.0), (0.015, 0.0, 8.0), (0.0, 0.1, 1.0)])
def test_an_error_common_to_all_windows_does_not_average_out(
    examined: Examination, noise: float, rounding: float, gained: float
) -> None:
    evidence = examined.model.evidence
    power = control_power(evidence)
    noisy = replace(evidence, control_variance=noise * power, control_rounding=rounding * power)
    first = noisy.subset(np.array([0]))
    information = []
    for copies in (1, 8):
        weight = SetModel(first.subset(np.zeros(copies, dtype=np.intp))).measured.control_weight
        assert weight is not None
        information.append(np.sum(weight**2))
    assert information[1] / information[0] == pytest.approx(gained, rel=0.15)


def test_nothing_is_read_where_nothing_is_missing(examined: Examination) -> None:
    missing = missing_immittance(examined.model, examined.extended, "bit", examined.extensions)
    assert missing.passive
    assert "no spring" in missing.reading
    assert np.all(missing.rational.real >= -1e-9)


def test_every_measurement_helps_or_changes_nothing(examined: Examination) -> None:
    advice = advise(examined, ())
    assert len({measurement.measurement for measurement in advice}) == len(advice) >= 7
    smallest = [measurement.smallest for measurement in advice]
    assert all(0 < size <= 1.0001 for size in smallest)
    assert smallest == sorted(smallest)


def test_advice_for_a_class_sets_its_members_apart(examined: Examination) -> None:
    members = ("local_damping_zone", "motor_compliance")
    separations = [measurement.separation for measurement in advise(examined, members)]
    assert separations == sorted(separations, reverse=True)
    assert separations[0] > 1.1 * present_separation(examined, members)


def test_something_unknown_leaves_a_reading(lagging: Processed, examined: Examination) -> None:
    verdicts = (Verdict("unknown", "record", 0.99, 960.0, 975.0),)
    examination = replace(examined, verdicts=verdicts, extensions=(), extended=examined.base)
    sets = [ExaminedSet(np.arange(2), examination)]
    stored = EXAMINATIONS.conform(examination_dataset(sets, well_data(lagging), 0.05))
    assert str(stored["missing_reading"].item()).startswith("at the port record: ")
    assert np.isfinite(stored["missing_rational"].values).all()
    assert stored.sizes["extension"] == 0
    assert identified_window_models(stored) == {}


def test_a_misfit_without_a_sure_gain_is_unknown(lagging: Processed, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(linear_verdicts, "held_out_gain", lambda *_: PredictiveGain(1.0, 10.0, 2))
    (verdict,) = examine(evidence(lagging)).verdicts
    assert verdict.verdict == UNKNOWN
    assert verdict.probability > 0.5
    assert "drive_lag" in verdict.evidence


def test_a_well_without_any_fit_gets_no_verdict(lagging: Processed, tmp_path: Path) -> None:
    well = lagging.copied(tmp_path / "results")
    fits = well.dataset("fits", "fits")
    fits["value"].values[:] = np.nan
    fits["accepted"].values[:] = False
    control = {key: value for key, value in fits.attrs.items() if str(key).startswith("controller_")}
    well.folders.write("fits", "fits", fits, **control)
    well.run("discrepancy")
    well.run("depth")
    assert well.dataset("discrepancy", "discrepancy")["verdict"].values.tolist() == ["", ""]
    assert well.dataset("discrepancy", "examination").sizes["set"] == 0
    assert len(read_verdicts(well.folders)) == 0
    assert np.isnan(well.dataset("depth", "depth")["bit_mobility_controlled"].values).all()


def test_the_control_can_be_tuned_for_the_extended_rig(lagging: Processed) -> None:
    window_model = identified_window_models(lagging.dataset("discrepancy", "examination"))[0]
    reached, truth = (
        margins(lambda s, system=system: loop_transfer(system, s))
        for system in (window_model.continuous_system, LAGGING.system)
    )
    assert reached.modulus == pytest.approx(truth.modulus, rel=0.1)
    assert reached.delay == pytest.approx(truth.delay, rel=0.2)


def test_a_window_is_simulated_as_the_rig_without_noise_turns(lagging: Processed, tmp_path: Path) -> None:
    quiet = drilled(replace(LAGGING, bit_noise=0.0), 600.0, 1)
    path = tmp_path / "window.csv"
    words = ["simulate", "window", str(lagging.folders.results), "well", "--output", str(path)]
    told = CliRunner().invoke(app, words)
    assert told.exit_code == 0, told.output
    table = pd.read_csv(path)
    assert tuple(table.columns) == COLUMNS
    # the simulated lead-in of the record is no part of the window, so its first period starts from rest
    later = slice(round(120 * RATE), None)
    speed = table["td_rpm"].to_numpy()[later] * RPM
    truth = quiet["speed"][: table.shape[0]][later]
    assert np.std(speed - truth) < 0.15 * np.std(truth)
    assert np.mean(speed) == pytest.approx(np.mean(truth), rel=1e-3)


@pytest.mark.parametrize(
    ("well", "window", "match"), [("well", "99", "Examined are: 0, 1"), ("other", "0", "Give the res")]
)
def test_what_was_not_examined_is_not_simulated(lagging: Processed, well: str, window: str, match: str) -> None:
    words = ["simulate", "window", str(lagging.folders.results), well, "--window", window]
    told = CliRunner().invoke(app, words)
    assert told.exit_code == 1
    assert match in told.output


@pytest.mark.parametrize("weight", [1e5, np.nan])
def test_a_named_cutting_torque_is_a_part_of_the_windows_mean_torque(
    lagging: Processed, monkeypatch: pytest.MonkeyPatch, weight: float
) -> None:
    rigs, windows = simulated_rigs(lagging.dataset("discrepancy", "examination")), lagging.dataset("windows", "windows")
    speed, torque = (float(windows[name][0]) for name in ("speed", "torque"))
    bit = replace(rigs[0].system.bit, cutting=(RegenerativeCutting(0.3 * torque, speed, 3),))
    cutting = replace(rigs[0], system=replace(rigs[0].system, bit=bit))
    monkeypatch.setattr(simulated_window, "simulated_rigs", lambda _: {0: cutting})
    read = WellFolders.read

    def with_weight(folders: WellFolders, *place: str) -> xr.Dataset:
        dataset = read(folders, *place)
        logged = {"weight_on_bit": ("window", np.full(windows.sizes["window"], weight))}
        return dataset.assign(logged) if place == ("windows", "windows") else dataset

    monkeypatch.setattr(WellFolders, "read", with_weight)
    found = simulated_window.simulated_window(lagging.folders.results, "well", int(windows["window"][0]))
    # before the bit's own vibration changes what it takes
    assert found.command[0] == pytest.approx(torque, rel=1e-3)


def _echoes(result: Reflectogram) -> list[tuple[float, float]]:
    """Distance (m) and size of every local extreme beyond the level, largest first."""
    size = np.abs(result.reflection)
    inner = (size[1:-1] >= size[:-2]) & (size[1:-1] >= size[2:]) & (size[1:-1] > result.level[1:-1])
    rows = np.flatnonzero(inner) + 1
    extremes = ((float(result.distance[row]), float(result.reflection[row])) for row in rows)
    return sorted(extremes, key=lambda echo: -abs(echo[1]))

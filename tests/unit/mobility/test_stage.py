"""Command mobilities, gates and stacks of simulated wells."""

from pathlib import Path

import numpy as np
import pytest

from drillid.datasets.codes import Gate
from drillid.physics.responses import command_mobility, laplace
from drillid.statistics import expected_ratio, sharing, sum_of_ratios_probability
from tests.simulated import SHALLOW, Processed


@pytest.mark.parametrize("window", range(4))
def test_errors_are_as_large_as_their_stated_variance(healthy: Processed, window: int) -> None:
    mobility = healthy.dataset("mobility", "mobility").isel(window=window)
    used = (mobility["gate"] == Gate.USED).values
    assert used.sum() > 400
    truth = command_mobility(SHALLOW.system, laplace(mobility["frequency"].values))
    ratio = np.abs(mobility["command_mobility"].values - truth) ** 2 / mobility["command_mobility_variance"].values
    freedom = mobility["degrees_of_freedom"].values
    assert ratio[used].mean() == pytest.approx(float(expected_ratio(freedom[0])), rel=0.25)
    shared = sharing(freedom, mobility["averages"].values)
    p_value = sum_of_ratios_probability(float(ratio[used].sum()), freedom[used], shared[used], fitted=0.0)
    assert 1e-4 < p_value < 1 - 1e-4


def test_variance_of_a_sweep_that_does_not_repeat_is_as_stated(troubled: Processed) -> None:
    mobility = troubled.dataset("mobility", "mobility").isel(window=1)
    truth = command_mobility(SHALLOW.system, laplace(mobility["frequency"].values))
    ratio = np.abs(mobility["command_mobility"].values - truth) ** 2 / mobility["command_mobility_variance"].values
    freedom = float(mobility["degrees_of_freedom"][0])
    assert ratio.mean() == pytest.approx(float(expected_ratio(freedom)), rel=0.3)


def test_windows_of_one_string_are_stacked(healthy: Processed) -> None:
    stacks, mobility = healthy.dataset("mobility", "stacks"), healthy.dataset("mobility", "mobility")
    assert stacks["first_window"].values.tolist() == [0]
    assert stacks["last_window"].values.tolist() == [3]
    assert stacks["windows"].values.tolist() == [4]
    assert healthy.problems["mobility"] == []
    truth = command_mobility(SHALLOW.system, laplace(mobility["frequency"].values))
    used = stacks["gate"].values[0] == Gate.USED
    error = np.abs(stacks["command_mobility"].values[0] - truth)[used]
    single = np.abs(mobility["command_mobility"].values - truth)[:, used]
    assert np.sqrt(np.mean(error**2)) < 0.65 * np.sqrt(np.mean(single**2))


def test_a_speed_without_response_passes_no_gate_and_is_told(troubled: Processed) -> None:
    mobility = troubled.dataset("mobility", "mobility")
    swept = {"frequency": slice(None, 4.0)}
    assert (mobility["gate"].isel(window=2) != Gate.USED).all()
    assert (mobility["gate"].isel(window=2).sel(swept) == Gate.TOO_INCOHERENT).all()
    assert (mobility["gate"].isel(window=0).sel(swept) == Gate.USED).all()
    told = {problem.where.split(" at ")[0]: problem.what for problem in troubled.problems["mobility"]}
    assert told.keys() == {"window 2"}
    assert [problem.what for problem in troubled.problems["mobility"]] == ["no frequency passes the coherence gate"]


def test_every_frequency_has_its_reason(healthy: Processed, tmp_path: Path) -> None:
    well = healthy.copied(tmp_path / "results")
    spectra = well.dataset("spectra", "spectra")
    frequency = spectra["frequency"].values
    spectra["sweep_power"].values[:, frequency > 4.5] *= 1e-9
    spectra["cross_speed"].values[:, frequency > 4.5] *= 1e-9
    weak = (frequency > 0.4) & (frequency < 1.2)
    spectra["cross_speed"].values[:, weak] *= 1e-3
    certain = int(np.searchsorted(frequency, 2.0))
    exact = np.abs(spectra["cross_speed"].values[:, certain]) ** 2 / spectra["sweep_power"].values[:, certain]
    spectra["speed_power"].values[:, certain] = exact * (1 + 1e-9)
    well.folders.write("spectra", "spectra", spectra)
    well.run("mobility")
    gates = well.dataset("mobility", "mobility")["gate"].values
    assert np.all(gates[:, frequency > 4.5] == Gate.OUTSIDE_SWEEP)
    assert np.all(gates[:, (frequency > 0.6) & (frequency < 0.8)] == Gate.TOO_INCOHERENT)
    assert np.all(gates[:, certain] == Gate.TOO_COHERENT)
    assert np.all(gates[:, (frequency > 2.1) & (frequency < 4.0)] == Gate.USED)


def test_responses_inside_the_control_loop_are_those_of_drive_and_controller(healthy: Processed) -> None:
    mobility = healthy.dataset("mobility", "mobility")
    s = laplace(mobility["frequency"].values)
    controller = SHALLOW.top_drive.controller
    control = controller.proportional + controller.integral / s
    command = command_mobility(SHALLOW.system, s)
    free = command / (1 - control * command)
    np.testing.assert_allclose(mobility["control_response"].values, np.broadcast_to(control, (4, s.size)), rtol=0.02)
    sure = np.abs(free) ** 2 > 100 * mobility["torque_mobility_variance"].values
    ratio = np.abs(mobility["torque_mobility"].values - free) ** 2 / mobility["torque_mobility_variance"].values
    expected = float(expected_ratio(mobility["degrees_of_freedom"].values).mean())
    assert sure.mean() > 0.3
    assert ratio[sure].mean() == pytest.approx(expected, rel=0.15)


def test_without_logged_command_nothing_is_known_of_the_control_loop(healthy: Processed, tmp_path: Path) -> None:
    well = healthy.copied(tmp_path / "results")
    records = well.dataset("records", "records")
    records["torque_command"][:] = np.nan
    well.folders.write("records", "records", records)
    for stage in ("spectra", "mobility"):
        assert well.run(stage) == []
    mobility = well.dataset("mobility", "mobility")
    assert mobility["torque_mobility"].isnull().all()
    assert mobility["control_response_variance"].isnull().all()
    before = healthy.dataset("mobility", "mobility")["command_mobility"]
    np.testing.assert_allclose(mobility["command_mobility"], before)

"""Windows of simulated wells → their spectra, by lines or by Welch's averages."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from drillid.config import SpectraSettings
from tests.simulated import RATE, WINDOW_S, Processed


def test_windows_of_a_repeating_sweep_are_read_from_its_lines(healthy: Processed) -> None:
    spectra = healthy.dataset("spectra", "spectra")
    assert healthy.problems["spectra"] == []
    assert spectra.sizes["window"] == 4
    np.testing.assert_allclose(spectra["sweep_period"], 120.0, atol=0.5 / RATE)
    assert (spectra["averages"] == WINDOW_S / 120).all()
    assert (spectra["degrees_of_freedom"] == SpectraSettings().noise_lines - 2).all()
    np.testing.assert_allclose(np.diff(spectra["frequency"]), 1 / 120)
    assert np.isfinite(spectra["speed_spectrogram"]).all()


def test_a_window_whose_sweep_does_not_repeat_is_averaged_over_segments_and_told(troubled: Processed) -> None:
    spectra = troubled.dataset("spectra", "spectra")
    assert spectra["sweep_period"].values == pytest.approx([120, 0, 120])
    assert (spectra["degrees_of_freedom"].isel(window=1) < 4).all()
    assert (spectra["degrees_of_freedom"].isel(window=[0, 2]) == 18).all()
    [problem] = troubled.problems["spectra"]
    assert problem.where.startswith("window 1 at ")
    assert "the sweep does not repeat" in problem.what
    assert problem.remedy


def test_a_well_without_any_window_gets_no_spectra(healthy: Processed, tmp_path: Path) -> None:
    well = healthy.copied(tmp_path / "results")
    well.folders.write("windows", "windows", well.dataset("windows", "windows").isel(window=slice(0, 0)))
    shutil.rmtree(well.folders.stage("spectra"))
    assert well.run("spectra") == []
    assert not well.folders.stage("spectra").exists()


def test_sweep_power_is_that_of_the_records(healthy: Processed) -> None:
    spectra, records = healthy.dataset("spectra", "spectra"), healthy.dataset("records", "records")
    mean_square = float((records["torque_sweep"] ** 2).mean())
    assert 0.98 < float(spectra["sweep_power"][0].sum()) / 2 / mean_square < 1  # a little is beyond the lines used

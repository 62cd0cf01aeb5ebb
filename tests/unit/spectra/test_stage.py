"""Windows of simulated wells → their spectra, by lines or by Welch's averages."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from drillid.config.settings import Settings, SpectraSettings
from drillid.errors import EstimationError
from drillid.spectra.stage import is_usual, usual_sweep
from tests.simulated import RATE, WINDOW_S, Processed


@pytest.mark.parametrize("periods", [[60.0] * 3 + [120.0] * 3, [120.0, 100.0, 100.0], [120.0, 120.02] * 3])
def test_the_usual_period_is_that_of_most_windows(periods: list[float]) -> None:
    found = np.array(periods)
    usual, _ = usual_sweep(found, SpectraSettings(), RATE)
    assert usual in found
    assert np.count_nonzero(is_usual(found, usual, RATE)) >= len(periods) / 2


def test_windows_of_a_repeating_sweep_are_read_from_its_lines(healthy: Processed) -> None:
    spectra = healthy.dataset("spectra", "spectra")
    assert healthy.problems["spectra"] == []
    assert spectra.sizes["window"] == 4
    np.testing.assert_allclose(spectra["sweep_period"], 120.0, atol=0.5 / RATE)
    assert (spectra["averages"] == WINDOW_S / 120).all()
    lines = SpectraSettings().noise_lines
    freedom = spectra["degrees_of_freedom"]
    assert_noise_of_lines(freedom)
    # the lowest frequencies have fewer lines below them
    assert (freedom.diff("frequency") >= 0).all()
    assert (freedom >= lines / 3).all()
    np.testing.assert_allclose(np.diff(spectra["frequency"]), 1 / 120)
    assert np.isfinite(spectra["speed_spectrogram"]).all()


def assert_noise_of_lines(freedom: xr.DataArray) -> None:
    """Degrees of freedom are alike but at the lowest frequencies; the noise's smooth spectrum takes about a third."""
    lines = SpectraSettings().noise_lines
    assert np.ptp(freedom.sel(frequency=slice(0.2, None)).values) == 0
    assert lines / 2 < freedom.max() < lines - 2


def test_a_window_whose_sweep_does_not_repeat_is_estimated_without_that_and_told(troubled: Processed) -> None:
    spectra = troubled.dataset("spectra", "spectra")
    assert spectra["sweep_period"].values == pytest.approx([120, 0, 120])
    lines = SpectraSettings().noise_lines
    # 21 lines less three parameters each of response and transient, and two of a resonance
    assert np.isin(spectra["degrees_of_freedom"].isel(window=1), (lines // 4 + 1 - 6, lines // 4 + 1 - 8)).all()
    assert_noise_of_lines(spectra["degrees_of_freedom"].isel(window=[0, 2]))
    [problem] = troubled.problems["spectra"]
    assert problem.where.startswith("window 1 at ")
    assert "the sweep does not repeat" in problem.what
    assert problem.remedy


def test_a_shorter_window_has_wider_errors_and_a_spectrogram_that_ends_earlier(
    healthy: Processed, tmp_path: Path
) -> None:
    well = healthy.copied(tmp_path / "results")
    windows, seconds = well.dataset("windows", "windows"), round(0.6 * WINDOW_S)
    windows["samples"][0], windows["key"][0] = round(seconds * RATE), "another"
    windows["end"][0] = windows["start"][0] + np.timedelta64(seconds, "s")
    well.folders.write("windows", "windows", windows)
    assert [well.run(stage) for stage in ("spectra", "mobility", "fits")] == [[], [], []]
    spectra, fits = well.dataset("spectra", "spectra"), well.dataset("fits", "fits")
    assert spectra["averages"].isel(frequency=0).values.tolist() == [3, 5, 5, 5]
    assert spectra["speed_spectrogram"].isnull().any("spectrogram_frequency").mean("spectrogram_time").values[
        [0, 1]
    ] == pytest.approx([0.4, 0.0], abs=0.05)
    error = fits["standard_error"].sel(parameter="inertia_td").values
    assert 1.1 < error[0] / error[1:].mean() < 2.5


def test_a_spectrogram_has_segments_of_half_the_shortest_window_at_most(healthy: Processed, tmp_path: Path) -> None:
    well = healthy.copied(tmp_path / "results")
    well.run("spectra", settings=Settings(spectra=SpectraSettings(spectrogram_segment_s=2 * WINDOW_S)))
    spectra = well.dataset("spectra", "spectra")
    assert float(spectra["spectrogram_frequency"].diff("spectrogram_frequency")[0]) == pytest.approx(2 / WINDOW_S)
    assert np.isfinite(spectra["speed_spectrogram"]).all()


def test_a_band_without_lines_is_told(healthy: Processed, tmp_path: Path) -> None:
    well = healthy.copied(tmp_path / "results")
    settings = Settings(spectra=SpectraSettings(frequency_minimum_hz=21.0, frequency_maximum_hz=40.0))
    with pytest.raises(EstimationError, match="no two lines lie between 21 and 20 Hz"):
        well.run("spectra", settings=settings)


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


def test_a_linear_rig_shows_no_distortion_and_a_sweep_that_does_not_repeat_is_not_asked(troubled: Processed) -> None:
    spectra = troubled.dataset("spectra", "spectra")
    assert spectra["noise_level"].isel(window=[0, 2]).notnull().all()
    assert spectra["even_level"].isel(window=1).isnull().all()
    assert not spectra["even_detected"].any()
    assert not spectra["odd_detected"].any()
    assert np.all(spectra["band_end"] > spectra["band"])

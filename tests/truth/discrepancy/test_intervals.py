"""Residual tests and flags of windows hold their stated error rates, and what stands out is found."""

import numpy as np
import pytest
from scipy.stats import binom, kstest

from drillid.discrepancy import flag, normality_p_value, run_pulls, whiteness_p_value
from drillid.discrepancy.rules import CHANGES_SHARE, DATA_SHEET_SHARE, DETECTIONS_SHARE, LAW_SHARE, RESPONSES_SHARE
from drillid.discrepancy.verdicts.intervals import bridged, change_verdict
from drillid.excitation.torques import band_limited_noise
from drillid.spectra.local_polynomial import local_spectra
from drillid.statistics import to_normal


def test_residual_tests_are_uniform_on_white_gaussian_residuals_and_see_colour() -> None:
    rng = np.random.default_rng(13)
    white = rng.normal(size=(300, 475)) + 1j * rng.normal(size=(300, 475))
    assert kstest([normality_p_value(row) for row in white], "uniform").pvalue > 1e-3
    assert kstest([whiteness_p_value(row) for row in white], "uniform").pvalue > 1e-3
    coloured = (white[0][1:] + 0.5 * white[0][:-1]) / np.sqrt(1.25)
    assert whiteness_p_value(coloured) < 1e-6
    assert normality_p_value(white[0] * 1.3) < 1e-3


def test_residuals_of_a_sweep_that_does_not_repeat_pass_at_the_error_rate() -> None:
    rate, frequency, p_values = 25.0, np.arange(3, 200) / 60, []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        sweep = band_limited_noise(rng, round(600 * rate), 1 / rate, 600.0, (0.03, 4.5))
        speed = rng.normal(size=sweep.size)
        spectra = local_spectra(sweep, speed, speed, rate, frequency, 20)
        response = spectra.cross_speed / spectra.sweep_power
        ratio = response * np.sqrt(2 * spectra.averages * spectra.sweep_power / spectra.speed_noise)
        freedom = spectra.degrees_of_freedom
        normal = to_normal(ratio.real, freedom) + 1j * to_normal(ratio.imag, freedom)
        p_values.append(whiteness_p_value(normal, first_lag=2))
    assert kstest(p_values, "uniform").pvalue > 1e-3


def test_a_well_spends_its_error_rate_once() -> None:
    sets = RESPONSES_SHARE + DETECTIONS_SHARE + DATA_SHEET_SHARE + LAW_SHARE
    assert CHANGES_SHARE + (1 - CHANGES_SHARE) * sets == pytest.approx(1.0)


@pytest.mark.parametrize("scatter", [0.0, 1.0, 2.0])
def test_the_interval_of_a_change_holds_it_however_windows_scatter(scatter: float) -> None:
    rng, runs, covered = np.random.default_rng(16), 400, 0
    inside, error = np.isin(np.arange(24), np.arange(8, 13)), np.ones(24)
    for _ in range(runs):
        value = 15.0 * inside + np.hypot(1.0, scatter) * rng.normal(size=24)
        verdict = change_verdict({"damping_bha": (value, error)}, inside, ~inside, 0.0, 1.0, 1e-4, "said")
        covered += verdict.size_low <= 15.0 <= verdict.size_high
    assert binom.cdf(covered, runs, 0.95) > 1e-3


@pytest.mark.parametrize("restlessness", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("windows", [6, 12, 24])
def test_clean_wells_are_flagged_at_most_at_the_error_rate(windows: int, restlessness: float) -> None:
    rng = np.random.default_rng(14)
    run = np.repeat([0, 1], windows)
    wells, rate, flagged = 250, 0.05, 0
    for _ in range(wells):
        error = rng.uniform(10, 20, size=(2, run.size))
        value = 100 + restlessness * error * rng.normal(size=error.shape)
        flagged += flag([run_pulls(value[track], error[track], run)[1] for track in range(2)], rate).any()
    assert binom.sf(flagged - 1, wells, rate) > 1e-3


def test_an_interval_that_stands_out_of_its_run_is_flagged_and_its_run_change_is_not() -> None:
    rng = np.random.default_rng(15)
    run = np.repeat([0, 1], [10, 20])
    error = np.full(30, 30.0)
    value = np.where(run == 0, 160.0, 20.0) + error * rng.normal(size=30)
    value[18:22] += 300
    flagged = flag([run_pulls(value, error, run)[1], np.full(30, np.nan)], 0.01)
    assert np.flatnonzero(flagged).tolist() == [18, 19, 20, 21]


def test_windows_of_an_interval_do_not_hide_each_other_and_flag_no_others() -> None:
    rng = np.random.default_rng(19)
    run, wells, rate, whole, beside = np.zeros(18, int), 200, 0.05, 0, 0
    for _ in range(wells):
        error = rng.uniform(10, 20, size=18)
        value = 100 + 1.5 * error * rng.normal(size=18)
        value[6:10] = 300
        flagged = flag([run_pulls(value, error, run)[1], np.full(18, np.nan)], rate)
        whole += flagged[6:10].all()
        beside += np.delete(flagged, np.s_[6:10]).any()
    assert whole > 0.97 * wells
    assert binom.sf(beside - 1, wells, rate) > 1e-3


def test_a_run_of_few_windows_has_no_level() -> None:
    assert np.isnan(run_pulls(np.array([1.0, 2.0, 50.0]), np.ones(3), np.zeros(3, int))[0]).all()


def test_intervals_between_which_a_run_does_not_return_to_its_level_are_one() -> None:
    level, error = np.full(20, 40.0), np.full(20, 8.0)
    level[6:15] += 60.0
    noise = np.random.default_rng(3).standard_normal(20)
    inertia = 50.0 + noise[::-1], np.full(20, 1.0)
    flagged = np.isin(np.arange(20), [6, 7, 11, 14])
    run = np.zeros(20, dtype=np.int64)
    washed_out = level + 8 * noise, error
    assert np.flatnonzero(bridged(flagged, run, [washed_out, inertia])).tolist() == list(range(6, 15))
    level[8:11] = 40.0
    returned = level + 8 * noise, error
    expected = [6, 7, 11, 12, 13, 14]
    assert np.flatnonzero(bridged(flagged, run, [returned, inertia])).tolist() == expected
    # windows of another run, or without a fit, decide nothing
    run[9:] = 1
    assert np.flatnonzero(bridged(flagged, run, [washed_out, inertia])).tolist() == expected
    unknown = np.where(np.isin(np.arange(20), [12, 13]), np.nan, returned[0]), error
    assert np.flatnonzero(bridged(flagged, run * 0, [unknown])).tolist() == [6, 7, 11, 14]

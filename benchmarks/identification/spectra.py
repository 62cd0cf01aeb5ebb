"""What the spectra reach: time against a bare Fourier transform, and errors against their stated variances."""

import time
import timeit
from collections.abc import Callable, Sequence
from typing import Annotated

import numpy as np
import typer
from scipy.fft import rfft
from scipy.special import ndtri, stdtr

from benchmarks.identification.windows import SETTINGS, SimulatedWindow, grid, simulated_windows, spectra_of
from drillid.arrays import Complex, Floats
from drillid.discrepancy.stage import normality_p_value, whiteness_p_value
from drillid.excitation.torques import SWEEP_PERIOD, coloured_noise, exponential_sweeps
from drillid.physics.responses import command_mobility, laplace
from drillid.spectra.cross_spectra import Spectra, welch_spectra
from drillid.spectra.local_polynomial import local_spectra
from drillid.spectra.periodic import line_spectra
from drillid.spectra.stage import frequency_grid
from drillid.statistics import expected_ratio
from tests.simulated import RATE, WINDOW_S

_REPEATS = 50


def _channels() -> tuple[Floats, Floats, Floats]:
    """A window for timing: sweep, and twice noise of the same samples."""
    moments = np.arange(round(WINDOW_S * RATE)) / RATE
    generator = np.random.default_rng(0)
    speed, command = (coloured_noise(generator, moments.size, 1 / RATE, 1.0, 2.0) for _ in range(2))
    return exponential_sweeps(moments, 500.0, period=SWEEP_PERIOD), speed, command


def _seconds(work: Callable[[], object]) -> float:
    """Least processor time of many runs, s: the machine may be busy with other things."""
    return min(timeit.repeat(work, timer=time.process_time, repeat=_REPEATS, number=1))


def welch_over_fft() -> float:
    """Processor time of Welch's averages of one window over that of scipy.fft.rfft of its three channels."""
    channels = _channels()
    frequencies = frequency_grid(SETTINGS.spectra.segment_s / 2, SETTINGS.spectra, RATE)
    stacked = np.stack(channels)
    welch = _seconds(lambda: welch_spectra(*channels, RATE, SETTINGS.spectra.segment_s, frequencies))
    return welch / _seconds(lambda: rfft(stacked))


def local_polynomial_ms() -> dict[str, float]:
    """Processor time of one window at 50 Hz, ms: of a sweep that repeats, and of any excitation."""
    channels = _channels()
    lines = SETTINGS.spectra.noise_lines
    own = frequency_grid(SETTINGS.spectra.segment_s / 2, SETTINGS.spectra, RATE)
    return {
        "repeating": 1e3 * _seconds(lambda: line_spectra(*channels, RATE, SWEEP_PERIOD, grid(), lines)),
        "any": 1e3 * _seconds(lambda: local_spectra(*channels, RATE, own, lines // 4)),
    }


def lpm_ms() -> float:
    """Processor time of the local polynomial estimate of one window at 50 Hz, the slower of both kinds, ms."""
    return max(local_polynomial_ms().values())


def whitened_errors(windows: Sequence[SimulatedWindow]) -> tuple[Floats, Complex]:
    """Errors of the true model of each window, both (window, frequency).

    Returns
    -------
    ratio : |error|² over what its estimated variance makes of it in the mean, 1
    white : error as standard normal values, by Student's t with the variance's degrees of freedom
    """
    ratios, white = [], []
    for window in windows:
        spectra: Spectra = spectra_of(window)
        error = spectra.cross_speed / spectra.sweep_power - command_mobility(window.truth.system, laplace(grid()))
        variance = spectra.speed_noise / spectra.averages / spectra.sweep_power
        freedom = spectra.degrees_of_freedom
        inside = spectra.sweep_power > 1e-4 * np.median(spectra.sweep_power)
        ratios.append(np.where(inside, np.abs(error) ** 2 / variance / expected_ratio(freedom), np.nan))
        student = error * np.sqrt(2 / variance)
        normal = [ndtri(np.clip(stdtr(2 * freedom, part), 1e-300, 1 - 1e-16)) for part in (student.real, student.imag)]
        white.append(np.where(inside, normal[0] + 1j * normal[1], np.nan))
    return np.array(ratios), np.array(white)


def main(
    windows: Annotated[int, typer.Argument(min=1, help="How many simulated windows the errors are taken over.")] = 200,
) -> None:
    """Print times, and how well the stated variances hold."""
    print(f"Welch over a bare scipy.fft of the same samples   {welch_over_fft():6.2f}")
    for kind, value in local_polynomial_ms().items():
        print(f"local polynomials, sweep {kind:10s}, ms a window     {value:6.2f}")
    ratio, white = whitened_errors(simulated_windows(windows))
    rows = [row[np.isfinite(row)] for row in white]
    print(f"chi-squared per degree of freedom, true model     {np.nanmean(ratio):6.3f}   ({windows} windows)")
    for name, test in (("normality", normality_p_value), ("whiteness", whiteness_p_value)):
        refused = np.mean([test(row) < 0.01 for row in rows])
        print(f"windows refused at 1 % by the test of {name:10s}  {100 * refused:6.1f} %")


if __name__ == "__main__":
    typer.run(main)

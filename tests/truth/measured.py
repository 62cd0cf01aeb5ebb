"""Mobilities of windows of the time-domain simulator, as the tests of the fits take them."""

from drillid.config.settings import Settings
from drillid.fits.window_fit import Measured, measured_rows
from drillid.mobility.gate import gated_mobility
from drillid.spectra.cross_spectra import stacked
from drillid.spectra.periodic import line_spectra
from drillid.spectra.stage import frequency_grid
from tests.simulated import RATE, WINDOW_S, Truth, drilled

SETTINGS = Settings.checked({"fits": {"use_data_sheets": False}}, "test")


def measured(truth: Truth, seed: int) -> Measured:
    """The mobility of one window."""
    window, period = drilled(truth, WINDOW_S, seed), 120.0
    frequency = frequency_grid(period, SETTINGS.spectra, RATE)
    channels = (window["torque_sweep"], window["speed"], window["torque_command"])
    lines = line_spectra(*channels, RATE, period, frequency, SETTINGS.spectra.noise_lines)
    return measured_rows(gated_mobility(stacked([lines], frequency), SETTINGS.mobility))[0]

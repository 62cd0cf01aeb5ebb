"""Spectra → command mobility, and the responses of drive and control where the torque command is logged."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import xarray as xr

from drillid.errors import EstimationError
from drillid.mobility.channel_offset import channel_offset
from drillid.spectra.cross_spectra import Spectra


def command_mobility(spectra: xr.Dataset) -> xr.Dataset:
    """Command mobility with the injected sweep as instrument, its variance and coherence.

    The sweep is known without error and the noise is independent of it, so that the ratio is
    unbiased in closed loop too. The variance is that of the complex value.
    """
    power = spectra["sweep_power"]
    return xr.Dataset(
        {
            "command_mobility": spectra["cross_speed"] / power,
            "command_mobility_variance": spectra["speed_noise"] / spectra["averages"] / power,
            "averages": spectra["averages"],
            "degrees_of_freedom": spectra["degrees_of_freedom"],
            "coherence": (np.abs(spectra["cross_speed"]) ** 2 / (power * spectra["speed_power"])).clip(0, 1),
        }
    )


def closed_loop_responses(spectra: xr.Dataset) -> xr.Dataset:
    """Responses inside the control loop, where the torque command is logged; NaN where it is not.

    Joint input–output method with the sweep as instrument (Söderström and Stoica 1989, System
    Identification, chapter 10): the two responses to the sweep are divided, so that noise that
    circulates in the loop biases neither.

    - torque mobility ω/T_com = D e^(−sT_d)/(J_td s + Y_in), free of the controller;
    - control response −(T_com − T_sweep)/ω = A H, controller and filters alone.

    To first order the error of a ratio Q = X/Z is (x − Q z)/Z, with x and z the noise of both; its
    variance is theirs with their covariance. In an ideal log the command's noise is the speed's
    through A H, so that the control response is exact and its variance is that of the recording;
    the quantisation of the sweep, which repeats with it, causes the same error in every window.
    """
    power, averages = spectra["sweep_power"], spectra["averages"]
    speed, command = spectra["cross_speed"], spectra["cross_command"]
    speed_noise, command_noise, both = spectra["speed_noise"], spectra["command_noise"], spectra["cross_noise"]
    torque_mobility, control = speed / command, (power - command) / speed
    of_torque = speed_noise + np.abs(torque_mobility) ** 2 * command_noise - 2 * (np.conj(torque_mobility) * both).real
    of_control = command_noise + np.abs(control) ** 2 * speed_noise + 2 * (control * both).real
    # rounding leaves differences of equal terms a little above or below zero
    least_torque, least_control = (np.finfo(float).eps * noise for noise in (speed_noise, command_noise))
    of_torque = of_torque.where(of_torque > least_torque, least_torque)
    of_control = of_control.where(of_control > least_control, least_control)
    return xr.Dataset(
        {
            "torque_mobility": torque_mobility,
            "torque_mobility_variance": of_torque * power / np.abs(command) ** 2 / averages,
            "control_response": control,
            "control_response_variance": of_control * power / np.abs(speed) ** 2 / averages,
            "control_response_rounding": spectra["sweep_rounding"] * power / np.abs(speed) ** 2,
        }
    )


def channel_offsets(spectra: xr.Dataset) -> xr.Dataset:
    """Clock offset of the torque command's record in each window, with its standard error; NaN without a command, or
    where command or speed does not respond to the sweep.
    """
    frequencies = spectra["frequency"].values
    offsets = np.full((2, spectra.sizes["window"]), np.nan)
    for row in np.flatnonzero(spectra["cross_command"].notnull().all("frequency").values).tolist():
        with suppress(EstimationError):
            estimate = channel_offset(Spectra.of_row(spectra, row), frequencies)
            offsets[:, row] = estimate.offset, estimate.standard_error
    return xr.Dataset({"channel_offset": ("window", offsets[0]), "channel_offset_error": ("window", offsets[1])})

"""Cross spectra → command mobility, its variance, the coherence gate, and stacks of windows (paper, figure 7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from drillid.channel_offset import channel_offset
from drillid.cross_spectra import Spectra
from drillid.schema import WINDOW_COORDINATES, Gate
from drillid.statistics import sum_of_ratios_probability
from drillid.store import Problem, WellFolders, window_place

if TYPE_CHECKING:
    from drillid.config import MobilitySettings, Settings
    from drillid.sheets import Well

Floats = NDArray[np.float64]

_SWEEP_FLOOR = 1e-2
"""Sweep power below this share of its median counts as outside of the sweep.

Where the sweeps begin anew their slope jumps, so that a recorded sweep holds mirrored frequencies, at 50 Hz about
10⁻⁷ of its median power: 0.3 % of the amplitude at this floor, 0.03 % within the sweep's band."""


def command_mobility(spectra: xr.Dataset) -> xr.Dataset:
    """Command mobility with the injected sweep as instrument, its variance and coherence.

    The sweep is known without noise and the noise is independent of it, so that the ratio is
    without bias in closed loop too. The variance is that of the complex value.
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


def gated_mobility(spectra: xr.Dataset, settings: MobilitySettings) -> xr.Dataset:
    """Command mobility (window, frequency) with the limits of its coherence and which frequencies pass."""
    mobility = command_mobility(spectra)
    return mobility.merge(gate(spectra, mobility["coherence"], settings))


def closed_loop_responses(spectra: xr.Dataset) -> xr.Dataset:
    """Responses inside the control loop, where the torque command is logged; NaN where it is not.

    Joint input–output method with the sweep as instrument (Söderström and Stoica 1989, System
    Identification, chapter 10): both responses to the sweep are divided, so that noise that goes
    round the loop biases neither.

    - torque mobility ω/T_com = D e^(−sT_d)/(J_td s + Y_in), free of the controller;
    - control response −(T_com − T_sweep)/ω = A H, controller and filters alone.

    To first order the error of a ratio Q = X/Z is (x − Q z)/Z, with x and z the noise of both; its
    variance is theirs with their covariance. In a clean log the command's noise is the speed's
    through A H, so that the control response is exact and its variance is what the log adds; the
    steps of the recorded sweep, which repeat with it, add the same error in every window.
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
    """Clock offset of the torque command's record in each window, with its standard error; NaN without a command."""
    frequencies = spectra["frequency"].values
    found = np.full((2, spectra.sizes["window"]), np.nan)
    for row in np.flatnonzero(spectra["cross_command"].notnull().all("frequency").values).tolist():
        estimate = channel_offset(Spectra.of_row(spectra, row), frequencies)
        found[:, row] = estimate.offset, estimate.standard_error
    return xr.Dataset({"channel_offset": ("window", found[0]), "channel_offset_error": ("window", found[1])})


def gate(spectra: xr.Dataset, coherence: xr.DataArray, settings: MobilitySettings) -> xr.Dataset:
    """Least and largest coherence that a frequency may have, and which frequencies pass.

    Coherence γ² of n averages is the share of a signal-to-noise ratio F = (n − 1) γ²/(1 − γ²).
    Without response the mean of F over a band follows Fisher's F, whose upper quantile at the
    error rate gives the least coherence: a band passes or fails as a whole, so that no
    frequency is favoured for a lucky error. With response F follows the non-central F; the
    best three neighbours of a band, each per its sweep power, set its centre, and its upper
    quantile, at the error rate shared among the band's frequencies, gives the largest
    coherence: what is above has a noise too small to be believed.
    """
    from scipy.special import fdtri

    frequency = spectra["frequency"].values
    bands = np.floor(np.log2(frequency / frequency[0]) / settings.band_octaves).astype(int)
    shape, squared = coherence.shape, coherence.values
    signal = squared / np.maximum(1 - squared, 1e-12)
    numbers, freedoms = spectra["averages"].values, spectra["degrees_of_freedom"].values
    least, largest, gates = np.empty(shape), np.empty(shape), np.zeros(shape, dtype=np.int8)
    power = spectra["sweep_power"].values
    inside = power >= _SWEEP_FLOOR * np.median(power, axis=1, keepdims=True)
    for row in range(shape[0]):
        for band in np.unique(bands):
            member = bands == band
            usable = member & inside[row]
            count = max(int(usable.sum()), 1)
            averages, freedom = float(numbers[row, member].mean()), freedoms[row, member].mean()
            ratio = (averages - 1) * signal[row, usable]
            noise_freedom = max(min(freedom * count, (averages - 1) * count + freedom), 1e-3)
            bound = fdtri(2 * count, 2 * noise_freedom, 1 - settings.error_rate)
            best = _best_neighbours(ratio / power[row, usable]) if usable.any() else 0.0
            top = _largest_ratio(2 * best * power[row, member], freedom, settings.error_rate / count)
            least[row, member] = bound / (bound + averages - 1)
            largest[row, member] = top / (top + averages - 1)
            if usable.any() and ratio.mean() < bound:
                gates[row, member] = Gate.TOO_INCOHERENT
    gates[(gates == Gate.USED) & (squared > largest)] = Gate.TOO_COHERENT
    gates[~inside] = Gate.OUTSIDE_SWEEP
    dims = coherence.dims
    return xr.Dataset({"coherence_minimum": (dims, least), "coherence_maximum": (dims, largest), "gate": (dims, gates)})


def _largest_ratio(noncentrality: Floats, freedom: float, chance: float) -> Floats:
    """Upper quantile of the non-central F(2, 2ν), by Patnaik's central approximation (1949)."""
    from scipy.special import fdtri

    matched = (2 + noncentrality) ** 2 / (2 + 2 * noncentrality)
    return np.asarray((2 + noncentrality) / 2 * fdtri(matched, 2 * max(freedom, 1e-3), 1 - chance))


def _best_neighbours(ratio: Floats) -> float:
    width = min(3, ratio.size)
    return float(np.convolve(ratio, np.ones(width) / width, "valid").max())


def process(well: Well, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Command mobilities of all windows of a well, and their stacks."""
    spectra = folders.read("spectra", "spectra").drop_dims(["spectrogram_time", "spectrogram_frequency"]).load()
    mobility = gated_mobility(spectra, settings.mobility)
    mobility = mobility.merge(closed_loop_responses(spectra)).merge(channel_offsets(spectra))
    folders.write("mobility", "mobility", mobility.assign_coords({name: spectra[name] for name in WINDOW_COORDINATES}))
    stacks, problems = stack_windows(mobility, settings.mobility)
    folders.write("mobility", "stacks", stacks)
    return [*_unusable_windows(mobility), *problems]


def _unusable_windows(mobility: xr.Dataset) -> list[Problem]:
    used = (mobility["gate"] == Gate.USED).sum("frequency").values
    return [
        Problem(
            window_place(mobility, row),
            "no frequency passes the coherence gate",
            "Raise the sweep's amplitude or check the speed and sweep channels",
        )
        for row in np.flatnonzero(used == 0).tolist()
    ]


def stack_windows(mobility: xr.Dataset, settings: MobilitySettings) -> tuple[xr.Dataset, list[Problem]]:
    """Stacks of successive windows that share no sample, each weighted by its variance.

    A stack grows window by window as long as all of its windows agree within their variances and
    the depth changes little; where the next one does not agree, the stack ends with a row that
    says so. The error rate is shared among the tests that one stack can see.
    """
    stacks: list[xr.Dataset] = []
    problems: list[Problem] = []
    bound = settings.agreement_error_rate / (settings.stack_windows - 1)
    gates, depth = mobility["gate"].values, mobility["hole_depth"].values
    rows = [row for row in _without_overlap(mobility) if (gates[row] == Gate.USED).any()]
    while len(rows) > 1:
        members, chance = rows[:1], 1.0
        for row in rows[1 : settings.stack_windows]:
            if abs(depth[row] - depth[members[0]]) > settings.stack_depth_share * depth[row]:
                break
            agreement = agreement_probability(mobility.isel(window=[*members, row]))
            if not agreement >= bound:
                problems.append(_disagreement(mobility, members, row, agreement))
                break
            members, chance = [*members, row], agreement
        if len(members) > 1:
            stacks.append(_stack(mobility.isel(window=members), len(stacks), chance))
        rows = rows[len(members) :]
    if not stacks:
        return _no_stacks(mobility), problems
    return xr.concat(stacks, "stack", coords="minimal", compat="override", join="exact"), problems


def _without_overlap(mobility: xr.Dataset) -> list[int]:
    """Rows of windows that begin after the one before has ended."""
    chosen: list[int] = []
    for row, start in enumerate(mobility["start"].values):
        if not chosen or start >= mobility["end"].values[chosen[-1]]:
            chosen.append(row)
    return chosen


def agreement_probability(windows: xr.Dataset) -> float:
    """Chance of so much disagreement between windows (window, frequency) with one common mobility.

    Welch's test of equal means with estimated variances (1951) at each frequency, summed over them.
    """
    used = (windows["gate"] == Gate.USED).values.all(axis=0)
    if not used.any():
        return float("nan")
    mobility = windows["command_mobility"].values[:, used]
    variance = windows["command_mobility_variance"].values[:, used]
    freedom = windows["degrees_of_freedom"].values[:, used]
    weight = 1 / variance
    mean = np.sum(mobility * weight, axis=0) / np.sum(weight, axis=0)
    total = np.sum(np.abs(mobility - mean) ** 2 * weight, axis=0)
    contrasts = weight.shape[0] - 1
    spread = np.sum((1 - weight / weight.sum(axis=0)) ** 2 / (2 * freedom), axis=0)
    inflation = 1 + 2 * (contrasts - 1) / (contrasts * (contrasts + 2)) * spread
    pooled = contrasts * (contrasts + 2) / (6 * spread)
    shared = sharing(freedom, windows["averages"].values[:, used]).mean(axis=0) * contrasts
    return sum_of_ratios_probability(
        float(np.sum(total / inflation)), np.tile(pooled, contrasts), np.tile(shared, contrasts), fitted=0.0
    )


def sharing(degrees_of_freedom: Floats, averages: Floats) -> Floats:
    """How many frequencies one noise line serves: ν of its estimate against the n − 1 lines each frequency brings."""
    return np.maximum(degrees_of_freedom / np.maximum(averages - 1, 1e-9), 1.0)


def _stack(windows: xr.Dataset, number: int, chance: float) -> xr.Dataset:
    """Mean weighted by the estimated variances, whose own errors its variance counts (Meier 1953)."""
    used = windows["gate"] == Gate.USED
    weight = xr.where(used, 1 / windows["command_mobility_variance"], 0.0)
    total = weight.sum("window")
    some = total > 0
    share = weight / total.where(some)
    mobility = (share * windows["command_mobility"]).sum("window").where(some)
    inflation = 1 + (2 * share * (1 - share) / windows["degrees_of_freedom"]).sum("window")
    variance = inflation / total.where(some)
    averages = xr.where(used, windows["averages"], 0.0).sum("window")
    signal = np.abs(mobility) ** 2 / variance
    stack = xr.Dataset(
        {
            "command_mobility": mobility,
            "command_mobility_variance": variance,
            "averages": xr.where(used, windows["averages"] - 1, 0.0).sum("window") + 1,
            "degrees_of_freedom": xr.where(used, windows["degrees_of_freedom"], 0.0).sum("window"),
            "coherence": (signal / (signal + averages - 1)).where(some, 0.0),
            "coherence_minimum": windows["coherence_minimum"].mean("window"),
            "coherence_maximum": windows["coherence_maximum"].mean("window"),
            "gate": xr.where(some, np.int8(Gate.USED), windows["gate"].max("window")),
            "agreement_probability": chance,
            "windows": windows.sizes["window"],
        }
    )
    return stack.expand_dims(stack=[number]).assign_coords(
        hole_depth=("stack", [float(windows["hole_depth"].mean())]),
        first_window=("stack", [int(windows["window"][0])]),
        last_window=("stack", [int(windows["window"][-1])]),
    )


def _disagreement(mobility: xr.Dataset, members: list[int], row: int, chance: float) -> Problem:
    names = [str(int(mobility["window"][member])) for member in members]
    others = f"windows {names[0]} to {names[-1]}" if len(names) > 1 else f"window {names[0]}"
    where = window_place(mobility, row)
    if np.isnan(chance):
        what = f"shares no frequency that passes the gate with {others}; they are not stacked"
        return Problem(where, what, "Look at the coherence of these windows")
    return Problem(
        where,
        f"does not agree with {others} (chance {chance:.2g}), so they are not stacked",
        "None needed: the string changed between them; see the parameters against depth",
    )


def _no_stacks(mobility: xr.Dataset) -> xr.Dataset:
    return _stack(mobility.isel(window=[0]), 0, 1.0).isel(stack=slice(0, 0))

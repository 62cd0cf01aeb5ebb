"""How much torque other excitations need for the coherence of three simultaneous exponential sweeps.

Run by `python -m benchmarks.excitation`. A 3200 m string under the published speed control, bit noise of 500 N m rms
below 2 Hz, and a 10-minute window; coherence is compared at the middle of each half octave from 0.05 to 4 Hz.
"""

from dataclasses import dataclass

import numpy as np
import typer

from drillid.arrays import Floats
from drillid.excitation.design import Experiment, crest_factor, design, half_octaves, lines_within, power_per_band
from drillid.excitation.torques import (
    SWEEP_BANDS,
    band_limited_noise,
    coloured_noise_density,
    exponential_sweeps,
    linear_sweep,
    odd_multisine,
    powered_sweep,
    white_noise,
)
from drillid.physics.eight_parameters import KnownEquipment
from drillid.physics.equipment import Controller, polar_moment
from drillid.physics.parameters import PARAMETERS

BAND = (0.05, 4.0)
RATE = 50.0
PERIOD = 120.0
WINDOW = 600.0
AMPLITUDE = 500.0
"""N m, of each of the three sweeps."""
NEGLIGIBLE_SHARE = 1e-6
"""Share of power below which a half octave counts as not excited."""
DETERMINED = (2, 3, 5, 7)
"""Parameters whose errors are shown: those that one window determines."""


@dataclass(frozen=True)
class Row:
    """One excitation against the three sweeps."""

    name: str
    crest: float
    rms_everywhere: float
    """N m rms for at least the sweeps' coherence in every half octave; infinite where one is not excited."""
    rms_middle: float
    """N m rms for the sweeps' coherence in the median half octave."""
    errors: Floats
    """Relative standard errors of the parameters that one window determines, at the sweeps' rms."""


def experiment() -> Experiment:
    """The rig of the physics page with half a kilonewton metre of bit noise."""
    pipe, collars = polar_moment(0.1397, 0.1214), polar_moment(0.1651, 0.0714)
    equipment = KnownEquipment(Controller(1500.0, 800.0), 100.0, collars)
    parameters = np.array([200.0, 2.5e8, 3100.0, pipe, 0.04, 1105.0, 40.0, equipment.collar_inertia + 40.0])
    frequency = np.geomspace(0.01, 25.0, 400)
    return Experiment(parameters, equipment, frequency, coloured_noise_density(frequency, 500.0, 2.0), WINDOW)


def torques(case: Experiment) -> dict[str, Floats]:
    """Whole periods at 50 Hz; noises are as long as the window, as they do not repeat."""
    time, long = np.arange(0, PERIOD, 1 / RATE), round(WINDOW * RATE)
    generator = np.random.default_rng(1)
    best = design(case, 1.0, tuple(list(PARAMETERS)[index] for index in DETERMINED), band=BAND)
    odd, _ = odd_multisine(generator, 600.0, BAND, PERIOD)
    return {
        "three exponential sweeps": exponential_sweeps(time, AMPLITUDE, SWEEP_BANDS, PERIOD),
        "one exponential sweep": exponential_sweeps(time, AMPLITUDE, [BAND], PERIOD),
        "linear sweep": linear_sweep(time, AMPLITUDE, BAND, PERIOD),
        "odd multisine, random phases": odd.sampled(time.size),
        "odd multisine, low crest": odd.with_low_crest().sampled(time.size),
        "designed sweep": powered_sweep(time, AMPLITUDE, best.edges, best.power, PERIOD),
        "designed multisine": best.multisine(PERIOD).sampled(time.size),
        "noise, 0.05 to 4 Hz": band_limited_noise(generator, long, 1 / RATE, 600.0, BAND),
        "white noise to 25 Hz": white_noise(generator, long, 600.0),
    }


def table(case: Experiment) -> list[Row]:
    """All excitations against the three sweeps."""
    edges = half_octaves(*BAND)
    signals = torques(case)
    sweeps = signals["three exponential sweeps"]
    reference, rms = power_per_band(sweeps, RATE, edges), float(np.sqrt(np.mean(sweeps**2)))
    rows = []
    for name, torque in signals.items():
        mean_square = float(np.mean(torque**2))
        share = power_per_band(torque, RATE, edges) / mean_square
        needed = np.sqrt(np.divide(reference, share, out=np.full_like(share, np.inf), where=share > NEGLIGIBLE_SHARE))
        frequency, power = lines_within(torque, RATE, BAND)
        errors = case.standard_errors(frequency, power * rms**2 / mean_square) / case.parameters
        everywhere, middle = float(needed.max()), float(np.median(needed))
        rows.append(Row(name, crest_factor(torque), everywhere, middle, errors[list(DETERMINED)]))
    return rows


def main() -> None:
    """Print the tables."""
    case = experiment()
    rows = table(case)
    edges = half_octaves(*BAND)
    reference = power_per_band(torques(case)["three exponential sweeps"], RATE, edges)
    coherence = case.coherence(np.sqrt(edges[1:] * edges[:-1]), reference / np.diff(edges))
    print("Coherence of the three sweeps in each half octave:", " ".join(f"{value:.2f}" for value in coherence))
    names = [list(PARAMETERS)[index] for index in DETERMINED]
    print("Torque for that coherence, N m, and relative errors at the sweeps' own rms, %")
    print(f"{'':30}{'crest':>6}{'rms everywhere':>16}{'peak':>7}{'rms in the middle':>19}{'peak':>7}", end="")
    print("".join(f"{name:>14}" for name in names))
    for row in rows:
        print(f"{row.name:30}{row.crest:6.2f}{row.rms_everywhere:16.0f}{row.rms_everywhere * row.crest:7.0f}", end="")
        print(f"{row.rms_middle:19.0f}{row.rms_middle * row.crest:7.0f}", end="")
        print("".join(f"{100 * error:14.2f}" for error in row.errors))


if __name__ == "__main__":
    typer.run(main)

"""Stiff, soft and impedance-matched speed control of one identified rig, tuned and compared.

The rig is that of `benchmarks.excitation`, with the uncertainty of one of its windows; the bit's torque per weight
falls from 60 to 30 mm with a threshold speed of 6 rad/s.
"""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from benchmarks.excitation import AMPLITUDE, BAND, PERIOD, RATE, experiment
from drillid.control.stick_slip import simulated_lowest_speed, stick_slip_map
from drillid.control.tuning import Family, Tuning, controlled_by, first_sample, sampled_systems, tune
from drillid.excitation.design import lines_within
from drillid.excitation.torques import exponential_sweeps
from drillid.figures.control import draw_bit_mobility, draw_stick_slip_map
from drillid.figures.layout import save
from drillid.physics.equipment import Controller
from drillid.physics.nonlinear import Cutting, Weakening

STIFF = Controller(20000.0, 20000.0)
CUTTING = Cutting(0.06, 0.03, Weakening(6.0))
WEIGHTS = np.linspace(2e4, 2e5, 37)
SIMULATED_WEIGHT = 1e5
_DPI = 150
FAMILIES: dict[str, Family] = {
    "soft torque": "proportional integral",
    "soft torque, inertia compensated": "inertia compensation",
    "impedance matched": "impedance matching",
}


def main(
    folder: Annotated[
        Path | None,
        typer.Argument(help="Folder for the drawings of stick-slip map and bit mobility; without it none are drawn."),
    ] = None,
) -> None:
    """Tune controllers of three families and print their performance."""
    case = experiment()
    frequency, power = lines_within(exponential_sweeps(np.arange(0, PERIOD, 1 / RATE), AMPLITUDE), RATE, BAND)
    samples = sampled_systems(case.parameters, case.covariance(frequency, power), case.equipment)
    system = first_sample(samples)
    stiff = controlled_by(samples, STIFF)
    tuned = {name: tune(stiff, family) for name, family in FAMILIES.items()}
    controllers = {"stiff": STIFF} | {name: tuning.controller for name, tuning in tuned.items()}
    stability = stick_slip_map(system, CUTTING, WEIGHTS, controllers)
    simulated = {}
    for name, controller in controllers.items():
        predicted = float(np.interp(SIMULATED_WEIGHT, stability.weight, stability.speed[name]))
        bracket = (0.93 * predicted, 1.07 * predicted)
        lowest = simulated_lowest_speed(controlled_by(system, controller), CUTTING, SIMULATED_WEIGHT, bracket)
        simulated[name] = (SIMULATED_WEIGHT, lowest)
        print(f"{name:34}{_row(tuned.get(name), predicted, lowest)}")
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        save(draw_stick_slip_map(stability, simulated), folder / "stick_slip_map.png", _DPI)
        systems = {name: controlled_by(samples, controller) for name, controller in controllers.items()}
        save(draw_bit_mobility(systems), folder / "bit_mobility_controlled.png", _DPI)


def _row(tuning: Tuning | None, predicted: float, simulated: float) -> str:
    rpm = 30 / np.pi
    text = (
        f"stable from {predicted * rpm:5.1f} rpm at {SIMULATED_WEIGHT / 1e3:.0f} kN, simulated {simulated * rpm:5.1f}"
    )
    if tuning is None:
        return text
    settings = ", ".join(f"{name} {value:.4g} {unit}" for name, (value, unit) in tuning.in_units().items())
    kept = tuning.margins
    margins = f"gain {kept.gain.min():.1f}, phase {np.degrees(kept.phase.min()):.0f} deg, sensitivity "
    peak = f"bit mobility at most {tuning.value * 1e3 * rpm:.1f} rpm/(kN m), stiff {tuning.present * 1e3 * rpm:.1f}"
    return f"{text}; {peak}; {margins}{kept.sensitivity.max():.2f}; {settings}"


if __name__ == "__main__":
    typer.run(main)

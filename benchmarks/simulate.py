"""How many times faster than real time the simulator runs a 4000 m string in elements of 15 m, on one core.

Run it as `python -m benchmarks.simulate` at the root of the project.
"""

import timeit
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import typer

from drillid.excitation.torques import exponential_sweeps
from drillid.physics.damping import RootDrag
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Motor, Section, TopDrive, polar_moment
from drillid.physics.nonlinear import (
    Cutting,
    DriveLimits,
    Gear,
    NonlinearRig,
    RegenerativeBit,
    SpeedSensor,
    Weakening,
)
from drillid.physics.soft_string import Pipe, Survey, side_forces, wall_contact
from drillid.simulation.simulate import Simulation, simulate

ELEMENT = 15.0
SIMULATED = 600.0
SPEED, WEIGHT = 12.0, 8e4

_PIPE = Section(3900.0, polar_moment(0.1397, 0.1214), kappa=200.0, delta=2.5e8)
_COLLARS = Section(100.0, polar_moment(0.1651, 0.0714), kappa=200.0, delta=2.5e8)
SYSTEM = DrillingSystem(TopDrive(1100.0, 0.04, Controller(1500.0, 800.0)), (_PIPE, _COLLARS), Bit(40.0, 40.0))
TIME_STEP = ELEMENT / float(np.sqrt(_PIPE.shear_modulus / _PIPE.density))


def rigs() -> dict[str, NonlinearRig]:
    """Rigs from a linear one to one with all nonlinear parts."""
    survey = Survey.from_degrees([0, 500, 1500, 4000], [0, 0, 50, 50])
    tally = [Pipe(3900.0, 0.1397, 0.1214, 0.168), Pipe(100.0, 0.1651, 0.0714, 0.1651)]
    contact = wall_contact(side_forces(survey, tally, 1200.0, WEIGHT), 0.25, 0.2, Weakening(1.0))
    cutting = Cutting(0.08, 0.04, Weakening(4.0))
    full = NonlinearRig(
        replace(SYSTEM, top_drive=replace(SYSTEM.top_drive, delay_jitter=0.002), motor=Motor(5e4, 200.0, 20.0)),
        contact=contact,
        cutting=cutting,
        regenerative=RegenerativeBit(5, 2e5, 0.004, 1e-6),
        gear=Gear(0.02, 150.0, 1e6),
        limits=DriveLimits(torque=40e3, rate=50e3, jitter_interval=4 * TIME_STEP),
        sensor=SpeedSensor(resolution=0.01, ripple=0.002),
        control_interval=2 * TIME_STEP,
    )
    dragged = replace(SYSTEM, string=(replace(_PIPE, laws=(RootDrag(100.0),)), _COLLARS))
    return {
        "linear": NonlinearRig(SYSTEM),
        "Stribeck bit": NonlinearRig(SYSTEM, cutting=cutting),
        "wall contact": NonlinearRig(SYSTEM, contact=contact, cutting=cutting),
        "everything but laws with memory": full,
        "drag of mud, with memory": NonlinearRig(dragged),
    }


def run(rig: NonlinearRig, energies: bool) -> Simulation:
    """Start of rotation, then drilling with the sweep."""
    steps = TIME_STEP * np.arange(round(SIMULATED / TIME_STEP))
    return simulate(
        rig,
        np.where(steps > 60, exponential_sweeps(steps, 500.0), 0.0),
        SPEED * np.interp(steps, [0, 10], [0.0, 1.0]),
        np.zeros(steps.size),
        weight_on_bit=WEIGHT * np.interp(steps, [30, 40], [0.0, 1.0]),
        time_step=TIME_STEP,
        sample_interval=4 * TIME_STEP,
        energies=energies,
    )


def ratio(task: Callable[[], object]) -> float:
    """Simulated seconds per second, best of three, after one run that compiles."""
    task()
    return SIMULATED / min(timeit.repeat(task, repeat=3, number=1))


def main() -> None:
    """Print one line for each rig."""
    print(f"{SIMULATED:.0f} s of a 4000 m string, elements of {ELEMENT:.0f} m, step {1e3 * TIME_STEP:.2f} ms")
    for name, rig in rigs().items():
        plain, accounted = (ratio(partial(run, rig, on)) for on in (False, True))
        print(f"{name:34s} {plain:7.0f} times real time, {accounted:7.0f} with the energies")


if __name__ == "__main__":
    typer.run(main)

"""What a cause leaves must be noise, however much it explains: a string that no catalogue holds, from the simulator."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from drillid.config.settings import Settings
from drillid.discrepancy.catalogue import CATALOGUE, Cause
from drillid.discrepancy.evidence import OperatingPoints
from drillid.discrepancy.gather import Series, gather
from drillid.discrepancy.inference.unknown import ALONG_PIPE
from drillid.discrepancy.verdicts.engine import examine
from drillid.discrepancy.verdicts.verdict import UNKNOWN, Verdict
from drillid.excitation.torques import coloured_noise, exponential_sweeps
from drillid.fits.datasheet import DataSheet
from drillid.physics.equipment import DrillingSystem, Section
from drillid.simulation.simulate import SAMPLE_INTERVAL, simulate
from tests.simulated import DEEP, LEAD_IN_S, RATE, WINDOW_S

STEP, NOISE, SPEED = 0.005, 100.0, 10.5
PIECE, PERIOD = 50.0, 600.0
"""m"""


def rippled(pipe: Section, ripple: float) -> tuple[Section, ...]:
    """The pipe with a wall that is thicker and thinner in turn, by a share of its polar moment."""
    begins = np.arange(0.0, pipe.length, PIECE)
    moments = pipe.polar_moment * (1 + ripple * np.sin(2 * np.pi * (begins + PIECE / 2) / PERIOD))
    return tuple(replace(pipe, length=PIECE, polar_moment=float(moment)) for moment in moments)


def verdict_on(ripple: float, causes: Sequence[Cause] | None = None) -> Verdict:
    """The only verdict on a window of ten minutes, given all causes or some."""
    steps = round((LEAD_IN_S + WINDOW_S) / STEP)
    noise = coloured_noise(np.random.default_rng(3), steps, STEP, NOISE, 2.0)
    result = simulate(
        DrillingSystem(DEEP.top_drive, (*rippled(DEEP.pipe, ripple), DEEP.collars), DEEP.bit),
        exponential_sweeps(np.arange(steps) * STEP, DEEP.sweep_amplitude),
        np.full(steps, SPEED),
        DEEP.bit_torque + noise,
        mean_bit_torque=DEEP.bit_torque,
        time_step=STEP,
    )
    sweep = exponential_sweeps(result.time, DEEP.sweep_amplitude)
    channels = (sweep, result.speed_reading, result.torque_command)
    window = Series(*(values[round(LEAD_IN_S / SAMPLE_INTERVAL) :] for values in channels))
    depth, mean = np.array([DEEP.bit_depth]), np.array([SPEED])
    points = OperatingPoints(depth, depth, mean, np.array([DEEP.bit_torque]), np.array([np.nan]))
    sheet = DataSheet(
        DEEP.top_drive.controller,
        collar_length=float(DEEP.collars.length),
        collar_polar_moment=float(DEEP.collars.polar_moment),
        delay=float(DEEP.top_drive.delay),
        delay_error=0.004,
        inertia_td=float(DEEP.top_drive.inertia),
        inertia_td_error=0.02 * float(DEEP.top_drive.inertia),
        polar_moment=float(DEEP.pipe.polar_moment),
        polar_moment_error=0.05 * float(DEEP.pipe.polar_moment),
        length_relative=0.02,
        control_interval=SAMPLE_INTERVAL / 8,
    )
    (verdict,) = examine(gather([window], RATE, points, sheet, Settings()), catalogue=causes).verdicts
    return verdict


def test_a_ripple_of_the_wall_is_unknown_however_much_a_cause_explains() -> None:
    verdict = verdict_on(0.45)
    assert verdict.verdict == UNKNOWN
    assert "the nearest known effect is" in verdict.evidence


def test_a_slight_ripple_that_reflects_within_a_narrow_band_is_seen_along_the_pipe() -> None:
    along = ("extra_section", "tapered_string", "local_damping_zone", "distributed_bha", "wave_speed")
    verdict = verdict_on(0.1, [CATALOGUE[name] for name in along])
    assert (verdict.verdict, verdict.family) == (UNKNOWN, ALONG_PIPE)

"""Sections too short for the simulator's time step."""

from dataclasses import replace

import numpy as np
import pytest

from drillid.errors import SettingsError
from drillid.physics.attachments import MountedInertia, with_law
from drillid.physics.equipment import DrillingSystem
from drillid.physics.nonlinear import NonlinearRig
from drillid.physics.responses import command_mobility, laplace
from drillid.simulation.grid import element_counts
from drillid.simulation.short_sections import with_short_sections_extended
from tests.truth.rigs import SYSTEM

STEP = 0.005
FREQUENCY = np.geomspace(0.05, 4.0, 60)


def _cut(*lengths: float) -> DrillingSystem:
    """The usual system with more sections of strong damping at the end of its pipe, taken from its length."""
    pipe, *below = SYSTEM.string
    pieces = [replace(pipe, length=length, kappa=1e5) for length in lengths]
    return replace(SYSTEM, string=(replace(pipe, length=pipe.length - sum(lengths)), *pieces, *below))


def test_a_section_of_no_length_changes_nothing() -> None:
    joined = with_short_sections_extended(_cut(0.0), STEP)
    assert joined == SYSTEM
    with pytest.raises(SettingsError, match="section of 0"):
        element_counts(NonlinearRig(_cut(0.0)), STEP)


@pytest.mark.parametrize("lengths", [(6.0,), (6.0, 3.0), (200.0, 6.0), (6.0, 200.0)])
def test_short_sections_keep_inertia_drag_and_responses(lengths: tuple[float, ...]) -> None:
    system = _cut(*lengths)
    joined = with_short_sections_extended(system, STEP)
    element_counts(NonlinearRig(joined), STEP)

    def drag(which: DrillingSystem) -> float:
        return sum(float(each.kappa * each.polar_moment * each.length) for each in which.string)

    assert sum(each.length for each in joined.string) == pytest.approx(sum(each.length for each in system.string))
    assert sum(each.inertia for each in joined.string) == pytest.approx(sum(each.inertia for each in system.string))
    assert drag(joined) == pytest.approx(drag(system))
    s = laplace(FREQUENCY)
    there, here = command_mobility(joined, s), command_mobility(system, s)
    dropped = command_mobility(_cut(*(length for length in lengths if length > 100.0)), s)
    assert np.abs(there - here).max() < 0.02 * np.abs(here).max()
    assert np.linalg.norm(there - here) < 0.2 * np.linalg.norm(dropped - here)


@pytest.mark.parametrize("depth", [13.0, 15.0, 2885.0, 2887.0])
def test_an_inertia_mounted_beside_a_short_section_is_kept(depth: float) -> None:
    """3 m or 5 m of pipe are left beside the 20 m that it is spread over."""
    mounted = with_law(SYSTEM.string, depth, MountedInertia(300.0, 1.0, 0.1))
    joined = with_short_sections_extended(replace(SYSTEM, string=mounted), 0.0025)
    element_counts(NonlinearRig(joined), 0.0025)
    laws = [(law, section) for section in joined.string for law in section.laws]
    whole = sum(law.inertia * section.length / law.spread for law, section in laws if isinstance(law, MountedInertia))
    assert whole == pytest.approx(300.0)
    s = laplace(FREQUENCY)
    there, here = command_mobility(joined, s), command_mobility(replace(SYSTEM, string=mounted), s)
    # its place moves by less than a wave passes in a time step
    assert np.linalg.norm(there - here) < 0.03 * np.linalg.norm(command_mobility(SYSTEM, s) - here)

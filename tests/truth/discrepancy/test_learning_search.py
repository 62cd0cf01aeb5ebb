"""A heavy inertia on a spring is found although the base model has absorbed its effect in parameters of its own."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from drillid.config.rig import Rig
from drillid.discrepancy.inference.base_fit import fit_base
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.learning.elements import ELEMENTS
from drillid.discrepancy.learning.search import best_of
from drillid.physics.attachments import MountedInertia, with_law
from drillid.physics.equipment import DrillingSystem
from tests.simulated import DEEP, WINDOW_S, Truth, drilled
from tests.truth.discrepancy.wells import evidence_of

MOUNT = MountedInertia(inertia=100.0, frequency=1.0, loss=0.06)
PLACES = 0.4, 0.22, 0.62
SHEETS = {
    "name": "deep",
    "channels": {
        name: {"column": name, "unit": unit}
        for name, unit in (("torque_command", "N m"), ("torque_sweep", "N m"), ("speed", "rad/s"), ("bit_depth", "m"))
    },
    "controller": {"proportional": "1500 N m s/rad", "integral": "800 N m/rad"},
    "drive_delay": {"value": "0.041 s", "tolerance": "0.003 s"},
    "top_drive_inertia": {"value": "1120 kg m^2", "relative": "3 %"},
    "pipe": {"outer_diameter": "139.7 mm", "inner_diameter": "121.4 mm"},
    "collars": [{"outer_diameter": "165.1 mm", "inner_diameter": "71.4 mm", "length": "100 m"}],
}


@dataclass(frozen=True)
class Mounted(Truth):
    """A deep rig with the inertia on its string."""

    place: float = 0.0
    """Share of the depth."""

    @property
    def system(self) -> DrillingSystem:
        """All of the equipment."""
        return DrillingSystem(
            self.top_drive, with_law((self.pipe, self.collars), self.place * self.bit_depth, MOUNT), self.bit
        )


def heavy(place: float) -> tuple[SetModel, SetFit]:
    """Four windows and the base model's fit to them."""
    truth = Mounted(**vars(replace(DEEP, bit_noise=200.0)), place=place)
    stands = [drilled(truth, 2 * WINDOW_S, seed) for seed in (51, 52)]
    return fit_base(evidence_of(truth, stands, Rig.checked(SHEETS, "deep")))


@pytest.mark.parametrize("place", PLACES)
def test_a_heavy_mounted_inertia_is_found_wherever_it_hangs(place: float) -> None:
    model, base = heavy(place)
    element = next(each for each in ELEMENTS if each.name == "mounted inertia")
    found = best_of(model, base, (), element)
    # a right model leaves one per complex value
    assert found.fit.cost < 1.1 * np.count_nonzero(model.measured.weight) < base.cost
    assert found.place == pytest.approx(place, abs=0.02)
    truth = np.array([MOUNT.inertia, MOUNT.frequency, MOUNT.loss])
    assert np.all(np.abs(found.fit.point.sizes - truth) < 4 * found.fit.size_errors)

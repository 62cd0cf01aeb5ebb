"""Rounding of the recorded speed to steps, as a part of the noise."""

import numpy as np

from drillid.discrepancy.detectors.detector import Inspection
from drillid.discrepancy.rules import ROUNDING_HIDES
from drillid.records.quality import quantisation_step


def rounding(inspection: Inspection) -> tuple[float, float]:
    """Step of the recorded speed, rad/s, and the share of its rounding in all noise; NaN and 0 where there is none."""
    step = quantisation_step(inspection.logged.speed)
    if step is None:
        return np.nan, 0.0
    residual = inspection.residual
    # one-sided densities, (rad/s)²/Hz
    of_steps = step**2 / 6 / residual.sample_rate
    density = 2 * residual.noise / (residual.record.rate * np.sum(residual.taper**2))
    return step, of_steps / float(np.median(density[residual.inside]))


def rounding_hides(inspection: Inspection) -> bool:
    """Whether steps are so coarse that their noise grows with the sweep, and their slopes hide the acceleration."""
    return rounding(inspection)[1] > ROUNDING_HIDES

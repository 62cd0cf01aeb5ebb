"""Evidence for something unknown in a response: a smooth disturbance at a port, fitted with the base's own figures.

A disturbance that is not small bends the response more than its linear effect says, and a base that is far from the
data has no useful derivative. So each port's disturbance is fitted, for some amplitudes of its prior.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.discoveries.response import Fit, fit
from drillid.arrays import Complex
from drillid.discrepancy.catalogue import WindowModel
from drillid.discrepancy.inference import unknown
from drillid.discrepancy.inference.smooth import smooth_functions
from drillid.physics.responses import laplace
from drillid.physics.top_drive import drive

_EVALUATIONS = 60
_STEP = 0.1
_AMPLITUDES = 3.0 * _STEP ** np.arange(4)
"""Standard deviations of the prior, relative to the response or to the top's inertia at the middle frequency."""


@dataclass(frozen=True, eq=False)
class Smooth:
    """A smooth complex function of log frequency: the record's factor less one, or an admittance at top or bit."""

    port: str
    basis: Complex
    """(coefficient, F), with the amplitude."""

    def mobility(self, window_model: WindowModel, value: Any, s: Complex) -> Any:
        """The disturbed response."""
        if self.port == "record":
            return window_model.mobility(s) * (1 + value)
        system = window_model.system
        if self.port == "bit":
            bit = replace(system.bit, damping=system.bit.damping + value)
            return replace(window_model, system=replace(system, bit=bit)).mobility(s)
        mobility = window_model.mobility(s)
        command = window_model.recording.transfer(s) * drive(system.top_drive, s)
        return mobility / (1 + value * mobility / command)


def unknown_evidence(base: Fit) -> dict[str, float]:
    """Log Bayes factor of a disturbance at each port of the problem, its amplitude averaged over."""
    return {port: _evidence(base, port) for port in base.problem.ports}


def average(ports: Mapping[str, float]) -> float:
    """Log Bayes factor averaged over the ports."""
    from scipy.special import logsumexp

    return float(logsumexp(list(ports.values())) - np.log(len(ports)))


def _evidence(base: Fit, port: str) -> float:
    from scipy.special import logsumexp

    measured, inertia = base.problem.measured, base.problem.window_model(base.coordinates).system.top_drive.inertia
    real = smooth_functions(measured.frequency, unknown.FUNCTIONS)
    scale = 1.0 if port == "record" else float(inertia) * float(np.median(np.abs(laplace(measured.frequency))))
    both = np.concatenate([real, 1j * real]) * scale
    rest, none, count = np.linalg.slogdet(base.information)[1], np.zeros(len(both)), base.coordinates.size
    undisturbed, warm = np.append(base.coordinates, none), np.append(np.zeros(count), none)
    found: list[float] = []
    for amplitude in _AMPLITUDES:
        more = fit(replace(base.problem, disturbance=Smooth(port, both * amplitude)), [undisturbed, warm], _EVALUATIONS)
        found.append(base.cost - more.cost - 0.5 * (np.linalg.slogdet(more.information)[1] - rest))
        warm = np.append(more.coordinates[:count], more.coordinates[count:] / _STEP)
    return float(logsumexp(found) - np.log(len(found)))

"""Damping laws with memory in the time domain: each is fitted by a sum of relaxations.

A law's shunt admittance per length becomes d + m s + Σ rₖ s/(s + pₖ), a damper, an inertia and Maxwell elements;
its series admittance times length becomes c/s + d + Σ gₖ/(s + pₖ), a stiffness, a damper
and Maxwell elements. All but c are non-negative, so that the sum is as passive as the law. The √s of mud drag is
the limit of such a sum for ever denser pₖ (diffusive representation, Montseny 1998, ESAIM Proceedings 5, 159–175).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drillid.arrays import Array, Floats
from drillid.errors import SettingsError
from drillid.physics.attachments import MountedInertia, Relaxation
from drillid.physics.damping import ConstantLossFactor, DampingLaw, HystereticLoss
from drillid.physics.equipment import Section

RATES = 2 * np.pi * np.geomspace(0.004, 60.0, 18)
"""pₖ of any law, rad/s."""
FITTED = 2j * np.pi * np.geomspace(0.02, 15.0, 120)
"""s at which laws are fitted, rad/s."""
LARGEST_MISFIT = 0.02
"""Relative to the law."""


@dataclass(frozen=True, eq=False)
class Relaxations:
    """All laws of one section, per length of string."""

    damping: float
    """d of the shunt, N s/rad."""
    inertia: float
    """m of the shunt, kg m."""
    shunt: Floats
    """(rates,) rₖ, N s/rad."""
    stiffness: float
    """c of the series, N m²/rad."""
    coupling: float
    """d of the series, N m² s/rad."""
    series: Floats
    """(rates,) gₖ, N m²/rad."""


def rates_of(string: Sequence[Section]) -> Floats:
    """pₖ for a string, rad/s: RATES, and those of laws that are single relaxations themselves."""
    own = {float(law.rate) for section in string for law in section.laws if isinstance(law, Relaxation)}
    return np.append(RATES, sorted(rate for rate in own if rate > 0))


def relaxations(section: Section, rates: Floats = RATES) -> Relaxations:
    """Fit all laws of a section except mounted inertias, which are simulated as bodies of their own.

    Ideal hysteretic damping, which is not causal, becomes a constant loss factor.

    Raises
    ------
    SettingsError
        If the sum misses a law by more than LARGEST_MISFIT.
    """
    laws = [_causal(law) for law in section.laws if not isinstance(law, MountedInertia)]
    relaxing = 1 / (FITTED[:, None] + rates)
    ones = np.ones_like(FITTED)
    shunt = _fitted([law.shunt(section, FITTED) for law in laws], [ones, FITTED], FITTED[:, None] * relaxing)
    series = _fitted([law.series(section, FITTED) for law in laws], [1 / FITTED, -1 / FITTED, ones], relaxing)
    return Relaxations(shunt[0], shunt[1], shunt[2:], series[0] - series[1], series[2], series[3:])


def plain(section: Section) -> Section:
    """The section without its laws."""
    return replace(section, laws=())


def _causal(law: DampingLaw) -> DampingLaw:
    return ConstantLossFactor(law.loss_factor) if isinstance(law, HystereticLoss) else law


def _fitted(terms: Sequence[object], columns: Sequence[Array], rest: Array) -> Floats:
    """Non-negative coefficients by least squares of the relative misfit."""
    from scipy.optimize import nnls

    design = np.concatenate([np.stack(columns, axis=1), rest], axis=1)
    target = np.sum([np.broadcast_to(np.asarray(term, dtype=complex), FITTED.shape) for term in terms], axis=0)
    size = np.abs(target)
    if not np.any(size > 0):
        return np.zeros(design.shape[1])
    relative = design / size[:, None]
    scale = np.abs(relative).max(axis=0)
    rows = np.concatenate([(relative / scale).real, (relative / scale).imag])
    right = np.concatenate([(target / size).real, (target / size).imag])
    coefficients, _ = nnls(rows, right)
    misfit = np.abs((relative / scale) @ coefficients - target / size).max()
    if misfit > LARGEST_MISFIT:
        raise SettingsError(
            "simulation, damping laws of a section",
            f"their fit by relaxations is off by {misfit:.1%}",
            "Use laws that are passive and smooth over 0.02 … 15 Hz",
        )
    return np.asarray(coefficients / scale, dtype=float)

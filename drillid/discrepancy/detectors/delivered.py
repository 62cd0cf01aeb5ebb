"""Size of a limit of the drive from the torque that it lets pass.

The speed of the top drive follows the delivered torque by a linear response that is smooth in frequency, whatever the
control feeds back. The torque that a wrong limit would let pass has other harmonics than the delivered torque, which no
smooth response turns into those of the speed. So the likely limit is that under which the harmonics of the speed
scatter least about a locally polynomial response (Pintelon and Schoukens 2012, System Identification, chapter 7),
relative to the noise between the harmonics.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.fft import rfft
from scipy.optimize import brentq, minimize_scalar

from drillid.arrays import Complex, Floats, Indices
from drillid.discrepancy.detectors.residual_record import ResidualRecord

_BLOCK, _ORDER = 10, 2
"""Harmonics over which the response relative to the fitted model's is a polynomial, and its order."""
_TOLD = 5.0
"""Standard deviations by which a limit must fit better than none."""
_TRIED = 24
"""Limits tried before the best of them is refined."""
_EXACT = 1e-5
"""Relative accuracy of a limit and of the ends of its interval."""


@dataclass(frozen=True)
class _Block:
    """Harmonics over which the response is a polynomial, and the lines between them."""

    harmonics: Indices
    between: Indices

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the harmonics' scatter."""
        return 2 * (self.harmonics.size - _ORDER - 1)

    def left(self, speed: Complex, torque: Complex, lines: Indices) -> Floats:
        """Power (lines,) that the response at the harmonics leaves unexplained in some of the lines."""
        response, *_ = np.linalg.lstsq(self._columns(torque, self.harmonics), speed[self.harmonics], rcond=None)
        return np.asarray(np.abs(speed[lines] - self._columns(torque, lines) @ response) ** 2, dtype=float)

    def _columns(self, torque: Complex, lines: Indices) -> Complex:
        first, last = self.harmonics[[0, -1]]
        place = (2 * lines[:, None] - first - last) / (last - first)
        return np.asarray(torque[lines, None] * place ** np.arange(_ORDER + 1), dtype=complex)


@dataclass(frozen=True, eq=False)
class _Delivery:
    """A window's speed compared with the torque that any limit would let pass."""

    residual: ResidualRecord
    delivered: Callable[[float], Floats]

    @cached_property
    def blocks(self) -> list[_Block]:
        """Blocks in the band in which the model is valid; none where the sweep is not periodic."""
        residual = self.residual
        harmonics = np.flatnonzero(residual.harmonics & residual.inside)
        between = np.flatnonzero(residual.off_harmonics)
        count = harmonics.size // _BLOCK if residual.periods else 0
        chosen = np.array_split(harmonics, count) if count else []
        return [_Block(own, between[(between > own[0]) & (between < own[-1])]) for own in chosen]

    @cached_property
    def speed(self) -> Complex:
        """Lines (line,) of the speed."""
        return self._lines(self.residual.speed)

    def torque(self, limit: float) -> Complex:
        """Lines (line,) of the speed with which the fitted model follows the torque that a limit lets pass."""
        return self._lines(self.delivered(limit)) * self.residual.top_mobility

    def scatter(self, torque: Complex) -> Floats:
        """Sums of squares (block,) of the harmonics about the response to a torque."""
        return np.array([block.left(self.speed, torque, block.harmonics).sum() for block in self.blocks])

    def noise(self, torque: Complex) -> Floats:
        """Noise power (block,) between the harmonics; single tones do not raise it."""
        left = [block.left(self.speed, torque, block.between) for block in self.blocks]
        return np.array([float(np.median(power) / np.log(2)) for power in left])

    def _lines(self, series: Floats) -> Complex:
        # with these weights no harmonic leaks into another
        return np.asarray(rfft(self.residual.without_trend(series) * self.residual.period_weight), dtype=complex)


def limit_by_delivery(
    residual: ResidualRecord, limits: Floats, delivered: Callable[[float], Floats]
) -> tuple[float, float] | None:
    """Size of a limit and its standard error; None where the speed does not distinguish it from no limit.

    Parameters
    ----------
    residual : of a window with a logged command and a periodic sweep
    limits : range in which the limit is sought, in the unit of the size
    delivered : torque (samples,) that a limit lets pass, N m
    """
    delivery = _Delivery(residual, delivered)
    if not delivery.blocks:
        return None
    places = np.linspace(np.log(limits.min()), np.log(limits.max()), _TRIED)
    torques = [delivery.torque(np.exp(place)) for place in places]
    weight = 2 / np.min([delivery.noise(torque) for torque in torques], axis=0)

    def misfit(place: float) -> float:
        return float(delivery.scatter(delivery.torque(np.exp(place))) @ weight)

    best = int(np.argmin([delivery.scatter(torque) @ weight for torque in torques]))
    near = places[max(best - 1, 0)], places[min(best + 1, _TRIED - 1)]
    least = minimize_scalar(misfit, bounds=near, method="bounded", options={"xatol": _EXACT})
    scale = max(1.0, least.fun / sum(block.freedom for block in delivery.blocks))
    if misfit(np.inf) - least.fun < _TOLD**2 * scale:
        return None
    ends = _ends(misfit, float(least.x), (places[0], places[-1]), least.fun + scale)
    if ends is None:
        return None
    size = float(np.exp(least.x))
    return size, size * (ends[1] - ends[0]) / 2


def _ends(
    misfit: Callable[[float], float], least: float, bounds: tuple[float, float], level: float
) -> tuple[float, float] | None:
    """Where the misfit rises to a level on either side of its minimum; None where it does not within the bounds."""
    if min(misfit(bounds[0]), misfit(bounds[1])) < level:
        return None
    low, high = (brentq(lambda place: misfit(place) - level, least, bound, xtol=_EXACT) for bound in bounds)
    return low, high

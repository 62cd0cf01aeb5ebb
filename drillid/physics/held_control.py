"""Control that samples and holds: a computer reads the speed at intervals h and holds its command in between.

A command that is held for h is late by a uniformly distributed time: the drive is multiplied by
(1 − e^(−sh))/(sh) = e^(−sh/2) sinh(sh/2)/(sh/2), a delay by h/2, which counts as part of T_d, and a variance of h²/12
(Åström and Wittenmark 1997, Computer-Controlled Systems, chapters 2 and 3). The readings fold (alias) what the steps of
the command add at multiples of their rate. There the top drive's inertia J is the load, whose speed at the readings
follows exactly: where the drive itself is late by m + f intervals, m whole ones and a part f,

    z^(−m) (1 − f + f/z) h/(J (z − 1)) = e^(−sT_d)/(J s) (1 + s²h² (f(1 − f)/2 − 1/24) + …),   z = e^(sh),

so that altogether the variance is v = h² (f(1 − f) − 1/12): h²/12 in the mean over f, and between −h²/12 and h²/6. The
series is the response of a delay of 0 with probability 1 − f, else of h, about its mean, over that of a uniform one.
Further cumulants follow from these two: the third is κ = h³ f(1 − f)(1 − 2f), at most 0.1 h³; the fourth makes 1 % at
4 Hz where h is 45 ms.

Cumulants are for what knows no load but the inertia, and for derivatives; `Held` has the sum with the string as load.

What depends on f is folded from the multiples k of the rate: 1 + Σ s² e^(−νT) G(s + ν)/(G(s) (s + ν)²) over ν = 2πik/h,
k ≠ 0, with T = T_d − h/2 and the filters G between command and reading. Their ratio is taken at s = 0, for the first
multiple, which folds most, together with its slope; from the third multiple on, its modulus is the second's, and so is
its phase per multiple. A recorder that keeps the readings holds what they would be if the recorder's clock and
filter took the place of the control's: its time stamps have the difference in v, and in κ, between the two.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.physics.dual_numbers import composed, primal, unstacked
from drillid.physics.held_kernel import QUANTITIES, WAYS, folded
from drillid.physics.images_kernel import images

Cumulants = tuple[Any, Any, Any, Any]
"""Cumulants from the second (s²) to the fifth (s⁵)."""


Part = TypeVar("Part", bound=Any)
"""What has cumulants of holding: a top drive or a recording."""


class Filters(NamedTuple):
    """Filters between a held command and the readings of its effect; quantities may be Duals."""

    lag: Any = 0.0
    """s, time constant of the drive."""
    speed_filter: Any = 0.0
    """s, that of the control's reading."""
    variance: Any = 0.0
    """s², of the drive's delay where that jitters."""
    clock_variance: Any = 0.0
    """s², of the recorder's time stamps."""
    corner_time: Any = 0.0
    """s, one over the angular corner frequency of the recorder's Butterworth filter; 0 without one."""
    order: int = 1
    """Its order."""


NO_FILTERS = Filters()


def read_and_kept(interval: Any, delay: Any, offset: Any, filters: Filters = NO_FILTERS) -> tuple[Cumulants, Cumulants]:
    """Cumulants that holding a command and reading its effect add to its delay, and those that the recorded readings
    have in addition; any argument may be a Dual.

    They are continuous where the whole delay is a multiple of h plus h/2; v has a kink there. Fourth and fifth are
    plain numbers, as their derivatives hardly matter.

    Parameters
    ----------
    interval, delay : h and T_d, which includes h/2; s
    offset : of the recorder's clock, s
    """
    arguments = interval, delay, offset, *filters[:-1]
    values = [primal(each) for each in arguments]
    shape = np.broadcast(*values).shape
    table = np.empty((*shape, QUANTITIES))
    for place, value in enumerate(values):
        table[..., place] = value
    windows = table.size // QUANTITIES
    cumulants, slopes = np.empty((2, 4, windows)), np.empty((2, 2, QUANTITIES, windows))
    folded(table.reshape(windows, QUANTITIES), filters.order, cumulants, slopes)
    by_quantity = slopes.reshape(4, QUANTITIES, *shape)
    parts = [(by_quantity[:, place], each) for place, each in enumerate(arguments)]
    second, third, later_second, later_third = unstacked(composed(cumulants[:, :2].reshape(4, *shape), parts))
    read, later = cumulants[:, 2:].reshape(2, 2, *shape)
    return (second, third, *read), (later_second, later_third, *later)


@dataclass(frozen=True)
class Held:
    """A command that is held, and its effect as read: plain numbers, all scalars or of shape (window, 1)."""

    quantities: tuple[Any, ...]
    """The eight of `drillid.physics.held_kernel`: interval, delay, offset and filters."""
    order: int
    """Of the recorder's filter."""
    read: Cumulants
    """What holding adds to the cumulants of the delay."""
    later: Cumulants
    """What the recorded readings have in addition."""

    @classmethod
    def of(
        cls, interval: Any, delay: Any, offset: Any, filters: Filters, cumulants: tuple[Cumulants, Cumulants]
    ) -> "Held":
        """The values of quantities that may be Duals, with the cumulants that `read_and_kept` gives for them."""
        read, later = (tuple(primal(each) for each in of_way) for of_way in cumulants)
        quantities = tuple(primal(each) for each in (interval, delay, offset, *filters[:-1]))
        return cls(quantities, filters.order, read, later)

    @property
    def interval(self) -> Any:
        """Of the control, s."""
        return self.quantities[0]

    def steps(self, s: Complex) -> Complex:
        """Response of a command held for an interval, about its mean delay."""
        half = 0.5 * s * self.interval
        return np.asarray(np.sinh(half) / half, dtype=complex)

    def images(self, s: Complex, inertia: Any, admittance: Any) -> tuple[Complex, Complex]:
        """What the control's readings fold, and the recorded ones, relative to the drive's torque, rad/(N m s).

        Parameters
        ----------
        s : (F,) imaginary, 1/s
        inertia : of the top drive, kg m²
        admittance : characteristic one of the pipe, N m s/rad
        """
        values = np.broadcast_arrays(*self.quantities, primal(inertia), primal(admittance))
        table = np.stack(values, axis=-1).astype(float).reshape(-1, QUANTITIES + 2)
        order = self.order if np.any(table[:, QUANTITIES - 1] > 0) else 0
        found, omega = np.empty((len(table), WAYS, s.size), dtype=complex), np.ascontiguousarray(s.imag)
        for row, filled in zip(table, found, strict=True):
            images(row[:QUANTITIES], filter_pairs(order), order, row[-2], row[-1], omega, filled)
        read, kept = np.moveaxis(found, 1, 0).reshape(WAYS, *np.shape(values[0])[:-1], s.size)
        return read, kept


def filter_pairs(order: int) -> Floats:
    """Linear coefficients of the quadratic factors of a Butterworth filter's polynomial, (order // 2,)."""
    return np.asarray(2 * np.sin(np.pi * (2 * np.arange(order // 2) + 1) / (2 * order)) if order else [], dtype=float)


def beyond(part: Part, cumulants: Cumulants) -> Part:
    """A top drive, or a recording, less the values of what holding adds to its cumulants; their derivatives stay."""
    variance, third, *higher = cumulants_beyond(part, cumulants)
    return replace(part, hold_variance=variance, hold_skewness=third, hold_higher=tuple(higher))


def cumulants_beyond(part: Any, cumulants: Cumulants | None) -> Cumulants:
    """Those that holding adds to a top drive or a recording, less the values of some; their derivatives stay."""
    own = part.hold_variance, part.hold_skewness, *part.hold_higher
    if cumulants is None:
        return own
    variance, third, fourth, fifth = (each - value for each, value in zip(own, cumulants, strict=True))
    return variance, third, fourth, fifth


def held_logarithm(s: Any, third: Any, fourth: Any, fifth: Any) -> Any:
    """Addition of the third (s³) to fifth (s⁵) cumulants to the logarithm of a delay's response."""
    if all(isinstance(each, float) and each == 0 for each in (third, fourth, fifth)):
        return 0.0
    return s**3 * (third / -6) + s**4 * (fourth / 24) + s**5 * (fifth / -120)

"""Elements of learnt extensions: rational immittances along the string, and rational factors of transfers.

Each term of an element is a cause with one size, so that a learnt extension is fitted, predicted with, stored and
simulated as a named cause is. A term that needs another, such as the frequency of a mounted inertia, acts on the last
one in the model. Immittances are positive real by their form and the bounds of their sizes (Foster 1924, Bell System
Technical Journal 3, 259–267; Brune 1931, Journal of Mathematics and Physics 10, 191–236).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drillid.arrays import Complex, Floats
from drillid.discrepancy.catalogue.cause import Cause, OperatingPoint, Size, WindowModel
from drillid.discrepancy.learning.process import PROCESSES
from drillid.discrepancy.learning.term import FACTOR_OF, Term, depth_of, shaping_at, with_shaping
from drillid.physics.attachments import MountedInertia, Relaxation, with_joint, with_law, with_lump
from drillid.physics.damping import DampingLaw
from drillid.physics.equipment import Section
from drillid.physics.strings import String

PIECES = 24
"""Equal lengths of pipe in each of which its polar moment may differ."""
_LAST = -1


class _PlacedTerm(Term):
    """An element attached to the string; the shape is its place."""

    is_place = True

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """The element at its place."""
        depth = depth_of(shape, window_model, operating_point)
        return window_model.with_string(*self.hung(window_model.system.string, depth, size))

    @abstractmethod
    def hung(self, string: String, depth: Any, size: Any) -> String:
        """The string with the element at a depth, m."""


class LearntInertia(_PlacedTerm):
    """A lump of inertia."""

    name = "learnt_inertia"
    meaning = "an inertia turns with the string"
    size = Size("inertia", "kg m²", 50.0, 0.0, 2e3)

    def hung(self, string: String, depth: Any, size: Any) -> String:
        """The inertia added."""
        return with_lump(string, depth, inertia=size)


class LearntDamper(_PlacedTerm):
    """A damper to ground."""

    name = "learnt_damper"
    meaning = "the string is braked at a place"
    size = Size("damping", "N m s/rad", 100.0, 0.0, 5e3)

    def hung(self, string: String, depth: Any, size: Any) -> String:
        """The damping added."""
        return with_lump(string, depth, damping=size)


class LearntJoint(_PlacedTerm):
    """A soft joint."""

    name = "learnt_joint"
    meaning = "a joint gives way within the string"
    size = Size("compliance", "rad/(N m)", 2e-5, 0.0, 2e-3)

    def hung(self, string: String, depth: Any, size: Any) -> String:
        """The compliance added."""
        return with_joint(string, depth, size)


class MountInertia(_PlacedTerm):
    """An inertia on a spring and a damper. Its frequency and loss are further terms."""

    name = "mount_inertia"
    meaning = "an inertia hangs on the string by a spring"
    size = Size("inertia", "kg m²", 50.0, 0.0, 2e3)

    def hung(self, string: String, depth: Any, size: Any) -> String:
        """The inertia, on a spring and damper that the next terms state."""
        return with_law(string, depth, MountedInertia(size, 0.0, 0.0))


class _LawTerm(Term):
    """A parameter of the last law of a kind in the string."""

    law: type[DampingLaw]
    parameter: str

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """The parameter added to the last law of its kind."""
        string = window_model.system.string
        places = [index for index, section in enumerate(string) if self._of(section)]
        own = self._of(string[places[_LAST]])[_LAST]
        changed = replace(own, **{self.parameter: getattr(own, self.parameter) + size})
        sections = (
            replace(section, laws=tuple(changed if law is own else law for law in section.laws)) for section in string
        )
        return window_model.with_string(*sections)

    def _of(self, section: Section) -> list[Any]:
        return [law for law in section.laws if type(law) is self.law]


class MountFrequency(_LawTerm):
    """Frequency of the mounted inertia."""

    name, law, parameter = "mount_frequency", MountedInertia, "frequency"
    meaning = "the frequency of the inertia on its spring"
    size = Size("frequency", "Hz", 2.0, 0.02, 12.0)


class MountLoss(_LawTerm):
    """Loss of the mounted inertia."""

    name, law, parameter = "mount_loss", MountedInertia, "loss"
    meaning = "the loss of the inertia's mount"
    size = Size("loss, twice the damping ratio", "1", 0.3, 1e-3, 4.0)


class DragCoefficient(Term):
    """Drag through an elastic layer along the whole string."""

    name = "drag_coefficient"
    meaning = "a drag with memory acts along the string"
    size = Size("coefficient", "N s/m⁴", 500.0, 0.0, 2e4)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """Drag whose rate the next term states."""
        law = Relaxation(size, 0.0)
        sections = (replace(section, laws=(*section.laws, law)) for section in window_model.system.string)
        return window_model.with_string(*sections)


class DragRate(_LawTerm):
    """Rate of the drag with memory."""

    name, law, parameter = "drag_rate", Relaxation, "rate"
    meaning = "the rate at which the drag relaxes"
    size = Size("rate", "rad/s", 10.0, 0.3, 200.0)


class ProfilePiece(Term):
    """Polar moment of a piece of the string; the shape is the piece's number from the top."""

    name = "profile"
    meaning = "the string's polar moment varies along it"
    size = Size("logarithm of the polar moment per stated one", "1", 0.03, -1.5, 1.5)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """The piece with another polar moment."""
        string = window_model.system.string
        if len(string) < PIECES:
            string = _in_pieces(string, operating_point)
        own = replace(string[int(shape)], polar_moment=string[int(shape)].polar_moment * np.exp(size))
        return window_model.with_string(*string[: int(shape)], own, *string[int(shape) + 1 :])


def _in_pieces(string: tuple[Section, ...], operating_point: OperatingPoint) -> tuple[Section, ...]:
    """The string with its pipe cut into PIECES of equal length in the mean, which go down with it."""
    pipe, *below = string
    usual = float(np.mean(operating_point.length)) / PIECES
    lower = [pipe.length - usual * (PIECES - 1 - number) for number in range(PIECES)]
    ends = [np.maximum(end, 0.0) for end in lower]
    pieces = [replace(pipe, length=end - begin) for begin, end in zip([0.0, *ends[:-1]], ends, strict=True)]
    return (*pieces, *below)


class _ShapingTerm(Term):
    """A coefficient of the rational factor at a port above the string."""

    parameter: str

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """The coefficient added to the factor."""
        before = shaping_at(self.port, window_model)
        changed = replace(before, **{self.parameter: getattr(before, self.parameter) + size})
        return with_shaping(self.port, window_model, changed)


_LIMITS = {
    "zero_1": ("s", 0.03, -2.0, 2.0),
    "zero_2": ("s²", 0.005, -1.0, 1.0),
    "pole_1": ("s", 0.03, 0.0, 2.0),
    "pole_2": ("s²", 0.005, 0.0, 1.0),
}


def _shaping_term(at: str, coefficient: str) -> Term:
    unit, typical, low, high = _LIMITS[coefficient]

    class ShapingTerm(_ShapingTerm):
        """One coefficient at one port."""

        name, port, parameter = f"{at}_{coefficient}", at, coefficient
        meaning = f"{FACTOR_OF[at]} has a response of its own"
        size = Size(coefficient.replace("_", " of order "), unit, typical, low, high)

    return ShapingTerm()


STRING_TERMS = (
    *(LearntInertia(), LearntDamper(), LearntJoint(), MountInertia(), MountFrequency(), MountLoss()),
    *(DragCoefficient(), DragRate(), ProfilePiece()),
)
TERMS: dict[str, Cause] = {term.name: term for term in STRING_TERMS} | {
    f"{port}_{coefficient}": _shaping_term(port, coefficient) for port in FACTOR_OF for coefficient in _LIMITS
}
TERMS |= {term.name: term for terms in PROCESSES.values() for term in terms}
"""All terms by name; no name is one of the catalogue's."""


@dataclass(frozen=True)
class Element:
    """Terms that are learnt together."""

    name: str
    terms: tuple[str, ...]
    has_place: bool
    """Whether the shape of its first term is a place along the string."""
    ports: tuple[str, ...]
    """Those of `unknown.CHANNELS` at which an unknown misfit may be due to this element."""
    starts: tuple[tuple[float, ...], ...]
    """Sizes from which fits begin, in units of the terms' typical sizes."""
    admittance: Callable[[Complex, Floats], Any] | None = None
    """Admittance per unit of its first size, N m s/rad, from s and its sizes, where it is attached at its place."""

    @property
    def order(self) -> int:
        """Number of its parameters, the place included."""
        return len(self.terms) + self.has_place


PORTS_ALONG = ("top", "upper string", "lower string", "bit", "data sheet")
"""Ports of elements along the string."""
_MOUNT_STARTS = tuple((1.0, frequency / 2.0, 1.0) for frequency in (0.15, 0.3, 0.6, 1.2, 2.4, 4.0))


def _mounted(s: Complex, sizes: Floats) -> Complex:
    return np.asarray(MountedInertia(1.0, *sizes[1:].tolist()).admittance(s), dtype=complex)


ELEMENTS = (
    Element("inertia", ("learnt_inertia",), True, PORTS_ALONG, ((1.0,),), lambda s, sizes: s),
    Element("damper", ("learnt_damper",), True, PORTS_ALONG, ((1.0,),), lambda s, sizes: np.ones_like(s)),
    Element("joint", ("learnt_joint",), True, PORTS_ALONG, ((1.0,), (10.0,))),
    Element(
        "mounted inertia",
        ("mount_inertia", "mount_frequency", "mount_loss"),
        True,
        PORTS_ALONG,
        _MOUNT_STARTS,
        _mounted,
    ),
    Element("drag with memory", ("drag_coefficient", "drag_rate"), False, PORTS_ALONG, ((1.0, 0.2), (1.0, 2.0))),
    Element("profile", ("profile",) * PIECES, False, PORTS_ALONG, ((0.0,) * PIECES,)),
    *(
        Element(
            f"{port} factor of order {order}",
            tuple(f"{port}_{kind}_{power}" for kind in ("zero", "pole") for power in range(1, order + 1)),
            False,
            (port,),
            starts,
        )
        for port in FACTOR_OF
        for order, starts in (
            (1, ((0.0, 1.0), (1.0, 0.0))),
            (2, ((0.0, 0.0, 0.5, 0.2), (0.0, 2.0, 0.5, 2.0), (0.0, 10.0, 2.0, 10.0))),
        )
    ),
)
"""Elements that are tried, from the simplest."""

"""The fingerprint of a learnt extension: its elements with places, sizes and covariance, and how like another's it is.

A fingerprint holds the best fit of every element to the same data, so that two wells are compared by the same element
even where a different one was chosen in each; of a law, it holds the kind that was chosen alone. Two extensions are the
same where some element explains both with common parameters: twice the loss of log-likelihood by that is a likelihood
ratio with as many degrees of freedom as the element has parameters (Wilks 1938, Annals of Mathematical Statistics 9,
60–62). A Gaussian process, whose coefficients belong to its kernel, is described by its values at the frequencies of
`process.COMPARED`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import chdtrc

from drillid.arrays import Floats
from drillid.discrepancy.inference.coordinates import SHARED
from drillid.discrepancy.inference.set_fit import SetFit, fit_set
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.learning.elements import ELEMENTS
from drillid.discrepancy.learning.process import COMPARED, PROCESS_AT, curves
from drillid.discrepancy.learning.search import Candidate, placed

PLACE_TOLERANCE = 0.03
"""Standard deviation of the place of one and the same thing in two wells, as a share of the string's length."""
SIZE_TOLERANCE = 0.15
"""Relative standard deviation of its sizes, as the data sheets of rigs are wrong by a few percent."""
SAME = 0.01
"""p-value from which two fingerprints count as the same."""
LAW_OF = "law of"
"""Start of a law's name among elements; what it is a law of follows."""
CONTROL_LAW = "law of the speed control"
_PLACE_STEP = 0.01


@dataclass(frozen=True, eq=False)
class Described:
    """One element as a description of what was found."""

    element: str
    values: Floats
    """Sizes of its terms in their units, and its place as a share of the string where it has one; real parts and
    imaginary parts of a process."""
    covariance: Floats
    loss: float
    """Nats by which it explains less than the best element."""

    def content(self) -> dict[str, Any]:
        """Plain values, from which `of` makes it again."""
        return {
            "element": self.element,
            "values": self.values.tolist(),
            "covariance": self.covariance.tolist(),
            "loss": self.loss,
        }

    @classmethod
    def of(cls, content: Mapping[str, Any]) -> Described:
        """The inverse of `content`."""
        values, covariance = (np.array(content[name], dtype=float) for name in ("values", "covariance"))
        return cls(str(content["element"]), values, covariance, float(content["loss"]))


@dataclass(frozen=True, eq=False)
class Fingerprint:
    """What was found in one well, as described by every element."""

    gain: float
    """Nats that the best element explains."""
    described: tuple[Described, ...]

    def content(self) -> dict[str, Any]:
        """Plain values, from which `of` makes it again."""
        return {"gain": self.gain, "described": [each.content() for each in self.described]}

    @classmethod
    def of(cls, content: Mapping[str, Any]) -> Fingerprint:
        """The inverse of `content`."""
        return cls(float(content["gain"]), tuple(map(Described.of, content["described"])))

    def likeness(self, other: Fingerprint) -> float:
        """p-value of both being the same thing: the largest over the elements that describe both."""
        theirs = {each.element: each for each in other.described}
        values = [
            _p_value(own, theirs[own.element]) for own in self.described if own.element in theirs and own.values.size
        ]
        return max(values, default=0.0)

    @property
    def resembles(self) -> str:
        """The textbook element that comes nearest, with the share of what was found that it leaves."""
        named = [(each, _textbook(each)) for each in self.described]
        told = [(each.loss, text) for each, text in named if text]
        if not told:
            return "no textbook element"
        loss, text = min(told)
        return f"{text} (leaves {loss / max(self.gain, 1e-9):.0%} of it)"


def fingerprint(model: SetModel, base: SetFit, candidates: Sequence[Candidate]) -> Fingerprint:
    """The fingerprint of what a model lacks.

    Parameters
    ----------
    base : fit of the model without extensions
    candidates : the model with every single element; profiles along the string have none
    """
    single = [each for each in candidates if each.element.name != "profile"]
    least = min(each.fit.cost for each in single)
    return Fingerprint(base.cost - least, tuple(_described(model, each, each.fit.cost - least) for each in single))


def _described(model: SetModel, candidate: Candidate, loss: float) -> Described:
    values = candidate.fit.point.sizes
    covariance: Floats = np.asarray(np.linalg.inv(candidate.fit.information)[SHARED:, SHARED:], dtype=float)
    if _is_process(candidate.element.name):
        known = curves(candidate.extensions[0].shape, COMPARED)
        parts = np.concatenate([known.real, known.imag], axis=1)
        return Described(candidate.element.name, values @ parts, parts.T @ covariance @ parts, loss)
    if candidate.element.has_place:
        values = np.append(values, candidate.place)
        covariance = np.asarray(np.pad(covariance, (0, 1)), dtype=float)
        covariance[-1, -1] = _place_variance(model, candidate)
    return Described(candidate.element.name, values, covariance, loss)


def _place_variance(model: SetModel, candidate: Candidate) -> float:
    """Variance of the place from the curvature of the cost, with all else refitted at each place on the string."""
    middle = float(np.clip(candidate.place, _PLACE_STEP, 1 - _PLACE_STEP))
    before, at, after = (
        fit_set(model, candidate.fit.point, placed(candidate.element, place)).cost
        for place in (middle - _PLACE_STEP, middle, middle + _PLACE_STEP)
    )
    curvature = (before + after - 2 * at) / _PLACE_STEP**2
    return float(min(1 / max(curvature, 1e-9), 1.0))


def _p_value(first: Described, second: Described) -> float:
    """p-value of two descriptions by the same element being of the same thing."""
    sizes = (np.abs(first.values) + np.abs(second.values)) / 2
    if _is_process(first.element):
        # a part may be zero where the process is not
        sizes = np.full_like(sizes, np.sqrt(np.mean(sizes**2)))
    # each of the two wells deviates
    tolerance = 2 * (SIZE_TOLERANCE * sizes) ** 2
    if not _is_process(first.element) and first.values.size > _size_count(first.element):
        tolerance[-1] = 2 * PLACE_TOLERANCE**2
    covariance = first.covariance + second.covariance + np.diag(tolerance)
    difference = first.values - second.values
    distance = float(difference @ np.linalg.solve(covariance, difference))
    # an element pays for describing one of them worse than another element does
    return float(chdtrc(first.values.size, distance + 2 * (first.loss + second.loss)))


def _is_process(element: str) -> bool:
    return element.startswith(PROCESS_AT)


def _size_count(element: str) -> int:
    """Number of an element's sizes; a law's is its curvature."""
    return 1 if element.startswith(LAW_OF) else len(_terms(element))


def _terms(element: str) -> Sequence[str]:
    return next(each.terms for each in ELEMENTS if each.name == element)


def _textbook(described: Described) -> str:
    """The element in a textbook's words; empty where it has none."""
    values, name = described.values, described.element
    if _is_process(name):
        return ""
    if name.startswith(LAW_OF):
        return _law_words(name, values)
    sizes = dict(zip(_terms(name), values, strict=False))
    if name == "inertia":
        return f"an inertia of {sizes['learnt_inertia']:.3g} kg m² at {values[-1]:.0%} of the string"
    if name == "damper":
        return f"a damper of {sizes['learnt_damper']:.3g} N m s/rad at {values[-1]:.0%} of the string"
    if name == "joint":
        stiffness = 1e-3 / max(sizes["learnt_joint"], 1e-12)
        return f"a series spring of {stiffness:.3g} kN m/rad at {values[-1]:.0%} of the string"
    if name == "mounted inertia":
        stiffness = sizes["mount_inertia"] * (2 * np.pi * sizes["mount_frequency"]) ** 2 / 1e3
        mounted = f"an inertia of {sizes['mount_inertia']:.3g} kg m² on a spring of {stiffness:.3g} kN m/rad"
        return f"{mounted} at {values[-1]:.0%} of the string"
    if name.endswith("factor of order 1"):
        port = name.split()[0]
        lag, lead = sizes[f"{port}_pole_1"], sizes[f"{port}_zero_1"]
        return f"a lag of {1e3 * (lag - lead):.3g} ms in the {port}"
    return ""


def _law_words(name: str, values: Floats) -> str:
    """A law as a drag by the squared speed, a gain by the squared error, or a coupling that softens or stiffens."""
    if name == CONTROL_LAW:
        return f"a gain of the speed control that changes by {values[0]:.3g} N m s³/rad³ times the squared error"
    if values.size == 1:
        memory = name.partition("with")[2]
        return f"a drag of {values[0] / 2:.3g} N m s²/rad² at the bit{' with' + memory if memory else ''}"
    change = "softens" if values[0] > 0 else "stiffens"
    return f"a coupling at {values[1]:.0%} of the string that {change} by {1e6 * abs(values[0]):.3g} rad/(kN m)²"

"""Terms of a Gaussian process over frequency at a port: a learnt extension where the data show no rational order.

At the ports above the string f is the relative change of what the port transfers, elsewhere an admittance per
characteristic admittance of the string. A term is one coefficient of f; its shape is the number of the kernel, and its
prior, as that of any size, is the one that the kernel states.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from drillid.arrays import Complex
from drillid.discrepancy.catalogue.cause import OperatingPoint, Size, WindowModel
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.inference.unknown import PORTS, RELATIVE
from drillid.discrepancy.learning.term import BIT, FACTOR_OF, TOP, Term, depth_of, shaping_at, with_shaping
from drillid.discrepancy.rules import WIDE_PRIOR
from drillid.physics.attachments import SPREAD, with_law
from drillid.physics.equipment import Section
from drillid.physics.gaussian_process import COUNT, ProcessAdmittance, ProcessShaping, functions

RATES = tuple(np.geomspace(2.0, 40.0, 9).tolist())
"""λ, rad/s; the nodes of the process have no finer resolution than 2 rad/s."""
AMPLITUDES = tuple((10.0 ** np.arange(-2.5, 0.6, 0.25)).tolist())
"""Prior standard deviation of f at zero frequency."""
KERNELS = tuple((rate, amplitude) for rate in RATES for amplitude in AMPLITUDES)
"""Hyperparameters by their number."""
PROCESS_AT = "process at"
"""Start of the element's name; the port follows."""
COMPARED = 2j * np.pi * np.array([0.15, 0.3, 0.6, 1.0, 1.6, 2.4, 3.4])
"""Values of the Laplace variable s at which processes of different kernels are compared."""
_PLACES = {"top": TOP, "upper string": 1 / 3, "lower string": 2 / 3, "bit": BIT}
_FURTHEST = 8.0


class _ProcessTerm(Term):
    """One coefficient of the process at a port; the shape is the number of its kernel."""

    number: int
    size = Size("coefficient", "prior standard deviations", 1 / WIDE_PRIOR, -_FURTHEST, _FURTHEST)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """The coefficient added to the process."""
        rate, amplitude = KERNELS[int(shape)]
        if self.port in RELATIVE:
            before = shaping_at(self.port, window_model)
            if not isinstance(before, ProcessShaping):
                rational = (before.zero_1, before.zero_2, before.pole_1, before.pole_2)
                before = ProcessShaping(*rational, rate=rate)
            changed = replace(before, coefficients=self._added(before.coefficients, amplitude * size))
            return with_shaping(self.port, window_model, changed)
        string = window_model.system.string
        if not any(_process_of(section) for section in string):
            depth = depth_of(_PLACES[self.port], window_model, operating_point)
            string = with_law(string, depth, ProcessAdmittance(rate, (0.0,) * COUNT, SPREAD))
        return window_model.with_string(*(self._grown(section, amplitude * size) for section in string))

    def _added(self, coefficients: tuple[Any, ...], size: Any) -> tuple[Any, ...]:
        return (
            *coefficients[: self.number],
            coefficients[self.number] + size,
            *coefficients[self.number + 1 :],
        )

    def _grown(self, section: Section, size: Any) -> Section:
        own = _process_of(section)
        if own is None:
            return section
        changed = replace(own, coefficients=self._added(own.coefficients, size))
        return replace(section, laws=tuple(changed if law is own else law for law in section.laws))


def _process_of(section: Section) -> ProcessAdmittance | None:
    return next((law for law in section.laws if isinstance(law, ProcessAdmittance)), None)


def _term(at: str, place: int) -> Term:
    class ProcessTerm(_ProcessTerm):
        """One coefficient at one port."""

        name, port, number = f"{at.replace(' ', '_')}_process_{place}", at, place
        meaning = (
            f"{FACTOR_OF[at]} has a response of its own"
            if at in FACTOR_OF
            else f"an admittance that is no simple element hangs in the string ({at})"
        )

    return ProcessTerm()


PROCESSES: dict[str, tuple[Term, ...]] = {port: tuple(_term(port, number) for number in range(COUNT)) for port in PORTS}
"""Terms by port."""


def is_process(term: object) -> bool:
    """Whether a term is a coefficient of a process."""
    return isinstance(term, _ProcessTerm)


def curves(kernel: float, s: Complex) -> Complex:
    """Functions of s by which coefficients multiply, (COUNT, s)."""
    rate, amplitude = KERNELS[int(kernel)]
    return np.asarray(amplitude * functions(rate, s), dtype=complex)


def process_at(port: str, kernel: int) -> tuple[Extension, ...]:
    """The process at a port as extensions."""
    return tuple(Extension(term, float(kernel)) for term in PROCESSES[port])

"""The coupling's twist in the balances of torque of motor and load, line by line: what in it is not linear.

Current = J ω̇ + c ω + k φ + term for the motor, ω̇ = k/J φ + c/J φ̇ + d/J ω + term for the load, with twist φ. All are
linear in their parameters, so a further term costs one column of least squares, and is judged on other periods.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from benchmarks.discoveries.jackknife import jackknife_error
from benchmarks.discoveries.motor_fit import HIGHEST_HZ, LOWEST_HZ
from drillid.arrays import Complex, Floats

_LINES = np.arange(LOWEST_HZ, HIGHEST_HZ + 1)
_BLOCK = 16
"""Neighbouring lines that a jackknife leaves out together."""


@dataclass(frozen=True)
class Term:
    """A non-linear term of one balance."""

    relative: float
    """Its part of the coupling's torque at the largest twist; of a friction, of the largest speed's linear drag."""
    error: float
    """Standard error, by a jackknife over lines."""
    before: float
    """Rms of the balance's error on even periods per rms of its left side, without the term."""
    after: float
    """The same with it."""


def balances(current: Floats, turned: Floats, load_turned: Floats, twist: Floats, delay: float) -> Mapping[str, Term]:
    """Play (a jump at no twist) and softening (a cube of it) of the coupling, seen from motor and from load.

    Parameters
    ----------
    current, turned, load_turned, twist : (period, sample), A, rad/s, rad/s, rad
    delay : s, of the torque after its current
    """
    s = 2j * np.pi * _LINES
    motor = (_lines(current) * np.exp(-s * delay), [_lines(twist), s * _lines(turned), _lines(turned)])
    load = (s * _lines(load_turned), [_lines(twist), s * _lines(twist), _lines(load_turned)])
    largest = float(np.abs(twist[1:]).max())
    terms = {"play": (np.sign(twist), 1 / largest), "softening": (twist**3, largest**2)}
    return {
        f"{name}, {side}": _term(left, right, _lines(term), scale)
        for name, (term, scale) in terms.items()
        for side, (left, right) in (("motor", motor), ("load", load))
    }


def _lines(signal: Floats) -> Complex:
    return np.asarray(np.fft.rfft(signal, axis=1)[:, _LINES], dtype=complex)


def _term(left: Complex, right: list[Complex], term: Complex, scale: float) -> Term:
    """The first column is the coupling's stiffness, by which the term's coefficient is divided."""
    odd, even = slice(1, None, 2), slice(2, None, 2)
    columns = np.stack([*right, term], axis=-1)
    fitted, held = columns[odd].mean(0), columns[even].mean(0)
    wanted, kept = left[odd].mean(0), left[even].mean(0)
    parameters, plain = _solved(fitted, wanted), _solved(fitted[:, :-1], wanted)
    places = np.arange(_LINES.size) // _BLOCK
    each = [_share(_solved(fitted[places != one], wanted[places != one]), scale) for one in np.unique(places)]
    size = np.sqrt(np.mean(np.abs(kept) ** 2))
    misses = (kept - held[:, :-1] @ plain, kept - held @ parameters)
    before, after = (float(np.sqrt(np.mean(np.abs(one) ** 2)) / size) for one in misses)
    return Term(_share(parameters, scale), jackknife_error(each), before, after)


def _share(parameters: Floats, scale: float) -> float:
    return float(parameters[-1] / parameters[0] * scale)


def _solved(columns: Complex, wanted: Complex) -> Floats:
    real = np.concatenate([columns.real, columns.imag])
    return np.asarray(np.linalg.lstsq(real, np.concatenate([wanted.real, wanted.imag]), rcond=None)[0], dtype=float)

"""A microstrip line measured with open, short and loaded end, fitted jointly by the equations of the drill string.

Speed plays voltage and torque current: a `Section` of unit polar moment is a line whose density is its capacitance
(F/m) and whose shear modulus is one over its inductance (H/m). Its reflection against 50 Ω is compared with the
measured one below 3 GHz, once for the plain line with ideal ends, and once with a connector (delay, inductance,
capacitance) and a reactance at each end.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import typer
from skrf import Network

from drillid.arrays import Complex, Floats
from drillid.errors import LogError
from drillid.physics.damping import DampingLaw, Steel
from drillid.physics.equipment import Section
from drillid.physics.line import input_admittance
from drillid.physics.responses import laplace

DATA = Path(__file__).parents[2] / "shared" / "data" / "line"
FILES = {"open": "P1-MSL_Open_50.s1p", "short": "P1-MSL_Short_50.s1p", "load": "P1-MSL_Load_50.s1p"}
HIGHEST_HZ = 3e9
REFERENCE_OHM = 50.0
LENGTH = 0.05
"""m, nominal; only delay and impedance are seen in the reflection."""

PLAIN: Mapping[str, tuple[float, float, float]] = {
    "impedance_ohm": (50.0, 20.0, 100.0),
    "delay_ns": (0.34, 0.1, 1.0),
    "conductor_loss": (0.2, 0.0, 100.0),
    "dielectric_loss": (0.01, 0.0, 0.5),
    "load_ohm": (50.0, 20.0, 100.0),
}
"""Start, lowest and highest value; a passive line."""
CONNECTED: Mapping[str, tuple[float, float, float]] = {
    **PLAIN,
    "connector_delay_ns": (0.02, 0.0, 0.3),
    "connector_nh": (0.1, 0.0, 5.0),
    "connector_pf": (0.05, 0.0, 5.0),
    "open_pf": (0.02, 0.0, 5.0),
    "short_nh": (0.05, 0.0, 5.0),
    "load_nh": (0.05, -5.0, 5.0),
}
"""The same with the connector and the ends; a load may be capacitive, which reads as a negative inductance."""


@dataclass(frozen=True)
class ConductorLoss(DampingLaw):
    """Skin effect: series impedance r √s per length, to the line's inductance in series."""

    resistance: Any
    """r, Ω √s/m."""

    def series(self, section: Steel, s: Any) -> Any:
        """What the law adds to the admittance times length, 1/(s/G + r √s) − G/s for unit polar moment."""
        stiffness = section.shear_modulus * section.polar_moment / s
        return 1 / (1 / stiffness + self.resistance * np.sqrt(s)) - stiffness


@dataclass(frozen=True)
class DielectricLoss(DampingLaw):
    """Conductance in proportion to the capacitance's admittance: the loss tangent."""

    tangent: Any

    def shunt(self, section: Steel, s: Any) -> Any:
        """Conductance |ω| C tan δ per length."""
        return section.density * section.polar_moment * np.abs(np.imag(s)) * self.tangent


def read_touchstone(path: Path) -> tuple[Floats, Complex]:
    """Frequency (Hz) and reflection of a one-port file against 50 Ω.

    Raises
    ------
    LogError
        If the file is not understood, or its reference is another impedance.
    """
    network = Network()
    try:
        # Network(path) would try to unpickle the file first
        network.read_touchstone(path)
    except ValueError as error:
        raise LogError(str(path), f"is not understood: {error}", "Give a one-port Touchstone file") from None
    if network.f.size == 0 or network.nports != 1:
        raise LogError(str(path), "holds no reflection of one port", "Give a one-port Touchstone file")
    if np.any(network.z0 != REFERENCE_OHM):
        raise LogError(str(path), "has another reference impedance", f"Give a file against {REFERENCE_OHM:g} Ω")
    return network.f, network.s[:, 0, 0]


def line_section(parameters: Mapping[str, float]) -> Section:
    """The line as a section of unit polar moment."""
    per_metre = parameters["delay_ns"] * 1e-9 / LENGTH
    capacitance, inductance = per_metre / parameters["impedance_ohm"], per_metre * parameters["impedance_ohm"]
    laws = (ConductorLoss(parameters["conductor_loss"] * 1e-4), DielectricLoss(parameters["dielectric_loss"]))
    return Section(LENGTH, 1.0, density=capacitance, shear_modulus=1 / inductance, laws=laws)


def reflection(parameters: Mapping[str, float], end: str, s: Complex) -> Complex:
    """Reflection against 50 Ω of the line with one of the three ends, and the connector if `parameters` have it."""
    line = line_section(parameters)
    short = s * parameters.get("short_nh", 0.0) * 1e-9 + 1e-6
    load = parameters["load_ohm"] + s * parameters.get("load_nh", 0.0) * 1e-9
    ends = {"open": s * parameters.get("open_pf", 0.0) * 1e-12, "short": 1 / short, "load": 1 / load}
    seen = input_admittance(line, ends[end], s) + s * parameters.get("connector_pf", 0.0) * 1e-12
    seen = REFERENCE_OHM / (1 / seen + s * parameters.get("connector_nh", 0.0) * 1e-9)
    turned: Complex = (1 - seen) / (1 + seen) * np.exp(-2e-9 * s * parameters.get("connector_delay_ns", 0.0))
    return turned


@dataclass(frozen=True)
class LineFit:
    """A joint fit of the three ends."""

    parameters: dict[str, float]
    misfit: float
    """Rms of the complex reflection's misfit over all ends and frequencies."""
    by_end: dict[str, float]


def fit_line(
    ranges: Mapping[str, tuple[float, float, float]], frequency: Floats, measured: dict[str, Complex]
) -> LineFit:
    """Least squares within the ranges over all ends at once."""
    from scipy.optimize import least_squares

    s = laplace(frequency)
    start, low, high = np.array(list(ranges.values())).T

    def errors(values: Floats) -> Complex:
        parameters = dict(zip(ranges, values.tolist(), strict=True))
        return np.array([reflection(parameters, end, s) - seen for end, seen in measured.items()])

    def residuals(values: Floats) -> Floats:
        misfit = errors(values)
        return np.concatenate([misfit.real.ravel(), misfit.imag.ravel()])

    found = least_squares(residuals, start, bounds=(low, high), x_scale=np.maximum(np.abs(start), 0.01))
    squares = np.abs(errors(found.x)) ** 2
    by_end = dict(zip(measured, np.sqrt(squares.mean(axis=1)).tolist(), strict=True))
    return LineFit(dict(zip(ranges, found.x.tolist(), strict=True)), float(np.sqrt(squares.mean())), by_end)


def read_ends(folder: Path = DATA) -> tuple[Floats, dict[str, Complex]]:
    """Frequencies (Hz) up to 3 GHz, and the reflection with each end."""
    read = {end: read_touchstone(folder / name) for end, name in FILES.items()}
    frequency = read["open"][0]
    kept = frequency <= HIGHEST_HZ
    return frequency[kept], {end: seen[kept] for end, (_, seen) in read.items()}


def main() -> None:
    """Print the table."""
    frequency, measured = read_ends()
    print(f"{'model':26} {'rms':>8} " + " ".join(f"{end:>8}" for end in measured))
    for name, ranges in (("plain line", PLAIN), ("with connector and ends", CONNECTED)):
        fit = fit_line(ranges, frequency, measured)
        print(f"{name:26} {fit.misfit:8.4f} " + " ".join(f"{fit.by_end[end]:8.4f}" for end in measured))
        print("   " + ", ".join(f"{key} {value:.4g}" for key, value in fit.parameters.items()))


if __name__ == "__main__":
    typer.run(main)

"""The measured mobility of a motor that drives a load through a flexible coupling, and what a model of it lacks.

A multisine of torque current repeats 20 times; the first period carries the start. Mobility and its variance come
from the spread between periods. Models are fitted to the odd periods and judged on the even ones, which have no
part in the fit. The current is the measured one, so a lag that a fit finds is one of the speed's measurement and not
of the current loop. Torque is known as current only, so inertias, stiffnesses and dampings are per torque constant.
"""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import typer

from drillid.arrays import Complex, Floats
from drillid.errors import LogError
from drillid.physics.equipment import Controller, TopDrive
from drillid.physics.lumped import LumpedString
from drillid.physics.responses import laplace

Parameters = Mapping[str, float]
Model = Callable[[Parameters, Complex], Complex]

DATA = Path(__file__).parents[3] / "shared" / "data" / "bench" / "MultisineTypeA.mat"
PERIOD = 2500
RATE = 2500.0
LOWEST_HZ, HIGHEST_HZ = 11, 250


@dataclass(frozen=True, eq=False)
class MotorMobility:
    """Mean over periods, each (frequency,)."""

    frequency: Floats
    """Hz."""
    mobility: Complex
    """rad/s per A."""
    deviation: Floats
    """Standard deviation of the complex mean."""


def read_motor(path: Path) -> tuple[Floats, Floats]:
    """Torque current (A) and motor speed (rad/s), each (period, sample).

    Raises
    ------
    LogError
        If a channel is missing or is no whole number of periods.
    """
    from scipy.io import loadmat

    content = loadmat(path)
    if not {"iq_adx", "omega_max"} <= content.keys() or content["iq_adx"].size % PERIOD:
        raise LogError(str(path), "it has no whole periods of iq_adx and omega_max", "Give the multisine record")
    current, speed = (np.asarray(content[name], dtype=float).reshape(-1, PERIOD) for name in ("iq_adx", "omega_max"))
    return current, speed


def motor_mobility(current: Floats, speed: Floats) -> MotorMobility:
    """Mobility at the multisine's lines from periods (period, sample), with the errors-in-output deviation."""
    lines = np.arange(LOWEST_HZ, HIGHEST_HZ + 1)
    driven, turned = (np.fft.rfft(series, axis=1)[:, lines] for series in (current, speed))
    mobility = turned.mean(axis=0) / driven.mean(axis=0)
    periods = current.shape[0]
    spread = np.sum(np.abs(turned - mobility * driven) ** 2, axis=0) / (periods - 1) / periods
    deviation = np.sqrt(spread) / np.abs(driven.mean(axis=0))
    return MotorMobility(lines * RATE / PERIOD, np.asarray(mobility, dtype=complex), np.asarray(deviation, dtype=float))


def two_inertias(parameters: Parameters, s: Complex) -> Complex:
    """Motor and load with a damped coupling, behind a delay and a first-order lag."""
    return _mobility(parameters, s, parameters["load_drag"], parameters["stiffness"])


def complex_stiffness(parameters: Parameters, s: Complex) -> Complex:
    """The same with a coupling that loses the same share of its energy in each cycle."""
    return _mobility(
        parameters, s, parameters["load_drag"], parameters["stiffness"] * (1 + 1j * parameters["loss_factor"])
    )


def three_inertias(parameters: Parameters, s: Complex) -> Complex:
    """The same with a third inertia on a spring behind the load."""
    third = LumpedString(
        parameters["third_stiffness"], parameters["third_inertia"], internal_damping=parameters["third_damping"]
    ).admittance(s)
    return _mobility(parameters, s, parameters["load_drag"] + third, parameters["stiffness"])


def second_filter(parameters: Parameters, s: Complex) -> Complex:
    """The same with one more first-order lag."""
    return two_inertias(parameters, s) / (1 + s * parameters["second_lag"])


def _mobility(parameters: Parameters, s: Complex, load_drag: complex | Complex, stiffness: complex) -> Complex:
    string = LumpedString(
        stiffness, parameters["load"], parameters["damping"], load_drag, external_damping_top=parameters["drag"]
    )
    motor = TopDrive(parameters["motor"], parameters["delay"], Controller(0.0), lag=parameters.get("lag", 0.0))
    return string.command_mobility(motor, s)


_PLAIN = {
    "motor": 0.012,
    "load": 0.012,
    "stiffness": 1300.0,
    "damping": 0.1,
    "drag": 0.1,
    "load_drag": 0.1,
    "delay": 5e-4,
}
_LAG = _PLAIN | {"lag": 3e-3}
_THIRD = {"third_stiffness": 3000.0, "third_inertia": 1e-3, "third_damping": 0.1}
CANDIDATES: Mapping[str, tuple[Model, Parameters]] = {
    "two inertias, delay": (two_inertias, _PLAIN),
    "+ loss factor of the coupling": (complex_stiffness, _PLAIN | {"loss_factor": 0.01}),
    "+ third inertia": (three_inertias, _PLAIN | _THIRD),
    "+ first-order lag": (two_inertias, _LAG),
    "+ lag, loss factor": (complex_stiffness, _LAG | {"loss_factor": 0.01}),
    "+ lag, second lag": (second_filter, _LAG | {"second_lag": 2e-4}),
    "+ lag, third inertia": (three_inertias, _LAG | _THIRD),
}
"""Models with their starting values, from the simplest on."""


@dataclass(frozen=True, eq=False)
class MotorFit:
    """A fitted model and its misfit."""

    name: str
    parameters: dict[str, float]
    errors: dict[str, float]
    """Relative standard errors, from the spread between periods."""
    misfit: float
    """Mean of |measured − model|²/variance on the periods of the fit; 1 for an exact model."""
    held_out: float
    """The same on the periods left out."""
    relative: float
    """Rms of |measured − model|/|measured| on the periods left out."""
    rough: float
    """Rms of the part of that which jumps from line to line, as no linear model does: non-linear distortion."""


def fit_motor(name: str, fitted: MotorMobility, held_out: MotorMobility) -> MotorFit:
    """Weighted least squares of one of the candidates from some starting values; all parameters are positive."""
    from scipy.optimize import OptimizeResult, least_squares

    model, start = CANDIDATES[name]
    s = laplace(fitted.frequency)

    def residuals(logs: Floats) -> Floats:
        error = (model(_named(start, logs), s) - fitted.mobility) / fitted.deviation
        return np.concatenate([error.real, error.imag])

    trials: list[OptimizeResult] = []
    for moved in _starts(start):
        bounds = (moved - 12, moved + 12)
        trials.append(least_squares(residuals, moved, bounds=bounds, jac="3-point", max_nfev=1000))
    best = min(trials, key=lambda trial: float(trial.cost))
    parameters = _named(start, best.x)
    curvature = best.jac.T @ best.jac / 2
    errors = np.sqrt(np.diag(np.linalg.pinv(curvature)) / 2)
    modelled = model(parameters, laplace(held_out.frequency))
    relative = modelled / held_out.mobility - 1
    jumps = (relative[1:-1] - (relative[:-2] + relative[2:]) / 2) / np.sqrt(1.5)
    return MotorFit(
        name,
        parameters,
        dict(zip(start, errors.tolist(), strict=True)),
        float(2 * best.cost / s.size),
        float(np.mean(np.abs((modelled - held_out.mobility) / held_out.deviation) ** 2)),
        float(np.sqrt(np.mean(np.abs(relative) ** 2))),
        float(np.sqrt(np.mean(np.abs(jumps) ** 2))),
    )


def _starts(start: Parameters) -> list[Floats]:
    """Logarithms of the starting values: as they are, moved as a whole, damped, and with third inertias of all sizes.

    The misfit of a third inertia has many minima; from this grid the lowest is found whatever the last bits are.
    """
    moves: list[dict[str, float]] = [
        {},
        {"motor": 0.4, "load": 0.4, "stiffness": 0.4},
        {"motor": 2.5, "load": 2.5, "stiffness": 2.5},
        {"damping": 0.1, "drag": 10.0, "delay": 3.0},
    ]
    if "third_stiffness" in start:
        grid = itertools.product((0.1, 1.0, 10.0, 100.0), (0.1, 1.0, 10.0))
        moves += [{"third_stiffness": stiffness, "third_inertia": inertia} for stiffness, inertia in grid]
    return [np.log(np.array([value * move.get(key, 1.0) for key, value in start.items()])) for move in moves]


def _named(start: Parameters, logs: Floats) -> dict[str, float]:
    return dict(zip(start, np.exp(logs).tolist(), strict=True))


def halves(path: Path = DATA) -> tuple[MotorMobility, MotorMobility]:
    """Mobility from the odd and from the even periods, without the first, which starts from rest."""
    current, speed = read_motor(path)
    return motor_mobility(current[1::2], speed[1::2]), motor_mobility(current[2::2], speed[2::2])


def table(fits: list[MotorFit]) -> str:
    """The fits, one a line."""
    lines = [f"{'model':32} {'misfit':>9} {'held out':>9} {'relative rms':>13} {'rough':>8}"]
    lines += [
        f"{one.name:32} {one.misfit:9.1f} {one.held_out:9.1f} {one.relative:12.2%} {one.rough:8.2%}" for one in fits
    ]
    best = min(fits, key=lambda one: one.held_out)
    lines.append(f"parameters of '{best.name}':")
    lines += [f"  {key:16} {value:12.5g} ± {best.errors[key]:.1%}" for key, value in best.parameters.items()]
    return "\n".join(lines)


def draw(measured: MotorMobility, fits: list[MotorFit], path: Path) -> None:
    """Amplitude, phase and relative misfit of some fits."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(3, 1, sharex=True, figsize=(9, 9), layout="constrained")
    axes[0].loglog(measured.frequency, np.abs(measured.mobility), "k.", label="measured, even periods")
    axes[1].semilogx(measured.frequency, np.degrees(np.unwrap(np.angle(measured.mobility))), "k.")
    axes[2].loglog(measured.frequency, measured.deviation / np.abs(measured.mobility), "k.", label="spread")
    for one in fits:
        modelled = CANDIDATES[one.name][0](one.parameters, laplace(measured.frequency))
        axes[0].loglog(measured.frequency, np.abs(modelled), label=one.name)
        axes[1].semilogx(measured.frequency, np.degrees(np.unwrap(np.angle(modelled))))
        axes[2].loglog(measured.frequency, np.abs(modelled / measured.mobility - 1))
    for axis, label in zip(axes, ("mobility, rad/s per A", "phase, °", "relative misfit"), strict=True):
        axis.set_ylabel(label)
        axis.grid(alpha=0.3)
    axes[0].legend()
    axes[2].set_xlabel("frequency, Hz")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=120)
    plt.close(figure)


def main() -> None:
    """Print the table and draw the fits."""
    fitted, held_out = halves()
    fits = [fit_motor(name, fitted, held_out) for name in CANDIDATES]
    print(table(fits))
    path = Path("results/benchmarks/motor.png")
    draw(held_out, [one for one in fits if one.name in ("two inertias, delay", "+ first-order lag")] + fits[-1:], path)
    print(f"drawn in {path}")


if __name__ == "__main__":
    typer.run(main)

"""The coupling of the motor bench learnt as a law: torque against twist, a monotone spline in the load's balance.

`python -m benchmarks.discoveries.motor_law` prints the law with its band and what it gains, and draws it.

ω̇ = f(φ) + c/J φ̇ + d/J ω for the load, with twist φ: cubic B-splines of the twist, whose coefficients may only rise, so
that the law does (de Boor 2001, A Practical Guide to Splines, chapter 11). The twist is measured, so the balance is
linear in them and is solved line by line of the multisine; the number of pieces is the one that predicts left-out lines
best. It is fitted to the odd periods and judged on the even ones, beside a spring with the same dampings.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import typer

from benchmarks.discoveries.jackknife import jackknife_error
from benchmarks.discoveries.motor import MotorRecord, read_record
from benchmarks.discoveries.motor_fit import DATA, HIGHEST_HZ, LOWEST_HZ
from drillid.arrays import Complex, Floats
from drillid.discrepancy.predictive_gain import PredictiveGain
from drillid.statistics import TWO_SIDED

FIGURE = Path("results/benchmarks/motor_law.png")
PIECES = (2, 4, 8)
"""Numbers of pieces that are tried."""
_DEGREE = 3
_LINES = np.arange(LOWEST_HZ, HIGHEST_HZ + 1)
_BLOCK = 16
"""Neighbouring lines that are left out together."""
_ODD, _EVEN = slice(1, None, 2), slice(2, None, 2)
_DRAWN = 81


@dataclass(frozen=True, eq=False)
class Law:
    """A learnt law; torques per inertia of the load, rad/s²."""

    pieces: int
    twist: Floats
    """rad, (points,)."""
    torque: Floats
    error: Floats
    """Standard error, by a jackknife over blocks of lines."""
    spring: Floats
    """Of the spring that fits the same periods best."""
    gain: PredictiveGain
    """Share of the spring's squared error on the even periods that the law saves, over blocks of lines."""
    softening: float
    """Share by which the torque at the largest twist falls short of that of the stiffness at no twist."""
    softening_error: float
    before: float
    """Rms of the balance's error on the even periods per rms of its left side, with the spring."""
    after: float

    @property
    def offered(self) -> bool:
        """Whether the lower limit of the gain is above zero."""
        return self.gain.low > 0


def rising_splines(twist: Floats, largest: float, pieces: int) -> Floats:
    """Sums of B-splines over twist, (terms, …): any with coefficients of at least 0 rises; all are 0 at no twist."""
    from scipy.interpolate import BSpline

    inner = np.linspace(-largest, largest, pieces + 1)
    knots = np.concatenate([[-largest] * _DEGREE, inner, [largest] * _DEGREE])
    flat = np.append(np.clip(twist.ravel(), -largest, largest), 0.0)
    design = BSpline.design_matrix(flat, knots, _DEGREE).toarray()
    sums = np.cumsum(design[:, ::-1], axis=1)[:, -2::-1]
    return np.asarray((sums[:-1] - sums[-1]).T.reshape(-1, *twist.shape), dtype=float)


@dataclass(frozen=True, eq=False)
class _Balance:
    """The load's balance at every line: left side (lines,) and columns (lines, terms + 2), the dampings last."""

    left: Complex
    columns: Complex

    @classmethod
    def of(cls, record: MotorRecord, torques: Floats, periods: slice) -> "_Balance":
        """With terms of the torque, (terms, period, sample), in the mean over some periods."""
        s = 2j * np.pi * _LINES
        dampings = [s * _lines(record.twist, periods), _lines(record.load_turned, periods)]
        columns = np.stack([*(_lines(term, periods) for term in torques), *dampings], axis=-1)
        return cls(s * _lines(record.load_turned, periods), columns)

    def solved(self, kept: Floats | slice = slice(None)) -> Floats:
        """Coefficients from some lines; those of the torque are at least 0."""
        from scipy.optimize import lsq_linear

        columns, left = self.columns[kept], self.left[kept]
        rows, right = np.concatenate([columns.real, columns.imag]), np.concatenate([left.real, left.imag])
        low = np.append(np.zeros(rows.shape[1] - 2), [-np.inf, -np.inf])
        scale = np.sqrt(np.mean(rows**2, axis=0))
        return np.asarray(lsq_linear(rows / scale, right, (low, np.inf)).x / scale, dtype=float)

    def errors(self, coefficients: Floats) -> Floats:
        """Squared errors of the balance, (lines,)."""
        return np.asarray(np.abs(self.left - self.columns @ coefficients) ** 2, dtype=float)


def _lines(signal: Floats, periods: slice) -> Complex:
    return np.asarray(np.fft.rfft(signal[periods], axis=1)[:, _LINES].mean(0), dtype=complex)


def learn_law(record: MotorRecord) -> Law:
    """Learn the coupling's law on the odd periods and judge it on the even ones."""
    blocks, largest = np.arange(_LINES.size) // _BLOCK, float(np.abs(record.twist[1:]).max())
    tried = {}
    for pieces in PIECES:
        balance = _Balance.of(record, rising_splines(record.twist, largest, pieces), _ODD)
        without = [balance.solved(blocks != block) for block in np.unique(blocks)]
        missed = sum(balance.errors(one)[blocks == block].sum() for block, one in enumerate(without))
        tried[pieces] = float(missed), balance, without
    pieces = min(tried, key=lambda each: tried[each][0])
    _, balance, without = tried[pieces]
    spring = _Balance.of(record, record.twist[None], _ODD)
    fitted, linear = balance.solved(), spring.solved()
    held = _Balance.of(record, rising_splines(record.twist, largest, pieces), _EVEN)
    held_spring = _Balance.of(record, record.twist[None], _EVEN)
    before, after = held_spring.errors(linear), held.errors(fitted)
    twist = np.linspace(-largest, largest, _DRAWN)
    drawn = rising_splines(twist, largest, pieces)
    each = np.array([one[:-2] @ drawn for one in without])
    error = np.array([jackknife_error(column.tolist()) for column in each.T])
    power = float(np.mean(np.abs(held.left) ** 2))
    return Law(
        pieces,
        twist,
        fitted[:-2] @ drawn,
        error,
        linear[0] * twist,
        _gain(before, after, blocks),
        _softening(twist, fitted[:-2] @ drawn),
        jackknife_error([_softening(twist, one) for one in each]),
        float(np.sqrt(before.mean() / power)),
        float(np.sqrt(after.mean() / power)),
    )


def _gain(before: Floats, after: Floats, blocks: Floats) -> PredictiveGain:
    """Share of the squared error that is saved, with its error over blocks."""
    saved = np.array([(before - after)[blocks == block].sum() for block in np.unique(blocks)]) / before.sum()
    return PredictiveGain(float(saved.sum()), float(saved.std(ddof=1) * np.sqrt(saved.size)), saved.size)


def _softening(twist: Floats, torque: Floats) -> float:
    """By the line and the cube of the twist that come closest to the law."""
    columns = np.stack([twist, twist**3, np.ones(twist.size)], axis=-1)
    stiffness, cube, _ = np.linalg.lstsq(columns, torque, rcond=None)[0]
    return float(-cube * twist[-1] ** 2 / stiffness)


def table(law: Law) -> str:
    """The law with its band, and what it gains."""
    lines = [f"{'twist, mrad':>11} {'law, rad/s²':>12} {'95 % band':>11} {'spring':>9}"]
    for row in range(0, _DRAWN, 10):
        band = TWO_SIDED * law.error[row]
        lines.append(f"{1e3 * law.twist[row]:11.2f} {law.torque[row]:12.1f} {band:11.1f} {law.spring[row]:9.1f}")
    interval = TWO_SIDED * law.softening_error
    lines += [
        f"monotone spline of {law.pieces} pieces; at the largest twist the coupling is softer by "
        f"{law.softening:.1%} ± {interval:.1%}",
        f"error of the load's balance, even periods: {law.before:.2%} with a spring, {law.after:.2%} with the law",
        f"squared error saved there: {law.gain.value:.1%} ({law.gain.low:.1%} to {law.gain.high:.1%}); "
        + ("offered" if law.offered else "not offered"),
    ]
    return "\n".join(lines)


def draw(law: Law, path: Path) -> None:
    """The law beside the spring, and what it departs from it, with the band."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, (whole, rest) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
    twist, band = 1e3 * law.twist, TWO_SIDED * law.error
    whole.plot(twist, law.torque, "C1", label="learnt law")
    whole.plot(twist, law.spring, "k--", lw=0.9, label="spring")
    whole.fill_between(twist, law.torque - band, law.torque + band, color="C1", alpha=0.3, lw=0, label="95 % band")
    whole.set(xlabel="twist, mrad", ylabel="torque per inertia of the load, rad/s²")
    whole.legend()
    departs = law.torque - law.spring
    rest.plot(twist, departs, "C1")
    rest.fill_between(twist, departs - band, departs + band, color="C1", alpha=0.3, lw=0)
    rest.axhline(0, color="k", ls="--", lw=0.9)
    rest.set(xlabel="twist, mrad", ylabel="law less spring, rad/s²")
    for axis in (whole, rest):
        axis.grid(alpha=0.3)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=120)
    plt.close(figure)


def main() -> None:
    """Print the table and draw the law."""
    if not DATA.is_file():
        typer.echo(f"the motor's record is not at {DATA}", err=True)
        raise typer.Exit(1)
    law = learn_law(read_record())
    print(table(law))
    draw(law, FIGURE)
    print(f"drawn in {FIGURE}")


if __name__ == "__main__":
    typer.run(main)

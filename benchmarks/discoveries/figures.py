"""Figures of the discoveries: verdicts against depth, the motor before and after, the field's start in time."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np

from benchmarks.discoveries.field import SERIES, Misses
from benchmarks.discoveries.motor import MotorExamined
from benchmarks.discoveries.rows import Discovery
from benchmarks.field.log import FieldLog
from benchmarks.field.start_up import FITTED_S
from drillid.discrepancy.verdicts.verdict import NONE, UNKNOWN
from drillid.simulation.start_up import RATE
from drillid.units import RPM

_COLOURS = {NONE: "0.75", UNKNOWN: "C3"}


def _figure(rows: int, columns: int, **options: Any) -> Any:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    return plt.subplots(rows, columns, layout="constrained", **options)


def _save(figure: Any, path: Path) -> None:
    import matplotlib.pyplot as plt

    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw_wells(rows: Sequence[Discovery], path: Path) -> None:
    """Verdicts of each well as bars along its hole depth."""
    wells = list(dict.fromkeys(one.data for one in rows))
    figure, axes = _figure(len(wells), 1, figsize=(11, 1 + 1.3 * len(wells)), squeeze=False)
    for axis, well in zip(axes[:, 0], wells, strict=True):
        own = [one for one in rows if one.data == well]
        first, last = min(one.from_m for one in own), max(one.to_m for one in own)
        for place, one in enumerate(own):
            axis.barh(place, one.to_m - one.from_m, left=one.from_m, color=_COLOURS.get(one.verdict, "C0"), alpha=0.6)
            size = f", {one.size[0]:.3g} {one.unit}" if np.isfinite(one.size[0]) else ""
            at = f", {one.location_m:.0f} m along the string" if np.isfinite(one.location_m) else ""
            words = f" {one.verdict} ({one.probability:.2g}){size}{at} "
            side = "right" if one.from_m > (first + last) / 2 else "left"
            axis.text(one.from_m, place, words, va="center", ha=side, fontsize=9)
        axis.set(xlim=(first, max(last, first + 1)), ylim=(len(own) - 0.5, -0.5), yticks=[], ylabel=well)
    axes[-1, 0].set_xlabel("hole depth, m")
    _save(figure, path)


def draw_motor(found: MotorExamined, path: Path) -> None:
    """Mobility, misfit before and after, the record beside the angle, and the evidence for each cause."""
    figure, ((size, evidence), (misfit, record)) = _figure(2, 2, figsize=(13, 9))
    frequency = found.speed[1].frequency
    base, best = found.by_speed.base, found.by_speed.fits[found.by_speed.cause]
    size.loglog(frequency, np.abs(found.speed[1].value), "k.", ms=4, label="by the recorded speed")
    size.loglog(frequency, np.abs(found.angle[1].value), ".", color="0.6", ms=4, label="by the angle")
    misfit.loglog(
        frequency, found.speed[1].deviation / np.abs(found.speed[1].value), "k.", ms=3, label="spread between periods"
    )
    noise = base.problem.measured
    misfit.loglog(frequency, noise.deviation / np.abs(noise.value), "0.6", label="with what jumps from line to line")
    for model, label, colour in (
        (base, "two inertias, delay", "C1"),
        (best, f"with {found.by_speed.cause}", "C0"),
        (found.by_angle.base, "two inertias, delay, by the angle", "C2"),
    ):
        measured = found.angle[1] if model is found.by_angle.base else found.speed[1]
        size.loglog(frequency, np.abs(model.predicted(frequency)), colour, lw=1)
        misfit.loglog(frequency, np.abs(model.predicted(frequency) / measured.value - 1), colour, lw=1, label=label)
    ratio = found.ratio[1].value
    filtered = found.of_record.fits[found.of_record.cause].predicted(frequency)
    record.semilogx(frequency, np.abs(ratio), "k.", ms=3, label="recorded speed per derivative of the angle")
    record.semilogx(frequency, np.abs(filtered), "C0", label="first-order low pass")
    _evidence(evidence, found)
    size.set_ylabel("mobility, rad/s per A")
    misfit.set(xlabel="frequency, Hz", ylabel="misfit per response, even periods")
    record.set(xlabel="frequency, Hz", ylabel="amplitude")
    for axis in (size, misfit, record):
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8)
    _save(figure, path)


def _evidence(axis: Any, found: MotorExamined) -> None:
    """Log Bayes factors of the causes by speed and by angle."""
    names = [*found.by_speed.evidence, UNKNOWN]
    for offset, (weighed, label) in enumerate(((found.by_speed, "by speed"), (found.by_angle, "by angle"))):
        values = [*weighed.evidence.values(), weighed.disturbed]
        axis.barh(np.arange(len(names)) + 0.4 * offset, values, 0.4, label=label)
    axis.set_xscale("symlog")
    axis.set(yticks=np.arange(len(names)) + 0.2, yticklabels=names, xlabel="log Bayes factor against two inertias")
    axis.invert_yaxis()
    axis.legend(fontsize=8)
    axis.grid(alpha=0.3)


def draw_field(log: FieldLog, found: Mapping[str, Misses], path: Path) -> None:
    """Measured and simulated series of the models, and their rms misses."""
    figure, axes = _figure(3, 1, figsize=(12, 11))
    middle = (log.bit_slowest + log.bit_fastest) / 2
    measured = {"torque": log.torque / 1e3, "bit speed": middle / RPM}
    shown = [next(iter(found)), *list(found)[-2:]]
    for axis, (series, (_, unit)) in zip(axes[:2], SERIES.items(), strict=True):
        time = np.arange(measured[series].size) / RATE
        axis.plot(time, measured[series], "k", lw=1, label="measured")
        for name in shown:
            miss = found[name].miss[series][1]
            axis.plot(time[: miss.size], miss + measured[series][: miss.size], lw=1, label=name)
        axis.axvline(FITTED_S, color="k", ls=":", lw=1)
        axis.set(xlabel="time, s (fitted up to the dots)", ylabel=f"{series}, {unit.removesuffix(' rms')}")
        axis.legend(fontsize=8, ncols=2)
        axis.grid(alpha=0.3)
    _bars(axes[2], found)
    _save(figure, path)


def _bars(axis: Any, found: Mapping[str, Misses]) -> None:
    """Misses of every model per those of the first one."""
    places = np.arange(len(found))
    first = next(iter(found.values()))
    spans = ((0.0, FITTED_S, "fitted, 0–45 s"), (FITTED_S, 60.0, "held out, 45–60 s"))
    for number, (series, (begin, end, label)) in enumerate((one, span) for one in SERIES for span in spans):
        share = [one.rms(series, begin, end) / first.rms(series, begin, end) for one in found.values()]
        axis.bar(places + 0.2 * number - 0.3, share, 0.2, label=f"{series}, {label}")
    axis.set(xticks=places, ylabel="rms miss per that of viscous drag")
    axis.set_xticklabels([fill(name, 22) for name in found], fontsize=8)
    axis.legend(fontsize=8, ncols=2)
    axis.grid(alpha=0.3)

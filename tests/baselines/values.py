"""Numbers that hold the status quo: no law, data sheet or publication states them, yet a change of them is to be seen.

Each function computes the numbers of one stored file; `python -m tests.baselines.make` writes the files again.
Recordings of others are read from ../shared/data; what they give may be stored here, they themselves may not.
"""

import functools
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.discoveries import motor_fit
from benchmarks.discoveries.field import Misses
from benchmarks.discoveries.field_rows import field_rows, simulated
from benchmarks.discoveries.motor import MotorExamined, examine_motor, read_record
from benchmarks.discoveries.motor_fit import CANDIDATES, fit_motor, halves
from benchmarks.discoveries.motor_rows import motor_rows
from benchmarks.discoveries.rows import Discovery
from benchmarks.field import start_up as field
from benchmarks.field.log import FieldLog, read_field_log
from benchmarks.field.start_up import LADDER, jittered_misfits
from benchmarks.microstrip import CONNECTED, PLAIN, fit_line, read_ends
from benchmarks.microstrip import DATA as LINE
from drillid.config.listing import Well
from drillid.config.rig import Rig
from drillid.config.settings import Settings
from drillid.datasets.store import WellFolders
from drillid.fits.window_fit import Prior, fit
from drillid.physics.parameters import PARAMETERS
from drillid.records import stage as records
from drillid.simulation.start_up import RATE, STATISTICS_DELAY
from drillid.simulation.start_up_fit import misfit
from drillid.windows import stage as windows
from tests.simulated import DEEP, SHALLOW
from tests.truth.measured import SETTINGS, measured

Values = dict[str, float | str]

ROOT = Path(__file__).resolve().parents[2]
RIG_LOGS = ROOT.parent / "shared" / "data" / "rig-logs"


def rig_logs() -> Values:
    """Problem rows of the records and windows of three recorded wells, by kind, and their windows."""
    found: Values = {}
    for name in ("W10", "W21", "W23"):
        rig = Rig.from_yaml(ROOT / "config" / "shared-rigs" / "rigs" / f"{name}.yaml")
        well = Well(name, rig, tuple(sorted((RIG_LOGS / name).iterdir())))
        with TemporaryDirectory() as folder:
            folders = WellFolders(Path(folder), name)
            problems = [row for stage in (records, windows) for row in stage.process(well, folders, Settings())]
            window = folders.read("windows", "windows").load()
        found |= {f"{name}: {what}": count for what, count in sorted(Counter(row.what for row in problems).items())}
        found |= {f"{name}: windows": window.sizes["window"], f"{name}: first depth, m": float(window["hole_depth"][0])}
    return found


def field_start() -> Values:
    """Misses of the authors and of each model of the field well's start of rotation, kN m and rpm rms to 45 s."""
    log = read_field_log(field.DATA)
    time = np.arange(log.torque.size) / RATE
    late = np.interp(time - STATISTICS_DELAY, time, log.authors_bit_speed)
    found: Values = {}
    for name, speed in (("authors", log.authors_bit_speed), ("authors, stamps at the end", late)):
        authors = misfit(log, log.authors_torque, speed)
        found |= {f"{name}: torque": authors.torque_rms, f"{name}: bit speed": authors.bit_rms}
    for name, (friction, _) in LADDER.items():
        torque, bit, extremes = np.sqrt(np.mean(jittered_misfits(friction, log) ** 2, axis=0)).tolist()
        found |= {f"{name}: torque": torque, f"{name}: bit speed": bit, f"{name}: extremes": extremes}
    return found


def field_discoveries() -> Values:
    """Verdicts, sizes and gains on the field well's start of rotation."""
    log, found = simulated_field()
    return _rows(field_rows(found, log))


@functools.cache
def simulated_field() -> tuple[FieldLog, dict[str, Misses]]:
    """The field log, and the misses of each model's simulation."""
    log = read_field_log(field.DATA)
    return log, simulated(log)


def motor_discoveries() -> Values:
    """Verdicts, sizes and gains on the motor bench."""
    return _rows(motor_rows(examined_motor()))


@functools.cache
def examined_motor() -> MotorExamined:
    """The motor's record, examined."""
    return examine_motor(read_record())


def _rows(rows: tuple[Discovery, ...]) -> Values:
    found: Values = {}
    for number, row in enumerate(rows):
        numbers = {"probability": row.probability, "size": row.size[0], "gain": row.gain[0], "least gain": row.gain[1]}
        told = {"verdict": row.verdict} | {name: value for name, value in numbers.items() if np.isfinite(value)}
        found |= {f"{number} {row.data}: {name}": value for name, value in told.items()}
    return found


def motor_fits() -> Values:
    """Misfits of models of the motor bench, fitted to odd and scored on even periods, and the lag that one finds."""
    fits = [fit_motor(name, *halves()) for name in CANDIDATES]
    found: Values = {}
    for one in fits:
        found |= {f"{one.name}: misfit": one.misfit, f"{one.name}: held out": one.held_out}
        found |= {f"{one.name}: relative": one.relative, f"{one.name}: rough": one.rough}
    return found | {"lag, s": next(one for one in fits if one.name == "+ first-order lag").parameters["lag"]}


def line_fits() -> Values:
    """Rms misfit of the measured microstrip line's reflection, plain and with connector and ends."""
    found: Values = {}
    for name, ranges in (("plain", PLAIN), ("connected", CONNECTED)):
        fitted = fit_line(ranges, *read_ends())
        found |= {f"{name}: all ends": fitted.misfit} | {f"{name}: {end}": rms for end, rms in fitted.by_end.items()}
    return found


def window_fits() -> Values:
    """Standard errors of fits without advance information: medians of eight simulated windows of two rigs."""
    found: Values = {}
    for name, truth in (("deep", DEEP), ("shallow", SHALLOW)):
        fits = [fit(measured(truth, seed), truth.known, Prior.silent(), SETTINGS.fits) for seed in range(8)]
        errors = np.median([one.error for one in fits], axis=0).tolist()
        found |= {f"{name}: {parameter}": error for parameter, error in zip(PARAMETERS, errors, strict=True)}
    return found


BASELINES: dict[str, tuple[Callable[[], Values], Path | None]] = {
    "rig_logs": (rig_logs, RIG_LOGS),
    "field_start": (field_start, field.DATA),
    "field_discoveries": (field_discoveries, field.DATA),
    "motor_discoveries": (motor_discoveries, motor_fit.DATA),
    "motor_fits": (motor_fits, motor_fit.DATA),
    "line_fits": (line_fits, LINE),
    "window_fits": (window_fits, None),
}
"""By the name of the stored file, what computes it and the recordings that it needs."""

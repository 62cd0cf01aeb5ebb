"""Extended models in the examination dataset: the variables that are stored, and the model made from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from drillid.arrays import Booleans, Floats
from drillid.discrepancy.catalogue import CATALOGUE, OperatingPoint, WindowModel
from drillid.discrepancy.inference.coordinates import Extension, Point
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.learning.elements import TERMS
from drillid.physics.equipment import STEEL_DENSITY, Bit, Controller, DrillingSystem, Section, TopDrive, of_window
from drillid.physics.nonlinear import ErrorLaw, NonlinearRig, SpeedLaw, TwistLaw
from drillid.physics.sensor import Recording
from drillid.simulation.short_sections import with_short_sections_extended
from drillid.simulation.simulate import TIME_STEP

if TYPE_CHECKING:
    import xarray as xr

    from drillid.discrepancy.sets import ExaminedSet


COORDINATES = (
    *("kappa", "delta", "length", "polar_moment", "delay", "inertia_td", "damping_bha", "inertia_bit"),
    *("proportional", "integral", "speed_filter", "torque_filter", "clock_offset"),
    *("control_interval", "delay_variance", "clock_variance"),
    *("collar_length", "collar_polar_moment", "mean_speed", "mean_torque", "depth_length"),
)
"""Parameters that describe a window before causes are added, SI: the eight of the transmission line, with the inertia
below the collars; the control; the offset between the clocks; the interval at which the control samples and holds, and
how far the variances that it adds to delay and clock are off their formula; the collars; the operating point that
causes depend on.
"""


def coordinates(model: SetModel, point: Point) -> dict[str, Floats]:
    """The COORDINATES of every window in SI units, each of shape (window,)."""
    window_model, sheet = model.window_model_at(point), model.evidence.data_sheet
    system, operating_point = window_model.system, model.operating_point
    pipe, top_drive, controller = system.string[0], system.top_drive, system.top_drive.controller
    values = [pipe.kappa, pipe.delta, pipe.length, pipe.polar_moment, top_drive.delay, top_drive.inertia]
    values += [system.bit.damping, system.bit.inertia, controller.proportional, controller.integral]
    values += [controller.speed_filter, controller.torque_filter, window_model.recording.clock_offset]
    values += [window_model.control_interval, top_drive.hold_variance, window_model.recording.hold_variance]
    values += [sheet.collar_length, sheet.collar_polar_moment]
    values += [operating_point.speed, operating_point.torque, operating_point.length]
    shape = (model.evidence.windows, 1)
    return {
        name: np.broadcast_to(np.asarray(value, dtype=float), shape)[:, 0]
        for name, value in zip(COORDINATES, values, strict=True)
    }


def parameters(model: SetModel, point: Point) -> Floats:
    """The eight parameters of each window, (window, 8) in the order of the schema."""
    values = coordinates(model, point)
    inertia = values["inertia_bit"] + STEEL_DENSITY * values["collar_polar_moment"] * values["collar_length"]
    return np.stack([*(values[name] for name in COORDINATES[:7]), inertia], axis=1)


def window_model_of(
    values: Mapping[str, Floats], extensions: Sequence[Extension], sizes: Sequence[float]
) -> WindowModel:
    """The model of all windows of a set with its causes; the inverse of `coordinates`.

    Parameters
    ----------
    values : by the names of COORDINATES, each of shape (window,)
    extensions, sizes : causes of the set, and the size of each
    """
    column = {name: value[:, None] for name, value in values.items()}
    pipe = Section(column["length"], column["polar_moment"], column["kappa"], column["delta"])
    collars = replace(pipe, length=column["collar_length"], polar_moment=column["collar_polar_moment"])
    string = (pipe, collars) if np.any(column["collar_length"] > 0) else (pipe,)
    controller = Controller(column["proportional"], column["integral"], column["speed_filter"], column["torque_filter"])
    top_drive = TopDrive(column["inertia_td"], column["delay"], controller, hold_variance=column["delay_variance"])
    system = DrillingSystem(top_drive, string, Bit(column["inertia_bit"], column["damping_bha"]))
    recording = Recording(clock_offset=column["clock_offset"], hold_variance=column["clock_variance"])
    window_model = WindowModel(system, recording, control_interval=column["control_interval"])
    operating_point = OperatingPoint(column["mean_speed"], column["mean_torque"], column["depth_length"])
    for extension, size in zip(extensions, sizes, strict=True):
        present = size * extension.present(len(column["kappa"]))
        window_model = extension.cause.extend(window_model, present, extension.shape, operating_point)
    return window_model


def extension_variables(sets: Sequence[ExaminedSet], windows: int) -> dict[str, tuple[Any, ...]]:
    """Causes that stay in the model of a set, along `extension`, and the coordinates of every window."""
    values = np.full((windows, len(COORDINATES)), np.nan)
    rows: list[tuple[Any, ...]] = []
    present: list[Booleans] = []
    for number, examined in enumerate(sets):
        examination = examined.examination
        extended = examination.extended
        values[examined.rows] = np.stack(list(coordinates(examination.model, extended.point).values()), axis=1)
        for index, extension in enumerate(examination.extensions):
            size, error = extended.point.sizes[index], extended.size_errors[index]
            rows.append((number, extension.cause.name, extension.shape, extended.point.shapes[index], size, error))
            inside = examined.rows if extension.windows is None else examined.rows[list(extension.windows)]
            present.append(np.isin(np.arange(windows), inside))
    names = ("set", "cause", "shape", "fitted_shape", "size", "size_error")
    columns = list(zip(*rows, strict=True)) or [()] * len(names)
    return {
        "coordinates": (("window", "coordinate"), values),
        "extension_present": (("extension", "window"), np.array(present, dtype=bool).reshape(len(rows), windows)),
        **{
            f"extension_{name}": ("extension", np.array(column, dtype=object if name == "cause" else float))
            for name, column in zip(names, columns, strict=True)
        },
    }


def extended_window_model(examination: xr.Dataset, number: int) -> WindowModel:
    """The extended model of a set, with parameters of shape (window, 1) over the windows of the set.

    Parameters
    ----------
    examination : the examination dataset
    number : of the set
    """
    rows = np.flatnonzero(examination["window_set"].values == number)
    values = examination["coordinates"].values[rows].T
    of_set = examination.isel(extension=np.flatnonzero(examination["extension_set"].values == number))
    extensions = [
        Extension(
            (CATALOGUE | TERMS)[str(cause)].shaped(float(fitted)),
            float(shape),
            tuple(np.flatnonzero(present[rows]).tolist()),
        )
        for cause, shape, fitted, present in zip(
            of_set["extension_cause"].values,
            of_set["extension_shape"].values,
            of_set["extension_fitted_shape"].values,
            of_set["extension_present"].values,
            strict=True,
        )
    ]
    return window_model_of(
        dict(zip(COORDINATES, values, strict=True)), extensions, of_set["extension_size"].values.tolist()
    )


def identified_window_models(examination: xr.Dataset) -> dict[int, WindowModel]:
    """The extended model of every window in whose set a cause was named, by the window's row.

    Each can be used like any other model of the rig: `window_model.continuous_system` in drillid.control, modes and
    responses in time, `window_model.system` for responses in the measured band, and `window_model.mobility(s)` as the
    response that records contain.
    """
    return _models_of(examination, "extension_set")


def _models_of(examination: xr.Dataset, variable: str) -> dict[int, WindowModel]:
    """The model of every window of the sets that a variable lists, by the window's row."""
    models: dict[int, WindowModel] = {}
    numbers = np.unique(examination[variable].values)
    for number in numbers[numbers >= 0].astype(int).tolist():
        window_model = extended_window_model(examination, number).held()
        rows = np.flatnonzero(examination["window_set"].values == number).tolist()
        for index, row in enumerate(rows):
            models[row] = of_window(window_model, (index,), (len(rows),))
    return models


def simulated_rigs(examination: xr.Dataset) -> dict[int, NonlinearRig]:
    """The rig of every window that was examined, with what was named or learnt, by its row, for `drillid.simulation`.

    A law of the bit is taken less its tangent at the window's mean speed, which the system's damping holds. A coupling
    has, besides its law, the compliance that keeps its twist from ever falling, and its law is about the window's mean
    torque. Effects of the recording on the speed are no part of the rig.
    """
    return {
        row: NonlinearRig(
            with_short_sections_extended(window_model.continuous_system, TIME_STEP),
            law=_bit_law(examination, row),
            coupling=_coupling(examination, row, window_model),
            control_law=_control_law(examination, row),
        )
        for row, window_model in _models_of(examination, "window_set").items()
    }


def _bit_law(examination: xr.Dataset, row: int) -> SpeedLaw | None:
    number = int(examination["window_set"].values[row])
    speed, torque = (examination[f"law_{name}"].values[number] for name in ("speed", "torque"))
    if not np.isfinite(torque).all():
        return None
    mean = float(examination["coordinates"].sel(coordinate="mean_speed").values[row])
    return SpeedLaw(speed, less_tangent(speed, torque, mean), float(examination["law_memory"].values[number]))


def _coupling(examination: xr.Dataset, row: int, window_model: WindowModel) -> TwistLaw | None:
    number = int(examination["window_set"].values[row])
    torque, twist = (examination[f"coupling_{name}"].values[number] for name in ("torque", "twist"))
    if not np.isfinite(twist).all():
        return None
    length = float(sum(section.length for section in window_model.system.string))
    mean = float(examination["coordinates"].sel(coordinate="mean_torque").values[row])
    bend = less_tangent(torque, twist, mean)
    least = max(0.0, -float(np.diff(bend).min()) / float(torque[1] - torque[0]))
    return TwistLaw(float(examination["coupling_place"].values[number]) * length, torque, bend + least * torque)


def _control_law(examination: xr.Dataset, row: int) -> ErrorLaw | None:
    number = int(examination["window_set"].values[row])
    error, torque = (examination[name].values[number] for name in ("control_speed_error", "control_torque"))
    if not np.isfinite(torque).all():
        return None
    return ErrorLaw(error, torque)


def less_tangent(place: Floats, value: Floats, mean: float) -> Floats:
    """A law (points,), straight beyond its ends, less its tangent at a mean."""
    at = np.clip(mean, place[0], place[-1])
    slope = np.interp(at, place, np.gradient(value, place))
    return np.asarray(value - np.interp(at, place, value) - slope * (place - at), dtype=float)

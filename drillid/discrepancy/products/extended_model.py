"""Extended models in the examination dataset: what is stored of them, and the system that they describe."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from drillid.arrays import Booleans, Floats
from drillid.discrepancy.catalogue import CATALOGUE, OperatingPoint, WindowModel
from drillid.discrepancy.inference.set_model import Extension, Point, SetModel
from drillid.physics.equipment import STEEL_DENSITY, Bit, Controller, DrillingSystem, Section, TopDrive
from drillid.physics.sensor import Recording

if TYPE_CHECKING:
    import xarray as xr

    from drillid.discrepancy.sets import ExaminedSet


FIGURES = (
    *("kappa", "delta", "length", "polar_moment", "delay", "inertia_td", "damping_bha", "inertia_bit"),
    *("proportional", "integral", "speed_filter", "torque_filter", "clock_offset"),
    *("collar_length", "collar_polar_moment", "mean_speed", "mean_torque", "depth_length"),
)
"""What describes a window before causes are added, SI: the eight parameters with the inertia below the collars, the
control, the offset between the clocks, the collars, and the circumstances that causes may know."""


def figures(model: SetModel, point: Point) -> dict[str, Floats]:
    """Figures of every window, each of shape (window,)."""
    window_model, known = model.window_model_at(point), model.evidence.data_sheet
    system, operating_point = window_model.system, model.operating_point
    pipe, top_drive, controller = system.string[0], system.top_drive, system.top_drive.controller
    values = [pipe.kappa, pipe.delta, pipe.length, pipe.polar_moment, top_drive.delay, top_drive.inertia]
    values += [system.bit.damping, system.bit.inertia, controller.proportional, controller.integral]
    values += [controller.speed_filter, controller.torque_filter, window_model.recording.clock_offset]
    values += [known.collar_length, known.collar_polar_moment]
    values += [operating_point.speed, operating_point.torque, operating_point.length]
    shape = (model.evidence.windows, 1)
    return {
        name: np.broadcast_to(np.asarray(value, dtype=float), shape)[:, 0]
        for name, value in zip(FIGURES, values, strict=True)
    }


def parameters(model: SetModel, point: Point) -> Floats:
    """The eight parameters of each window, (window, 8) in the order of the schema."""
    figure = figures(model, point)
    inertia = figure["inertia_bit"] + STEEL_DENSITY * figure["collar_polar_moment"] * figure["collar_length"]
    return np.stack([*(figure[name] for name in FIGURES[:7]), inertia], axis=1)


def window_model_of(
    figure: Mapping[str, Floats], extensions: Sequence[Extension], sizes: Sequence[float]
) -> WindowModel:
    """The model of all windows of a set with its causes; the inverse of `figures`.

    Parameters
    ----------
    figure : arrays of shape (window,)
    extensions, sizes : causes of the set and how large each is
    """
    one = {name: values[:, None] for name, values in figure.items()}
    pipe = Section(one["length"], one["polar_moment"], one["kappa"], one["delta"])
    collars = replace(pipe, length=one["collar_length"], polar_moment=one["collar_polar_moment"])
    string = (pipe, collars) if np.any(one["collar_length"] > 0) else (pipe,)
    controller = Controller(one["proportional"], one["integral"], one["speed_filter"], one["torque_filter"])
    top_drive = TopDrive(one["inertia_td"], one["delay"], controller)
    system = DrillingSystem(top_drive, string, Bit(one["inertia_bit"], one["damping_bha"]))
    window_model = WindowModel(system, Recording(clock_offset=one["clock_offset"]))
    operating_point = OperatingPoint(one["mean_speed"], one["mean_torque"], one["depth_length"])
    for extension, size in zip(extensions, sizes, strict=True):
        here = size * extension.present(len(one["kappa"]))
        window_model = extension.cause.extend(window_model, here, extension.shape, operating_point)
    return window_model


def extension_variables(sets: Sequence[ExaminedSet], windows: int) -> dict[str, tuple[Any, ...]]:
    """Variables along `extension`: every cause that stays in the model of a set; and figures of every window."""
    values = np.full((windows, len(FIGURES)), np.nan)
    rows: list[tuple[Any, ...]] = []
    present: list[Booleans] = []
    for number, one in enumerate(sets):
        found = one.examination
        values[one.rows] = np.stack(list(figures(found.model, found.extended.point).values()), axis=1)
        for place, extension in enumerate(found.extensions):
            size, error = found.extended.point.sizes[place], found.extended.size_errors[place]
            rows.append((number, extension.cause.name, extension.shape, size, error))
            inside = one.rows if extension.windows is None else one.rows[list(extension.windows)]
            present.append(np.isin(np.arange(windows), inside))
    names = ("set", "cause", "shape", "size", "size_error")
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
    """The extended model of a set, with figures of shape (window, 1) over the windows of the set.

    Parameters
    ----------
    examination : the dataset of that name
    number : of the set
    """
    rows = np.flatnonzero(examination["window_set"].values == number)
    values = examination["coordinates"].values[rows].T
    of_set = examination.isel(extension=np.flatnonzero(examination["extension_set"].values == number))
    extensions = [
        Extension(CATALOGUE[str(cause)], float(shape), tuple(np.flatnonzero(present[rows]).tolist()))
        for cause, shape, present in zip(
            of_set["extension_cause"].values,
            of_set["extension_shape"].values,
            of_set["extension_present"].values,
            strict=True,
        )
    ]
    return window_model_of(
        dict(zip(FIGURES, values, strict=True)), extensions, of_set["extension_size"].values.tolist()
    )


def identified_window_models(examination: xr.Dataset) -> dict[int, WindowModel]:
    """The extended model of every window in whose set a cause was named, by the window's row.

    Each can be used wherever a model of the rig is: `window_model.system` in drillid.physics and
    drillid.control.tuning, and `setup.mobility(s)` for what the records show of it.
    """
    found: dict[int, WindowModel] = {}
    for number in np.unique(examination["extension_set"].values).astype(int).tolist():
        window_model = extended_window_model(examination, number)
        for place, row in enumerate(np.flatnonzero(examination["window_set"].values == number).tolist()):
            found[row] = _of_window(window_model, place)
    return found


def _of_window(value: Any, place: int) -> Any:
    """Figures of one window, as numbers, out of equipment with figures of shape (window, 1)."""
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{one.name: _of_window(getattr(value, one.name), place) for one in fields(value)})
    if isinstance(value, tuple):
        return tuple(_of_window(one, place) for one in value)
    if isinstance(value, np.ndarray) and value.ndim:
        return float(value[place if value.shape[0] > 1 else 0].item())
    return value

"""A described well fitted to the first part of a measured start of rotation, and judged on the rest of it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from drillid.config.described_well import DescribedWell, write_fitted
from drillid.datasets.store import Problem, WellFolders
from drillid.simulation.start_up import RATE
from drillid.simulation.start_up_files import read_start_up, read_survey
from drillid.simulation.start_up_fit import BOUNDS, MeasuredStartUp
from drillid.start_ups.judging import DESCRIBED, FITTED, Judged, judged
from drillid.units import RPM

if TYPE_CHECKING:
    from drillid.config.listing import StartUp
    from drillid.config.settings import Settings

_SPANS = ("seen", "held out")
_AT_BOUND = 1e-3
"""Distance from a bound, relative to it, within which a value lies at it."""


def process(start_up: StartUp, folders: WellFolders, settings: Settings) -> list[Problem]:
    """Fit and judge one start of rotation: its dataset, its figure, and the description with which to predict.

    Raises
    ------
    DrillidError
        If a file cannot be used, or something is to be fitted that has no bounds.
    """
    from drillid.figures.layout import save
    from drillid.figures.start_up import draw

    described, log = DescribedWell.from_yaml(start_up.description), read_start_up(start_up.log)
    before = described.model(read_survey(start_up.survey), start_up.depth, start_up.fitted)
    seen = settings.start_ups.seen_share * log.duration
    after = before.fit(log, seen, settings.start_ups.evaluations)
    found = judged({DESCRIBED: before, FITTED: after}, log, seen)
    dataset = dataset_of(found, log, seen)
    folders.write("start_ups", "start_ups", dataset, depth_m=start_up.depth)
    for suffix in settings.figures.formats:
        path = folders.stage("start_ups") / f"start_up.{suffix}"
        save(draw(folders.name or folders.well, start_up.depth, dataset), path, settings.figures.dpi)
    best = found.models[found.kept]
    path = folders.stage("start_ups") / "description.yaml"
    write_fitted(start_up.description, best.friction, best.equipment.pipe_shear_modulus, path)
    return list(_problems(dataset))


def dataset_of(found: Judged, log: MeasuredStartUp, seen: float) -> xr.Dataset:
    """The dataset of a judged start of rotation."""
    models = list(found.models.values())
    spans = [(0.0, seen), (seen, log.duration)]
    misfits = np.array([model.misfits(log, spans) for model in models])
    simulated = [model.simulated(log) for model in models]
    size = min(each.torque.size for each in simulated)
    gains = [found.gains[name] for name in found.models]
    values = np.array([model.values for model in models])
    bounds = np.array([BOUNDS[name] for name in models[0].fitted])
    near = np.abs(values[..., None] / bounds - 1) < _AT_BOUND
    return xr.Dataset(
        {
            "top_speed": ("time", log.top_speed[:size]),
            "torque": ("time", log.torque[:size]),
            "bit_slowest": ("time", log.bit_slowest[:size]),
            "bit_fastest": ("time", log.bit_fastest[:size]),
            "simulated_torque": (("model", "time"), [each.torque[:size] for each in simulated]),
            "simulated_bit_speed": (("model", "time"), [each.recorded_bit_speed()[:size] for each in simulated]),
            "span_from": ("span", [begin for begin, _ in spans]),
            "span_to": ("span", [end for _, end in spans]),
            "torque_rms": (("model", "span"), 1e3 * misfits[..., 0]),
            "bit_rms": (("model", "span"), RPM * misfits[..., 1]),
            "gain": ("model", [each.value for each in gains]),
            "gain_low": ("model", [each.low for each in gains]),
            "gain_high": ("model", [each.high for each in gains]),
            "kept": ("model", [name == found.kept for name in found.models]),
            "value": (("model", "parameter"), values),
            "at_bound": (
                ("model", "parameter"),
                near.any(axis=-1) & np.array([[name != DESCRIBED] for name in found.models]),
            ),
        },
        {
            "time": np.arange(size) / RATE,
            "model": list(found.models),
            "span": list(_SPANS),
            "parameter": list(models[0].fitted),
        },
    )


def _problems(dataset: xr.Dataset) -> Iterator[Problem]:
    """What a reader of the results must know."""
    if not np.isfinite(dataset["bit_slowest"].values).any():
        what = "the speed of the bit is not measured: models are fitted to and judged by the torque alone"
        yield Problem(
            "bit_rpm_min_measured", what, "Give the downhole record's half-second extremes where there is one"
        )
    begin, end = (float(dataset[name][-1]) for name in ("span_from", "span_to"))
    if not bool(dataset["kept"].sel(model=FITTED)):
        value, low = (float(dataset[name].sel(model=FITTED)) for name in ("gain", "gain_low"))
        what = f"what was fitted predicts {begin:.1f} to {end:.1f} s no better than the description"
        remedy = "The description is kept; give a longer log, or fit less"
        yield Problem(f"{begin:.1f} to {end:.1f} s", f"{what} (gain {value:.3g}, lower end {low:.3g})", remedy)
    at_bound = dataset["at_bound"].sel(model=FITTED)
    for name in dataset["parameter"].values[at_bound.values]:
        low, high = BOUNDS[str(name)]
        what = f"the fitted value lies at the end of its bounds, {low:g} to {high:g}"
        yield Problem(str(name), what, "The log does not determine it: leave it out of what is fitted")

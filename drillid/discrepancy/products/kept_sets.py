"""What is stored of the examination of each set of a well, made anew or taken over from an earlier run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from drillid.arrays import Indices
from drillid.datasets.examined import EXAMINATIONS
from drillid.datasets.measured import WINDOW_COORDINATES
from drillid.datasets.reuse import Memo
from drillid.discrepancy.products.dataset import examination_dataset
from drillid.discrepancy.rules import LAW_SHARE
from drillid.discrepancy.sets import ExaminedSet, WellData, examine_set, shared_error_rate, window_sets
from drillid.discrepancy.verdicts.engine import decisions
from drillid.discrepancy.verdicts.verdict import Verdict

if TYPE_CHECKING:
    from drillid.discrepancy.base_rates import BaseRates
    from drillid.discrepancy.verdicts.examination import Examination

_OF_WELL = {*WINDOW_COORDINATES, "set", "window_set", "extension_set"}
"""Variables that say where a set lies in its well."""


@dataclass(frozen=True, eq=False)
class StoredSet:
    """One set of windows.

    rows : of its windows in the well
    examination : the dataset of this set alone, whose windows are its own
    """

    key: str
    rows: Indices
    verdicts: tuple[Verdict, ...]
    examination: xr.Dataset


def examine_well(
    data: WellData,
    error_rate: float,
    base_rates: BaseRates | None,
    memo: Memo,
    earlier: xr.Dataset | None,
    common_causes: bool,
) -> list[StoredSet]:
    """Examine every set of a well that has changed.

    Parameters
    ----------
    error_rate : probability that a well in which nothing is wrong gets a verdict other than none; the sets share it
    base_rates : of causes, before the data are looked at
    memo : of detections and verdicts
    earlier : examinations of an earlier run
    common_causes : whether to store the sets' statistics of causes that they may share with other wells
    """
    sets = window_sets(data.rig, data.windows, data.fits)
    share = shared_error_rate(error_rate, len(sets))
    earlier = None if earlier is None else earlier.load().drop_encoding()
    numbers = {} if earlier is None else {str(key): number for number, key in enumerate(earlier["key"].values)}
    contents = [data.windows[name].values.tolist() for name in ("window", "key")] + [data.fits["key"].values.tolist()]
    found = []
    for rows in sets:
        key = memo.key("set", [[content[row] for content in contents] for row in rows], error_rate)
        is_known = earlier is not None and key in numbers and key in memo.earlier
        if earlier is not None and is_known and _decides_alike(memo.earlier[key], share):
            content, examination = memo.earlier[key], _of_set(earlier, numbers[key])
            for name in content["detections"]:
                memo.take_over(name)
        else:
            known = set(memo.found)
            examined = examine_set(data, rows, share, base_rates, memo)
            alone = ExaminedSet(np.arange(rows.size), examined.examination)
            examination = examination_dataset([alone], data.at(rows), error_rate, common_causes)
            content = {"verdicts": [asdict(verdict) for verdict in examined.verdicts]}
            content["detections"] = sorted(memo.found.keys() - known)
            content |= _decided(examined.examination, share)
        memo.found[key] = content
        verdicts = tuple(Verdict(**verdict) for verdict in content["verdicts"])
        found.append(StoredSet(key, rows, verdicts, examination))
    return found


def _decided(examination: Examination, share: float) -> dict[str, Any]:
    """Decisions in a set's examination that its share of the error rate has made, and the p-values behind them."""
    misfit, detections = float(examination.p_value), [float(each.p_value) for each in examination.detections]
    of_law = float(examination.law_p_value)
    return {"p_values": [misfit, detections, of_law], "decisions": _decisions(misfit, detections, of_law, share)}


def _decides_alike(content: Mapping[str, Any], share: float) -> bool:
    """Whether another share of the error rate, as the well has more sets, leaves the examination as it is."""
    misfit, detections, of_law = content["p_values"]
    return bool(_decisions(misfit, detections, of_law, share) == content["decisions"])


def _decisions(misfit: float, detections: Sequence[float], of_law: float, share: float) -> list[bool]:
    """The result of `decisions`, and whether a law is looked for."""
    return [*decisions(misfit, detections, share), of_law < share * LAW_SHARE]


def _of_set(examination: xr.Dataset, number: int) -> xr.Dataset:
    """The part of a well's dataset that is of one set."""
    rows, extensions = (np.flatnonzero(examination[name].values == number) for name in ("window_set", "extension_set"))
    return examination.isel(set=[number], window=rows, extension=extensions)


def joined(sets: Sequence[StoredSet], data: WellData) -> xr.Dataset:
    """The dataset of a well; windows that are in no set have no values in it."""
    if not sets:
        return EXAMINATIONS.empty()
    variables: dict[str, tuple[tuple[str, ...], Any]] = {}
    for name, declared in EXAMINATIONS.variables.items():
        if name in _OF_WELL or name == "key":
            continue
        values = [stored.examination[name].values for stored in sets]
        values = [value.astype(object) for value in values] if declared.dtype == "str" else values
        own = {"set", "window", "extension"}.intersection(declared.dims)
        variables[name] = (declared.dims, _over_windows(sets, declared.dims, values, data) if own else values[0])
    variables["key"] = (("set",), np.array([stored.key for stored in sets], dtype=object))
    number = np.full(data.windows.sizes["window"], -1)
    for index, stored in enumerate(sets):
        number[stored.rows] = index
    extensions = [stored.examination.sizes["extension"] for stored in sets]
    variables["window_set"] = (("window",), number)
    variables["extension_set"] = (("extension",), np.repeat(np.arange(len(sets)), extensions))
    return xr.Dataset(variables).assign_coords(
        {name: data.mobility[name] for name in WINDOW_COORDINATES} | {"set": np.arange(len(sets))}
    )


def _over_windows(sets: Sequence[StoredSet], dims: tuple[str, ...], values: Sequence[Any], data: WellData) -> Any:
    """Values of all sets joined along the first dimension; values of windows are put in the rows of these windows."""
    if "window" not in dims:
        return np.concatenate(values)
    axis, windows = dims.index("window"), data.windows.sizes["window"]
    spread = []
    for stored, value in zip(sets, values, strict=True):
        shape = [*value.shape[:axis], windows, *value.shape[axis + 1 :]]
        missing: Any = False if value.dtype == bool else np.nan * (1 + 1j) if value.dtype == complex else np.nan
        whole = np.full(shape, missing, dtype=value.dtype)
        np.moveaxis(whole, axis, 0)[stored.rows] = np.moveaxis(value, axis, 0)
        spread.append(whole)
    if axis:
        return np.concatenate(spread)
    whole = spread[0]
    for stored, other in zip(sets[1:], spread[1:], strict=True):
        whole[stored.rows] = other[stored.rows]
    return whole

"""What the figures of part of a well draw, so that figures without changes are kept as they are.

Figures that are not listed here draw all windows, and change with every new one.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr

from drillid.figures.data import WellResults, shown_set, shown_sets, successive_windows

_MODELS = ["accepted", "command_mobility_fitted", "bit_mobility_stiff", "bit_mobility_controlled"]
"""Variables of the depth dataset that show the model of a single window."""


def drawn_content(results: WellResults, name: str) -> list[Any] | None:
    """Everything that a figure draws, in a form that JSON can hold; None where it draws all of the well."""
    if name not in _CONTENTS:
        return None
    return [results.name, *results.band, *_CONTENTS[name](results)]


def _middle_window(results: WellResults) -> list[Any]:
    row = results.middle
    return [_hash(results.spectra.isel(window=row)), _hash(_models(results, [row]))]


def _models(results: WellResults, rows: list[int]) -> xr.Dataset:
    """Models of the windows, without their joint fit, which changes with every new window."""
    return results.depth[_MODELS].isel(depth=rows)


def _successive_windows(results: WellResults) -> list[Any]:
    shown = successive_windows(results)
    datasets = [results.mobility.isel(window=shown.rows), _models(results, shown.rows)]
    if shown.stack is not None:
        datasets += [results.stacks.isel(stack=shown.stack), results.stack_fits.isel(stack=shown.stack)]
    return [shown.stack is None, *map(_hash, datasets)]


def _one_set(results: WellResults) -> list[Any]:
    number = shown_set(results.examination)
    return [] if number is None else _of_sets(results, [number])


def _several_sets(results: WellResults) -> list[Any]:
    return _of_sets(results, shown_sets(results.examination))


def _of_sets(results: WellResults, numbers: Sequence[int]) -> list[Any]:
    """Sets with their windows, and the verdicts that their titles state."""
    examination = results.examination.drop_vars(["set", "window_set", "extension_set"])
    content: list[Any] = []
    for number in numbers:
        rows = np.flatnonzero(results.examination["window_set"].values == number)
        extensions = np.flatnonzero(results.examination["extension_set"].values == number)
        part = examination.isel(set=number, window=rows, extension=extensions)
        begin, end = (float(part[name]) for name in ("from_m", "to_m"))
        table = results.verdicts
        titled = table[(table["from_m"] <= end) & (table["to_m"] >= begin)]
        windows = (results.windows.isel(window=rows), results.mobility.isel(window=rows))
        content += [_hash(part), *map(_hash, windows), titled.to_csv()]
    return content


_CONTENTS: dict[str, Callable[[WellResults], list[Any]]] = {
    "spectrograms": _middle_window,
    "command_mobility_measured": _successive_windows,
    "command_mobility_fitted": _successive_windows,
    "evidence": _several_sets,
    "distinguishability": _one_set,
    "held_out": _one_set,
    "reflectogram": _one_set,
}


def _hash(dataset: xr.Dataset) -> str:
    """Hash of the names, shapes and values of all variables."""
    found = hashlib.sha256()
    for name, variable in sorted(dataset.variables.items(), key=lambda item: str(item[0])):
        values = variable.values
        found.update(f"{name} {variable.dims} {values.shape} {values.dtype}".encode())
        found.update(repr(values.tolist()).encode() if values.dtype == object else values.tobytes())
    return found.hexdigest()

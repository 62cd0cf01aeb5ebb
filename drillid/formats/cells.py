"""Cells of a column as floats."""

from __future__ import annotations

from typing import Any

import numpy as np

from drillid.arrays import Floats, Integers
from drillid.errors import LogError
from drillid.formats.description import Note
from drillid.formats.places import Places, shortened

NULL_VALUES = (-999.25, -9999.0, -9999.25)
"""Numbers that drilling recorders write for missing values."""

_MOST_WORDS = 5
"""Largest number of different words among numbers that are taken as missing values."""


def numbers(places: Places, name: str, column: Any, null_values: tuple[float, ...] = ()) -> tuple[Floats, list[Note]]:
    """Cells as floats, shape (row,), the recorders' null values and `null_values` as NaN; and notes on missing values.

    Raises
    ------
    LogError
        If a cell is not a number; the message names file, column and row.
    """
    import pandas as pd
    import pyarrow as pa

    if pa.types.is_temporal(column.type):
        raise LogError(places.column(name), "holds times, not numbers", "Map another column in the rig description")
    notes = list[Note]()
    if column.type == pa.float64():
        values = np.require(column.to_numpy(), dtype=np.float64, requirements=["W"])
    else:
        cells = column.to_pandas()
        found = pd.to_numeric(cells, errors="coerce")
        wrong = np.flatnonzero(found.isna() & cells.notna() & (cells.astype(str).str.strip() != ""))
        words = _words(cells, wrong)
        if words:
            told = ", ".join(f"'{shortened(word)}' ({count})" for word, count in words.items())
            what = f"the cells {told} of column '{name}' are taken as missing values"
            notes.append((what, "Correct them if they stand for values"))
        elif wrong.size:
            row = int(wrong[0])
            raise LogError(
                places.cell(name, row),
                f"'{shortened(cells.iloc[row])}' is not a number",
                f"Correct the cell{places.in_line(row)}, or leave it empty if there is no value",
            )
        values = found.to_numpy(dtype=np.float64, copy=True)
    stated = {*NULL_VALUES, *null_values, np.inf, -np.inf}
    for null in stated | {float(np.float32(each)) for each in stated}:
        values[values == null] = np.nan
    return values, notes


def _words(cells: Any, wrong: Integers) -> dict[str, int]:
    """Words among numbers that a historian writes for missing values, such as 'No Data', with their counts.

    They are few and without digits, each is repeated, and most cells are numbers; otherwise there are none.
    """
    found = cells.iloc[wrong].astype(str).str.strip().value_counts()
    known = int(cells.notna().sum())
    repeated = len(found) <= _MOST_WORDS and all(count > 1 for count in found)
    without_digits = not any(character.isdigit() for word in found.index for character in word)
    return dict(found.items()) if repeated and without_digits and 2 * wrong.size < known else {}

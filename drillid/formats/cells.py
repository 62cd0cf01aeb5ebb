"""Cells of a column as floats."""

from __future__ import annotations

from typing import Any

import numpy as np

from drillid.arrays import Floats
from drillid.errors import LogError
from drillid.formats.places import Places, shortened

NULL_VALUES = (-999.25, -9999.0, -9999.25)
"""Numbers that drilling recorders write for missing values."""


def numbers(places: Places, name: str, column: Any, null_values: tuple[float, ...] = ()) -> Floats:
    """Cells as floats, the recorders' null values and `null_values` as NaN, shape (row,).

    Raises
    ------
    LogError
        If a cell is not a number; the message names file, column and row.
    """
    import pandas as pd
    import pyarrow as pa

    if pa.types.is_temporal(column.type):
        raise LogError(places.column(name), "holds times, not numbers", "Map another column in the rig description")
    if column.type == pa.float64():
        values = np.require(column.to_numpy(), dtype=np.float64, requirements=["W"])
    else:
        cells = column.to_pandas()
        found = pd.to_numeric(cells, errors="coerce")
        wrong = np.flatnonzero(found.isna() & cells.notna() & (cells.astype(str).str.strip() != ""))
        if wrong.size:
            row = int(wrong[0])
            raise LogError(
                places.cell(name, row),
                f"'{shortened(cells.iloc[row])}' is not a number",
                f"Correct the cell{places.in_line(row)}, or leave it empty where there is no value",
            )
        values = found.to_numpy(dtype=np.float64, copy=True)
    for null in (*NULL_VALUES, *null_values, np.inf, -np.inf):
        values[values == null] = np.nan
    return values

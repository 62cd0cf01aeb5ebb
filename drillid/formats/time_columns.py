"""Arrow columns of times: what they hold, and times of day with their leading zeros."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from drillid.arrays import Booleans, Integers

if TYPE_CHECKING:
    import pandas as pd

Stamps = NDArray[np.datetime64]
_OFFSET = r"[T ].*(?:Z|[+-]\d\d(?::?\d\d)?)$"


def is_number(kind: Any) -> bool:
    """Whether an Arrow type holds numbers."""
    import pyarrow as pa

    return bool(pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind))


def zoned_stamps(column: Any) -> Stamps | None:
    """UTC stamps, ns, of a column whose stamps all have a zone, in a fraction of the memory; None for any other."""
    import pyarrow as pa

    zoned_text = pa.types.is_string(column.type) and str(column[0]).endswith("Z")
    if column.null_count or not (zoned_text or (pa.types.is_timestamp(column.type) and column.type.tz)):
        return None
    try:
        whole = column.cast(pa.timestamp("ns", "UTC")).cast(pa.int64())
    except pa.ArrowInvalid:
        return None
    return np.asarray(whole.to_numpy()).view("datetime64[ns]")


def have_offsets(cells: pd.Series[Any]) -> Booleans:
    """Whether each stamp has a Z, or an offset such as +01:00 or +01, behind its time of day, shape (row,)."""
    return np.asarray(cells.astype(str).str.contains(_OFFSET, regex=True), dtype=bool)


def nanoseconds(times: pd.Series[Any]) -> Integers:
    """Ns since 1970, in UTC where the times have a zone."""
    bare = times.dt.tz_convert("UTC").dt.tz_localize(None) if times.dt.tz is not None else times
    return np.asarray(bare.to_numpy(), dtype="datetime64[ns]").astype(np.int64)


def padded(text: Any) -> Any:
    """Times of day such as 60001 with their leading zeros, as 060001."""
    import pyarrow.compute as pc

    whole = pc.replace_substring_regex(text, r"[.,].*$", "")
    rest = pc.replace_substring_regex(text, r"^\d*", "")
    return pc.binary_join_element_wise(pc.utf8_lpad(whole, 6, "0"), rest, "")


def padded_clock(column: Any) -> Any:
    """Numbers such as 60001.5 as times of day, 060001.500000."""
    import pyarrow as pa
    import pyarrow.compute as pc

    numbers = column.cast(pa.float64()).to_numpy()
    whole = np.floor(numbers)
    micro = np.rint((numbers - whole) * 1e6).astype(np.int64)
    digits = pc.utf8_lpad(pc.cast(pa.array(whole.astype(np.int64)), pa.string()), 6, "0")
    return pc.binary_join_element_wise(digits, pc.utf8_lpad(pc.cast(pa.array(micro), pa.string()), 6, "0"), ".")

"""Units that a file states once for all columns of a table."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from drillid.formats.arrow_tables import as_text
from drillid.formats.description import Note
from drillid.formats.mnemonics import is_no_unit, split_unit
from drillid.formats.places import shortened
from drillid.formats.since import start_of


def units_of(stated: Any, columns: Sequence[str]) -> tuple[dict[str, str], tuple[Note, ...]]:
    """Units by the names of the columns, those in the names themselves where none are stated, and notes.

    Parameters
    ----------
    stated : one unit for each column in their order, or by their names, as such or as text in JSON or with commas;
        None where the file states none
    """
    in_names = {name: unit for name in columns if (unit := split_unit(name)[1])}
    if stated is None:
        return in_names, ()
    found = _by_column(stated, columns)
    if found is None:
        return in_names, () if _is_start(stated) else (_unread(stated, columns),)
    return in_names | {name: unit for name, unit in found.items() if not is_no_unit(unit)}, ()


def _by_column(stated: Any, columns: Sequence[str]) -> dict[str, str] | None:
    """Units by column; None where it is not clear which unit is whose."""
    content = _parsed(stated)
    if isinstance(content, Mapping):
        own = {str(name): unit for name, unit in content.items() if isinstance(unit, str)}
        bare = {split_unit(name)[0]: name for name in columns}
        return {bare.get(name, name): unit for name, unit in own.items() if name in columns or name in bare} or None
    units = [str(unit).strip() for unit in as_text(np.ravel(np.asarray(content)).tolist())]
    return dict(zip(columns, units, strict=True)) if len(units) == len(columns) else None


def _parsed(stated: Any) -> Any:
    """Text as the list or the mapping that it represents."""
    if not isinstance(stated, str | bytes):
        return stated
    text = str(as_text([stated])[0])
    try:
        return json.loads(text)
    except ValueError:
        return re.split(r"[,;\t|]", text)


def _is_start(stated: Any) -> bool:
    """Whether it is not a list of units but states since when times count."""
    return isinstance(stated, str | bytes) and start_of(str(as_text([stated])[0])) is not None


def _unread(stated: Any, columns: Sequence[str]) -> Note:
    what = f"its units, '{shortened(stated)}', are not one for each of its {len(columns)} columns and are not read"
    return what, "State the units with the channels in the rig description"

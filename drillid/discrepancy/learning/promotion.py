"""A learnt extension as a module of the catalogue: its class is generated, and a person reads and names it.

The module has the form of those in drillid/discrepancy/catalogue. Its cause has one size, the share of what was learnt;
places, frequencies, losses and rates stay as they were. Added to the modules in the catalogue's `__init__.py`, it is
taken up by the screen, the search and the suites over all causes.
"""

from __future__ import annotations

import keyword
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from drillid.arrays import Floats
from drillid.discrepancy.catalogue import CATALOGUE, SYMPTOMS
from drillid.discrepancy.inference.coordinates import Extension
from drillid.discrepancy.learning.elements import TERMS
from drillid.discrepancy.verdicts.verdict import NONE, UNKNOWN
from drillid.errors import SettingsError, writing

FIXED = ("mount_frequency", "mount_loss", "drag_rate")
"""Terms that do not grow with the cause's size."""
_FAMILIES = {"drive": "drive", "control": "control", "record": "sensor", "top": "top", "bit": "bit"}
_TEMPLATE = '''"""{sentence}: learnt, and to be read and named before it is used.

From {source}.
"""

from typing import Any

from drillid.discrepancy.catalogue.cause import Cause, OperatingPoint, Size, WindowModel

_TERMS = (
{terms}
)
"""Name, shape and size of each term as it was learnt, and whether it grows with the cause."""


class {title}(Cause):
    """{sentence}, as it was learnt; the size is the share of it."""

    name, family, port = "{name}", "{family}", "{port}"
    meaning = "{meaning}"
    separated_by = "the same measurement in other wells"
    action = "Look at what stands there."
    size = Size("share of what was learnt", "1", 1.0, 0.0, 5.0)

    def extend(
        self, window_model: WindowModel, size: Any, shape: float, operating_point: OperatingPoint
    ) -> WindowModel:
        """All terms, those that grow in proportion to the size."""
        # late, as the terms are causes and stand on the catalogue
        from drillid.discrepancy.learning.elements import TERMS

        for term, place, value, grows in _TERMS:
            own = value * size if grows else value
            window_model = TERMS[term].extend(window_model, own, place, operating_point)
        return window_model


CAUSES = ({title},)
'''


def module_source(name: str, extensions: Sequence[Extension], sizes: Floats, source: str) -> str:
    """Source of a module with the class of a cause.

    Parameters
    ----------
    name : identifier of the cause, in lower case with underscores
    extensions, sizes : terms of a learnt extension
    source : where it was learnt, in words

    Raises
    ------
    SettingsError
        If the name is no identifier or that of another verdict, or nothing was learnt.
    """
    title = "".join(word.capitalize() for word in name.split("_"))
    if name != name.lower() or not all(each.isidentifier() and not keyword.iskeyword(each) for each in (name, title)):
        raise SettingsError("promotion", f"'{name}' cannot name a cause", "Give lower case words joined by underscores")
    if name in (NONE, UNKNOWN, *CATALOGUE, *SYMPTOMS):
        raise SettingsError("promotion", f"'{name}' is a verdict already", "Give it a name of its own")
    learnt = [(each, size) for each, size in zip(extensions, sizes.tolist(), strict=True) if each.cause.name in TERMS]
    if not learnt:
        raise SettingsError(
            "promotion",
            f"{source} has no learnt extension of the responses",
            "Choose a set whose evidence tells of one; a law that is not linear needs a class of its own",
        )
    terms = [
        f'    ("{each.cause.name}", {each.shape!r}, {size:.6g}, {each.cause.name not in FIXED}),'
        for each, size in learnt
    ]
    cause = learnt[0][0].cause
    return _TEMPLATE.format(
        name=name,
        title=title,
        meaning=cause.meaning,
        sentence=cause.meaning[0].upper() + cause.meaning[1:],
        family=_FAMILIES.get(cause.port, "string"),
        port=_FAMILIES.get(cause.port, "string"),
        source=source,
        terms="\n".join(terms),
    )


def read_examination(path: Path) -> xr.Dataset:
    """The examination dataset at a path that a user gives.

    Raises
    ------
    SettingsError
        If there is no such dataset, or it is another one.
    """
    remedy = "Give the examination.zarr of a well"
    try:
        examination: xr.Dataset = xr.open_zarr(path, consolidated=False)
    except (OSError, ValueError) as error:
        raise SettingsError(str(path), "there is no such dataset", remedy) from error
    if "extension_set" not in examination:
        raise SettingsError(str(path), "it is no examination of a well", remedy)
    return examination


def write_module(examination: xr.Dataset, number: int, name: str, source: str, path: Path) -> None:
    """Write the module of what was learnt in one set of an examination dataset.

    Raises
    ------
    SettingsError
        As `module_source`, and if the file cannot be written.
    """
    rows = np.flatnonzero(examination["extension_set"].values == number)
    of_set = examination.isel(extension=rows)
    pairs = zip(of_set["extension_cause"].values, of_set["extension_shape"].values, strict=True)
    known = [TERMS.get(str(cause)) for cause in of_set["extension_cause"].values]
    extensions = [
        Extension(term, float(shape)) for term, (_, shape) in zip(known, pairs, strict=True) if term is not None
    ]
    sizes = of_set["extension_size"].values[[term is not None for term in known]]
    text = module_source(name, extensions, np.asarray(sizes, dtype=float), f"{source}, set {number}")
    with writing(path, "--output"):
        path.write_text(text)

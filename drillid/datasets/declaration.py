"""How a dataset is declared: variables with dimensions, dtype, unit and meaning; conforming a dataset to it."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from drillid.errors import DatasetError

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Variable:
    """Declaration of one variable of a dataset."""

    dims: tuple[str, ...]
    dtype: str
    units: str
    long_name: str
    flags: type[enum.IntEnum] | type[enum.IntFlag] | None = None

    def attributes(self) -> dict[str, Any]:
        """CF attributes: units, long_name and, for coded values, flag meanings."""
        attributes: dict[str, Any] = {"long_name": self.long_name}
        if self.units:
            attributes["units"] = self.units
        if self.flags is not None:
            kind = "flag_masks" if issubclass(self.flags, enum.IntFlag) else "flag_values"
            attributes[kind] = [int(member) for member in self.flags]
            attributes["flag_meanings"] = " ".join(str(member.name).lower() for member in self.flags)
        return attributes


@dataclass(frozen=True)
class DatasetSchema:
    """Declaration of one dataset; variables named like a dimension are coordinates."""

    title: str
    variables: dict[str, Variable]
    coordinates: tuple[str, ...] = field(default=())

    def conform(self, dataset: xr.Dataset, **attributes: Any) -> xr.Dataset:
        """Cast to the declared dtypes, attach the declared attributes, check the rest.

        Raises
        ------
        DatasetError
            If a variable is missing, undeclared or has dimensions other than declared, or values that its declared type
            cannot hold, such as NaN as a whole number.
        """
        missing = self.variables.keys() - dataset.variables.keys()
        undeclared = dataset.variables.keys() - self.variables.keys()
        if missing or undeclared:
            raise DatasetError(
                self.title,
                f"variables missing: {sorted(missing)}, undeclared: {sorted(map(str, undeclared))}",
                "Make the dataset and its schema in drillid/datasets agree",
            )
        import xarray as xr

        # one construction at the end, as each assignment to a dataset aligns all of its variables
        columns: dict[str, Any] = {}
        for name, declared in self.variables.items():
            variable = dataset.variables[name]
            if variable.dims != declared.dims:
                raise DatasetError(
                    f"{self.title}, variable {name}",
                    f"dimensions are {variable.dims}, declared are {declared.dims}",
                    "Make the dataset and its schema in drillid/datasets agree",
                )
            kept = {} if declared.dtype.startswith("datetime") else declared.attributes()
            kept = kept or {"long_name": declared.long_name}
            columns[name] = (declared.dims, self._cast(name, variable.values), kept)
        along = {name for name, declared in self.variables.items() if (name,) == declared.dims}
        chosen = along.union(self.coordinates, dataset.coords)
        coordinates = {name: columns.pop(name) for name in self.variables if name in chosen}
        described = {"Conventions": "CF-1.11", "title": self.title, "source": "drillid", **attributes}
        return xr.Dataset(columns, coordinates, described)

    def _cast(self, name: str, values: Any) -> np.ndarray[Any, Any]:
        """Values of a variable in its declared dtype; text becomes objects, which zarr stores with variable length."""
        dtype, found = self.variables[name].dtype, np.asarray(values)
        if dtype == "str":
            # zarr's variable-length strings cannot be cast to fixed-length ones directly
            return found.astype(object).astype(str).astype(object)
        if found.dtype.kind != "f" or np.dtype(dtype).kind not in "iub":
            return found.astype(dtype)
        # NaN becomes any number
        with np.errstate(invalid="ignore"):
            cast = found.astype(dtype)
        lost = np.argwhere(cast != found)
        if lost.size:
            raise DatasetError(
                f"{self.title}, variable {name}",
                f"{found[tuple(lost[0])]} at {lost[0].tolist()} is no {dtype}, as which it is declared",
                "Fill in what is missing, or declare a floating type in drillid/datasets",
            )
        return cast

    def empty(self) -> xr.Dataset:
        """The dataset without any row."""
        import xarray as xr

        empty = {
            name: (declared.dims, np.empty((0,) * len(declared.dims), dtype=declared.dtype))
            for name, declared in self.variables.items()
        }
        return self.conform(xr.Dataset(empty))


def each(dims: tuple[str, ...], dtype: str = "float64", **variables: tuple[str, str]) -> dict[str, Variable]:
    """Variables that share dimensions and dtype, by name: unit and meaning."""
    return {name: Variable(dims, dtype, units, long_name) for name, (units, long_name) in variables.items()}

"""A dataset is made what its declaration says, or refused with what differs."""

import enum

import numpy as np
import pytest
import xarray as xr

from drillid.datasets.declaration import DatasetSchema, Variable
from drillid.errors import DatasetError


class Colour(enum.IntEnum):
    """One of several."""

    RED = 1
    BLUE = 2


class Marks(enum.IntFlag):
    """Any of several."""

    OLD = 1
    TORN = 4


SCHEMA = DatasetSchema(
    "Pages",
    {
        "page": Variable(("page",), "int64", "", "number"),
        "height": Variable(("page",), "float32", "m", "height of the page"),
        "colour": Variable(("page",), "int8", "", "colour", Colour),
        "marks": Variable(("page",), "uint8", "", "marks", Marks),
        "place": Variable(("page",), "str", "", "where it lies"),
    },
    coordinates=("place",),
)


def pages() -> xr.Dataset:
    """Two pages as a stage would make them."""
    columns = {
        "height": [0.2, 0.3],
        "colour": [Colour.RED, Colour.BLUE],
        "marks": [Marks.OLD | Marks.TORN, 0],
        "place": ["here", "there"],
    }
    return xr.Dataset({name: ("page", values) for name, values in columns.items()}, {"page": [1, 2]})


def test_types_and_attributes_are_those_declared() -> None:
    found = SCHEMA.conform(pages(), well="W1")
    assert {name: str(found[name].dtype) for name in ("page", "height", "colour", "marks")} == {
        "page": "int64",
        "height": "float32",
        "colour": "int8",
        "marks": "uint8",
    }
    assert found["height"].attrs == {"long_name": "height of the page", "units": "m"}
    assert set(found.coords) == {"page", "place"}
    assert (found.attrs["title"], found.attrs["well"]) == ("Pages", "W1")


def test_one_of_several_has_values_and_any_of_several_has_masks() -> None:
    found = SCHEMA.conform(pages())
    assert found["colour"].attrs["flag_values"] == [1, 2]
    assert found["colour"].attrs["flag_meanings"] == "red blue"
    assert found["marks"].attrs["flag_masks"] == [1, 4]
    assert not {"flag_masks", "units"} & found["colour"].attrs.keys()
    assert "flag_values" not in found["marks"].attrs


def test_what_is_missing_or_not_declared_is_named() -> None:
    with pytest.raises(DatasetError, match=r"missing: \['height'\], undeclared: \['width'\]"):
        SCHEMA.conform(pages().rename(height="width"))


def test_other_dimensions_are_refused() -> None:
    with pytest.raises(
        DatasetError, match=r"variable height.*dimensions are \('page', 'side'\), declared are \('page',\)"
    ):
        SCHEMA.conform(pages().assign(height=(("page", "side"), np.ones((2, 2)))))


@pytest.mark.parametrize("value", [np.nan, 1.5, 300.0])
def test_values_that_the_declared_type_cannot_hold_are_refused(value: float) -> None:
    assert SCHEMA.conform(pages().assign(colour=("page", [1.0, 2.0])))["colour"].dtype == "int8"
    with pytest.raises(DatasetError, match=rf"variable colour: {value} at \[1\] is no int8"):
        SCHEMA.conform(pages().assign(colour=("page", [1.0, value])))


def test_an_empty_dataset_has_all_variables_and_no_row() -> None:
    empty = SCHEMA.empty()
    assert empty.variables.keys() == SCHEMA.variables.keys()
    assert empty.sizes["page"] == 0

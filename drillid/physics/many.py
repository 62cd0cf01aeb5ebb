"""One description that stands for many windows, taken apart into those of single windows."""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar

import numpy as np

from drillid.errors import SettingsError

Part = TypeVar("Part")


def window_shape(part: Any) -> tuple[int, ...]:
    """Shape of the windows that a part's figures stand for; () where all figures are plain numbers.

    Raises
    ------
    SettingsError
        If a figure's last axis, that of frequency, is not of length 1.
    """
    shapes = [np.shape(figure) for figure in _figures(part) if np.ndim(figure) > 0]
    for shape in shapes:
        if shape[-1] != 1:
            raise SettingsError(
                "equipment", f"a figure has the shape {shape}", "Give an array of windows the shape (..., 1)"
            )
    return np.broadcast_shapes(*(shape[:-1] for shape in shapes))


def of_window(part: Part, index: tuple[int, ...], shape: tuple[int, ...]) -> Part:
    """The part of one window in plain numbers.

    Parameters
    ----------
    part : any dataclass of figures, laws and parts, or a tuple of them
    index, shape : the window's, of `window_shape`
    """

    def taken(value: Any) -> Any:
        if is_dataclass(value) and not isinstance(value, type):
            changed: Any = value
            return replace(changed, **{field.name: taken(getattr(value, field.name)) for field in fields(value)})
        if isinstance(value, tuple):
            return tuple(taken(one) for one in value)
        return np.broadcast_to(value, (*shape, 1))[index].item() if np.ndim(value) > 0 else value

    one: Part = taken(part)
    return one


def _figures(part: Any) -> Iterator[Any]:
    if is_dataclass(part) and not isinstance(part, type):
        for field in fields(part):
            yield from _figures(getattr(part, field.name))
    elif isinstance(part, tuple):
        for one in part:
            yield from _figures(one)
    elif part is not None:
        yield part

"""Exact derivatives of any composed model: forward-mode automatic differentiation on numpy arrays.

A `Dual` carries an array and its derivatives to P parameters through every ufunc that the physics
uses, by the chain rule (Griewank and Walther 2008, Evaluating Derivatives, chapter 3). As the physics
is written with ufuncs only, any parameter of the equipment, and s itself, may be a Dual. There is no step
size: the derivatives are as exact as the values.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache, reduce
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from numpy.typing import ArrayLike

from drillid.arrays import Array, Indices

Slope = Callable[..., Any]
"""Partial derivative of a ufunc with respect to one argument, a function of (result, *arguments)."""


def _one(*_: Any) -> float:
    return 1.0


_SLOPES: dict[np.ufunc, tuple[Slope, ...]] = {
    np.add: (_one, _one),
    np.subtract: (_one, lambda r, a, b: -1.0),
    np.multiply: (lambda r, a, b: b, lambda r, a, b: a),
    np.divide: (lambda r, a, b: 1 / b, lambda r, a, b: -r / b),
    np.power: (lambda r, a, b: b * a ** (b - 1), lambda r, a, b: r * np.log(a)),
    np.maximum: (lambda r, a, b: np.where(a >= b, 1.0, 0.0), lambda r, a, b: np.where(a >= b, 0.0, 1.0)),
    np.minimum: (lambda r, a, b: np.where(a <= b, 1.0, 0.0), lambda r, a, b: np.where(a <= b, 0.0, 1.0)),
    np.negative: (lambda r, a: -1.0,),
    np.positive: (_one,),
    np.square: (lambda r, a: 2 * a,),
    np.reciprocal: (lambda r, a: -r * r,),
    np.sqrt: (lambda r, a: 0.5 / r,),
    np.exp: (lambda r, a: r,),
    np.expm1: (lambda r, a: r + 1,),
    np.log: (lambda r, a: 1 / a,),
    np.sin: (lambda r, a: np.cos(a),),
    np.cos: (lambda r, a: -np.sin(a),),
    np.arctan: (lambda r, a: 1 / (1 + a * a),),
    np.sinh: (lambda r, a: np.cosh(a),),
    np.cosh: (lambda r, a: np.sinh(a),),
    np.tanh: (lambda r, a: 1 - r * r,),
}
_WITHOUT_SLOPE = frozenset(
    (np.less, np.less_equal, np.greater, np.greater_equal, np.equal, np.not_equal, np.isfinite, np.isnan, np.sign)
)
"""Ufuncs of the values alone."""


def _operator(ufunc: np.ufunc) -> Callable[..., Any]:
    """The method for an operator whose first argument is a Dual."""
    slope = _SLOPES[ufunc][0]

    def applied(self: "Dual", other: Any) -> "Dual":
        if isinstance(other, Dual):
            made: Dual = self.__array_ufunc__(ufunc, "__call__", self, other)
            return made
        result = np.asarray(ufunc(self.value, other))
        return self._chained(result, None if slope is _one else slope(result, self.value, other))

    return applied


def _reflected(ufunc: np.ufunc) -> Callable[..., Any]:
    """The method for an operator whose second argument alone is a Dual."""
    slope = _SLOPES[ufunc][1]

    def applied(self: "Dual", other: Any) -> "Dual":
        result = np.asarray(ufunc(other, self.value))
        return self._chained(result, None if slope is _one else slope(result, other, self.value))

    return applied


class Dual(NDArrayOperatorsMixin):
    """An array and its derivatives.

    Only derivatives to parameters already involved are carried: most parameters of a rig enter late.

    Parameters
    ----------
    value : shape (...)
    tangents : shape (P, ...), derivative to each parameter, broadcasts against `value`; or (K, ...) to some of them
    indices : (K,) of these parameters; by default all, or those that are not 0 in `tangents` of shape (P,)
    parameters : P, needed with `indices`
    """

    def __init__(
        self, value: ArrayLike, tangents: ArrayLike, indices: Indices | None = None, parameters: int = 0
    ) -> None:
        self.value: Array = np.asarray(value)
        rows = np.asarray(tangents)
        self.parameters = parameters if indices is not None else rows.shape[0]
        if indices is None:
            indices = rows.nonzero()[0] if rows.ndim == 1 else np.arange(rows.shape[0])
            rows = rows[indices] if rows.ndim == 1 else rows
        self.indices = indices
        self.tangents: Array = _aligned(rows, self.value.ndim)

    @classmethod
    def _made(cls, value: Array, tangents: Array, indices: Indices, parameters: int) -> "Dual":
        """A Dual from parts that already have the right shapes."""
        made = cls.__new__(cls)
        made.value, made.tangents, made.indices, made.parameters = value, tangents, indices, parameters
        return made

    @classmethod
    def of_parameter(cls, value: Array, slope: Array, place: int, parameters: int) -> "Dual":
        """A Dual that depends on one parameter alone, with a derivative of the value's shape."""
        return cls._made(value, slope[None], _index(place), parameters)

    def _chained(self, value: Array, slope: Any) -> "Dual":
        """A function of this one variable, with its derivative; that of None is one."""
        tangents = _aligned(self.tangents, value.ndim)
        return Dual._made(value, tangents if slope is None else slope * tangents, self.indices, self.parameters)

    def __repr__(self) -> str:
        return f"Dual({self.value!r}, {self.tangents!r}, {self.indices!r}, {self.parameters})"

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        """Apply a ufunc to the values, and the chain rule to the tangents; other ufuncs raise TypeError."""
        if method != "__call__" or kwargs:
            return NotImplemented
        values = [argument.value if isinstance(argument, Dual) else argument for argument in inputs]
        slopes = _SLOPES.get(ufunc)
        if slopes is None:
            return ufunc(*values) if ufunc in _WITHOUT_SLOPE else NotImplemented
        result, total = np.asarray(ufunc(*values)), None
        for argument, slope in zip(inputs, slopes, strict=True):
            if isinstance(argument, Dual):
                tangents = _aligned(argument.tangents, result.ndim)
                part = tangents if slope is _one else slope(result, *values) * tangents, argument.indices
                total = part if total is None else _summed(*total, *part)
        return Dual._made(result, *total, self.parameters) if total is not None else result

    # with a Dual as the first argument, numpy need not be asked whose operator applies
    __add__ = _operator(np.add)
    __sub__ = _operator(np.subtract)
    __mul__ = _operator(np.multiply)
    __truediv__ = _operator(np.divide)

    def __neg__(self) -> "Dual":
        return Dual._made(-self.value, -self.tangents, self.indices, self.parameters)

    __radd__ = _reflected(np.add)
    __rsub__ = _reflected(np.subtract)
    __rmul__ = _reflected(np.multiply)
    __rtruediv__ = _reflected(np.divide)

    def full_tangents(self) -> Array:
        """Derivatives to all parameters, in the shape (P, *value.shape)."""
        full = np.zeros((self.parameters, *self.value.shape), dtype=self.tangents.dtype)
        full[self.indices] = self.tangents
        return full


@lru_cache(maxsize=1000)
def _index(place: int) -> Indices:
    return np.array([place])


def _summed(tangents: Array, first: Indices, others: Array, second: Indices) -> tuple[Array, Indices]:
    """Sum of the tangents of two arguments, and the indices of its parameters."""
    if first is second:
        return tangents + others, first
    union = _union(first.tobytes(), second.tobytes())
    if union is None:
        return tangents + others, first
    indices, rows, further = union
    # worked out only if they differ, as either call takes as long as a sum of small arrays
    shape, kind = tangents.shape[1:], tangents.dtype
    if shape != others.shape[1:]:
        shape = np.broadcast_shapes(shape, others.shape[1:])
    if kind != others.dtype:
        kind = np.result_type(tangents, others)
    total = np.zeros((indices.size, *shape), dtype=kind)
    total[rows] = tangents
    total[further] += others
    return total, indices


Rows = Indices | slice


@lru_cache(maxsize=10_000)
def _union(first: bytes, second: bytes) -> tuple[Indices, Rows, Rows] | None:
    """Union of two sets of indices, and the places of each set within it; None where the sets are the same."""
    one, other = (np.frombuffer(each, dtype=np.intp) for each in (first, second))
    indices = np.union1d(one, other)
    if one.size == other.size == indices.size:
        return None
    return indices, _rows(np.searchsorted(indices, one)), _rows(np.searchsorted(indices, other))


def _rows(places: Indices) -> Rows:
    """Places as a slice if they are consecutive, which is much faster."""
    if places.size and places[-1] - places[0] == places.size - 1:
        return slice(int(places[0]), int(places[-1]) + 1)
    return places


def _aligned(tangents: Array, dimensions: int) -> Array:
    """Tangents with axes of length 1 after the first, to broadcast against values with this number of dimensions."""
    missing = dimensions + 1 - tangents.ndim
    return tangents.reshape(tangents.shape[0], *(1,) * missing, *tangents.shape[1:]) if missing > 0 else tangents


def primal(quantity: Any) -> Any:
    """The value without its derivatives."""
    return quantity.value if isinstance(quantity, Dual) else quantity


def vanishes(quantity: Any) -> bool:
    """Whether the value is zero everywhere."""
    return quantity == 0 if isinstance(quantity, float) else not np.any(primal(quantity))


def lifted(function: Callable[[Any], Any], slope: Callable[[Any], Any], argument: Any) -> Any:
    """Value of a function of one variable outside the table of ufuncs, with its derivative given as `slope`."""
    if not isinstance(argument, Dual):
        return function(argument)
    return argument._chained(np.asarray(function(argument.value)), slope(argument.value))


def linear(operator: Callable[[Array], Array], argument: Any) -> Any:
    """Image under a linear operator that acts on the last axis, such as a Fourier transform."""
    if not isinstance(argument, Dual):
        return operator(np.asarray(argument))
    tangents = np.broadcast_to(argument.tangents, (argument.indices.size, *argument.value.shape))
    return Dual(operator(argument.value), operator(tangents), argument.indices, argument.parameters)


def derivatives(function: Callable[..., Any], parameters: ArrayLike) -> tuple[Array, Array]:
    """Value of a function of P parameters and its derivative to each.

    Parameters
    ----------
    function : takes P arguments of shape (..., 1), returns an array of shape (..., frequency)
    parameters : shape (..., P)

    Returns
    -------
    value : shape (..., frequency)
    derivatives : shape (..., P, frequency)
    """
    columns = np.moveaxis(np.asarray(parameters)[..., None], -2, 0)
    directions = np.eye(columns.shape[0])
    result = function(*(Dual(column, direction) for column, direction in zip(columns, directions, strict=True)))
    if not isinstance(result, Dual):
        value = np.asarray(result)
        return value, np.zeros((*value.shape[:-1], columns.shape[0], value.shape[-1]))
    return result.value, np.moveaxis(result.full_tangents(), 0, -2)


def composed(value: Array, parts: Sequence[tuple[Array, Any]]) -> Any:
    """A function of several variables with its partial derivatives given, by the chain rule; the value itself where no
    variable is a Dual.

    Parameters
    ----------
    parts : partial derivative with respect to each variable, of the value's shape, and the variable
    """
    duals = [(slope, argument) for slope, argument in parts if isinstance(argument, Dual)]
    if not duals:
        return value
    each = [(slope * _aligned(argument.tangents, value.ndim), argument.indices) for slope, argument in duals]
    return Dual(value, *reduce(lambda total, part: _summed(*total, *part), each), duals[0][1].parameters)


def unstacked(stack: Any) -> list[Any]:
    """The entries along the first axis of an array, or of a Dual whose tangents have its value's shape."""
    if not isinstance(stack, Dual):
        return list(stack)
    entries = zip(stack.value, stack.tangents.swapaxes(0, 1), strict=True)
    return [Dual._made(value, tangents, stack.indices, stack.parameters) for value, tangents in entries]

"""Dual numbers against 40-digit arithmetic, and against the derivatives of the paper's model derived by hand."""

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest

from drillid.physics.dual_numbers import Dual, derivatives, lifted, linear, primal
from drillid.physics.eight_parameters import KnownEquipment, command_mobility_with_derivatives
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, TopDrive
from drillid.physics.responses import command_mobility, laplace
from drillid.physics.time_responses import bit_step_response

POINTS = (0.7, 1.9, 0.4 + 1.3j, 2.1 - 0.6j)
UFUNCS: dict[str, tuple[Callable[..., Any], Callable[..., Any]]] = {
    "add": (lambda x: x + 2 * x + 1.5, lambda x: 3 * x + 1.5),
    "subtract": (lambda x: 3.0 - x - x * x, lambda x: 3 - x - x**2),
    "multiply": (lambda x: (x * 3.0) * (2.0 * x), lambda x: 6 * x**2),
    "divide": (lambda x: x / (1.0 + x) + 2.0 / x, lambda x: x / (1 + x) + 2 / x),
    "power": (lambda x: x**3 + x ** (-0.5), lambda x: x**3 + x ** mpmath.mpf(-0.5)),
    "exponent": (lambda x: 1.7**x + x**x, lambda x: mpmath.mpf(1.7) ** x + x**x),
    "negative": (lambda x: -x + (+x) * x, lambda x: -x + x * x),
    "sqrt": (np.sqrt, mpmath.sqrt),
    "square": (np.square, lambda x: x**2),
    "reciprocal": (np.reciprocal, lambda x: 1 / x),
    "exp": (np.exp, mpmath.exp),
    "expm1": (np.expm1, mpmath.expm1),
    "log": (np.log, mpmath.log),
    "sin": (np.sin, mpmath.sin),
    "cos": (np.cos, mpmath.cos),
    "arctan": (np.arctan, mpmath.atan),
    "sinh": (np.sinh, mpmath.sinh),
    "cosh": (np.cosh, mpmath.cosh),
    "tanh": (np.tanh, mpmath.tanh),
}


@pytest.mark.parametrize("point", POINTS)
@pytest.mark.parametrize("name", UFUNCS)
def test_every_ufunc_has_its_exact_slope(name: str, point: complex) -> None:
    function, exact = UFUNCS[name]
    result = function(Dual(np.array([point]), np.ones((1, 1))))
    with mpmath.workdps(40):
        assert abs(complex(exact(mpmath.mpmathify(point))) - result.value[0]) <= 1e-14 * abs(result.value[0])
        slope = complex(mpmath.diff(exact, mpmath.mpmathify(point)))
    assert abs(slope - result.tangents[0, 0]) <= 1e-13 * abs(slope)


def test_larger_and_smaller_take_the_slope_of_the_one_they_choose() -> None:
    value, slopes = derivatives(lambda a, b: np.maximum(a, b) + 10 * np.minimum(a, b), [[1.0, 2.0], [5.0, 3.0]])
    np.testing.assert_array_equal(value[:, 0], [12.0, 35.0])
    np.testing.assert_array_equal(slopes[..., 0], [[10.0, 1.0], [1.0, 10.0]])


def test_a_ufunc_without_a_slope_is_refused() -> None:
    with pytest.raises(TypeError):
        np.floor(Dual(1.5, [1.0]))


def test_comparisons_look_at_values() -> None:
    assert bool(Dual(1.5, [1.0]) > 1.0)
    assert not bool(np.isnan(Dual(1.5, [np.nan])))


def test_shapes_broadcast_as_arrays_do() -> None:
    """Windows (3, 1), scalars and frequencies (4,), in any order."""
    frequency = np.arange(1.0, 5.0)
    parameters = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])
    value, slopes = derivatives(lambda a, b: 2.0 + a * frequency + frequency * b / a, parameters)
    a, b = parameters[:, :1], parameters[:, 1:]
    np.testing.assert_allclose(value, 2 + a * frequency + frequency * b / a, rtol=1e-15)
    np.testing.assert_allclose(slopes[:, 0], frequency * (1 - b / a**2), rtol=1e-15)
    np.testing.assert_allclose(slopes[:, 1], frequency / a, rtol=1e-15)


def test_a_function_that_ignores_its_parameters_has_no_slope() -> None:
    value, slopes = derivatives(lambda a, b: np.ones(5), [1.0, 2.0])
    assert value.shape == (5,)
    np.testing.assert_array_equal(slopes, np.zeros((2, 5)))


def test_linear_operators_and_lifted_functions() -> None:
    argument = Dual(np.array([1.0, 2.0]), np.array([[1.0], [0.5]]))
    image = linear(np.cumsum, argument)
    np.testing.assert_array_equal(image.value, [1.0, 3.0])
    np.testing.assert_array_equal(lifted(np.cbrt, lambda x: 1 / (3 * np.cbrt(x) ** 2), 8.0), 2.0)
    cube_root = lifted(np.cbrt, lambda x: 1 / (3 * np.cbrt(x) ** 2), Dual(8.0, [2.0]))
    assert primal(cube_root) == pytest.approx(2.0)
    assert cube_root.tangents[0] == pytest.approx(1 / 6)


@pytest.mark.parametrize("collars", [0.0, 90.0])
def test_composed_model_has_the_derivatives_that_were_derived_by_hand(collars: float) -> None:
    equipment = KnownEquipment(Controller(1500.0, 800.0, 0.05, 0.02), collars, 1.2e-4 if collars else 0.0)
    points = np.array(
        [
            [100.0, 3e8, 2700.0, 1.6e-5, 0.04, 1100.0, 20.0, 180.0],
            [1.0, 2e9, 8000.0, 6e-6, 0.1, 300.0, 2000.0, 160.0],
        ]
    )
    s = laplace(np.geomspace(0.05, 5, 40))

    def mobility(*parameters: Any) -> Any:
        kappa, delta, length, polar, delay, inertia_td, damping, inertia = parameters
        string = [Section(length, polar, kappa, delta)]
        if collars:
            string.append(Section(collars, equipment.collar_polar_moment, kappa, delta))
        bit = Bit(inertia - equipment.collar_inertia, damping)
        return command_mobility(
            DrillingSystem(TopDrive(inertia_td, delay, equipment.controller), tuple(string), bit), s
        )

    by_hand = command_mobility_with_derivatives(points, equipment, s)
    value, slopes = derivatives(mobility, points)
    np.testing.assert_allclose(value, by_hand[0], rtol=1e-12)
    scale = np.abs(by_hand[1]).max(axis=-1, keepdims=True)
    np.testing.assert_array_less(np.abs(slopes - by_hand[1]), 1e-11 * np.abs(by_hand[1]) + 1e-13 * scale)


def test_step_responses_carry_derivatives_too() -> None:
    """Against central differences, good to about 1e-7."""
    point = np.array([1500.0, 1.6e-5, 60.0])

    def step(length: Any, polar: Any, inertia: Any) -> Any:
        pipe = Section(length, polar, 100.0, 3e8)
        system = DrillingSystem(TopDrive(1100.0, 0.04, Controller(1500.0, 800.0)), (pipe,), Bit(inertia, 20.0))
        return bit_step_response(system, 6.0, 0.05)[1]

    value, slopes = derivatives(step, point)
    np.testing.assert_array_equal(value, step(*point))
    for row, size in enumerate(point):
        offset = np.zeros(3)
        offset[row] = 3e-5 * size
        difference = (step(*(point + offset)) - step(*(point - offset))) / (2 * offset[row])
        np.testing.assert_allclose(slopes[row], difference, atol=1e-6 * np.abs(difference).max())

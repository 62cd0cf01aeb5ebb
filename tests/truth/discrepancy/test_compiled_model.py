"""The compiled responses are those of the composed model, with all derivatives, whatever the cause."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drillid.arrays import Complex
from drillid.discrepancy.catalogue import CATALOGUE, Cause, OperatingPoint, WindowModel
from drillid.discrepancy.inference.unknown import PORTS
from drillid.discrepancy.learning.elements import ELEMENTS, TERMS, Element
from drillid.discrepancy.learning.process import process_at
from drillid.discrepancy.learning.search import placed
from drillid.physics.compiled_system import compiled_system, data_of
from drillid.physics.damping import DampingLaw, HystereticLoss, Steel, StokesLayerDrag
from drillid.physics.dual_numbers import Dual
from drillid.physics.equipment import (
    Bit,
    Controller,
    DrillingSystem,
    ImpedanceMatching,
    Motor,
    RegenerativeCutting,
    Section,
    Shaping,
    StribeckCutting,
    TopDrive,
    polar_moment,
)
from drillid.physics.gaussian_process import COUNT
from drillid.physics.responses import laplace
from drillid.physics.sensor import Recording

WINDOWS, SHARED = 2, 12
# two blocks of the compiled code, the second one not full
FREQUENCY = np.geomspace(0.05, 8.0, 130)
S = laplace(FREQUENCY)
ROWS = np.arange(5, 125, 3)
OPERATING_POINT = OperatingPoint(np.array([[10.0], [14.0]]), np.full((2, 1), 5e3), np.array([[2800.0], [2830.0]]))
CASES = [(cause, shape) for cause in CATALOGUE.values() for shape in cause.shapes]


def coordinates(count: int) -> list[Dual]:
    """Relative changes of quantities, of which the first two differ from window to window."""
    directions = np.eye(count)
    return [
        Dual(np.array([[0.01], [-0.02]]) if place < 2 else np.full((1, 1), 0.01 * place), direction)
        for place, direction in enumerate(directions)
    ]


def window_model(c: list[Dual]) -> WindowModel:
    """A model whose every quantity depends on a coordinate."""
    pipe = Section(
        OPERATING_POINT.length * (1 + c[2]),
        polar_moment(0.1397, 0.1214) * (1 + c[3]),
        200 * (1 + c[0]),
        2e8 * (1 + c[1]),
    )
    collars = replace(pipe, length=100.0, polar_moment=polar_moment(0.1651, 0.0714))
    controller = Controller(1500 * (1 + c[4]), 800 * (1 + c[5]), 0.01 * (1 + c[6]), 0.02, 200.0, 0.05)
    late = 3e-6 * (1 + c[8])
    held = {"hold_skewness": late, "hold_higher": (1e-7, -2e-9)}
    top_drive = TopDrive(1100 * (1 + c[7]), 0.04 * (1 + c[8]), controller, 0.01 * (1 + c[8]), **held)
    system = DrillingSystem(top_drive, (pipe, collars), Bit(60 * (1 + c[9]), 400 * (1 + c[10])))
    clock = {"clock_jitter": 0.002 * (1 + c[11]), "hold_skewness": -2e-6 * (1 + c[11]), "hold_higher": (-1e-7, 1e-9)}
    recording = Recording(clock_offset=0.01 * (1 + c[11]), **clock)
    return WindowModel(system, recording)


@cache
def measured() -> tuple[Complex, Complex]:
    draws = np.random.default_rng(0).standard_normal((4, WINDOWS, FREQUENCY.size))
    return 1e-4 * (draws[0] + 1j * draws[1]), (1e3 * (draws[2] + 1j * draws[3]))[:, ROWS]


def both_ways(model: WindowModel, count: int) -> list[tuple[Complex, Complex]]:
    """Whitened residuals and derivatives by the composed and by the compiled model."""
    mobility, control = measured()
    weight, control_weight = np.full(mobility.shape, 1e5), np.full(control.shape, 1e-2)
    weight[1, ::7], control_weight[0, ::5] = 0.0, 0.0
    residuals, slopes = [], []
    responses = (model.mobility(S), mobility, weight), (model.control(S[ROWS]), control, control_weight)
    for response, data, of_data in responses:
        residuals.append((data - getattr(response, "value", response)) * of_data)
        tangents = response.full_tangents() if isinstance(response, Dual) else np.zeros((count, 1, 1))
        slopes.append(np.broadcast_to(np.moveaxis(tangents * of_data, 0, 1), (WINDOWS, count, data.shape[1])))
    held = model.held()
    compiled = compiled_system(held.system, held.recording, held.course, held.folding)
    assert compiled is not None
    data = data_of(FREQUENCY, mobility, weight, ROWS, control, control_weight)
    composed = np.concatenate(residuals, axis=-1), np.concatenate(slopes, axis=-1)
    return [composed, compiled.whitened(data, count)]


def assert_alike(model: WindowModel, count: int) -> None:
    composed, compiled = both_ways(model, count)
    np.testing.assert_allclose(compiled[0], composed[0], rtol=1e-10, atol=1e-11 * np.abs(composed[0]).max())
    for quantity in range(count):
        one, other = compiled[1][:, quantity], composed[1][:, quantity]
        np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-10 * np.abs(other).max())


@pytest.mark.parametrize(("cause", "shape"), CASES, ids=lambda entry: getattr(entry, "name", str(entry)))
def test_every_cause_is_computed_exactly(cause: Cause, shape: float) -> None:
    *c, _ = coordinates(SHARED + 1)
    size = Dual(np.array([[cause.size.typical]]), np.eye(SHARED + 1)[SHARED])
    assert_alike(cause.extend(window_model(c), size, shape, OPERATING_POINT), SHARED + 1)


def test_parts_that_no_cause_brings_are_computed_exactly() -> None:
    c = coordinates(SHARED)
    base = window_model(c)
    motor = Motor(2e4 * (1 + c[0]), 50 * (1 + c[1]), 20 * (1 + c[2]))
    laws = StribeckCutting(3e3, 2e3, 2.0, OPERATING_POINT.speed * (1 + c[3]), 2.0), RegenerativeCutting(3e3, 12.0, 5)
    bit = replace(base.system.bit, cutting=laws)
    shaping, renewal = Shaping(0.02 * (1 + c[7]), pole_1=0.01), 0.03 * (1 + c[6])
    changed = {"filter_frequency": 9 * (1 + c[5]), "filter_order": 3, "shaping": shaping, "renewal": renewal}
    recording = replace(base.recording, scale=-1.1 * (1 + c[4]), **changed)
    assert_alike(WindowModel(replace(base.system, motor=motor, bit=bit), recording), SHARED)


@pytest.mark.parametrize("filtered", [False, True])
@pytest.mark.parametrize("parts", [1, 3])
def test_held_control_is_computed_alike(filtered: bool, parts: int) -> None:
    *c, interval = coordinates(SHARED + 1)
    model = window_model(c)
    top_drive = replace(
        model.system.top_drive, hold_variance=1e-6 * (1 + c[8]), hold_skewness=0.0, hold_higher=(0.0, 0.0)
    )
    recording = Recording(clock_offset=0.01 * (1 + c[11]), hold_variance=1e-6 * (1 + c[11]))
    if filtered:
        top_drive = replace(top_drive, lag=0.004 * (1 + c[8]))
        recording = replace(recording, filter_frequency=9 * (1 + c[5]), filter_order=3)
    else:
        controller = replace(top_drive.controller, speed_filter=0.0)
        top_drive = replace(top_drive, delay_jitter=0.0, controller=controller)
    system = replace(model.system, top_drive=top_drive)
    held = WindowModel(system, recording, control_interval=0.03 * (1 + interval))
    assert_alike(held.with_course([20.0 * part * (1 + c[10]) for part in range(parts)]), SHARED + 1)


def test_without_coordinates_there_are_residuals_alone() -> None:
    plain: list[Dual] = [0.01] * SHARED  # type: ignore[list-item]
    (residual, _), (compiled, slopes) = both_ways(window_model(plain), 0)
    np.testing.assert_allclose(compiled, residual, rtol=1e-10, atol=1e-11 * np.abs(residual).max())
    assert slopes.shape == (WINDOWS, 0, FREQUENCY.size + ROWS.size)


def test_products_are_those_of_the_rows_and_of_the_windows_asked_for() -> None:
    model = window_model(coordinates(SHARED))
    mobility, control = measured()
    weights = np.full(mobility.shape, 1e5), np.full(control.shape, 1e-2)
    data = data_of(FREQUENCY, mobility, weights[0], ROWS, control, weights[1])
    compiled = compiled_system(model.system, model.recording, model.course)
    assert compiled is not None
    residual, jacobian = compiled.whitened(data, SHARED)
    rows = np.concatenate([jacobian, residual[:, None]], axis=1)
    of_mobilities, of_all = compiled.products(data, SHARED, np.array([1]))
    for sums, part in ((of_all, rows[1]), (of_mobilities, rows[1, :, : FREQUENCY.size])):
        scale = np.sqrt(np.sum(np.abs(part) ** 2, axis=1))
        expected = (part @ np.conj(part.T)).real / np.outer(scale, scale)
        np.testing.assert_allclose(sums[1] / np.outer(scale, scale), expected, rtol=0, atol=1e-12)
        assert not sums[0].any()


@pytest.mark.parametrize("element", ELEMENTS, ids=lambda element: element.name)
def test_every_element_that_is_learnt_is_computed_exactly(element: Element) -> None:
    count = SHARED + len(element.terms)
    c = coordinates(count)
    extended = window_model(c[:SHARED])
    for extension, relative in zip(placed(element, 0.4), c[SHARED:], strict=True):
        size = TERMS[extension.cause.name].size.typical * (1 + relative)
        extended = extension.cause.extend(extended, size, extension.shape, OPERATING_POINT)
    assert_alike(extended, count)


@pytest.mark.parametrize("port", PORTS)
def test_a_gaussian_process_is_computed_exactly_at_every_port(port: str) -> None:
    c = coordinates(SHARED + COUNT)
    extended = window_model(c[:SHARED])
    for extension, size in zip(process_at(port, 30), c[SHARED:], strict=True):
        extended = extension.cause.extend(extended, size, extension.shape, OPERATING_POINT)
    assert_alike(extended, SHARED + COUNT)


class LawInSeries(DampingLaw):
    """One that a user has added."""

    def series(self, section: Steel, s: Complex) -> Complex:
        """A weak spring in parallel."""
        return 1e-3 * section.shear_modulus * section.polar_moment / s


def test_a_law_that_differs_from_window_to_window_is_computed_exactly() -> None:
    c = coordinates(SHARED)
    base = window_model(c)
    pipe, collars = base.system.string
    layer = StokesLayerDrag(1200.0 * (1 + c[0]), 0.05 * (1 + c[4]), 0.16)
    string = replace(pipe, laws=(layer,)), replace(collars, laws=(layer,))
    assert_alike(replace(base, system=replace(base.system, string=string)), SHARED)


def test_what_the_compiled_model_does_not_know_is_left_to_the_composed_one() -> None:
    base = window_model(coordinates(SHARED))
    system, recording = base.system, base.recording
    pipe, collars = system.string
    matched = replace(system.top_drive.controller, matching=ImpedanceMatching(1 / 400, 1100.0))
    twice = RegenerativeCutting(3e3, 12.0, 5), RegenerativeCutting(1e3, 12.0, 3)
    others = [
        replace(system, string=(replace(pipe, laws=(LawInSeries(),)), collars)),
        replace(system, string=(pipe, replace(collars, laws=(HystereticLoss(0.01),)))),
        replace(system, top_drive=replace(system.top_drive, controller=matched)),
        replace(system, bit=replace(system.bit, cutting=twice)),
        replace(system, motor=Motor(np.inf)),
    ]
    assert [compiled_system(other, recording, base.course) for other in others] == [None] * len(others)

"""What no cause explains is learnt: an inertia that hangs on the string by a spring, simulated in time."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
import xarray as xr

from drillid.arrays import Complex
from drillid.discrepancy.base_rates import BaseRates
from drillid.discrepancy.catalogue import CATALOGUE, WindowModel
from drillid.discrepancy.inference.screen import screen
from drillid.discrepancy.inference.set_fit import SetFit, fit_set
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.learning.elements import ELEMENTS, TERMS, Element
from drillid.discrepancy.learning.examined import learnt_words
from drillid.discrepancy.learning.fingerprint import Fingerprint
from drillid.discrepancy.learning.offer import LearntExtension, learnt_extension
from drillid.discrepancy.learning.search import _directions, placed
from drillid.discrepancy.products.extended_model import extended_window_model, extension_variables
from drillid.discrepancy.sets import ExaminedSet
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.verdict import Verdict
from drillid.physics.attachments import MountedInertia, with_law
from drillid.physics.dual_numbers import Dual
from drillid.physics.equipment import DrillingSystem
from drillid.physics.responses import laplace, string_admittance
from tests.simulated import SHALLOW, WINDOW_S, Truth, drilled
from tests.truth.discrepancy.test_catalogue import OPERATING_POINT, S, window_model
from tests.truth.discrepancy.wells import evidence_of

MOUNT = MountedInertia(inertia=8.0, frequency=1.6, loss=0.3)
DEPTH = 480.0


@dataclass(frozen=True)
class Mounted(Truth):
    """A rig on whose string an inertia hangs by a spring, half way down."""

    @property
    def system(self) -> DrillingSystem:
        """All of the equipment."""
        string = with_law((self.pipe, self.collars), DEPTH, MOUNT)
        return DrillingSystem(self.top_drive, string, self.bit)


def fitted(truth: Truth, seed: int) -> tuple[SetModel, SetFit]:
    """Four windows of a rig and the base model's fit to them."""
    stands = [drilled(truth, 2 * WINDOW_S, seed), drilled(truth, 2 * WINDOW_S, seed + 1)]
    model = SetModel(evidence_of(truth, stands))
    return model, min((fit_set(model, start) for start in (model.start(), model.expected())), key=lambda fit: fit.cost)


@pytest.fixture(scope="module")
def mounted() -> tuple[SetModel, SetFit]:
    """Windows of the rig with a mounted inertia, and the base model's fit to them."""
    return fitted(Mounted(**vars(SHALLOW)), 31)


@pytest.fixture(scope="module")
def learnt(mounted: tuple[SetModel, SetFit]) -> LearntExtension:
    """What is learnt of the mounted inertia."""
    extension = learnt_extension(*mounted)
    assert extension is not None
    return extension


def test_a_mounted_inertia_is_learnt_where_it_hangs_and_predicts_unseen_windows(learnt: LearntExtension) -> None:
    assert learnt.offered
    assert [name for name, _ in learnt.elements] == ["mounted inertia"]
    assert learnt.elements[0][1] == pytest.approx(DEPTH / SHALLOW.bit_depth, abs=0.03)
    truth = np.array([MOUNT.inertia, MOUNT.frequency, MOUNT.loss])
    assert np.all(np.abs(learnt.fit.point.sizes - truth) < 4 * learnt.fit.size_errors)


def test_a_learnt_extension_is_stored_and_read_as_a_named_cause_is(
    mounted: tuple[SetModel, SetFit], learnt: LearntExtension
) -> None:
    model, base = mounted
    before = screen(model, base, (), [CATALOGUE["drive_lag"]], np.random.default_rng(0))
    unknown = Verdict("unknown", "upper string", 0.9, 0.0, 1000.0)
    examination = Examination((unknown,), model, base, base, (), before, before, None, (), BaseRates(), before.p_value)
    extended = replace(examination, extended=learnt.fit, extensions=learnt.extensions)
    assert "an inertia hangs on the string by a spring" in learnt_words(extended)
    variables = extension_variables([ExaminedSet(np.arange(4), extended)], 4)
    stored = xr.Dataset(variables | {"window_set": ("window", np.zeros(4, dtype=int))})
    again = extended_window_model(stored, 0).mobility(model.s)
    np.testing.assert_allclose(again, model.predicted(learnt.fit.point, learnt.extensions), rtol=1e-9)


@pytest.mark.parametrize("element", [each for each in ELEMENTS if each.admittance], ids=lambda element: element.name)
def test_directions_by_the_admittance_are_those_of_the_whole_model(
    mounted: tuple[SetModel, SetFit], element: Element
) -> None:
    model, base = mounted
    tried = [(place, np.array(typical(element))) for place in (0.0, 0.4, 1.0)]
    found = _directions(model, base, (), element, tried)
    whole = _directions(model, base, (), replace(element, admittance=None), tried)
    assert np.abs(found - whole).max() < 1e-9 * np.abs(whole).max()


def test_nothing_is_offered_where_nothing_is_wrong() -> None:
    extension = learnt_extension(*fitted(SHALLOW, 41))
    assert extension is None or not extension.offered


def extended(element: Element, sizes: object) -> WindowModel:
    """The catalogue's test rig with an element half way down."""
    model, extensions = window_model(), placed(element, 0.5)
    for extension, size in zip(extensions, sizes, strict=True):  # type: ignore[call-overload]
        model = extension.cause.extend(model, size, extension.shape, OPERATING_POINT)
    return model


def typical(element: Element) -> list[float]:
    return [TERMS[name].size.typical for name in element.terms]


@pytest.mark.parametrize("element", ELEMENTS, ids=lambda element: element.name)
def test_an_element_without_size_changes_nothing(element: Element) -> None:
    sizes = [0.0, *typical(element)[1:]] if len(element.terms) in (2, 3) and element.name[0] in "md" else None
    result = extended(element, sizes or [0.0] * len(element.terms)).mobility(S)
    if "factor" not in element.name:
        np.testing.assert_allclose(result, window_model().mobility(S), rtol=1e-6)


@pytest.mark.parametrize("element", ELEMENTS, ids=lambda element: element.name)
def test_derivatives_are_those_of_central_differences(element: Element) -> None:
    sizes = np.array(typical(element))
    directions = np.eye(sizes.size)
    exact = extended(element, [Dual(np.full((1, 1), size), row) for size, row in zip(sizes, directions, strict=True)])
    slopes = exact.mobility(S).full_tangents()
    for number, size in enumerate(sizes):
        step = 1e-4 * size * directions[number]
        difference = extended(element, sizes + step).mobility(S) - extended(element, sizes - step).mobility(S)
        np.testing.assert_allclose(
            slopes[number], difference / (2e-4 * size), rtol=1e-4, atol=1e-6 * np.abs(slopes).max()
        )


@pytest.mark.parametrize("element", ELEMENTS, ids=lambda element: element.name)
@pytest.mark.parametrize("share", [0.01, 1.0, 10.0])
def test_the_string_stays_passive_at_any_size(element: Element, share: float) -> None:
    sizes = np.clip(share * np.array(typical(element)), None, [TERMS[name].size.high for name in element.terms])
    admittance: Complex = string_admittance(extended(element, sizes).system, laplace(np.geomspace(0.01, 10.0, 400)))
    assert np.all(np.real(admittance) > 0)


def test_the_fingerprint_names_the_textbooks_element_and_is_like_itself_alone(learnt: LearntExtension) -> None:
    found = learnt.fingerprint
    assert "on a spring of" in found.resembles
    again = Fingerprint.of(found.content())
    assert found.likeness(again) > 0.5
    other = [replace(each, values=3.0 * each.values) for each in found.described]
    assert found.likeness(replace(found, described=tuple(other))) < 0.01

"""A response of no low order is learnt as a Gaussian process over frequency: a recorder that adds an echo of the speed.

Rig and recorder are simulated in time; a delayed copy of the speed is added to its samples.
"""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from drillid.arrays import Floats
from drillid.discrepancy.base_rates import BaseRates
from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.inference.base_fit import fit_base
from drillid.discrepancy.inference.held_out_gain import gain_on
from drillid.discrepancy.inference.screen import screen
from drillid.discrepancy.inference.set_fit import SetFit
from drillid.discrepancy.inference.set_model import SetModel
from drillid.discrepancy.inference.unknown import PORTS
from drillid.discrepancy.learning.elements import Element
from drillid.discrepancy.learning.examined import learnt_words
from drillid.discrepancy.learning.fingerprint import SAME, Fingerprint, fingerprint
from drillid.discrepancy.learning.offer import LearntExtension, learnt_extension
from drillid.discrepancy.learning.process import KERNELS, PROCESS_AT, PROCESSES, curves, process_at
from drillid.discrepancy.learning.process_search import fitted_process
from drillid.discrepancy.learning.search import Candidate, learn
from drillid.discrepancy.products.extended_model import extended_window_model, extension_variables
from drillid.discrepancy.products.prediction import held_out_predictions
from drillid.discrepancy.sets import ExaminedSet
from drillid.discrepancy.verdicts.examination import Examination
from drillid.discrepancy.verdicts.verdict import Verdict
from drillid.physics.dual_numbers import Dual
from drillid.physics.gaussian_process import COUNT, NODES, covariance, functions
from drillid.physics.responses import laplace
from drillid.physics.time_responses import bit_step_response
from tests.simulated import RATE, SHALLOW, WINDOW_S, drilled
from tests.truth.discrepancy.test_catalogue import OPERATING_POINT, S, window_model
from tests.truth.discrepancy.wells import evidence_of

SHARE, LATE_S = 0.12, 0.7
Case = tuple[SetModel, SetFit]


def echoed(speed: Floats, late: float, share: float) -> Floats:
    """The speed with a share of itself of some seconds ago."""
    change = speed - speed.mean()
    samples = round(late * RATE)
    return speed + share * np.concatenate([np.zeros(samples), change[:-samples]])


def fitted(seed: int, late: float = LATE_S, share: float = SHARE) -> Case:
    """Two windows of the small rig, and the base model's fit to them."""
    stand = drilled(SHALLOW, 2 * WINDOW_S, seed)
    return fit_base(evidence_of(SHALLOW, [stand | {"speed": echoed(stand["speed"], late, share)}]))


@pytest.fixture(scope="module")
def case() -> Case:
    """Windows of the rig whose record has an echo."""
    return fitted(31)


@pytest.fixture(scope="module")
def learnt(case: Case) -> LearntExtension:
    """What is learnt of the echo."""
    extension = learnt_extension(*case)
    assert extension is not None
    return extension


def test_an_echo_is_learnt_as_a_process_at_the_record(learnt: LearntExtension) -> None:
    assert learnt.offered
    assert [name for name, _ in learnt.elements] == [f"{PROCESS_AT} record"]


def test_the_process_recovers_what_the_true_echo_gains(case: Case, learnt: LearntExtension) -> None:
    model, base = case
    held = np.zeros(model.evidence.used.shape, dtype=bool)
    held[1::3] = True
    noise = np.count_nonzero(model.evidence.used[held.all(axis=1)])
    before = base.chi2 / model.evidence.windows
    # the responses' misfit falls to what the noise makes of it
    after = learnt.fit.chi2 / model.evidence.windows
    assert after < 1.1 * 2 * noise / np.count_nonzero(held.all(axis=1))
    gain = gain_on(model, held, (base.point, ()), (learnt.fit.point, learnt.extensions))
    assert gain.value > 0.9 * 0.5 * (before - after)


def test_the_curve_is_the_echos_within_its_interval(learnt: LearntExtension) -> None:
    s = laplace(np.array([0.2, 0.4, 0.8, 1.3, 2.0, 3.0]))
    known = curves(learnt.extensions[0].shape, s)
    truth = SHARE * np.exp(-s * LATE_S)
    count = len(learnt.extensions)
    errors = np.linalg.inv(learnt.fit.information)[-count:, -count:]
    found = learnt.fit.point.sizes @ known
    variance = np.einsum("jf,jk,kf->f", known.real, errors, known.real)
    variance += np.einsum("jf,jk,kf->f", known.imag, errors, known.imag)
    assert np.abs(found - truth).max() < 0.25 * SHARE
    assert np.sum(np.abs(found - truth) ** 2 / variance) < 4 * 2 * s.size


def test_it_is_stored_and_predicts_as_a_named_cause_does(case: Case, learnt: LearntExtension) -> None:
    model, base = case
    before = screen(model, base, (), [CATALOGUE["drive_lag"]], np.random.default_rng(0))
    unknown = Verdict("unknown", "record", 0.9, 0.0, 1000.0)
    examination = Examination((unknown,), model, base, base, (), before, before, None, (), BaseRates(), before.p_value)
    extended = replace(examination, extended=learnt.fit, extensions=learnt.extensions)
    assert "a Gaussian process over frequency" in learnt_words(extended)
    variables = extension_variables([ExaminedSet(np.arange(2), extended)], 2)
    stored = xr.Dataset(variables | {"window_set": ("window", np.zeros(2, dtype=int))})
    again = extended_window_model(stored, 0)
    np.testing.assert_allclose(again.mobility(model.s), model.predicted(learnt.fit.point, learnt.extensions), rtol=1e-9)
    _, step = bit_step_response(again.system, 10.0, 0.02)
    assert np.all(np.isfinite(step))
    row, plain, better = held_out_predictions(extended)
    weight, measured = model.measured.weight[row], model.evidence.mobility[row]
    misfits = [
        np.sum(np.abs(weight * (each.mobility(model.evidence.frequency) - measured)) ** 2) for each in (plain, better)
    ]
    assert misfits[1] < 0.5 * misfits[0]


def described(case: Case) -> Fingerprint:
    """The fingerprint of the process that is fitted at the record."""
    model, base = case
    found = fitted_process(model, base, ("record",))
    assert found is not None
    port, extensions, fit = found
    element = Element(f"{PROCESS_AT} {port}", tuple(each.cause.name for each in extensions), False, (port,), ())
    return fingerprint(model, base, [Candidate(element, 0.0, extensions, fit)])


def test_the_same_echo_in_another_well_is_told_the_same_and_another_is_not(case: Case) -> None:
    own, again, other = (described(each) for each in (case, fitted(51), fitted(61, 0.45)))
    assert own.likeness(again) >= SAME
    assert own.likeness(other) < SAME
    assert Fingerprint.of(own.content()).likeness(again) == pytest.approx(own.likeness(again))


def test_without_an_echo_a_process_predicts_nothing() -> None:
    model, base = fitted(41, share=0.0)
    assert fitted_process(model, base, PORTS) is None
    assert not any(each.element.name.startswith(PROCESS_AT) for each in learn(model, base)[0])


@pytest.mark.parametrize("rate", [2.0, 10.0, 40.0])
def test_the_functions_have_the_covariance_of_the_process(rate: float) -> None:
    known = functions(rate, NODES)
    found = np.einsum("jf,jg->fg", known, known.conj())
    np.testing.assert_allclose(found, covariance(rate, NODES[:, None], NODES.conj()), atol=1e-5)
    np.testing.assert_allclose(functions(rate, NODES.conj()), known.conj(), atol=1e-12)


@pytest.mark.parametrize("port", PORTS)
def test_a_process_of_no_size_changes_nothing_and_has_exact_derivatives(port: str) -> None:
    kernel = KERNELS.index(min(KERNELS, key=lambda each: abs(each[1] - 0.1) + abs(each[0] - 6)))
    extensions = process_at(port, kernel)

    def mobility(sizes: list[object]) -> object:
        model = window_model()
        for extension, size in zip(extensions, sizes, strict=True):
            model = extension.cause.extend(model, size, extension.shape, OPERATING_POINT)
        return model.mobility(S)

    np.testing.assert_allclose(mobility([0.0] * COUNT), window_model().mobility(S), rtol=1e-6)
    sizes = np.random.default_rng(1).normal(size=COUNT)
    exact = mobility([Dual(np.full((1, 1), size), row) for size, row in zip(sizes, np.eye(COUNT), strict=True)])
    assert isinstance(exact, Dual)
    slopes = exact.full_tangents()
    for number in (0, 5, COUNT - 1):
        step = 1e-4 * np.eye(COUNT)[number]
        difference = np.asarray(mobility(list(sizes + step))) - np.asarray(mobility(list(sizes - step)))
        np.testing.assert_allclose(slopes[number], difference / 2e-4, rtol=1e-4, atol=1e-6 * np.abs(slopes).max())


def test_a_string_that_would_supply_energy_is_left_where_another_port_explains_it(case: Case) -> None:
    model, base = case
    found = fitted_process(model, base, ("lower string", "record"))
    assert found is not None
    port, extensions, _ = found
    assert port == "record"
    assert extensions[0].cause is PROCESSES["record"][0]

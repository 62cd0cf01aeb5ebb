"""A cause's evidence is what remains once all that it frees is integrated over, the windows' deviations among it, and
a score is about where the windows' posteriors have most mass.
"""

import numpy as np
import pytest

from drillid.arrays import Complex
from drillid.discrepancy.catalogue import CATALOGUE
from drillid.discrepancy.inference.base_fit import fit_base
from drillid.discrepancy.inference.coordinates import COORDINATES, Extension, Point
from drillid.discrepancy.inference.far_off_data_sheet import chance_of_evidence
from drillid.discrepancy.inference.most_mass import bias_of_curvature, of_most_mass
from drillid.discrepancy.inference.projection import columns, project
from drillid.discrepancy.inference.screen import screen
from drillid.discrepancy.inference.search import search
from drillid.discrepancy.inference.set_fit import SetFit, expanded
from drillid.discrepancy.inference.set_model import SetModel
from drillid.fits.datasheet import DataSheet
from drillid.physics.equipment import Bit, Controller, Section, TopDrive, polar_moment
from tests.simulated import Truth, drilled
from tests.truth.discrepancy.wells import evidence_of

WINDOWS, WINDOW_S = 6, 300.0
STRONG = np.log(20.0)
"""Odds that are strong evidence (Kass and Raftery 1995)."""
SOUND = Truth(
    pipe=Section(1800.0, polar_moment(0.127, 0.1086), kappa=200.0, delta=2.5e8),
    collars=Section(60.0, polar_moment(0.1651, 0.0714), kappa=200.0, delta=2.5e8),
    top_drive=TopDrive(1390.0, 0.0315, Controller(1200.0, 650.0)),
    bit=Bit(40.0, 30.0),
    sweep_amplitude=420.0,
    bit_noise=300.0,
    bit_torque=3600.0,
)
SHEET = DataSheet(
    SOUND.top_drive.controller,
    collar_length=float(SOUND.collars.length),
    collar_polar_moment=float(SOUND.collars.polar_moment),
    delay=0.030,
    delay_error=0.003,
    inertia_td=1420.0,
    inertia_td_error=0.03 * 1420.0,
    polar_moment=float(SOUND.pipe.polar_moment),
    polar_moment_error=0.05 * float(SOUND.pipe.polar_moment),
    length_relative=0.02,
)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_resonance_that_each_window_turns_into_its_own_noise_is_no_evidence(seed: int) -> None:
    model, base = _fitted(WINDOWS, seed)
    zone = [CATALOGUE["local_damping_zone"]]
    screened = screen(model, base, (), zone, np.random.default_rng(0))
    best, *_ = search(model, base, (), screened, zone, time_varying={}, all_causes=True)
    assert best.log_evidence < STRONG


def test_many_windows_of_two_periods_in_which_nothing_is_wrong_have_no_misfit() -> None:
    model, base = _fitted(24, seed=1)
    assert screen(model, base, (), list(CATALOGUE.values()), np.random.default_rng(0)).p_value > 0.05
    # windows whose damping follows the noise to nearly none draw the set below the truth
    damping, error = COORDINATES.index("damping_bha"), np.sqrt(np.diag(np.linalg.inv(base.information)))
    off = of_most_mass(model, base).shared[damping] - SOUND.bit.damping / 50.0
    assert abs(off) < 0.5 * error[damping]


def test_evidence_where_data_sheets_are_far_off_is_as_rare_as_it_is_large() -> None:
    """In the mean a Bayes factor is one where nothing is wrong, so that e^E is exceeded once in e^E (Markov)."""
    model, base = _fitted(WINDOWS, seed=1)
    causes = [CATALOGUE[name] for name in ("controller_gain", "drive_lag", "extra_section", "wave_speed")]
    evidence = np.arange(-3.0, 6.0)
    chances = [chance_of_evidence(model, base, causes, each, np.random.default_rng(0)) for each in evidence]
    assert np.all(np.diff(chances) <= 0)
    # of data sheets that are off by so much, and not for ever where no draw is
    assert 0.01 < chances[0] < 0.5
    assert 0 < chances[-1] < 0.01
    assert np.all(chances <= len(causes) * np.exp(-evidence))


class _Bent(SetModel):
    """A model whose first residual is bent in the windows' deviations, however little these change the rest."""

    bend = 0.0

    def residual(self, point: Point, extensions: tuple[Extension, ...] = ()) -> Complex:
        own = super().residual(point, extensions)
        own[:, 0] += self.bend * np.sum(point.local**2, axis=1)
        return own


@pytest.mark.parametrize(("bend", "share"), [(0.2, 1.0), (20.0, 0.0)])
def test_the_bias_of_curved_responses_is_theirs_times_the_variance_where_it_is_small(bend: float, share: float) -> None:
    model, base = _fitted(1, seed=1)
    bent = _Bent(model.evidence, model.deviation)
    straight = bias_of_curvature(model, base.point, ())
    bent.bend = bend
    variances = np.diagonal(np.linalg.inv(expanded(model, base.point, ()).normal.corner), axis1=1, axis2=2)
    bias = bias_of_curvature(bent, base.point, ())
    np.testing.assert_allclose(bias[0, 0], share * (straight[0, 0] + bend * variances.sum()), rtol=1e-6)
    np.testing.assert_allclose(bias[0, 1:], share * straight[0, 1:])


@pytest.mark.parametrize("name", ["tapered_string", "local_damping_zone"])
def test_an_effect_between_two_places_that_are_tried_is_seen_at_one_of_them(name: str) -> None:
    """By 80 % of its information and more."""
    model, base = _fitted(2, seed=1)
    cause, shapes = CATALOGUE[name], np.array(CATALOGUE[name].shapes)
    places = np.concatenate([shapes, (shapes[1:] + shapes[:-1]) / 2])
    candidates = [Extension(cause, float(place)) for place in places]
    information = project(model, base, (), columns(model, base, (), candidates)).information
    cosine = information / np.sqrt(np.outer(np.diag(information), np.diag(information)))
    seen = cosine[shapes.size :, : shapes.size] ** 2
    assert seen.max(axis=1).min() > 0.8


def _fitted(windows: int, seed: int) -> tuple[SetModel, SetFit]:
    return fit_base(evidence_of(SOUND, [drilled(SOUND, windows * WINDOW_S, seed)], SHEET, WINDOW_S))

"""Responses of the ideal test from compiled numbers: those of the closed forms of either world, with their slopes."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.hidden import Hidden, altered
from benchmarks.blind.ideal.ideal import Ideal
from benchmarks.blind.ideal.line import COLUMNS, DERIVED, top_load, top_load_slopes
from benchmarks.blind.ideal.of_case import ideal_of
from benchmarks.blind.ideal.responses import NUISANCES
from benchmarks.blind.other_world.rig import Piece
from benchmarks.blind.other_world.theory import string_response
from benchmarks.blind.world import WORLDS
from benchmarks.learn.cases import CaseResponses, well
from benchmarks.learn.effects import HIDEABLE
from drillid.arrays import Floats
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, TopDrive
from drillid.physics.responses import string_admittance

FREQUENCY = 2 * np.pi * np.linspace(0.05, 4.0, 60)
STEP = 1e-6


def _ideal(world: str) -> Ideal:
    case, _ = WORLDS[world].plain_case(50011, 2)
    return ideal_of(replace(case, command_logged=True))


def _linear(world: str) -> list[str]:
    return [name for name, effect in WORLDS[world].effects.items() if effect.linear]


def _closed_form(ideal: Ideal, hidden: tuple[Hidden, ...], nuisances: Floats) -> Floats:
    """Whitened responses of the second window without compiled numbers, (rows,)."""
    theory = ideal.theory(frozenset(cause.name for cause in hidden))
    return theory._joined(1, ideal.responses.expected(1, hidden, nuisances, theory.s, theory.shares))


@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.parametrize("deviation", [0.0, 0.3])
def test_responses_and_slopes_are_those_of_the_closed_forms(world: str, deviation: float) -> None:
    ideal = _ideal(world)
    draw = np.random.default_rng(0).standard_normal(len(NUISANCES))
    nuisances = np.maximum(deviation * draw * ideal.priors.shared, -0.5)
    for name in _linear(world):
        low, high = ideal.responses.size_range(Hidden(name, 0.0, 0.4))
        hidden = (Hidden(name, float(np.sqrt(low * high)), 0.4),)
        theory = ideal.theory(frozenset({name}))
        expected = _closed_form(ideal, hidden, nuisances)
        np.testing.assert_allclose(
            theory.response(1, hidden, nuisances), expected, atol=1e-8 * np.abs(expected).max(), err_msg=name
        )
        steps = STEP * np.eye(len(NUISANCES))
        ends = [[_closed_form(ideal, hidden, nuisances + sign * step) for step in steps] for sign in (1, -1)]
        wanted = (np.array(ends[0]) - np.array(ends[1])).T / (2 * STEP)
        error = np.abs(theory.slopes(1, nuisances, hidden) - wanted).max(axis=0)
        assert np.all(error <= 1e-4 * np.abs(wanted).max(axis=0)), name


def test_what_is_hidden_to_be_learnt_has_the_responses_of_the_closed_forms() -> None:
    case = well(12, 0, windows=2)
    ideal = Ideal(replace(case, command_logged=True), CaseResponses(case))
    for name, hideable in HIDEABLE.items():
        low, high = hideable.effect.range(case.world(0, hidden=()), case.context(Hidden(name, 0.0, 0.4)))
        hidden = (Hidden(name, float(np.sqrt(low * high)), 0.4),)
        expected = _closed_form(ideal, hidden, np.zeros(len(NUISANCES)))
        found = ideal.theory(frozenset({name})).response(1, hidden)
        np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max(), err_msg=name)


def test_derivatives_of_every_number_of_a_string() -> None:
    string = np.array(
        [
            [1500.0, 1.2e-5, 7850.0, 79.3e9, 120.0, 3e8, 40.0, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0],
            [20.0, 4e-5, 7850.0, 79.3e9, 300.0, 3e8, 0.0, 0.0, 12.0, 30.0, 2e4, 1.1, 0.2],
            [180.0, 6e-5, 7850.0, 79.3e9, 80.0, 3e8, 0.0, 0.02, 40.0, 90.0, 0.0, 0.0, 0.0],
        ]
    )
    below = np.full(FREQUENCY.size, -20.0 + 5.0j)
    places = np.array([(piece, column) for piece in range(3) for column in DERIVED])
    for causal in (True, False):
        load, slopes = top_load_slopes(string, causal, below, FREQUENCY, np.eye(len(places)), places)
        np.testing.assert_allclose(load, top_load(string, causal, below, FREQUENCY), rtol=1e-12)
        for slope, (piece, column) in zip(slopes, places, strict=True):
            step = 1e-4 * max(string[piece, column], 1e-2 * string[:, column].max())
            ends = []
            for sign in (1, -1):
                moved = string.copy()
                moved[piece, column] += sign * step
                ends.append(top_load(moved, causal, below, FREQUENCY))
            wanted = (ends[0] - ends[1]) / (2 * step)
            np.testing.assert_allclose(
                slope, wanted, atol=1e-4 * np.abs(wanted).max(), err_msg=f"{COLUMNS[column]} of piece {piece}"
            )


def test_a_line_that_amplifies_its_waves_has_the_admittance_of_the_library() -> None:
    s = 1j * FREQUENCY
    string = (Piece(2500.0, 1.2e-5, wall_damping=-300.0, steel_damping=3e8, inertia_below=30.0, damping_below=40.0),)
    system = DrillingSystem(
        TopDrive(2000.0, 0.03, Controller(500.0)), (Section(2500.0, 1.2e-5, -300.0, 3e8),), Bit(30.0, 40.0)
    )
    np.testing.assert_allclose(string_response(string, s)[0], string_admittance(system, s), rtol=1e-9)


def test_distances_on_fewer_windows_are_lower_bounds() -> None:
    case, _ = WORLDS["own"].plain_case(50011, 4)
    ideal, hidden = ideal_of(case), (Hidden("drive_lag", 0.02, 0.5),)
    bounds = [part.least_distance(hidden) for part in (*ideal.parts, ideal)]
    assert len(bounds) == 3
    assert 0 < bounds[0] < bounds[1] < bounds[2]


@pytest.mark.parametrize("change", [-0.1, 1e-6, 0.1])
def test_longer_collars_begin_where_the_pipe_ends(change: float) -> None:
    """Whatever the nuisances take for the pipe's length, the rig has so much more of collars."""
    case, _ = WORLDS["other"].plain_case(50020, 1)
    nuisances = change * (np.arange(len(NUISANCES)) == list(NUISANCES).index("length"))
    plain = case.window(0, (), nuisances)
    longer = case.window(0, (Hidden("distributed_bha", 80.0, 0.5),), nuisances)
    assert longer.length == pytest.approx(plain.length)
    collars = case.rig.collars[0].moment
    assert sum(piece.length for piece in longer.string if piece.moment == collars) == pytest.approx(
        80.0 + sum(piece.length for piece in plain.string if piece.moment == collars)
    )


def test_an_altered_part_is_one_that_is_replaced() -> None:
    piece = Piece(10.0, 1e-5)
    assert altered(piece, length=12.0) == replace(piece, length=12.0)
    assert piece.length == 10.0

"""Side forces of the soft string against closed forms."""

import numpy as np
import pytest

from drillid.errors import SettingsError
from drillid.physics.nonlinear import WallContact, Weakening
from drillid.physics.soft_string import Pipe, Survey, side_forces, wall_contact

PIPE = Pipe(2000.0, 0.1397, 0.1214, 0.168)
MUD = 1200.0
WEIGHT = PIPE.buoyed_weight(MUD)


def total(contact: WallContact) -> float:
    return float(np.sum(contact.dynamic * np.diff(contact.edges)))


def test_buoyed_weight_is_that_of_the_steel_less_the_mud_it_displaces() -> None:
    assert pytest.approx(np.pi / 4 * (0.1397**2 - 0.1214**2) * 6650 * 9.80665) == WEIGHT


def test_a_straight_hole_carries_the_weight_across_it() -> None:
    forces = side_forces(Survey.from_degrees([0, 2500], [35, 35]), [PIPE], MUD)
    lean = np.radians(35)
    np.testing.assert_allclose(forces.side_force, WEIGHT * np.sin(lean))
    middle = (forces.edges[1:] + forces.edges[:-1]) / 2
    np.testing.assert_allclose(forces.tension, WEIGHT * np.cos(lean) * (2000 - middle))
    assert total(wall_contact(forces, 0.3, 0.2)) == pytest.approx(0.2 * WEIGHT * np.sin(lean) * 2000 * 0.084)


def test_a_vertical_string_touches_nothing() -> None:
    assert not side_forces(Survey.from_degrees([0, 2000], [0, 0]), [PIPE], MUD).side_force.any()


def test_weight_on_bit_takes_tension_off_the_whole_string() -> None:
    survey = Survey.from_degrees([0, 2000], [0, 60])
    free, loaded = (side_forces(survey, [PIPE], MUD, weight) for weight in (0.0, 5e4))
    np.testing.assert_allclose(free.tension - loaded.tension, 5e4)


def test_build_section_against_its_closed_form() -> None:
    """Under enough tension a string in an arc of curvature k lies on the upper side, f = F(z) k − w sin θ."""
    end, tension = np.radians(60), 6e5
    curvature = end / 2000
    forces = side_forces(Survey.from_degrees([0, 2000], [0, 60]), [PIPE], MUD, -tension)
    side = (WEIGHT * np.sin(end) + curvature * tension) * 2000 - 2 * WEIGHT * (1 - np.cos(end)) / curvature
    assert np.sum(forces.side_force * np.diff(forces.edges)) == pytest.approx(side, rel=1e-5)


def test_a_turn_pulls_across_the_weight() -> None:
    """The azimuth passes through north; weight and pull of the turn add at right angles."""
    forces = side_forces(Survey.from_degrees([0, 2000], [90, 90], [330, 30]), [PIPE], MUD, -3e5)
    turn = np.radians(60) / 2000
    np.testing.assert_allclose(forces.side_force, np.hypot(WEIGHT, 3e5 * turn))


def test_each_pipe_has_its_own_weight_and_radius() -> None:
    collars = Pipe(100.0, 0.2032, 0.0714, 0.2032)
    forces = side_forces(Survey.from_degrees([0, 2100], [90, 90]), [PIPE, collars], MUD)
    torque = WEIGHT * 2000 * 0.084 + collars.buoyed_weight(MUD) * 100 * 0.1016
    assert total(wall_contact(forces, 1.0, 1.0)) == pytest.approx(torque)


def test_weakening_falls_from_static_to_dynamic() -> None:
    law = Weakening(2.0, 3.0)
    assert law.level(10.0, 4.0, 0.0) == 10.0
    assert law.level(10.0, 4.0, -2.0) == pytest.approx(4 + 6 / np.e)
    assert law.level(10.0, 4.0, 50.0) == pytest.approx(4.0)
    assert law.slope(10.0, 4.0, 1.5) == pytest.approx(
        (law.level(10.0, 4.0, 1.5 + 1e-6) - law.level(10.0, 4.0, 1.5 - 1e-6)) / 2e-6, rel=1e-6
    )


@pytest.mark.parametrize(
    ("depth", "inclination"), [([0, 0], [0, 1]), ([0], [0]), ([0, 100], [0, 200]), ([0, 100], [0, 1, 2])]
)
def test_unusable_surveys_are_refused(depth: list[float], inclination: list[float]) -> None:
    with pytest.raises(SettingsError, match="survey"):
        Survey.from_degrees(depth, inclination)


def test_a_survey_that_ends_above_the_bit_is_refused() -> None:
    with pytest.raises(SettingsError, match="1900 m, the string 0 … 2000 m"):
        side_forces(Survey.from_degrees([0, 1900], [0, 0]), [PIPE], MUD)


def test_dynamic_above_static_friction_is_refused() -> None:
    with pytest.raises(SettingsError, match="dynamic ≤ static"):
        WallContact(np.array([0.0, 1.0]), np.array([1.0]), np.array([2.0]))

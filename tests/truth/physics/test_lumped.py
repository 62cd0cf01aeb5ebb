"""The lumped two-inertia model and modified strings."""

import numpy as np
import pytest

from drillid.errors import SettingsError
from drillid.physics.dual_numbers import derivatives
from drillid.physics.equipment import Bit, Controller, DrillingSystem, Section, TopDrive
from drillid.physics.lumped import LumpedString, ladder_string_admittance
from drillid.physics.responses import command_mobility, laplace, string_admittance
from drillid.physics.strings import cut, tapered, with_zone

S = laplace(np.geomspace(0.05, 5.0, 61))
PIPE = Section(2000.0, 1.6e-5, 120.0, 3e8)
COLLARS = Section(100.0, 1.2e-4, 80.0, 2e8)
DRIVE = TopDrive(1100.0, 0.04, Controller(1500.0, 800.0))


def test_undamped_lumped_model_is_spring_and_inertia() -> None:
    lumped = LumpedString(stiffness=600.0, inertia_bha=150.0)
    resonance = np.sqrt(600.0 / 150.0)
    np.testing.assert_allclose(lumped.clamped_mode, 1j * resonance, rtol=1e-14)
    np.testing.assert_allclose(lumped.admittance(S), 150.0 * S / (1 + (S / resonance) ** 2), rtol=1e-11)


def test_damped_lumped_model_solves_its_equations_of_motion() -> None:
    lumped = LumpedString(600.0, 150.0, 30.0, 60.0)
    roots = np.roots([150.0, 30.0 + 60.0, 600.0])
    assert lumped.clamped_mode == pytest.approx(roots[roots.imag > 0][0], rel=1e-13)
    overdamped = LumpedString(600.0, 150.0, 0.0, 3000.0)
    assert overdamped.clamped_mode == pytest.approx(np.roots([150.0, 3000.0, 600.0]).max(), rel=1e-10)
    for s, mobility in zip(S, lumped.command_mobility(DRIVE, S), strict=True):
        spring, drive = 600.0 / s + 30.0, np.exp(-0.04 * s)
        motion = np.array(
            [
                [1100.0 * s + drive * (1500.0 + 800.0 / s) + spring, -spring],
                [-spring, 150.0 * s + 60.0 + spring],
            ]
        )
        assert np.linalg.solve(motion, [drive, 0])[0] == pytest.approx(mobility, rel=1e-11)


def test_a_section_lumped_is_one_element_of_the_ladder() -> None:
    system = DrillingSystem(DRIVE, (PIPE,), Bit(90.0, 30.0))
    lumped = LumpedString.of_section(PIPE, 90.0, 30.0)
    np.testing.assert_allclose(lumped.admittance(S), ladder_string_admittance(system, S, 1), rtol=1e-12)


def test_the_lumped_model_holds_at_low_frequency_only() -> None:
    """Below half the first mode within 5 %; at the third mode it is invalid."""
    system, lumped = DrillingSystem(DRIVE, (PIPE,), Bit(400.0, 30.0)), LumpedString.of_section(PIPE, 400.0, 30.0)
    error = np.abs(lumped.command_mobility(DRIVE, S) / command_mobility(system, S) - 1)
    frequency = S.imag / 2 / np.pi
    assert error[frequency < 0.1].max() < 0.05
    assert error[frequency > 0.5].max() > 0.2


def test_a_string_cut_is_the_same_string() -> None:
    system = DrillingSystem(DRIVE, (PIPE, COLLARS), Bit(40.0))
    for depth in (0.0, 700.0, 2000.0, 2060.0, 2100.0):
        above, below = cut((PIPE, COLLARS), depth)
        assert sum(section.length for section in above) == pytest.approx(depth)
        again = DrillingSystem(DRIVE, above + below, Bit(40.0))
        np.testing.assert_allclose(string_admittance(again, S), string_admittance(system, S), rtol=1e-9)


def test_a_zone_is_a_section_of_its_own() -> None:
    zoned = with_zone((PIPE, COLLARS), 1950.0, 80.0, 7.0)
    assert [section.length for section in zoned] == pytest.approx([1950.0, 50.0, 30.0, 70.0])
    assert [section.kappa for section in zoned] == pytest.approx([120.0, 840.0, 560.0, 80.0])
    assert [section.polar_moment for section in zoned] == [1.6e-5, 1.6e-5, 1.2e-4, 1.2e-4]


def test_where_a_zone_lies_shows_and_has_a_derivative() -> None:
    def mobility(top: float) -> np.ndarray:
        string = with_zone((PIPE, COLLARS), top, 150.0, 30.0)
        return command_mobility(DrillingSystem(DRIVE, string, Bit(40.0)), S)

    value, slopes = derivatives(mobility, np.array([900.0]))
    difference = (mobility(900.1) - mobility(899.9)) / 0.2
    np.testing.assert_allclose(slopes[0], difference, atol=1e-6 * np.abs(difference).max())
    assert np.max(np.abs(slopes[0] * 100 / value)) > 0.01


@pytest.mark.parametrize("depth", [-1.0, 2101.0, np.nan])
def test_a_cut_outside_the_string_is_refused(depth: float) -> None:
    with pytest.raises(SettingsError, match="from 0 to 2100"):
        cut((PIPE, COLLARS), depth)


def test_windows_that_cut_different_sections_are_refused() -> None:
    with pytest.raises(SettingsError, match="different windows"):
        cut((PIPE, COLLARS), np.array([[1900.0], [2050.0]]))


def test_a_taper_converges_with_second_order() -> None:
    def admittance(pieces: int) -> np.ndarray:
        string = tapered(Section(800.0, 1.6e-5, 100.0, 2e8), 6e-5, pieces)
        return string_admittance(DrillingSystem(DRIVE, string, Bit(40.0, 50.0)), S[:40])

    coarse, middle, fine = (admittance(pieces) for pieces in (20, 40, 80))
    ratio = np.abs(coarse - middle).max() / np.abs(middle - fine).max()
    assert 3.5 < ratio < 4.5

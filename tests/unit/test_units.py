"""Units as rig logs and data sheets give them → SI."""

import numpy as np
import pytest

from drillid.units import parse, to_si_factor


@pytest.mark.parametrize(
    ("unit", "si_unit", "factor"),
    [
        ("rpm", "rad/s", np.pi / 30),
        ("kN m", "N m", 1e3),
        ("ft-lbf", "N m", 1.3558179483314),
        ("ft", "m", 0.3048),
        ("L/min", "m^3/s", 1e-3 / 60),
        # a mass counts with standard gravity where a force is asked for
        ("t", "N", 9806.65),
        ("klbf", "N", 4448.2216152605),
    ],
)
def test_factors_are_those_of_the_definitions(unit: str, si_unit: str, factor: float) -> None:
    assert to_si_factor(unit, si_unit) == pytest.approx(factor, rel=1e-12)


def test_units_of_another_kind_and_unknown_ones_are_refused() -> None:
    with pytest.raises(ValueError, match="'psi' cannot be a unit of rad/s"):
        to_si_factor("psi", "rad/s")
    with pytest.raises(ValueError, match="'furlongz' is unknown"):
        to_si_factor("furlongz", "m")


def test_a_quantity_is_a_number_with_its_unit_or_bare_in_si() -> None:
    assert parse("40 ms", "s") == pytest.approx(0.04)
    assert parse(0.04, "s") == 0.04
    with pytest.raises(ValueError, match="lacks its unit"):
        parse("40", "s")
    with pytest.raises(ValueError, match="is not a number"):
        parse("forty ms", "s")

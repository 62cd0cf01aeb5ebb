"""Units as rig logs and data sheets give them → SI: what is read, and what is refused with its reason."""

import sys

import pytest

from drillid.units import parse, to_si_factor


@pytest.mark.parametrize(
    ("unit", "si_unit", "reason"),
    [
        ("psi", "rad/s", "'psi' cannot be a unit of rad/s"),
        ("rpm", "Hz", "'rpm' cannot be a unit of Hz"),
        ("furlongz", "m", "'furlongz' is unknown"),
        ("kNnm", "N m", "'kNnm' is unknown; did you mean 'kNm'"),
        ("1/s", "rad/s", "does not say whether it counts radians or revolutions"),
        ("Nm/(1/min)", "N m s/rad", "does not say whether it counts radians or revolutions"),
        ("ton", "N", "may be 1000 kg, 2000 lb or 2240 lb; write 't' for the metric ton"),
        ("Mlbs", "N", "may be a thousand or a million; write out which"),
        ("", "m", "is not a unit"),
        ("((m", "m", "is not a unit"),
        ("m)", "m", "is not a unit"),
        ("1/0", "m", "is not a unit"),
        ("rpm^99", "rad/s", "is not a unit"),
        ("rpm**(9**9**9)", "rad/s", "is not a unit"),
        ("__import__('os').getcwd()", "m", "is not a unit"),
        ("lambda: 1", "m", "is not a unit"),
        ("kN" * 40, "N", "is longer than 60 characters"),
        ("9e9 " * 14 + "m", "m", "is not a unit"),
    ],
)
def test_what_is_no_unit_of_the_kind_is_refused_with_its_reason(unit: str, si_unit: str, reason: str) -> None:
    with pytest.raises(ValueError, match="unit") as error:
        to_si_factor(unit, si_unit)
    assert reason in str(error.value)


def test_letters_of_another_case_are_read_where_one_unit_of_the_kind_fits_and_never_against_an_exact_one() -> None:
    assert to_si_factor("MN", "N") == 1e6
    assert to_si_factor("mN", "N") == 1e-3
    assert to_si_factor("kn", "N") == 1e3
    with pytest.raises(ValueError, match="cannot be a unit of N"):
        to_si_factor("mn", "N")


def test_units_of_the_field_are_read_without_importing_pint(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pint", None)
    to_si_factor.cache_clear()
    assert to_si_factor("kft.lbf", "N m") == pytest.approx(1355.8179483314)


def test_units_that_pint_alone_knows_are_read_too() -> None:
    assert to_si_factor("angstrom", "m") == pytest.approx(1e-10)
    assert to_si_factor("kilofurlong", "m") == pytest.approx(1000 * 660 * 1200 / 3937)


@pytest.mark.parametrize("unit", ["cft", "hft", "msft", "Tyard"])
def test_a_first_letter_but_k_is_no_prefix_of_what_pint_knows_by_the_others(unit: str) -> None:
    with pytest.raises(ValueError, match=f"the unit '{unit}' is unknown"):
        to_si_factor(unit, "m")


@pytest.mark.parametrize(
    ("text", "si_unit", "value"),
    [
        ("40 ms", "s", 0.04),
        ("139.7mm", "m", 0.1397),
        ("5.5 in", "m", 0.1397),
        ("5-1/2 in", "m", 0.1397),
        ("5 1/2 in", "m", 0.1397),
        ('12¼"', "m", 0.31115),
        ("½ in", "m", 0.0127),
        ("3%", "dimensionless", 0.03),
        (".04 s", "s", 0.04),
        ("38e3 N m s/rad", "N m s/rad", 38e3),
        ("-1 ms", "s", -0.001),
        ("50 1/s", "Hz", 50.0),
        ("50 1 / s", "Hz", 50.0),
    ],
)
def test_a_quantity_is_a_number_with_its_unit(text: str, si_unit: str, value: float) -> None:
    assert parse(text, si_unit) == pytest.approx(value, rel=1e-12)


def test_a_bare_number_is_in_si() -> None:
    assert parse(0.04, "s") == 0.04
    assert parse(3, "m") == 3.0


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("40", "lacks its unit; write it after the number, such as '40 s'"),
        ("forty ms", "is not a number with a unit of s"),
        ("0,04 s", "write a point before the decimals, and nothing between thousands"),
        ("1,500 s", "write a point before the decimals, and nothing between thousands"),
        ("1 500 s", "holds a further number after '1'; write nothing between thousands"),
        ("1\u00a0500 s", "holds a further number after '1'; write nothing between thousands"),
        ("5 1 / 2 s", "and a fraction as in '5-1/2 in'"),
        ("5.0 1/2 s", "and a fraction as in '5-1/2 in'"),
        ("2 5/8 3 s", "and a fraction as in '5-1/2 in'"),
        (True, "'True' is not a number"),
        (None, "'None' is not a number"),
    ],
)
def test_what_is_no_quantity_is_refused_with_its_reason(text: object, reason: str) -> None:
    with pytest.raises(ValueError, match="'") as error:
        parse(text, "s")
    assert reason in str(error.value)


def test_a_number_beyond_all_bounds_is_refused() -> None:
    with pytest.raises(ValueError, match="too large"):
        parse(10**400, "s")

"""A measured microstrip line obeys the equations of the drill string."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.microstrip import CONNECTED, DATA, PLAIN, fit_line, line_section, read_ends, read_touchstone, reflection
from drillid.errors import LogError
from drillid.physics.responses import laplace


@pytest.fixture(scope="module")
def ends() -> tuple[np.ndarray, dict[str, np.ndarray]]:
    if not DATA.is_dir():
        pytest.skip(f"the measured line is not at {DATA}")
    frequency, measured = read_ends()
    return frequency[::10], {end: seen[::10] for end, seen in measured.items()}


def test_connector_and_ends_explain_what_the_plain_line_leaves(ends: tuple[np.ndarray, dict[str, np.ndarray]]) -> None:
    plain, connected = (fit_line(ranges, *ends) for ranges in (PLAIN, CONNECTED))
    assert plain.misfit > 2 * connected.misfit
    assert connected.misfit < 0.0115
    assert connected.parameters["impedance_ohm"] == pytest.approx(50, abs=2)
    assert connected.parameters["load_ohm"] == pytest.approx(50, abs=1)


def test_a_fit_recovers_a_line_that_obeys_the_model() -> None:
    frequency = np.linspace(1e7, 3e9, 150)
    truth = {name: start for name, (start, _, _) in CONNECTED.items()} | {"impedance_ohm": 47.0, "delay_ns": 0.3}
    measured = {end: reflection(truth, end, laplace(frequency)) for end in ("open", "short", "load")}
    fit = fit_line(CONNECTED, frequency, measured)
    assert fit.misfit < 1e-5
    assert fit.parameters["impedance_ohm"] == pytest.approx(47.0, rel=1e-3)


def test_the_line_is_passive_and_ideal_ends_without_loss_reflect_all() -> None:
    s = laplace(np.linspace(1e7, 3e9, 50))
    lossy = {name: start for name, (start, _, _) in PLAIN.items()}
    assert np.all(np.abs(reflection(lossy, "open", s)) < 1)
    lossless = lossy | {"conductor_loss": 0.0, "dielectric_loss": 0.0}
    np.testing.assert_allclose(np.abs(reflection(lossless, "open", s)), 1, rtol=1e-9)
    assert line_section(lossless).characteristic_admittance == pytest.approx(1 / 50)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("# GHZ S RI R 75.0\n1 0 0\n", "impedance"),
        ("# GHZ S RI R 50.0\n1 0 0 0\n", "not understood"),
        ("# GHZ S RI R 50.0\n1 0 zero\n", "not understood"),
        ("# GHZ S RI R 50.0\n", "no reflection"),
    ],
)
def test_files_that_are_not_understood_are_refused(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "odd.s1p"
    path.write_text(text)
    with pytest.raises(LogError, match=said):
        read_touchstone(path)


def test_units_and_formats_are_those_of_the_option_line(tmp_path: Path) -> None:
    path = tmp_path / "polar.s1p"
    path.write_text("! polar\n# MHZ S MA R 50\n1 0.5 90\n2 1 180\n")
    frequency, reflected = read_touchstone(path)
    np.testing.assert_allclose(frequency, [1e6, 2e6])
    np.testing.assert_allclose(reflected, [0.5j, -1], atol=1e-12)

"""The paper's table 1, worked out apart from this project with 30 digits."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from drillid.physics.eight_parameters import KnownEquipment, drilling_system
from drillid.physics.equipment import Controller, DrillingSystem, Section, polar_moment
from drillid.physics.line import input_impedance
from drillid.physics.parameters import PARAMETERS
from drillid.physics.responses import bit_mobility, command_mobility, laplace
from drillid.physics.time_responses import bit_step_response

REFERENCE = Path(__file__).parents[4] / "shared" / "reference"
EQUIPMENT = KnownEquipment(Controller(1500.0, 800.0))

pytestmark = pytest.mark.skipif(not REFERENCE.exists(), reason=f"the reference tables are not at {REFERENCE}")


def table(name: str) -> pd.DataFrame:
    return pd.read_csv(REFERENCE / name)


def systems() -> list[tuple[str, DrillingSystem]]:
    rows = table("table1.csv").set_index("measurement")[list(PARAMETERS)]
    return [(str(name), drilling_system(row.to_numpy(), EQUIPMENT)) for name, row in rows.iterrows()]


@pytest.mark.parametrize("column", ["command", "bit_stiff", "bit_soft"])
def test_mobilities_agree_with_thirty_digit_arithmetic(column: str) -> None:
    reference = table("mobility.csv").set_index("measurement")
    for name, system in systems():
        expected = reference.loc[name]
        s = laplace(expected["frequency_hz"].to_numpy())
        value = command_mobility(system, s) if column == "command" else bit_mobility(system, s, stiff="stiff" in column)
        np.testing.assert_allclose(
            value, expected[f"{column}_re"].to_numpy() + 1j * expected[f"{column}_im"].to_numpy(), rtol=1e-9
        )


@pytest.mark.parametrize(("column", "stiff"), [("stiff", True), ("soft", False)])
def test_step_responses_agree_with_numerical_inverse_laplace_transform(column: str, stiff: bool) -> None:
    reference = table("step.csv").set_index("measurement")
    for name, system in systems():
        if name not in reference.index:
            continue
        expected = reference.loc[name]
        lags, bit_speed = bit_step_response(system, duration=16.0, interval=0.05, stiff=stiff)
        times = expected["time_s"].to_numpy()
        at = np.searchsorted(lags, times - 1e-9)
        np.testing.assert_allclose(lags[at], times, atol=1e-9)
        value, truth = bit_speed[at], expected[f"bit_speed_{column}_rad_s_per_nm"].to_numpy()
        early = times <= 7
        np.testing.assert_allclose(value[early], truth[early], rtol=1e-5)
        np.testing.assert_allclose(value[~early], truth[~early], atol=1e-6 * np.abs(truth).max())


def test_dips_and_peaks_of_row_a_are_where_the_paper_has_them() -> None:
    system = dict(systems())["A"]
    frequency = np.linspace(0.08, 1.9, 18201)
    amplitude = np.abs(command_mobility(system, laplace(frequency)))
    inner = slice(1, -1)
    dips = frequency[inner][(amplitude[inner] < amplitude[:-2]) & (amplitude[inner] < amplitude[2:])]
    peaks = frequency[inner][(amplitude[inner] > amplitude[:-2]) & (amplitude[inner] > amplitude[2:])]
    np.testing.assert_allclose(dips[:6], [0.155, 0.471, 0.796, 1.128, 1.466, 1.808], atol=0.0015)
    np.testing.assert_allclose(peaks[:6], [0.098, 0.208, 0.490, 0.815, 1.156, 1.505], atol=0.0015)


def test_modes_of_a_published_synthetic_well() -> None:
    """Aarsnes and Shor 2018, figure 8: clamped–free modes of pipe and collars."""
    pipe = Section(2500.0 - 230.0, polar_moment(0.146529, 0.123024), delta=1e5, shear_modulus=61e9)
    collars = Section(230.0, 8.494e-5, delta=1e5, shear_modulus=67e9)
    frequency = np.linspace(0.1, 2.0, 19001)
    s = laplace(frequency)
    impedance = np.zeros_like(s)
    for section in (pipe, collars):
        impedance = input_impedance(section, impedance, s)
    amplitude = np.abs(impedance)
    modes = frequency[1:-1][(amplitude[1:-1] > amplitude[:-2]) & (amplitude[1:-1] > amplitude[2:])]
    np.testing.assert_allclose(modes[:4], [0.226, 0.730, 1.293, 1.879], atol=0.003)

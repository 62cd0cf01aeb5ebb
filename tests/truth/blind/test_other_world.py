"""The second world's simulator: closed forms, their convergence, and what friction and gear must do."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.blind.other_world.elements import modes, propagator
from benchmarks.blind.other_world.relaxation import hysteresis, relaxing_drag, relaxing_hysteresis
from benchmarks.blind.other_world.rig import (
    FALLS,
    Blades,
    Contact,
    Control,
    Drive,
    Friction,
    Piece,
    Rock,
    Window,
    coupling,
)
from benchmarks.blind.other_world.simulate import Resolution, Simulation, simulate
from benchmarks.blind.other_world.theory import command_mobility, laplace, string_response
from drillid.arrays import Complex, Floats

REFERENCE = Path(__file__).parents[4] / "shared" / "reference"
PERIOD = 120.0
LINES = np.arange(6, 478, 4)
PIPE = Piece(2900.0, 1.6e-5, 200.0, 2.5e8)
COLLARS = Piece(100.0, 6e-5, 200.0, 2.5e8, inertia_below=40.0, damping_below=40.0)
USUAL = Resolution()
WINDOW = Window((PIPE, COLLARS), Control(1500.0, 800.0, 0.005), Drive(1100.0, 0.04), Rock(5000.0, 0.0, 2.0), 12.0, 50.0)


@pytest.fixture(scope="module")
def reference() -> pd.DataFrame:
    path = REFERENCE / "mobility.csv"
    if not path.is_file():
        pytest.skip(f"{path} is absent")
    table = pd.read_csv(REFERENCE / "table1.csv").rename(columns={"delay": "drive_delay"})
    return pd.read_csv(path).merge(table, on="measurement")


def response(result: Simulation) -> Complex:
    """Speed per sweep, both at the control's readings, at LINES in the last period."""
    readings = round(PERIOD / result.interval)
    speed, sweep = (np.fft.rfft(values[-readings:])[LINES] for values in (result.reading, result.sweep))
    return np.asarray(speed / sweep, dtype=complex)


def deviation(window: Window, resolution: Resolution = USUAL) -> Floats:
    """Relative deviation of a simulated command mobility from its closed form."""
    result = simulate(window, PERIOD, PERIOD, [1], resolution)
    return np.asarray(np.abs(response(result) / command_mobility(window, laplace(LINES / PERIOD)) - 1), dtype=float)


def rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(np.abs(values) ** 2)))


def _continuous(own: Complex, row: pd.Series, s: Complex) -> Complex:
    """Command mobility of reference rows under continuous control, from the string's admittance."""
    drive = np.exp(-s * row["drive_delay"])
    return np.asarray(drive / (row["inertia_td"] * s + own + drive * (1500 + 800 / s)), dtype=complex)


def _row_of(table: pd.DataFrame) -> tuple[pd.Series, tuple[Piece, ...], Complex, Complex]:
    row = table.iloc[0]
    string = (
        Piece(
            row["length"],
            row["polar_moment"],
            row["kappa"],
            row["delta"],
            inertia_below=row["inertia_bha"],
            damping_below=row["damping_bha"],
        ),
    )
    s = laplace(table["frequency_hz"].to_numpy())
    return row, string, s, table["command_re"].to_numpy() + 1j * table["command_im"].to_numpy()


def test_closed_forms_are_the_reference(reference: pd.DataFrame) -> None:
    for _, table in reference.groupby("measurement"):
        row, string, s, published = _row_of(table)
        np.testing.assert_allclose(_continuous(string_response(string, s)[0], row, s), published, rtol=1e-12)


def test_modes_converge_to_the_reference_with_the_square_of_the_element(reference: pd.DataFrame) -> None:
    """The error of the propagated modes is that of their poles and residues, as each step is exact."""
    worst = []
    for _, table in reference.groupby("measurement"):
        row, string, s, published = _row_of(table)
        errors = []
        for element in (100.0, 50.0, 25.0):
            now = modes(string, row["inertia_td"], element)
            step = propagator(now, np.zeros(1), 0.005)
            residues = step.observe[0] * (step.from_modal @ now.response @ now.ports(np.zeros(1))[0])
            free = (residues / (s[:, None] - step.poles)).sum(axis=1)
            free = (free + (residues.conj() / (s[:, None] - step.poles.conj())).sum(axis=1)) / 2
            drive = np.exp(-s * row["drive_delay"])
            errors.append(np.abs(drive * free / (1 + drive * (1500 + 800 / s) * free) / published - 1).max())
        worst.append(errors)
        assert np.all(np.abs(np.log2(np.divide(errors[:-1], errors[1:])) - 2) < 0.2)
    assert np.max(worst, axis=0)[-1] < 3e-4


def test_the_simulated_rig_converges_to_its_closed_form() -> None:
    """0.02 % as it is used; of second order in the element's length."""
    errors = [rms(deviation(WINDOW, Resolution(element=element))) for element in (160.0, 80.0, 40.0)]
    assert np.all(np.abs(np.log2(np.divide(errors[:-1], errors[1:])) - 2) < 0.3)
    assert rms(deviation(WINDOW)) < 2e-4


@pytest.mark.parametrize("interval", [0.01, 0.02, 0.05])
def test_control_that_samples_and_holds_has_its_closed_form(interval: float) -> None:
    assert deviation(WINDOW.with_control(interval=interval)).max() < 3e-3


MOTOR = (PIPE, replace(COLLARS, inertia_below=30.0), replace(coupling(2e4), inertia_below=60.0))
RIPPLED = (*(replace(PIPE, length=290.0, moment=1.6e-5 * (1 + 0.3 * (-1) ** number)) for number in range(10)), COLLARS)
VARIANTS = {
    "lag": (WINDOW.with_drive(lag=0.03), 1e-3),
    "speed filter": (WINDOW.with_control(speed_filter=0.03), 1e-3),
    "speed filter before rare readings": (WINDOW.with_control(interval=0.03, speed_filter=0.01), 1e-4),
    "torque filter": (WINDOW.with_control(torque_filter=0.03), 1e-3),
    "notch": (WINDOW.with_control(interval=0.03, notch=1.5), 1e-3),
    "resonant drive": (WINDOW.with_drive(resonance=4.0), 3e-3),
    "blades": (replace(WINDOW, blades=Blades(5, 800.0)), 3e-3),
    "motor": (replace(WINDOW, string=MOTOR), 1e-3),
    "structural damping": (replace(WINDOW, string=(replace(PIPE, loss_factor=0.1), COLLARS)), 1e-3),
    "boundary layer": (replace(WINDOW, string=(replace(PIPE, root_drag=1500.0), COLLARS)), 1e-3),
    "ripples": (replace(WINDOW, string=RIPPLED), 1e-3),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_each_part_of_a_rig_has_its_closed_form(name: str) -> None:
    window, tolerance = VARIANTS[name]
    assert rms(deviation(window)) < tolerance


def test_relaxations_are_their_laws_in_the_band_and_give_no_energy() -> None:
    s = 2j * np.pi * np.geomspace(0.05, 5.0, 100)
    drag, steel = relaxing_drag(), relaxing_hysteresis()
    np.testing.assert_allclose(drag(s), np.sqrt(s), rtol=2.5e-3)
    np.testing.assert_allclose(steel(s), hysteresis(s), atol=8e-3)
    everywhere = 2j * np.pi * np.geomspace(1e-4, 1e4, 200)
    assert (drag(everywhere).real > 0).all()
    assert (steel(everywhere).imag > 0).all()


@pytest.mark.parametrize("fall", FALLS)
@pytest.mark.parametrize("law", ["karnopp", "lugre"])
def test_friction_that_falls_with_speed_takes_damping_away(law: str, fall: str) -> None:
    rubbing = Friction.with_steepness(law, fall, 2000.0, 30.0, 12.0)
    assert rms(deviation(replace(WINDOW, bit_friction=rubbing))) < 5e-3
    wall = Friction.with_steepness(law, fall, 200.0, 0.5, 12.0)
    contacts = tuple(Contact((place + 0.5) / 12, wall) for place in range(12))
    assert rms(deviation(replace(WINDOW, contacts=contacts))) < 2e-3


@pytest.mark.parametrize("law", ["karnopp", "dahl", "lugre"])
def test_a_bit_that_the_rock_holds_stands(law: str) -> None:
    """A slow bit on rock of much more friction at rest sticks and slips; it never turns backward for long."""
    rubbing = Friction(law, 3000.0, 0.0 if law == "dahl" else 9000.0, "gaussian", 3.0)
    result = simulate(replace(WINDOW, bit_friction=rubbing, speed=4.0, sweep=500.0), 0.0, 60.0, [1])
    late = result.bit_speed[result.bit_speed.size // 2 :]
    assert np.isfinite(late).all()
    standing = np.mean(np.abs(late) < 0.05 * 4.0)
    assert standing > 0.2 if law != "dahl" else standing < 0.05
    assert late.mean() == pytest.approx(4.0, rel=0.15)


def test_play_opens_where_the_torque_changes_sign_and_nowhere_else() -> None:
    """A gear in contact is a rigid one."""
    pressed, loose = (replace(WINDOW, sweep=800.0, rock=replace(WINDOW.rock, mean=mean)) for mean in (9000.0, 0.0))
    for window, apart in ((pressed, False), (loose, True)):
        rigid, played = (simulate(window.with_drive(play=play), 0.0, 60.0, [1]) for play in (0.0, 0.05))
        change = rms(played.speed - rigid.speed) / np.std(rigid.speed)
        assert change > 0.03 if apart else change < 2e-3


def test_a_limited_drive_winds_no_integral_up() -> None:
    """Both ways against it keep the mean speed where the limit is above the mean load."""
    for gain in (0.0, 5.0):
        limited = WINDOW.with_drive(limit=6500.0).with_control(windup_gain=gain)
        result = simulate(replace(limited, sweep=500.0), PERIOD, PERIOD, [1])
        assert result.command.max() > 6500.0
        assert result.speed.mean() == pytest.approx(12.0, rel=0.05)


def test_a_growing_string_slows_its_modes() -> None:
    """The response of a string that grows is that of its mean length, to first order, and it keeps turning smoothly."""
    growing = replace(WINDOW, growth=20.0)
    assert rms(deviation(growing)) < 0.03
    result = simulate(replace(growing, sweep=0.0), PERIOD, PERIOD, [1])
    assert np.abs(result.speed - 12.0).max() < 0.02


def test_a_window_is_simulated_five_hundred_times_faster_than_it_lasts() -> None:
    rubbing = tuple(Contact((place + 0.5) / 10, Friction("lugre", 100.0)) for place in range(10))
    window = replace(
        WINDOW, string=(replace(PIPE, length=4900.0), COLLARS), contacts=rubbing, rock=Rock(5e3, 300.0, 2.0)
    )
    begin = time.process_time()
    simulate(window, PERIOD, 600.0, [1])
    assert 720.0 / (time.process_time() - begin) > 500.0

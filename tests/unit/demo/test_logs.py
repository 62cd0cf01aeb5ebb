"""The demo's logs are what its rig descriptions and sheets say, faults included, and follow the seed."""

import io
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from drillid.arrays import Floats
from drillid.config.rig import CHANNEL_UNITS, Channel, Rig
from drillid.config.settings import Settings, SimulateSettings
from drillid.demo.wells import STAND_LENGTH, WELLS, write_demo_logs
from drillid.errors import LogError, SettingsError
from drillid.excitation.torques import exponential_sweeps
from drillid.units import to_si_factor

ROOT = Path(__file__).parents[3]
SHORT = SimulateSettings(drilling_s=60.0, connection_s=40.0)
ROWS = 5000
SUFFIXES = {"D01": "parquet", "D02": "csv", "D03": "csv.gz"}


@pytest.fixture(scope="module")
def demo() -> Settings:
    return Settings.from_yaml(ROOT / "config/demo/config.yaml")


@pytest.fixture(scope="module")
def rigs(demo: Settings) -> dict[str, Rig]:
    sheet = pd.read_csv(ROOT / demo.wells, sep="\t", index_col="well")
    return {str(well): Rig.from_yaml(ROOT / demo.rigs / f"{rig}.yaml") for well, rig in sheet["rig"].items()}


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, pd.DataFrame]:
    """One short log of each well, as written."""
    folder = tmp_path_factory.mktemp("raw")
    paths = {well: folder / well / f"{well}_20250601T0600.{suffix}" for well, suffix in SUFFIXES.items()}
    for well, path in paths.items():
        write_demo_logs(well, [path], SHORT)
    return {well: read(path) for well, path in paths.items()}


def read(path: Path) -> pd.DataFrame:
    return pd.read_parquet(path) if path.suffix == ".parquet" else pd.read_csv(path)


def channel(log: pd.DataFrame, rig: Rig, name: Channel) -> Floats:
    """One channel in SI units, as a reader makes it of the rig description."""
    column = rig.channels[name]
    assert column is not None
    assert column.unit is not None
    return log[column.column].to_numpy() * to_si_factor(column.unit, CHANNEL_UNITS[name])


def test_sheets_and_rig_descriptions_belong_to_the_wells(demo: Settings, rigs: dict[str, Rig]) -> None:
    sheet = pd.read_csv(ROOT / demo.logs, sep="\t")
    assert set(rigs) == set(sheet["well"]) == set(WELLS)
    assert sheet["log"].is_unique
    for well, log in zip(sheet["well"], sheet["log"], strict=True):
        assert log.startswith(f"{demo.results}/raw/{well}/{well}_")
        assert log.endswith(SUFFIXES[well])


@pytest.mark.parametrize("well", WELLS)
def test_rig_description_names_the_columns_of_the_recorder(well: str, rigs: dict[str, Rig]) -> None:
    recorder = WELLS[well].log_writer
    described = {name: (column.column, column.unit) for name, column in rigs[well].channels.items()}
    assert described == {column.channel: (column.header, column.unit) for column in recorder.columns}
    assert rigs[well].time.column == recorder.time_header
    assert rigs[well].time.zone == (recorder.zone or "UTC")


@pytest.mark.parametrize("well", WELLS)
def test_truth_lies_within_the_tolerances_on_the_data_sheet(well: str, rigs: dict[str, Rig]) -> None:
    rig, truth = rigs[well], WELLS[well]
    assert rig.drive_delay is not None
    assert rig.top_drive_inertia is not None
    assert rig.pipe is not None
    assert rig.controller is not None
    assert abs(truth.top_drive.delay - rig.drive_delay.value) < 2 * rig.drive_delay.tolerance
    assert truth.top_drive.inertia == pytest.approx(rig.top_drive_inertia.value, rel=2 * rig.top_drive_inertia.relative)
    assert rig.controller.proportional == truth.top_drive.controller.proportional
    assert rig.controller.integral == truth.top_drive.controller.integral
    assert rig.controller.speed_filter == truth.top_drive.controller.speed_filter
    assert (rig.pipe.outer_diameter, rig.pipe.inner_diameter) == pytest.approx(
        (truth.pipe.outer_diameter, truth.pipe.inner_diameter)
    )
    collars = rig.collars_at(truth.first_depth)
    assert collars is not None
    assert collars.length == truth.collars_length
    assert collars.outer_diameter == pytest.approx(truth.collars.outer_diameter)


def test_only_stands_four_and_five_of_the_first_well_are_washed_out() -> None:
    for name, well in WELLS.items():
        changed = [stand + 1 for stand in range(7) if well.system(stand).bit != well.bit]
        assert changed == ([4, 5] if name == "D01" else [])
        lengths = [sum(section.length for section in well.system(stand).string) for stand in range(3)]
        np.testing.assert_allclose(np.diff(lengths), STAND_LENGTH)


@pytest.mark.parametrize("well", WELLS)
def test_log_holds_drilling_and_then_standstill(well: str, logs: dict[str, pd.DataFrame], rigs: dict[str, Rig]) -> None:
    log, rig, truth = logs[well], rigs[well], WELLS[well]
    time = seconds(log, rig)
    drilling, standing = time < 59, time > 95
    depth = channel(log, rig, "hole_depth")
    assert depth[0] == pytest.approx(truth.first_depth, abs=0.02)
    assert depth[-1] == pytest.approx(truth.first_depth + STAND_LENGTH, abs=0.02)
    assert np.median(channel(log, rig, "speed")[drilling]) == pytest.approx(truth.speed, rel=0.02)
    assert np.all(channel(log, rig, "speed")[standing] == 0)
    assert np.all(channel(log, rig, "torque_sweep")[standing] == 0)
    assert np.all(channel(log, rig, "flow")[standing] == 0)
    assert channel(log, rig, "torque_command")[drilling].mean() == pytest.approx(truth.bit_torque, rel=0.1)
    assert np.all(channel(log, rig, "bit_depth")[standing] < depth[-1] - 5)
    sweep = exponential_sweeps(time, truth.sweep_amplitude)[drilling]
    np.testing.assert_allclose(channel(log, rig, "torque_sweep")[drilling], sweep, atol=60 if jittered(well) else 1)


def jittered(well: str) -> bool:
    return WELLS[well].log_writer.faults.jitter > 0


def seconds(log: pd.DataFrame, rig: Rig) -> Floats:
    """Time since the nominal start, s, read as the rig description's clock says."""
    stamps = pd.to_datetime(log[rig.time.column])
    stamps = stamps if stamps.dt.tz is not None else stamps.dt.tz_localize(rig.time.zone)
    elapsed = (stamps - pd.Timestamp("2025-06-01T06:00Z")).dt.total_seconds()
    return np.asarray(elapsed, dtype=np.float64)


def test_logged_command_is_sweep_plus_what_the_controller_makes_of_the_logged_speed(
    logs: dict[str, pd.DataFrame], rigs: dict[str, Rig]
) -> None:
    """T_com − T_sweep − P e grows by I ∫ e dt."""
    log, rig = logs["D01"], rigs["D01"]
    error = channel(log, rig, "speed_set") - channel(log, rig, "speed")
    gains = WELLS["D01"].top_drive.controller
    held = channel(log, rig, "torque_command") - channel(log, rig, "torque_sweep") - gains.proportional * error
    integral = gains.integral * 0.02 * (np.cumsum(error) - (error + error[0]) / 2)
    drilled = slice(0, 2900)
    np.testing.assert_allclose((held - held[0])[drilled], integral[drilled], atol=3)


def test_faults_are_those_stated(logs: dict[str, pd.DataFrame], rigs: dict[str, Rig]) -> None:
    assert len(logs["D01"]) == ROWS
    assert np.unique(np.diff(seconds(logs["D01"], rigs["D01"])).round(9)).tolist() == [0.02]

    faults = WELLS["D02"].log_writer.faults
    time, speed = seconds(logs["D02"], rigs["D02"]), logs["D02"]["speed"].to_numpy()
    intervals = np.diff(time)
    assert intervals.max() == pytest.approx(faults.gap, abs=0.05)
    assert time[intervals.argmax()] == pytest.approx(SHORT.drilling_s / 2 - faults.gap / 2, abs=0.05)
    assert np.all(intervals > 0)
    assert np.std(time - 0.02 * np.rint(time / 0.02)) == pytest.approx(faults.jitter, rel=0.1)
    spikes = np.count_nonzero(speed[time < SHORT.drilling_s] == 0)
    assert 0 < spikes <= faults.speed_spikes

    lost = ROWS - len(logs["D03"])
    assert 0 < lost < 10 * ROWS * WELLS["D03"].log_writer.faults.dropped_share


def test_logs_follow_seed_well_and_stand(tmp_path: Path) -> None:
    settings = SimulateSettings(drilling_s=2.0, connection_s=0.0)

    def written(name: str, settings: SimulateSettings = settings) -> list[bytes]:
        paths = [tmp_path / name / f"D03_20250601T06{minute}0.csv.gz" for minute in (0, 3)]
        write_demo_logs("D03", paths, settings)
        return [path.read_bytes() for path in paths]

    first = written("first")
    assert written("again") == first
    assert written("other", settings.model_copy(update={"seed": 1}))[0] != first[0]
    speeds = [pd.read_csv(io.BytesIO(content), compression="gzip")["Rotary Speed (rpm)"] for content in first]
    assert not speeds[0].equals(speeds[1])


def test_unknown_wells_and_unusable_names_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="Use one of D01, D02, D03"):
        write_demo_logs("D99", [tmp_path / "D99_20250601T0600.csv"], SHORT)
    with pytest.raises(LogError, match="must end in its start"):
        write_demo_logs("D01", [tmp_path / "D01.csv"], SimulateSettings(drilling_s=1.0, connection_s=0.0))

"""Unknown logs: what they hold is told, the sweep is found by its signal, and the draft reads them as it is."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from typer.testing import CliRunner

from drillid.commands import app
from drillid.config.listing import Well
from drillid.config.rig import Clock, LogFile, Rig
from drillid.config.settings import Settings
from drillid.datasets.store import WellFolders
from drillid.inspection.draft import file_patterns
from drillid.inspection.inspect import Inspection, inspect
from drillid.inspection.sweep import find_sweep
from drillid.records.stage import process
from tests.raw_logs import RATE, START, drilling, save
from tests.unit.records.test_joining import slow_log, whole_log

NAMES = {
    "TQ": "Surface Torque (kN.m)",
    "SWEEP": "AUX 3 (kN.m)",
    "RPM": "Rotary RPM",
    "SET": "RPM Setpoint",
    "HOLE": "Hole Depth (ft)",
    "BIT": "Bit Depth (ft)",
    "FLOW": "Flow In (L/min)",
}
AT = np.arange(0, 120, 1 / RATE)
STAMPS = (AT * 1e9).round().astype(np.int64)
SWEEP = 500 * np.sin(2 * np.pi * (0.1 + 0.05 * np.mod(AT, 40)) * np.mod(AT, 40))


def inspected(*logs: Path, **clock: str) -> Inspection:
    settings = Settings().model_copy(update={"windows": Settings().windows.model_copy(update={"length_s": 60.0})})
    return inspect(logs, "Rig", Clock(**clock), LogFile(), settings)  # type: ignore[arg-type]


def test_a_draft_that_lacks_a_column_says_so_and_curves_are_known_by_their_aliases(tmp_path: Path) -> None:
    curves = "".join(
        f"<logCurveInfo><mnemonic>{name}</mnemonic><mnemAlias>{alias}</mnemAlias><unit>{unit}</unit></logCurveInfo>"
        for name, alias, unit in (("TIME", "", ""), ("S1", "RPMA", "rpm"), ("S2", "DMEA", "m"))
    )
    rows = "".join(f"<data>2025-03-04T06:00:{second:02d}Z,{second},1500</data>" for second in range(30))
    (tmp_path / "log.xml").write_text(f"<logs><log>{curves}<logData>{rows}</logData></log></logs>")
    found = inspected(tmp_path / "log.xml")
    assert {name: guess.column for name, guess in found.files[0].channels.items()} == {
        "speed": "S1",
        "hole_depth": "S2",
    }
    [(where, what, remedy)] = found.problems
    assert (where, what.partition(" yet")[0]) == ("draft", "has no column for torque_sweep")
    assert "'?'" in remedy


def test_the_draft_reads_the_log_as_it_is(tmp_path: Path) -> None:
    path = save(whole_log().rename(columns=NAMES), tmp_path / "log.csv")
    found = inspected(path)
    (contents,) = found.files
    assert {name: guess.column for name, guess in contents.channels.items()} == {
        "torque_command": NAMES["TQ"],
        "torque_sweep": NAMES["SWEEP"],
        "speed": NAMES["RPM"],
        "speed_set": NAMES["SET"],
        "hole_depth": NAMES["HOLE"],
        "bit_depth": NAMES["BIT"],
        "flow": NAMES["FLOW"],
    }
    assert contents.rate == pytest.approx(RATE)
    assert contents.sweep is not None
    assert contents.sweep.period_s == 40.0
    assert contents.sweep.low_hz < 0.15
    assert 3.5 < contents.sweep.high_hz < 4.5
    assert found.windows == 6
    assert found.problems == ()
    (tmp_path / "rig.yaml").write_text(found.draft)
    rig = Rig.from_yaml(tmp_path / "rig.yaml")
    folders = WellFolders(tmp_path / "results", "W1")
    assert process(Well("W1", rig, (path,)), folders, Settings()) == []
    records = folders.read("records", "records")
    np.testing.assert_allclose(records["torque_sweep"], whole_log()["SWEEP"] * 1e3, rtol=1e-5, atol=1e-3)
    assert "check the unit: the file states none" in found.draft


@pytest.mark.parametrize(
    ("hole", "feet", "flow", "torque", "other"),
    [("Hole Depth (ft)", "Bit Depth (ft)", "Flow In (gpm)", "ft-lbf", "N m"), ("Hole", "Bit", "Flow", "N m", "ft-lbf")],
)
def test_torques_without_unit_are_in_the_system_of_the_other_channels(
    tmp_path: Path, hole: str, feet: str, flow: str, torque: str, other: str
) -> None:
    log = drilling(30)
    log[["TQ", "SWEEP"]] *= 1e3
    names = {"TQ": "Torque", "SWEEP": "Injected", "SET": "RPM Setpoint", "HOLE": hole, "BIT": feet, "FLOW": flow}
    draft = inspected(save(log.rename(columns=names), tmp_path / "log.csv")).draft
    drafted = yaml.safe_load(draft)["channels"]
    assert (drafted["torque_command"]["unit"], drafted["torque_sweep"]["unit"]) == (torque, torque)
    line = next(line for line in draft.splitlines() if "torque_command" in line)
    assert line.endswith(f"check the unit: the file states none, this one fits the size, and so would {other}")


@pytest.mark.parametrize("sweep", ["Injected", "Injected [kft-lbf]"])
def test_torques_in_thousands_of_foot_pounds_are_told_by_the_other_channels(tmp_path: Path, sweep: str) -> None:
    log = drilling(30)
    log[["TQ", "SWEEP"]] /= 1.3558
    names = {"TQ": "Torque", "SWEEP": sweep, "SET": "RPM Setpoint", "HOLE": "Hole Depth (ft)", "BIT": "Bit Depth (ft)"}
    draft = inspected(save(log.rename(columns=names), tmp_path / "log.csv")).draft
    drafted = yaml.safe_load(draft)["channels"]
    assert (drafted["torque_command"]["unit"], drafted["torque_sweep"]["unit"]) == ("kft-lbf", "kft-lbf")
    line = next(line for line in draft.splitlines() if "torque_command" in line)
    assert "and so would kN m" in line


def test_units_at_the_end_of_names_are_taken(tmp_path: Path) -> None:
    names = {"TQ": "TQ_CMD_kNm", "SWEEP": "TQ_INJ_kNm", "SET": "RPM_SET", "HOLE": "DMEA_ft"}
    names |= {"BIT": "DBTM_ft", "FLOW": "FLOW_lpm"}
    found = inspected(save(drilling(30).rename(columns=names), tmp_path / "log.csv"))
    drafted = yaml.safe_load(found.draft)["channels"]
    assert {name: column["unit"] for name, column in drafted.items()} == {
        "torque_command": "kNm",
        "torque_sweep": "kNm",
        "speed": "rpm",
        "speed_set": "rpm",
        "hole_depth": "ft",
        "bit_depth": "ft",
        "flow": "lpm",
    }
    assert drafted["hole_depth"]["column"] == "DMEA_ft"


def test_a_sweep_is_found_though_its_rows_share_stamps(tmp_path: Path) -> None:
    log = whole_log().rename(columns=NAMES)
    save(log.assign(Time=log["Time"].dt.floor("s")), tmp_path / "log.csv")
    [found] = inspected(tmp_path / "log.csv").files
    assert found.rate == pytest.approx(RATE, rel=1e-3)
    assert found.channels["torque_sweep"].column == NAMES["SWEEP"]
    assert any("50 rows share each stamp" in what for what, _ in found.notes)


def test_slow_logs_are_drafted_as_logs_of_another_shape(tmp_path: Path) -> None:
    log = whole_log()
    fast = save(log.rename(columns=NAMES)[["Time", *list(NAMES.values())[:4]]], tmp_path / "stand 1.csv")
    slow = [
        save(slow_log(log, 37.4).rename(columns={"Hole": "DMEA (m)", "Speed": "RPMA"}), tmp_path / "1_depth.csv"),
        save(slow_log(whole_log(START + pd.Timedelta(days=1))), tmp_path / "2_depth.csv"),
    ]
    found = inspected(fast, slow[0])
    assert [other["files"] for other in yaml.safe_load(found.draft)["other_logs"]] == ["1_depth.csv"]
    assert found.windows == 6
    assert any("its clock differs from this log's by +37.4" in what for _, what, _ in found.problems)
    renamed = slow_log(whole_log(START + pd.Timedelta(days=1))).rename(columns={"Hole": "DMEA (m)", "Speed": "RPMA"})
    save(renamed, slow[1])
    assert [other["files"] for other in yaml.safe_load(inspected(fast, *slow).draft)["other_logs"]] == ["*_depth.csv"]


def test_the_draft_tells_slow_logs_from_fast_ones_of_the_same_ending(tmp_path: Path) -> None:
    logs = [whole_log(START + pd.Timedelta(days=day)) for day in range(2)]
    fast = [
        save(log.rename(columns=NAMES)[["Time", *list(NAMES.values())[:4]]], tmp_path / f"fast_{day}.csv")
        for day, log in enumerate(logs)
    ]
    slow = [
        save(slow_log(log).rename(columns={"Hole": "DMEA (m)"}), tmp_path / f"depth_{day}.csv")
        for day, log in enumerate(logs)
    ]
    found = inspected(*fast, *slow)
    assert [other["files"] for other in yaml.safe_load(found.draft)["other_logs"]] == ["depth_*.csv"]
    assert found.windows == 12


@pytest.mark.parametrize(
    ("slow", "others", "patterns"),
    [
        ("depth.csv", "fast.csv", "depth.csv"),
        ("d[1].csv", "fast.csv", "d[[]1].csv"),
        ("depth_1.csv depth_2.csv", "fast_1.csv fast_2.csv", "depth_*.csv"),
        ("depth_1.csv depth_12.csv", "fast_1.csv", "depth_*.csv"),
        ("depth_0600.csv depth_0630.csv", "fast_0600.csv", "depth_*.csv"),
        ("depth_20250303T0600Z.csv depth_20250303T0630Z.csv", "fast.csv", "depth_*.csv"),
        ("W1_slow_0600.csv W1_slow_0630.csv", "W1_0600.csv", "W1_slow_*.csv"),
        ("2025-03-03_depth.csv 2025-03-04_depth.csv", "2025-03-03_fast.csv", "*_depth.csv"),
        ("1.7z 2.7z", "fast.csv", "*.7z"),
        ("depth_1 depth_2", "fast.csv", "depth_*"),
        ("0601.csv 0602.csv", "0701.csv", "060*.csv"),
        ("1.csv 3.csv", "2.csv", "1.csv 3.csv"),
        ("Depth_1.csv Depth_2.csv", "DEPTH_FAST.CSV fast.csv", "Depth_1.csv Depth_2.csv"),
        ("slow/1.csv slow/2.csv", "fast/1.csv fast/2.csv", "slow/*.csv"),
        ("slow/1.csv", "fast/1.csv", "slow/1.csv"),
        ("a/1.csv b/1.csv", "c/1.csv", "a/1.csv b/1.csv"),
    ],
)
def test_patterns_of_slow_logs_match_them_and_no_other_file(slow: str, others: str, patterns: str) -> None:
    group, rest = ([Path("/data") / name for name in text.split()] for text in (slow, others))
    assert [pattern for pattern, _ in file_patterns(group, rest)] == patterns.split()


def test_what_was_decided_about_times_is_stated_in_the_draft(tmp_path: Path) -> None:
    log = drilling(30).rename(columns=NAMES)
    stamps = (log["Time"] + pd.Timedelta(days=21)).dt.strftime("%d/%m/%Y %H:%M:%S.%f")
    path = tmp_path / "log.csv"
    log.rename(columns={"Time": "Tid"}).assign(Tid=stamps).to_csv(path, index=False, sep=";", decimal=",")
    drafted = yaml.safe_load(inspected(path, zone="Europe/Oslo").draft)
    assert drafted["time"] == {"column": "Tid", "format": "day first", "zone": "Europe/Oslo"}
    assert drafted["file"] == {"decimal": ","}


def test_the_sweep_is_found_by_its_signal_among_others() -> None:
    noise = np.random.default_rng(5)
    columns = {
        "Torque": 9000 + SWEEP + noise.normal(0, 200, AT.size),
        "Vibration": noise.normal(0, 300, AT.size),
        "Tone": 400 * np.sin(2 * np.pi * AT),
        "Weight": 1e5 + noise.normal(0, 1e3, AT.size),
        "CH7": SWEEP,
    }
    found = find_sweep(columns, {}, STAMPS, RATE)
    assert found is not None
    assert (found.column, found.period_s) == ("CH7", 40.0)
    assert found.rms == pytest.approx(500 / np.sqrt(2), rel=0.05)
    assert find_sweep({name: values for name, values in columns.items() if name != "CH7"}, {}, STAMPS, RATE) is None
    assert find_sweep(columns, {"CH7": "rpm"}, STAMPS, RATE) is None, "what is in rpm is no torque"


def test_a_sweep_is_found_beside_a_gap() -> None:
    broken, by_row = np.delete(SWEEP, np.s_[700:917]), STAMPS[:-217]
    assert find_sweep({"CH7": broken}, {}, by_row, RATE) is None
    found = find_sweep({"CH7": broken}, {}, by_row, RATE, np.array([699]))
    assert found is not None
    assert found.period_s == 40.0


def test_a_sweep_is_found_though_rows_are_missing_here_and_there() -> None:
    kept = np.flatnonzero(np.random.default_rng(7).random(AT.size) > 0.002)
    late = np.random.default_rng(8).integers(0, 4_000_000, kept.size)
    rate = kept.size / 120
    found = find_sweep({"CH7": SWEEP[kept]}, {}, STAMPS[kept] + late, rate)
    assert found is not None
    assert found.period_s == 40.0
    assert find_sweep({"CH7": SWEEP[kept]}, {}, STAMPS[: kept.size], rate) is None, "the rows alone do not repeat"


def test_rows_of_one_time_hold_no_sweep() -> None:
    assert find_sweep({"SWEEP": SWEEP}, {}, np.zeros_like(STAMPS), 0.0) is None


def test_a_sweep_that_never_repeats_is_found_by_its_name_and_band() -> None:
    rough = np.convolve(np.random.default_rng(6).normal(size=AT.size + 14), np.hanning(15), "valid")
    random = rough - np.convolve(rough, np.full(101, 1 / 101), "same")
    assert find_sweep({"CH7": random}, {}, STAMPS, RATE) is None
    found = find_sweep({"TQ_INJECTED": random, "CH7": random}, {}, STAMPS, RATE)
    assert found is not None
    assert (found.column, found.period_s) == ("TQ_INJECTED", 0.0)


def test_why_a_column_with_a_unit_holds_no_numbers_is_told(tmp_path: Path) -> None:
    log = drilling(60).rename(columns=NAMES).astype({"Flow In (L/min)": object})
    log.loc[100, "Flow In (L/min)"] = "broken"
    (contents,) = inspected(save(log, tmp_path / "log.csv")).files
    assert contents.others == ("Flow In (L/min)",)
    assert any("row 101: 'broken' is not a number" in what for what, _ in contents.notes)


def test_gaps_text_and_what_is_missing_are_told(tmp_path: Path) -> None:
    log = drilling(60).rename(columns=NAMES).assign(Activity="drilling")
    log.loc[100:399, "Flow In (L/min)"] = np.nan
    (contents,) = inspected(save(log.drop(index=range(1000, 1500)), tmp_path / "log.csv")).files
    assert contents.others == ("Activity",)
    assert [seconds for _, seconds in contents.gaps] == [pytest.approx(10.02)]
    assert {column.name: round(column.missing, 2) for column in contents.columns}["Flow In (L/min)"] == 0.12
    assert contents.rate == pytest.approx(RATE, rel=1e-3)


def test_the_command_tells_drafts_and_writes(tmp_path: Path) -> None:
    log = save(drilling(30).rename(columns=NAMES), tmp_path / "log.csv")
    run = CliRunner().invoke(app, ["inspect", str(log), "--output", str(tmp_path / "rigs" / "r.yaml")])
    assert run.exit_code == 0, run.output
    assert "sweep in column 'AUX 3 (kN.m)': does not repeat" not in run.stdout
    assert Rig.from_yaml(tmp_path / "rigs" / "r.yaml").name == "Rig"
    told = json.loads(CliRunner().invoke(app, ["inspect", str(log), str(tmp_path / "none.csv"), "--json"]).stdout)
    assert told["files"][0]["channels"]["speed"] == {
        "column": "Rotary RPM",
        "unit": "rpm",
        "guessed": True,
        "others": ["deg/s"],
    }
    assert [row["what"] for row in told["refused"]] == ["does not exist"]
    assert yaml.safe_load(told["draft"])["channels"]["hole_depth"] == {"column": "Hole Depth (ft)", "unit": "ft"}
    refused = CliRunner().invoke(app, ["inspect", str(tmp_path / "none.csv")])
    assert refused.exit_code == 1
    assert "does not exist" in refused.stderr

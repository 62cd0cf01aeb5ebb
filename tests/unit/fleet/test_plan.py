"""How wells are laid out in jobs."""

import json
import shutil
from pathlib import Path

import pytest

from drillid.config.listing import Listing
from drillid.config.settings import FitsSettings, FleetSettings, Settings, SimulateSettings
from drillid.errors import SettingsError
from drillid.fleet.manifest import KEY, write_manifest
from drillid.fleet.plan import Plan


def plan(folder: Path, processes: int, **sizes: int) -> Plan:
    """One well a log of that many MB, 'name_csv' being the file 'name.csv'; the last well's log is missing."""
    wells = {}
    for name, size in sizes.items():
        path = folder / name.replace("_", ".")
        with path.open("wb") as log:
            log.truncate(size * 1_000_000)
        wells[name] = Listing(name, folder / "toy.yaml", (path, folder / "missing.csv"))
    return Plan(Settings(fleet=FleetSettings(processes=processes)), wells)


@pytest.mark.parametrize(
    ("sizes", "memory"),
    [
        ({}, 1000),
        ({"a_csv": 100, "b_csv": 50}, 2200),
        ({"a_las": 100, "b_xml": 50}, 2200),
        ({"a_csv.gz": 100}, 7000),
        ({"a_parquet": 100}, 7000),
    ],
)
def test_memory_goes_with_the_largest_log_and_its_format(tmp_path: Path, sizes: dict[str, int], memory: int) -> None:
    found = plan(tmp_path, 1, small_csv=0, **sizes)
    assert found.memory_mb(tuple(found.wells)) == memory
    several = plan(tmp_path, 3, small_csv=0, **sizes)
    assert several.memory_mb(tuple(several.wells)) == memory * several.threads(tuple(several.wells))


def test_files_that_snakemake_would_take_for_patterns_or_cannot_be_looked_at_are_no_inputs(tmp_path: Path) -> None:
    names = ["a.csv", "{word}.csv", "<word>.csv", "b[1].csv"]
    for name in names:
        (tmp_path / name).touch()
    files = *(tmp_path / name for name in names), tmp_path / ("a" * 300), tmp_path / "missing.csv"
    wells = {"W1": Listing("W1", tmp_path / "toy.yaml", files)}
    starts = {"S1": Listing("S1", tmp_path / ("y" * 300), files)}
    found = Plan(Settings(results=str(tmp_path / "results")), wells, starts)
    expected = [str(tmp_path / name) for name in ("a.csv", "b[1].csv")]
    assert found.logs(["W1"]) == expected
    assert found.start_up_files("S1") == expected
    assert found.outcome()["missing_logs"] == [str(path) for path in files[-2:]]


def test_a_manifest_goes_when_a_folder_is_gone_or_other_than_it_says(tmp_path: Path) -> None:
    wells = {name: Listing(name, tmp_path / "toy.yaml", ()) for name in ("W1", "W2", "W3")}
    found = Plan(Settings(results=str(tmp_path)), wells)
    for well in wells:
        (tmp_path / "fits" / well).mkdir(parents=True)
        (tmp_path / "fits" / well / KEY).write_text('{"key": "1"}')
        write_manifest(tmp_path / f"fits/{well}.json", [well], found.dependencies("fits", [well])["made_from"])
    found.drop_out_of_date()
    assert len(list(tmp_path.glob("fits/*.json"))) == 3
    found.forget("fits", ["W2"])
    shutil.rmtree(tmp_path / "fits/W3")
    expected = {f"fits/{well}.json": f"{well} not finished" for well in ("W2", "W3")}
    assert {str(path.relative_to(tmp_path)): reason for path, reason in found.out_of_date().items()} == expected
    assert len(list(tmp_path.glob("fits/*.json"))) == 3, "only what was asked for is deleted"
    found.drop_out_of_date()
    assert list(tmp_path.glob("fits/*.json")) == [tmp_path / "fits/W1.json"]


def test_results_from_another_machine_are_done_again_by_other_settings(tmp_path: Path) -> None:
    wells = {"W1": Listing("W1", tmp_path / "toy.yaml", ())}
    settings = Settings(results=str(tmp_path / "elsewhere"))
    folder = tmp_path / "results"
    for stage in ("windows", "fits"):
        (folder / stage / "W1").mkdir(parents=True)
        (folder / stage / "W1" / KEY).write_text('{"key": "1"}')
        made_from = Plan(settings, wells).dependencies(stage, ["W1"])["made_from"]
        write_manifest(folder / stage / "W1.json", ["W1"], made_from)
    for starts, kept in ((16, ["fits", "windows"]), (3, ["windows"])):
        here = Settings(results=str(folder), fits=FitsSettings(starts=starts))
        Plan(here, wells).drop_out_of_date()
        assert sorted(path.parent.name for path in folder.glob("*/W1.json")) == kept


def test_a_failed_well_that_leaves_its_batch_takes_the_manifest_along(tmp_path: Path) -> None:
    wells = {name: Listing(name, tmp_path / "toy.yaml", ()) for name in ("W1", "W2")}
    settings = Settings(results=str(tmp_path), fleet={"batch_size": 25})
    for well, content in (("W1", {"key": "1"}), ("W2", {"key": "2", "failed_on": "a log that was cut short"})):
        (tmp_path / "fits" / well).mkdir(parents=True)
        (tmp_path / "fits" / well / KEY).write_text(json.dumps(content))
    write_manifest(tmp_path / "fits/0000.json", wells)
    Plan(settings, {"W1": wells["W1"]}).drop_out_of_date()
    assert not (tmp_path / "fits/0000.json").exists()


def test_a_well_that_never_finished_is_a_reason_to_run_again(tmp_path: Path) -> None:
    wells = {"W1": Listing("W1", tmp_path / "toy.yaml", ())}
    found = Plan(Settings(results=str(tmp_path)), wells)
    (tmp_path / "fits/W1").mkdir(parents=True)
    write_manifest(tmp_path / "fits/W1.json", wells)
    found.drop_out_of_date()
    assert not (tmp_path / "fits/W1.json").exists()


def test_simulated_logs_lie_in_raw_and_are_stands_in_order() -> None:
    logs = tuple(Path(f"results/raw/W1/{name}.csv") for name in "ab")
    settings = Settings(results="results", simulate=SimulateSettings())
    found = Plan(settings, {"W1": Listing("W1", Path("toy.yaml"), logs)}).simulated_logs()
    assert found == {"W1/a.csv": ("W1", 0), "W1/b.csv": ("W1", 1)}
    elsewhere = Plan(settings, {"W1": Listing("W1", Path("toy.yaml"), (Path("raw/a.csv"),))})
    with pytest.raises(SettingsError, match="Put it in results/raw"):
        elsewhere.simulated_logs()


def test_a_key_that_a_configuration_holds_twice_is_refused_though_snakemake_took_one(tmp_path: Path) -> None:
    path = tmp_path / "config.yaml"
    path.write_text("wells: a.tsv\nwells: b.tsv\n")
    with pytest.raises(SettingsError, match="line 2: the key 'wells' is already given in line 1"):
        Plan.from_config({"wells": "b.tsv"}, [path])

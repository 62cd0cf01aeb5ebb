"""The workflow as a whole with toy stages: what runs, what is left alone, and what stops only itself."""

import hashlib
import os
from collections.abc import Iterable
from pathlib import Path

import pandas as pd
import pytest
from rocrate.rocrate import ROCrate

from drillid.config.settings import Settings
from drillid.errors import SettingsError
from drillid.fleet.crate import CRATE, settings_of
from drillid.fleet.stages import STAGES
from tests.workflow.toys import RIG, Checkout

TWO_WELLS = {"W1": ["a.csv", "b.csv"], "W-2": ["c.csv"]}
ONE_BATCH = ("--config", "fleet={batch_size: 25, processes: 1}")


def all_stages(*wells: str) -> list[str]:
    """Every stage of the wells."""
    return sorted(f"{stage} {well}" for stage in STAGES for well in wells)


def jobs(stages: Iterable[str], wells: Iterable[str]) -> set[str]:
    """Jobs of these stages with a well a batch, and what follows from them."""
    stages = set(stages)
    shown = {f"figures_of_well {well}" for well in wells} | ({"common_causes"} if "discrepancy" in stages else set())
    return {f"{stage} {well}" for stage in stages for well in wells} | shown | {"fleet", "report", "all"}


@pytest.mark.parametrize(
    ("sheet", "what"),
    [("wells", "lists no wells. Add a row for each well"), ("logs", "lists no logs. Add a row for each")],
)
def test_an_emptied_sheet_stops_the_run_and_leaves_the_results(sheet: str, what: str, finished: Checkout) -> None:
    finished.journal()
    path = finished.root / f"config/{sheet}.tsv"
    path.write_text(path.read_text().partition("\n")[0] + "\n")
    output = finished.run(expect=1)
    assert f"config/{sheet}.tsv: {what}" in output
    assert finished.journal() == []
    assert (finished.root / "results/main/records/W1/key.json").exists()


def test_every_stage_runs_once(finished: Checkout) -> None:
    assert sorted(finished.journal()) == all_stages("W-2", "W1")
    assert (finished.root / "results/main/report.html").read_text() == "W1 W-2"
    assert "Nothing to be done" in finished.run()


def test_replacing_a_log_and_adding_a_well_process_those_wells_alone(finished: Checkout) -> None:
    finished.journal()
    os.utime(finished.root / "raw/c.csv", (1e9, 1e9))  # back-dated: older than every output
    assert set(finished.would_run()) == jobs(STAGES, ["W-2"])
    os.utime(finished.root / "raw/c.csv")
    finished.sheets({**TWO_WELLS, "W3": ["d.csv"]})
    assert set(finished.would_run()) == jobs(STAGES, ["W-2", "W3"])
    finished.run("--until", "windows")
    assert sorted(finished.journal()) == ["records W-2", "records W3", "windows W-2", "windows W3"]


def test_a_page_that_is_gone_is_written_again(finished: Checkout) -> None:
    (finished.root / "results/main/report/W1.html").unlink()
    assert finished.would_run() == ["report", "all"]
    finished.run()
    assert (finished.root / "results/main/report/W1.html").exists()
    assert "Nothing to be done" in finished.run()


def test_in_a_batch_only_the_changed_well_is_done_again(finished: Checkout) -> None:
    finished.journal()
    (finished.root / "raw/a.csv").write_text("other samples")
    finished.sheets({**TWO_WELLS, "W3": ["d.csv"]})
    finished.run(*ONE_BATCH)
    assert sorted(finished.journal()) == all_stages("W1", "W3")
    assert (finished.root / "results/main/windows/W-2/windows.zarr").is_dir()
    assert (finished.root / "results/main/report.html").read_text() == "W1 W-2 W3"


AFTER_FITS = ("fits", "discrepancy", "depth", "figures")


def test_an_edit_of_the_library_redoes_the_stages_that_use_it_and_what_follows(finished: Checkout) -> None:
    finished.edit("shared", "# a comment changes nothing\n")
    assert finished.would_run() == []
    finished.edit("shared", "FURTHER = 2\n")
    assert set(finished.would_run()) == jobs(AFTER_FITS, TWO_WELLS)


@pytest.mark.parametrize(
    ("setting", "stages"),
    [("figures={dpi: 90}", ("figures",)), ("fits={starts: 2}", AFTER_FITS), ("fleet={processes: 2}", ())],
)
def test_a_setting_redoes_the_stages_that_read_it_and_what_follows(
    finished: Checkout, setting: str, stages: tuple[str, ...]
) -> None:
    found = set(finished.would_run("--config", setting))
    assert found == (jobs(stages, TWO_WELLS) if stages else set())


def test_a_rig_description_redoes_only_the_stages_that_read_the_changed_part(finished: Checkout) -> None:
    (finished.root / "config/rigs/toy.yaml").write_text(RIG + "drive_delay: {value: 40 ms}\n")
    assert set(finished.would_run()) == jobs(AFTER_FITS, TWO_WELLS)


def test_bad_wells_end_as_rows_and_the_others_go_on(checkout: Checkout) -> None:
    wells = {
        "Good": ["a.csv"],
        "Bad": ["bad.csv"],
        "Crash": ["crash.csv"],
        "Rig": ["e.csv"],
        "Lost": ["f.csv"],
        "Die": ["die.csv"],
        "NoRig": ["g.csv"],
        "NoLog": [],
    }
    (checkout.root / "config/rigs/broken.yaml").write_text(RIG.replace("controller", "controler"))
    checkout.sheets(wells, {"Rig": "broken", "NoRig": "missing"})
    for name in ("bad", "crash", "die"):
        (checkout.root / f"raw/{name}.csv").write_text(name)
    (checkout.root / "raw/f.csv").unlink()
    output = checkout.run(*ONE_BATCH)
    assert "Listed logs that are not there: 1 (raw/f.csv)." in output
    assert [line for line in checkout.journal() if line.startswith("depth")] == ["depth Good"]
    problems = pd.read_csv(checkout.root / "results/main/problems.csv", index_col="well")
    bad = problems.loc["Bad", ["stage", "where", "what", "remedy"]].to_list()
    assert bad == ["records", "bad.csv", "is bad", "Mend it"]
    assert problems.loc["Crash", "what"] == "RuntimeError: nobody foresaw this"
    assert "Did you mean 'controller'?" in problems.loc["Rig", "remedy"]
    assert problems.loc["NoRig", "what"] == "rig 'missing' has no description"
    assert problems.loc["NoLog", "what"] == "well 'NoLog' has no logs"
    assert problems.loc["Lost", "what"] == "does not exist"
    assert problems.loc["Die", "what"] == "the process was killed, probably out of memory"
    assert problems.loc["Good", "stage"] == "windows"
    log = (checkout.root / "results/main/logs/records/0000.log").read_text()
    assert "Traceback" in log
    assert "nobody foresaw this" in log


def test_a_mistake_in_a_sheet_or_setting_is_one_sentence(checkout: Checkout) -> None:
    checkout.sheets({"Well_1": ["a.csv"]})
    output = checkout.run("--config", "fits={start: 3}", expect=1)
    assert "unknown key 'fits.start'. Did you mean 'starts'?" in output
    sheet = checkout.root / "config/logs.tsv"
    sheet.write_text(sheet.read_text().replace("log\n", "logs\n", 1))
    output = checkout.run(expect=1)
    assert "config/logs.tsv: has an unknown column 'logs'. Did you mean 'log'?" in output
    assert "Traceback" not in output


def test_a_mistake_in_a_row_of_a_sheet_fails_its_well_until_it_is_mended(checkout: Checkout) -> None:
    sheet = checkout.root / "config/logs.tsv"
    checkout.sheets({"Well_1": ["a.csv"], "Well_2": ["b.csv"]})
    sound = sheet.read_text()
    sheet.write_text(sound + "Well_2\traw/a.csv\nWell_3\traw/c.csv\n")
    output = checkout.run()
    assert {line.split()[1] for line in checkout.journal()} == {"Well_1"}
    problems = pd.read_csv(checkout.root / "results/main/problems.csv", index_col="well")
    assert problems.loc["Well_2", "what"] == "log 'raw/a.csv' is already listed at config/logs.tsv, row 2"
    assert problems.loc["Well_2", "remedy"] == "Remove one of the rows"
    assert problems.loc["Well_3", "where"] == "config/logs.tsv, row 5"
    assert "2 of 3 wells failed: Well_2 (records: config/logs.tsv, row 4: " in output
    sheet.write_text(sound)
    output = checkout.run()
    assert {line.split()[1] for line in checkout.journal()} == {"Well_2"}
    assert "2 of 2 wells done." in output


def test_the_workflow_lints_clean(finished: Checkout) -> None:
    assert "Congratulations" in finished.run("--lint")


def test_the_run_is_described_as_a_crate(finished: Checkout) -> None:
    """Read by the library of others: the workflow, what it was given with its checksums, and what it made."""
    results = finished.root / "results/main"
    crate = ROCrate(results)
    assert crate.mainEntity["programmingLanguage"]["name"] == "Snakemake"
    assert Path(crate.mainEntity.id.removeprefix("file://")).name == "Snakefile"
    assert ".." not in crate.mainEntity.id
    assert {profile.id.rpartition("/")[0] for profile in crate.root_dataset["conformsTo"]} >= {
        "https://w3id.org/ro/wfrun/process",
        "https://w3id.org/ro/wfrun/workflow",
    }
    run = crate.dereference("#run")
    assert run["instrument"] is crate.mainEntity
    logs = {entity["name"]: entity["sha256"] for entity in run["object"] if entity.type == "File"}
    assert set(logs) == {"a.csv", "b.csv", "c.csv", "toy.yaml", "wells.tsv", "logs.tsv"}
    assert logs["a.csv"] == hashlib.sha256((finished.root / "raw/a.csv").read_bytes()).hexdigest()
    made = {entity.id for entity in run["result"]}
    assert {"fits/W-2/", "depth/W1/", "report.html"} <= made
    assert all((results / name).exists() for name in made)


def test_the_settings_of_a_run_are_read_from_its_results(finished: Checkout, tmp_path: Path) -> None:
    results = finished.root / "results/main"
    settings = settings_of(results)
    assert settings.results == str(results)
    assert settings.wells == "config/wells.tsv"
    assert settings.windows == Settings.from_yaml(finished.root / "config/config.yaml").windows
    with pytest.raises(SettingsError, match="holds no results of a finished run"):
        settings_of(tmp_path)
    (tmp_path / CRATE).write_text('{"@graph": []}')
    with pytest.raises(SettingsError, match="holds no results of a finished run"):
        settings_of(tmp_path)

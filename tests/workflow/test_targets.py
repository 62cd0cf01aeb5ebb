"""Rules and wells as targets: a run up to a stage, without one, with one forced, for one well, and after a deletion."""

import json
import re
import shutil
import zipfile
from pathlib import Path

from tests.workflow import killed
from tests.workflow.toys import Checkout, jobs_in

WELLS = {"W1": ["a.csv"], "W-2": ["c.csv"]}
ONE_BATCH = ("--config", "fleet={batch_size: 25, processes: 1}")


def test_a_run_up_to_a_stage_and_then_without_another(checkout: Checkout) -> None:
    checkout.sheets(WELLS)
    checkout.run(*ONE_BATCH, "--until", "records")
    assert checkout.journal() == ["records W1", "records W-2"]
    rest = ("windows", "spectra", "mobility", "fits", "discrepancy", "depth")
    assert set(checkout.would_run("--omit-from", "figures")) == {
        *(f"{stage} {well}" for stage in ("records", *rest) for well in WELLS),
        "common_causes",
    }
    checkout.run(*ONE_BATCH, "--omit-from", "spectra")
    assert checkout.journal() == ["windows W1", "windows W-2"]
    assert not (checkout.root / "results/main/report.html").exists()


def test_a_forced_stage_and_what_follows_are_done_again_for_all_wells(finished: Checkout) -> None:
    finished.journal()
    finished.would_run("-R", "fits")
    assert "Nothing to be done" in finished.run()
    finished.run("-R", "fits", "--until", "fits")
    assert sorted(finished.journal()) == ["fits W-2", "fits W1"]
    finished.run("--until", "discrepancy")
    assert sorted(finished.journal()) == ["discrepancy W-2", "discrepancy W1"]
    assert {f"{stage} {well}" for stage in ("depth", "figures") for well in WELLS} < set(finished.would_run())


def test_one_stage_of_one_well_takes_what_it_reads_along(checkout: Checkout) -> None:
    checkout.sheets(WELLS)
    checkout.run("results/main/mobility/W1")
    assert checkout.journal() == ["records W1", "windows W1", "spectra W1", "mobility W1"]
    checkout.run("results/main/windows/W1")
    assert checkout.journal() == []
    assert "No rule to produce results/main/fits/W9" in checkout.run("results/main/fits/W9", expect=1)


def test_a_target_comes_before_the_configuration_or_goes_through_the_command(checkout: Checkout) -> None:
    checkout.sheets(WELLS)
    target, configuration = "results/main/windows/W1", ("--configfile", "config/config.yaml")
    expected = ["records W1", "windows W1", "well W1"]
    assert checkout.would_run(target, *configuration) == expected
    (checkout.root / "profile").mkdir()
    (checkout.root / "profile/config.yaml").write_text("scheduler: greedy\n")
    done = killed.run(checkout, *configuration, target, "--dry-run")
    assert done.returncode == 0, done.stderr
    assert jobs_in(done.stdout + done.stderr) == expected


def test_a_deleted_folder_of_a_well_is_made_again_and_the_other_wells_are_kept(finished: Checkout) -> None:
    finished.journal()
    shutil.rmtree(finished.root / "results/main/figures/W1")
    assert set(finished.would_run()) == {"figures W1", "figures_of_well W1", "fleet", "report", "all"}
    finished.run()
    assert finished.journal() == ["figures W1"]
    shutil.rmtree(finished.root / "results/main/spectra/W1")
    finished.run("--until", "mobility")
    assert finished.journal() == ["spectra W1"], "mobility is kept, as it would be the same"
    assert (finished.root / "results/main/figures/W1/figure_6.png").is_file()
    assert finished.would_run("--until", "mobility") == []


def state(results: Path) -> dict[str, tuple[int, bytes]]:
    """Time and content of everything in the results."""
    files = [path for path in sorted(results.rglob("*")) if path.is_file()]
    return {str(path): (path.stat().st_mtime_ns, path.read_bytes()) for path in files}


def test_a_dry_run_says_what_is_out_of_date_and_why_and_changes_nothing(finished: Checkout) -> None:
    results = finished.root / "results/main"
    before = state(results)
    other = finished.run("--dry-run", "--config", "fits={starts: 3}")
    assert "fits W1" in jobs_in(other)
    assert "fits: other code, settings or rig descriptions" in other
    assert state(results) == before
    assert finished.would_run() == []
    shutil.rmtree(results / "spectra/W1")
    (results / "report/W-2.html").unlink()
    before = state(results)
    jobs = finished.run("--dry-run")
    assert {"spectra W1", "report"} < set(jobs_in(jobs))
    assert "spectra W-2" not in jobs_in(jobs)
    assert "spectra: W1 not finished" in jobs
    assert "report: page of W-2 missing" in jobs
    assert state(results) == before
    assert jobs_in(finished.run("--dry-run", "--until", "mobility")) == ["spectra W1", "mobility W1"]
    assert jobs_in(finished.run("--dry-run", "--omit-from", "spectra")) == []


def test_what_only_looks_changes_nothing(finished: Checkout) -> None:
    results = finished.root / "results/main"
    shutil.rmtree(results / "spectra/W1")
    (results / "report/W-2.html").unlink()
    before = state(results)
    looks = ("--lint", "--dag", "--rulegraph", "--filegraph", "--summary", "--list-rules", "--list-changes=params")
    for look in looks:
        finished.run(look)
        assert state(results) == before, look
    finished.journal()
    finished.run()
    assert "spectra W1" in finished.journal()
    assert finished.would_run() == []


def test_other_settings_are_seen_without_the_notes_of_snakemake(finished: Checkout) -> None:
    shutil.rmtree(finished.root / ".snakemake")
    assert finished.would_run() == []
    again = finished.would_run("--config", "fits={starts: 3}")
    assert "fits W1" in again
    assert "mobility W1" not in again


def test_what_is_over_all_wells_is_made_again_without_the_notes_of_snakemake(finished: Checkout) -> None:
    shutil.rmtree(finished.root / ".snakemake")
    assert finished.would_run("--config", "report={title: Night}") == ["report", "all"]
    finished.run()
    assert finished.would_run() == []
    shutil.rmtree(finished.root / ".snakemake")
    finished.sheets({"W1": WELLS["W1"]})
    finished.journal()
    assert set(finished.would_run()) == {"fleet", "common_causes", "report", "all"}
    finished.run()
    assert finished.journal() == []
    assert finished.would_run() == []


def test_wells_of_one_batch_share_a_job_and_are_kept_one_by_one(checkout: Checkout) -> None:
    checkout.sheets(WELLS)
    checkout.run(*ONE_BATCH, "--until", "windows")
    assert checkout.journal() == ["records W1", "records W-2", "windows W1", "windows W-2"]
    folder = checkout.root / "results/main/records"
    keys = {well: json.loads((folder / well / "key.json").read_text())["key"] for well in WELLS}
    assert json.loads((folder / "0000.json").read_text())["wells"] == keys
    shutil.rmtree(folder / "W-2")
    checkout.run(*ONE_BATCH, "--until", "windows")
    assert checkout.journal() == ["records W-2"]
    assert checkout.would_run(*ONE_BATCH, "--until", "windows") == []


def test_the_archived_report_sorts_figures_tables_and_the_report(finished: Checkout) -> None:
    finished.run("--report", "archive.zip")
    with zipfile.ZipFile(finished.root / "archive.zip") as archive:
        page = archive.read("archive/report.html").decode()
    texts = {name: re.findall(rf"var {name} = (\{{.*\}});\n", page) for name in ("categories", "results")}
    shown = {name: json.loads(text) for name, (text,) in texts.items()}
    results = "results/main"
    figures = {well: [f"{results}/figures/{well}/figure_6.png"] for well in WELLS}
    tables = [f"{results}/{name}.csv" for name in ("changes", "common_causes", "learnt", "problems", "verdicts")]
    pages = [f"{results}/report.html"]
    assert shown["categories"] == {"Figures": figures, "Tables": {"Other": tables}, "Report": {"Other": pages}}
    labels = [shown["results"][path]["labels"] for path in (*figures["W1"], *tables, *pages)]
    named = [{"table": name} for name in ("changes", "common causes", "learnt", "problems", "verdicts")]
    assert labels == [{"figure": "figure_6"}, *named, {"report": "fleet"}]
    assert "logs of well W1" in shown["results"][figures["W1"][0]]["caption"]

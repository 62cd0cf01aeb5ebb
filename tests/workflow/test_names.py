"""Wells that are called as people call them go through the whole workflow."""

import json

import pandas as pd

from tests.workflow.toys import Checkout


def test_a_well_has_its_folder_and_keeps_its_name_in_the_tables(checkout: Checkout) -> None:
    checkout.sheets({"34/10-A-12 H": ["a.csv"], "=A": ["bad.csv"]})
    (checkout.root / "raw/bad.csv").write_text("bad")
    results = checkout.root / "results/main"
    assert "records 34-10-A-12-H" in checkout.would_run()
    batch = ("--config", "fleet={batch_size: 25}")
    checkout.run(*batch)
    assert sorted(folder.name for folder in (results / "depth").iterdir() if folder.is_dir()) == ["34-10-A-12-H", "A"]
    text = (results / "problems.csv").read_text()
    assert "'=A,records,bad.csv,is bad,Mend it" in text
    assert pd.read_csv(results / "problems.csv")["well"].unique().tolist() == ["34/10-A-12 H", "'=A"]
    assert checkout.would_run(*batch) == []
    # a change of the name alone keeps the folder and does the well again
    checkout.sheets({"34-10-A-12-H": ["a.csv"], "=A": ["bad.csv"]})
    checkout.run(*batch, "--until", "records")
    assert "records 34-10-A-12-H" in checkout.journal()


def test_logs_of_any_name_are_read_and_no_name_stops_the_run(checkout: Checkout) -> None:
    odd = ["{word}.csv", "<word>.csv", "{batch}.csv", "a }{ b.csv", "[1].csv"]
    checkout.sheets({"Odd": odd, "W1": ["a.csv"]})
    with (checkout.root / "config/logs.tsv").open("a") as sheet:
        sheet.write(f"Long\traw/{'a' * 300}.csv\n")
    with (checkout.root / "config/wells.tsv").open("a") as sheet:
        sheet.write("Long\ttoy\t\n")
    until, folder = ("--until", "records"), checkout.root / "results/main/records"
    checkout.run(*until)
    status = {well: json.loads((folder / well / "key.json").read_text())["status"] for well in ("Odd", "W1", "Long")}
    assert status == {"Odd": "done", "W1": "done", "Long": "failed"}
    assert "does not exist" in (folder / "Long/problems.csv").read_text()
    assert checkout.would_run(*until) == []
    (checkout.root / "raw/{word}.csv").write_text("other samples")
    assert checkout.would_run(*until) == ["records Odd"]

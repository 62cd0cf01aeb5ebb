"""Wells that are called as people call them go through the whole workflow."""

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

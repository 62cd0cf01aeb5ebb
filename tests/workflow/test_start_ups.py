"""Measured starts of rotation go through the workflow beside the wells."""

import pandas as pd
from rocrate.rocrate import ROCrate

from tests.workflow.toys import Checkout

HEAD = "start_up\tdescription\tsurvey\tlog\tdepth_m\n"
CONFIG = ("--config", "start_up_sheet=config/start_ups.tsv")


def test_a_start_of_rotation_is_done_kept_done_again_and_fails_alone(checkout: Checkout) -> None:
    checkout.sheets({"W1": ["a.csv"]})
    for name in ("well.yaml", "survey.csv", "start.csv"):
        (checkout.root / "raw" / name).write_text("friction: {}\n")
    sheet, files = checkout.root / "config/start_ups.tsv", "raw/well.yaml\traw/survey.csv"
    sheet.write_text(f"{HEAD}B/1733\t{files}\traw/start.csv\t1733\nlost\t{files}\traw/lost.csv\t900\n")
    output = checkout.run(*CONFIG)
    assert "1 of 2 starts of rotation failed: lost (start_ups: raw/lost.csv: does not exist)" in output.replace(
        str(checkout.root) + "/", ""
    )
    problems = pd.read_csv(checkout.root / "results/main/problems.csv")
    assert problems.loc[problems["stage"] == "start_ups", "well"].tolist() == ["lost"]
    assert {"start_ups B/1733", "start_ups lost"} <= set(checkout.journal())
    assert checkout.would_run(*CONFIG) == []
    sheet.write_text(sheet.read_text().replace("1733\n", "1800\n"))
    assert set(checkout.would_run(*CONFIG)) == {"all", "start_ups B-1733", "fleet", "report"}
    checkout.run(*CONFIG)
    assert checkout.journal() == ["start_ups B/1733"]


def test_starts_of_rotation_without_wells_have_their_report(checkout: Checkout) -> None:
    checkout.sheets({})
    (checkout.root / "raw").mkdir(exist_ok=True)
    (checkout.root / "raw/start.csv").write_text("t_s")
    (checkout.root / "config/start_ups.tsv").write_text(f"{HEAD}B\traw/start.csv\traw/start.csv\traw/start.csv\t900\n")
    checkout.run(*CONFIG)
    assert checkout.journal() == ["start_ups B"]
    run = ROCrate(checkout.root / "results/main").dereference("#run")
    assert {"start.csv", "start_ups.tsv"} <= {entity["name"] for entity in run["object"] if entity.type == "File"}
    assert "start_ups of the start of rotation B" in {entity["name"] for entity in run["result"]}
    assert (checkout.root / "results/main/report.html").exists()


def test_without_a_sheet_there_are_none(finished: Checkout) -> None:
    assert finished.would_run() == []
    assert not (finished.root / "results/main/start_ups").exists()

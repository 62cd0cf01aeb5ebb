"""CSV files for people: no cell is a formula, numbers are numbers, and what is read is what was written."""

from pathlib import Path

import pandas as pd
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from drillid.datasets.tables import read_table, write_table

FORMULAS = ["=1+1", "=cmd|' /C calc'!A0", "+A1", "-A1", "@SUM(A1)", "\t=1", "\n=1", "＝1+1", "-2+3", "-", "--x"]


@pytest.mark.parametrize("text", FORMULAS)
def test_no_cell_begins_as_a_formula_does_and_reading_gives_the_text_again(text: str, tmp_path: Path) -> None:
    write_table(pd.DataFrame({"well": [text], "remedy": ["fine"]}), tmp_path / "problems.csv")
    written = (tmp_path / "problems.csv").read_bytes().decode().partition("\n")[2].lstrip('"')
    assert text == "-" or written[0] not in "=+-@\t\r＝"
    read = read_table(tmp_path / "problems.csv", dtype=str, keep_default_na=False)
    assert read["well"].tolist() == [text]
    assert read["remedy"].tolist() == ["fine"]


def test_numbers_stay_numbers_in_columns_of_numbers_and_of_text(tmp_path: Path) -> None:
    table = pd.DataFrame({"size": [-1.5, float("nan")], "count": [-2, 3], "text": ["-3.5", "+7e-3"]})
    write_table(table, tmp_path / "table.csv")
    assert (tmp_path / "table.csv").read_text() == "size,count,text\n-1.5,-2,-3.5\n,3,+7e-3\n"
    pd.testing.assert_frame_equal(read_table(tmp_path / "table.csv")[["size", "count"]], table[["size", "count"]])


def test_a_table_is_there_whole_or_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "new" / "table.csv"
    write_table(pd.DataFrame({"a": ["before"]}), path)

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(pd.DataFrame, "to_csv", full)
    with pytest.raises(OSError, match="No space left"):
        write_table(pd.DataFrame({"a": ["after"]}), path)
    assert read_table(path)["a"].tolist() == ["before"]


@example(texts=[" "])
@given(
    texts=st.lists(st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0\r"), min_size=1), min_size=1)
)
def test_any_text_comes_back_and_none_is_a_formula(tmp_path_factory: pytest.TempPathFactory, texts: list[str]) -> None:
    path = tmp_path_factory.mktemp("tables") / "table.csv"
    write_table(pd.DataFrame({"text": pd.Series(texts, dtype=object)}), path)
    assert read_table(path, dtype=str, keep_default_na=False)["text"].tolist() == texts
    assert not any(cell[0] in "=@" for cell in pd.read_csv(path, dtype=str, keep_default_na=False)["text"])


def test_a_carriage_return_becomes_a_space(tmp_path: Path) -> None:
    write_table(pd.DataFrame({"what": ["a\r\n=b", "\r=c"]}), tmp_path / "table.csv")
    assert read_table(tmp_path / "table.csv")["what"].tolist() == ["a \n=b", " =c"]

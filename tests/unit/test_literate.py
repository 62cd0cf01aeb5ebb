"""Pages from scripts: what cells print and draw is shown, what fails stops the page; the tutorial's page is current."""

from pathlib import Path

import pytest
import typer

from drillid.errors import SettingsError
from scripts import write_tutorial
from scripts.write_tutorial import cells, differences, write_page

ROOT = Path(__file__).parents[2]
SCRIPT = '''"""Only for editors."""

# %% [markdown]
# # Title
#
# A sum:

# %%
from matplotlib import pyplot as plt

total = 1 + 2
print(f"{total} = sum")

# %%
figure, axis = plt.subplots(num="A line, drawn")
axis.plot([0, total])
'''


def page_of(text: str, folder: Path) -> str:
    script = folder / "short.py"
    script.write_text(text)
    return write_page(script, folder / "out").read_text()


def test_a_page_shows_text_code_output_and_figures(tmp_path: Path) -> None:
    page = page_of(SCRIPT, tmp_path)
    assert "\n# Title\n\nA sum:\n" in page
    assert "```text\n3 = sum\n```" in page
    assert "![A line, drawn](short/a_line_drawn.png)" in page
    assert (tmp_path / "out/short/a_line_drawn.png").stat().st_size > 1000
    assert page.index("3 = sum") < page.index("plt.subplots")
    assert "Only for editors" not in page


def test_a_page_depends_on_its_script_alone_and_old_figures_go(tmp_path: Path) -> None:
    first = page_of(SCRIPT, tmp_path)
    picture = (tmp_path / "out/short/a_line_drawn.png").read_bytes()
    (tmp_path / "out/short/old.png").write_bytes(b"")
    assert page_of(SCRIPT, tmp_path) == first
    assert (tmp_path / "out/short/a_line_drawn.png").read_bytes() == picture
    assert not (tmp_path / "out/short/old.png").exists()


@pytest.mark.parametrize(
    ("code", "error"), [("1 / 0", ZeroDivisionError), ("import warnings; warnings.warn('late')", UserWarning)]
)
def test_a_cell_that_fails_or_warns_stops_the_page_at_its_line(
    code: str, error: type[Exception], tmp_path: Path
) -> None:
    with pytest.raises(error) as failure:
        page_of(f"{SCRIPT}\n# %%\n{code}\n", tmp_path)
    lines = [entry.lineno + 1 for entry in failure.traceback if str(entry.path).endswith("short.py")]
    assert lines == [SCRIPT.count("\n") + 3]
    assert not (tmp_path / "out/short.md").exists()


@pytest.mark.parametrize("mark", ["# %% [raw]\nwords", "# %% [markdown]\nx = 1"])
def test_what_is_no_cell_is_refused(mark: str) -> None:
    with pytest.raises(SettingsError, match="line 2"):
        cells(f"\n{mark}\n")


def test_the_tutorial_shows_every_cell_of_its_script() -> None:
    """Its numbers are compared where it is built; here only that no cell was edited without `make tutorial`."""
    page = (ROOT / "docs/tutorial.md").read_text()
    for cell in cells((ROOT / "docs/tutorial.py").read_text()):
        assert cell.source in page, f"cell after line {cell.metadata['line']}: run `make tutorial`"
    for line in page.splitlines():
        if line.startswith("!["):
            assert (ROOT / "docs" / line.rpartition("(")[2].rstrip(")")).is_file(), line


@pytest.mark.parametrize(
    ("line", "other", "same"),
    [
        ("kappa  435.2  5.8e+02 N s m-4", "kappa   435.3 5.9e+02 N s m-4", True),
        ("off by -1.9", "off by -2.0", True),
        ("500 of them pass", "588 of them pass", False),
        ("gain 1.0", "gain 1.5", False),
        ("delay 0.0389 s", "delay 0.0389 m", False),
        ("one line", "", False),
        ("3.1 and 4", "3.1", False),
    ],
)
def test_pages_differ_by_more_than_their_last_digits(line: str, other: str, same: bool) -> None:
    assert (differences(f"first\n{line}\n", f"first\n{other}\n") == []) == same


def test_a_line_too_many_is_the_only_difference() -> None:
    assert differences("first\nsecond 1.5\nthird\n", "first\nmore\nsecond 1.6\nthird\n") == [("", "more")]


@pytest.fixture
def docs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "docs"
    folder.mkdir()
    (folder / "tutorial.py").write_text(SCRIPT)
    write_page(folder / "tutorial.py", folder)
    monkeypatch.setattr(write_tutorial, "DOCS", folder)
    return folder


def test_the_command_fails_where_the_page_is_not_the_one_kept(docs: Path, tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    write_tutorial.main(elsewhere)
    kept = docs / "tutorial.md"
    kept.write_text(kept.read_text().replace("3 = sum", "9 = sum"))
    with pytest.raises(typer.Exit):
        write_tutorial.main(elsewhere)


def test_a_page_that_is_written_over_may_differ(docs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kept = docs / "tutorial.md"
    kept.write_text(kept.read_text().replace("3 = sum", "9 = sum"))
    write_tutorial.main(docs)
    assert capsys.readouterr().out == "< 9 = sum\n> 3 = sum\n"
    assert "3 = sum" in kept.read_text()
